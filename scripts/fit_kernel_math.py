#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fit the polynomials of libtensor/kernels/body/math.inc and attention.inc; prints C, lowest power first.

Least squares on Chebyshev points, reweighted towards the largest error (Lawson's iteration), which
tends to the minimax polynomial.
"""
import numpy as np
from scipy import special


def fit(f, lo, hi, degree, weight):
    t = 0.5 * (lo + hi) + 0.5 * (hi - lo) * np.cos(np.pi * (np.arange(4000) + 0.5) / 4000)
    y, w = f(t), np.full(t.shape, 1.0 / len(t))
    v = np.vander(t / hi, degree + 1, increasing=True)
    g = weight(t)
    for _ in range(300):
        s = np.sqrt(w) * g
        c = np.linalg.lstsq(v * s[:, None], y * s, rcond=None)[0]
        e = np.abs((v @ c - y) * g)
        w = w * (e + 1e-30)
        w /= w.sum()
    return c / hi ** np.arange(degree + 1), e.max()


def show(name, c, err):
    print("static const float %s[] = { %s };   /* weighted error %.1e */"
          % (name, ", ".join("%.9ef" % np.float32(x) for x in c), err))


def expm1_rest(r):              # (exp(r) - 1 - r) / r^2, by its series: r is small
    return sum(r ** (k - 2) / special.factorial(k) for k in range(2, 20))


def main():
    h = 0.5 * np.log(2) * 1.01
    show("exp_c", *fit(expm1_rest, -h, h, 4, lambda r: r * r))
    # 2^r = 1 + r P(r): for attention |r| <= 1/2, for sigmoid and silu 1/16
    for name, most, degree in (("exp2_c", 0.501, 4), ("decay_c", 0.0626, 2)):
        show(name, *fit(lambda r: np.expm1(r * np.log(2)) / r, -most, most, degree, lambda r: r))
    # tanh(x) = x + x s P(s), s = x^2 <= 0.6^2
    tanh_rest = lambda s: (np.tanh(np.sqrt(s)) / np.sqrt(s) - 1) / s
    show("tanh_c", *fit(tanh_rest, 1e-6, 0.36, 4, lambda s: s))
    # erf(x) = x + x P(s), s = x^2 <= 0.93^2
    erf_rest = lambda s: special.erf(np.sqrt(s)) / np.sqrt(s) - 1
    show("erf_c", *fit(erf_rest, 1e-6, 0.93 ** 2, 5, lambda s: np.ones_like(s)))
    # erf(t) = 1 - exp(-t Q(t)), 0.93 <= t <= 4
    tail = lambda t: -np.log(special.erfc(t)) / t
    show("erf_tail_c", *fit(tail, 0.92, 4.02, 6, lambda t: t * special.erfc(t)))


if __name__ == "__main__":
    main()
