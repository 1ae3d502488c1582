#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reference values of skinning, in NumPy float64: of a hand, and of a rig of SMPL-X's size.

    scripts/vectors/geometry.py hand > tests/geometry/hand_layer_vectors.h
    scripts/vectors/geometry.py skin > tests/geometry/skin_vectors.h

Both are made of hashed numbers, so that the C tests make the same ones and the files stay small.
"""
import sys

import numpy as np
from scipy.spatial.transform import Rotation

V, J = 778, 16
PARENT = [-1, 0, 1, 2, 0, 4, 5, 0, 7, 8, 0, 10, 11, 0, 13, 14]
TIPS = [728, 353, 442, 576, 694]
SIMPLE = [0, 13, 14, 15, 16, 1, 2, 3, 17, 4, 5, 6, 18, 10, 11, 12, 19, 7, 8, 9, 20]
SHOWN = [0, 1, 353, 500, 777]


def hashed(seed, *shape):
    """Numbers in [-1, 1), multiples of 2^-15: exact in float32."""
    n = int(np.prod(shape))
    with np.errstate(over="ignore"):
        x = np.arange(n, dtype=np.uint32) * np.uint32(2654435761) + np.uint32(seed)
        for shift, mul in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):
            x ^= x >> np.uint32(shift)
            x *= np.uint32(mul)
        x ^= x >> np.uint32(16)
    return ((x >> np.uint32(16)).astype(np.float64) / 32768 - 1).reshape(shape)


def hand():
    # Powers of two as scales, and shares that sum to one exactly, keep float32 and float64 the same hand.
    weights, regressor = np.zeros((V, J)), np.zeros((J, V))
    for i in range(V):
        for k, w in ((0, .5), (5, .25), (11, .25)):
            weights[i, (i + k) % J] += w
    for j in range(J):
        for k, w in ((0, .5), (100, .25), (200, .25)):
            regressor[j, (37 * j + k) % V] += w
    return {
        "template": hashed(1, V, 3) / 8,
        "shapedirs": hashed(2, V, 3, 10) / 256,
        "posedirs": hashed(3, V, 3, 135) / 256,
        "regressor": regressor,
        "weights": weights,
        "parent": PARENT,
    }


def rig(V, J, S):
    """A rig of any size: each vertex hangs on four joints, each joint stands between three vertices."""
    weights, regressor = np.zeros((V, J)), np.zeros((J, V))
    for i in range(V):
        for k, w in enumerate((.5, .25, .125, .125)):
            weights[i, (i // 8 + k * k) % J] += w
    for j in range(J):
        for k, w in ((0, .5), (100, .25), (200, .25)):
            regressor[j, (37 * j + k) % V] += w
    return {
        "template": hashed(1, V, 3) / 8,
        "shapedirs": hashed(2, V, 3, S) / 256,
        "posedirs": hashed(3, V, 3, 9 * (J - 1)) / 256,
        "regressor": regressor,
        "weights": weights,
        "parent": [-1] + [(2 * j - 1) // 3 for j in range(1, J)],
    }


def skin(h, R, beta):
    """Vertices and joints, 4 x 4 transforms throughout."""
    n = len(R)
    v = h["template"] + h["shapedirs"] @ beta
    joints = h["regressor"] @ v
    v = v + h["posedirs"] @ (R[1:] - np.eye(3)).reshape(-1)
    G = []
    for k in range(n):
        parent = h["parent"][k]
        local = np.eye(4)
        local[:3, :3] = R[k]
        local[:3, 3] = joints[k] - (joints[parent] if k else 0)
        G.append(local if k == 0 else G[parent] @ local)
    G = np.array(G)
    rest = np.tile(np.eye(4), (n, 1, 1))
    rest[:, :3, 3] = -joints
    T = np.einsum("ik,kab->iab", h["weights"], G @ rest)
    return np.einsum("iab,ib->ia", T, np.c_[v, np.ones(len(v))])[:, :3], G[:, :3, 3]


def pose(h, R, beta):
    """Vertices and keypoints of the hand, relative to the wrist."""
    v, joints = skin(h, R, beta)
    mano21 = np.concatenate([joints, v[TIPS]])
    return v - mano21[0], mano21[SIMPLE] - mano21[0]


def show(name, a):
    rows = ",\n".join("    { " + ", ".join("%.17g" % x for x in row) + " }" for row in a)
    print("static const double %s[%d][3] = {\n%s,\n};\n" % (name, len(a), rows))


def slope_of(loss):
    """The derivative at 0, by differences of order 4."""
    e = 1e-3
    return (8 * (loss(e) - loss(-e)) - (loss(2 * e) - loss(-2 * e))) / (12 * e)


def show_hand():
    h, beta = hand(), hashed(4, 10)
    R = Rotation.from_rotvec(hashed(5, J, 3)).as_matrix()
    v, keypoints = pose(h, R, beta)
    # The gradient of sum(g_v v) + sum(g_k keypoints) along one direction.
    g_v, g_k = hashed(6, V, 3), hashed(7, 21, 3)
    dR, dbeta = hashed(8, J, 3, 3), hashed(9, 10)

    def loss(e):
        a, b = pose(h, R + e * dR, beta + e * dbeta)
        return (g_v * a).sum() + (g_k * b).sum()

    print("static const int shown_vertex[] = { %s };\n" % ", ".join(map(str, SHOWN)))
    show("want_shown", v[SHOWN])
    show("want_mean_vertex", v.mean(0)[None])
    show("want_keypoints", keypoints)
    print("static const double want_slope = %.15g;" % slope_of(loss))


def show_skin():
    V, J, S = 10475, 55, 20
    shown = [0, 1, 15, 16, 5000, 10474]
    h, beta = rig(V, J, S), hashed(4, S)
    R = Rotation.from_rotvec(hashed(5, J, 3)).as_matrix()
    g_v, g_j = hashed(6, V, 3), hashed(7, J, 3)
    dR, dbeta = hashed(8, J, 3, 3), hashed(9, S)

    def from_root(R, beta):
        v, joints = skin(h, R, beta)
        return v - joints[0], joints - joints[0]

    def loss(e):
        a, b = from_root(R + e * dR, beta + e * dbeta)
        return (g_v * a).sum() + (g_j * b).sum()

    v, joints = from_root(R, beta)
    print("static const int shown_vertex[] = { %s };\n" % ", ".join(map(str, shown)))
    show("want_shown", v[shown])
    show("want_mean_vertex", v.mean(0)[None])
    show("want_joints", joints)
    print("static const double want_slope = %.15g;" % slope_of(loss))


def main():
    print("/* SPDX-License-Identifier: Apache-2.0 */")
    print("/* Made by scripts/vectors/geometry.py. */\n")
    {"hand": show_hand, "skin": show_skin}[sys.argv[1]]()


if __name__ == "__main__":
    main()
