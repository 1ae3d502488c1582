#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The opacity field of Gaussians by NumPy in double precision, view by view and Gaussian by Gaussian, as HOGS's
Appendix A has it (Eq. 12, 13, 16) with the minimum of GOF (Eq. 14), for tests/geometry/test_opacity.

    scripts/vectors/opacity.py          writes tests/vectors/opacity.npz

Alphas are added near to far, each times what those before it leave; the library takes the product of what they leave.
"""
import os

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
VIEWS, DISTANCE, LEAST, MOST = 16, 2.4, 1 / 255, 0.99
PHI = (1 + np.sqrt(5)) / 2


def gaussians(rng, n):
    centre = rng.normal(size=(n, 3))
    centre *= 0.04 * (0.6 + 0.4 * rng.random((n, 1))) / np.linalg.norm(centre, axis=1, keepdims=True)
    q, _ = np.linalg.qr(rng.normal(size=(n, 3, 3)))
    size = np.exp(rng.uniform(np.log(0.0005), np.log(0.012), size=(n, 3)))
    bent = np.eye(3) + 0.2 * rng.normal(size=(n, 3, 3))              # no rotation: skinning blends matrices
    return centre + [0.02, -0.01, 0.5], bent @ q * size[:, None, :], rng.uniform(0.002, 1, size=n)


def views(centre, axes):
    half = 3 * np.abs(axes).sum(axis=2)
    middle = 0.5 * ((centre - half).min(axis=0) + (centre + half).max(axis=0))
    signs = 3 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = centre[:, None] + np.einsum("nij,cj->nci", axes, signs)
    radius = np.linalg.norm(corners - middle, axis=2).max()
    i = np.arange(VIEWS)
    z, azimuth = -1 + 2 * i / (VIEWS - 1), 2 * np.pi * i / PHI
    r = np.sqrt(np.maximum(0, 1 - z * z))
    return middle, middle + DISTANCE * radius * np.stack([r * np.cos(azimuth), r * np.sin(azimuth), z], axis=1)


def seen_from(eye, middle, centre, precision, opacity, x):
    axis = (middle - eye) / np.linalg.norm(middle - eye)
    r = x - eye
    t_x = np.linalg.norm(r)
    r = r / t_x
    total, left = 0.0, 1.0
    for j in np.argsort((centre - eye) @ axis, kind="stable"):
        a, b = r @ precision[j] @ r, r @ precision[j] @ (eye - centre[j])
        c = (eye - centre[j]) @ precision[j] @ (eye - centre[j])
        best = -b / a
        t = min(t_x, best)
        alpha = min(MOST, opacity[j] * np.exp(-0.5 * (a * t * t + 2 * b * t + c)))
        if alpha < LEAST or best <= 0:
            continue
        total += alpha * left
        left *= 1 - alpha
    return total


def main():
    rng = np.random.default_rng(16)
    centre, axes, opacity = gaussians(rng, 60)
    precision = np.linalg.inv(axes @ axes.transpose(0, 2, 1) + 1e-12 * np.eye(3))
    middle, eyes = views(centre, axes)
    at = rng.integers(len(centre), size=300)
    x = centre[at] + np.einsum("nij,nj->ni", axes[at], rng.uniform(-3, 3, size=(300, 3)))
    seen = np.array([[seen_from(e, middle, centre, precision, opacity, p) for e in eyes] for p in x])
    mean = np.where((seen == 0).any(axis=1), 0, seen.mean(axis=1))
    np.savez_compressed(os.path.join(HERE, "../../tests/vectors/opacity.npz"), centre=centre, axes=axes,
                        opacity=opacity, places=x, mean=mean, min=seen.min(axis=1))
    print("places bare in a view: %d of %d; mean %.3f, min %.3f" % ((mean == 0).sum(), len(x), mean.mean(),
                                                                   seen.min(axis=1).mean()))


if __name__ == "__main__":
    main()
