#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""PLY files packed by Python's struct, and masks by an own telling of COCO's rule: python3 ply.py > ply_vectors.h"""
import random
import struct


def emit(name, data):
    print(f"static const uint8_t {name}[{len(data)}] = {{")
    for i in range(0, len(data), 20):
        print("    " + " ".join(f"{b}," for b in data[i:i + 20]))
    print("};\n")


HEADER = """ply
format {} 1.0
comment made by ply.py \\
obj_info of no matter
element vertex 4
property float x
property float32 y
property double z
property uchar red
property uint8 green
property uchar blue
property short extra
element face 2
property uchar flag
property list uchar int vertex_indices
element empty 3
element edge 1
property list uint32 ushort pair
property int8 sign
end_header
"""
VERTICES = [(0, 0, 0.5, 255, 0, 51, -300), (1, 0, 0.25, 0, 255, 51, 7), (1, 1, 0, 0, 0, 255, 0), (0, 1, -1, 9, 8, 7, 1)]
FACES = [(1, (0, 1, 2, 3)), (0, (0, 2, 3))]


def binary(order):
    out = b"".join(struct.pack(order + "ffdBBBh", *v) for v in VERTICES)
    for flag, f in FACES:
        out += struct.pack(f"{order}BB{len(f)}i", flag, len(f), *f)
    return out + struct.pack(order + "IHHb", 2, 65535, 1, -128)


def text():
    rows = [" ".join(map(str, v)) for v in VERTICES]
    rows += [f"{flag} {len(f)} " + " ".join(map(str, f)) for flag, f in FACES]
    return ("\n".join(rows) + "\n2 65535 1\n-128\n").encode()


def splat_names(rest):
    names = ["x", "y", "z"] + [f"f_dc_{i}" for i in range(3)] + [f"f_rest_{i}" for i in range(rest)]
    return names + ["opacity"] + [f"scale_{i}" for i in range(3)] + [f"rot_{i}" for i in range(4)]


def splats(rest):
    """Two Gaussians of degree 1, whose properties stand in reverse: each is 100 i + its place."""
    names = splat_names(rest)
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 2\n"
    head += "".join(f"property float {n}\n" for n in reversed(names)) + "end_header\n"
    body = b"".join(struct.pack(f"<{len(names)}f", *[100 * i + k for k in reversed(range(len(names)))]) for i in (0, 1))
    return head.encode() + body


def rle(mask, height, width):
    runs, last = [0], 0
    for x in range(width):
        for y in range(height):
            if mask[y][x] != last:
                runs.append(0)
                last = mask[y][x]
            runs[-1] += 1
    text = ""
    for i, n in enumerate(runs):
        n -= runs[i - 2] if i > 2 else 0
        while True:
            group, n = n & 31, n >> 5
            done = n == (-1 if group & 16 else 0)
            text += chr(48 + group + (0 if done else 32))
            if done:
                break
    return text


print("/* SPDX-License-Identifier: Apache-2.0 */\n/* Made by scripts/vectors/ply.py; do not edit. */\n#include <stdint.h>\n")
emit("ply_ascii", HEADER.format("ascii").replace("\n", "\r\n").encode() + text())
emit("ply_little", HEADER.format("binary_little_endian").encode() + binary("<"))
emit("ply_big", HEADER.format("binary_big_endian").encode() + binary(">"))
emit("ply_splats", splats(9))
random.seed(1)
mask = [[int((x - 20) ** 2 + 2 * (y - 15) ** 2 < 150 or random.random() < 0.1) for x in range(50)] for y in range(40)]
emit("mask_40x50", bytes(sum(mask, [])))
print(f'static const char mask_rle[] = "{rle(mask, 40, 50)}";'.replace("\\", "\\\\"))
