#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Delaunay tetrahedra of points in general position by Qhull, as SciPy has it (options Qbb Qc), for
tests/geometry/test_delaunay.

    scripts/vectors/delaunay.py         writes tests/vectors/delaunay.npz

Places are whole numbers that fill the 22 bits of lt_delaunay's grid, so that both see the same points: some spread
over a cube, some near a sphere's surface, some in clusters.
"""
import os

import numpy as np
from scipy.spatial import Delaunay

HERE = os.path.dirname(os.path.abspath(__file__))
MOST = 2 ** 22 - 1


def points():
    rng = np.random.default_rng(7)
    sphere = rng.normal(size=(150, 3))
    sphere *= (0.4 + 0.01 * rng.random((150, 1))) / np.linalg.norm(sphere, axis=1, keepdims=True)
    clusters = rng.random((6, 1, 3)) + 0.003 * rng.normal(size=(6, 25, 3))
    x = np.concatenate([rng.random((200, 3)), sphere + .5, clusters.reshape(-1, 3)])
    x = np.rint(np.clip(x, 0, 1) * (MOST - 2) + 1)
    return np.concatenate([[[0, 0, 0], [MOST, MOST, MOST]], x])


def main():
    x = points()
    tets = np.sort(Delaunay(x, qhull_options="Qbb Qc").simplices, axis=1)
    tets = tets[np.lexsort(tets.T[::-1])].astype(np.int32)
    np.savez_compressed(os.path.join(HERE, "../../tests/vectors/delaunay.npz"), points=x, tets=tets)
    print(len(x), len(tets))


if __name__ == "__main__":
    main()
