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
    # Phi(t) - 1/2 = t P(t - m), m the middle of one of eight pieces of 0 <= t <= 5.65
    step, half = np.float32(5.65 / 7.49), lambda t: 0.5 * special.erf(t / np.sqrt(2)) / t
    pieces = [fit(lambda r: half(m + r), -0.501 * step if m else 1e-6, 0.501 * step, 6, lambda r: 1 / half(m + r))
              for m in np.arange(8) * np.float64(step)]
    for power, of_pieces in enumerate(zip(*(c for c, _ in pieces))):
        show("half_normal[%d]" % power, np.array(of_pieces), max(err for _, err in pieces))


if __name__ == "__main__":
    main()
