#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Chamfer distance, F-scores and closest-point alignments of point sets by SciPy's k-d tree and NumPy's SVD, for
tests/eval/test_shape.

    scripts/vectors/shape.py            writes tests/vectors/shape.npz

Points lie on an L of two boxes, true and predicted, moved, turned and scaled. The similarity starts as it is, with pairs
within 10 mm, 30 rounds; the fit without rotation starts with means and sizes made equal.
"""
import os

import numpy as np
from scipy.spatial import cKDTree

HERE = os.path.dirname(os.path.abspath(__file__))


def surface(rng, n):
    x = rng.random((n, 3)) * [0.08, 0.03, 0.02]
    face = rng.integers(6, size=n)
    x[np.arange(n), face % 3] = np.where(face < 3, 0, np.array([0.08, 0.03, 0.02])[face % 3])
    bent = rng.random(n) < 0.4
    x[bent] = x[bent][:, [1, 0, 2]] * [0.6, 0.7, 1.2]
    return x + rng.normal(size=(n, 3)) * 2e-4


def turn(axis, angle):
    a = np.asarray(axis) / np.linalg.norm(axis)
    k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def umeyama(x, y):
    mx, my = x.mean(axis=0), y.mean(axis=0)
    u, d, vt = np.linalg.svd((y - my).T @ (x - mx) / len(x))
    s = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    r = u @ s @ vt
    c = np.trace(np.diag(d) @ s) / ((x - mx) ** 2).sum(axis=1).mean()
    return c, r, my - c * r @ mx


def similarity(x, y, within=0.01, rounds=30, tolerance=1e-6):
    c, r, t = 1.0, np.eye(3), y.mean(axis=0) - x.mean(axis=0)
    tree, last = cKDTree(y), (0.0, np.inf)
    for _ in range(rounds):
        d, j = tree.query(c * x @ r.T + t)
        near = d <= within
        now = near.mean(), np.sqrt((d[near] ** 2).mean())
        if abs(now[0] - last[0]) <= tolerance and abs(now[1] - last[1]) <= tolerance * last[1]:
            break
        last = now
        c, r, t = umeyama(x[near], y[j[near]])
    return c, r, t


def scale_translation(x, y):
    mx, my = x.mean(axis=0), y.mean(axis=0)
    sx, sy = (np.sqrt(((p - m) ** 2).sum(axis=1).mean()) for p, m in ((x, mx), (y, my)))
    u, v = (x - mx) / sx, (y - my) / sy
    scale, shift, last = 1.0, np.zeros(3), np.inf
    for _ in range(100):
        du, ju = cKDTree(v).query(u)
        dv, jv = cKDTree(u).query(v)
        rms = np.sqrt((np.concatenate([du, dv]) ** 2).mean())
        if rms < 1e-3 or last - rms < 1e-5:
            break
        last = rms
        a, b = np.concatenate([u, u[jv]]), np.concatenate([v[ju], v])
        ca, cb = a - a.mean(axis=0), b - b.mean(axis=0)
        s = (ca * cb).sum() / (ca * ca).sum()
        t = b.mean(axis=0) - s * a.mean(axis=0)
        u, scale, shift = s * u + t, s * scale, s * shift + t
    return scale * sy / sx, my + sy * shift - scale * sy / sx * mx


def scores(p, g):
    d_p, d_g = 100 * cKDTree(g).query(p)[0], 100 * cKDTree(p).query(g)[0]
    f = []
    for tau in (0.1, 0.5, 1.0):
        a, b = (d_p < tau).mean(), (d_g < tau).mean()
        f.append(2 * a * b / (a + b + 1e-7))
    return np.array([(d_p ** 2).mean() + (d_g ** 2).mean(), *f])


def main():
    rng = np.random.default_rng(24)
    g = surface(rng, 400) + [0.1, -0.05, 0.6]
    p = 1.08 * surface(rng, 350) @ turn([1, 2, 0.5], 0.15).T + [0.108, -0.048, 0.605]
    c, r, t = similarity(p, g)
    s, shift = scale_translation(p, g)
    np.savez_compressed(os.path.join(HERE, "../../tests/vectors/shape.npz"), p=p, g=g, raw=scores(p, g),
                        similarity=np.concatenate([[c], r.ravel(), t]), similar=scores(c * p @ r.T + t, g),
                        no_rotation=np.concatenate([[s], shift]), moved=scores(s * p + shift, g))
    print(c, s, scores(p, g), scores(c * p @ r.T + t, g), scores(s * p + shift, g), sep="\n")


if __name__ == "__main__":
    main()
