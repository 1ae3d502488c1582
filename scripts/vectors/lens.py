#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What OpenCV makes of lenses: points and a small picture, for tests/vision: python3 lens.py > lens_vectors.h"""
import cv2
import numpy as np

WIDTH, HEIGHT = 40, 30
K = np.array([[36.0, 0, 21.0], [0, 34.0, 13.5], [0, 0, 1]])
LENSES = [
    [-0.28, 0.07, 0.001, -0.002],
    [0.12, -0.05, -0.003, 0.002, 0.01],
    [0.4, -0.1, 0.001, 0.0005, 0.02, 0.5, -0.05, 0.01],
]


def emit(name, kind, x):
    flat = [f"{v:.12g}" for v in np.ravel(x)]
    print(f"static const {kind} {name}[{len(flat)}] = {{")
    for i in range(0, len(flat), 10 if kind == "double" else 20):
        print("    " + ", ".join(flat[i:i + (10 if kind == "double" else 20)]) + ",")
    print("};\n")


def main():
    print("/* SPDX-License-Identifier: Apache-2.0 */")
    print("/* Lenses of OpenCV: scripts/vectors/lens.py > tests/vision/lens_vectors.h */")
    print("#ifndef TESTS_VISION_LENS_VECTORS_H\n#define TESTS_VISION_LENS_VECTORS_H\n\n#include <stdint.h>\n")
    points = np.array([[x, y, 1] for x in (-0.5, -0.1, 0, 0.3) for y in (-0.3, 0, 0.35)], np.float64)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    picture = np.stack([6 * x, 8 * y, 120 + 100 * np.sin(x / 5) * np.cos(y / 4)], -1).astype(np.uint8)
    emit("lens_points", "double", points[:, :2])
    emit("lens_picture", "uint8_t", picture)
    for i, lens in enumerate(LENSES):
        seen, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), np.array(lens))
        emit(f"lens_seen_{i}", "double", seen)
        emit(f"lens_undistorted_{i}", "uint8_t", cv2.undistort(picture, K, np.array(lens)))
    print("#endif")


main()
