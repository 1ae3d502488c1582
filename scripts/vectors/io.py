#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Files made by Python, NumPy, SciPy and Pillow, as byte arrays for tests/io: python3 io.py > io_vectors.h

chumpy is not needed: a class of its name pickles the same way.
"""
import collections
import io
import os
import pickle
import sys
import types

import numpy as np
import scipy.sparse
from PIL import Image


def emit(name, data):
    print(f"static const uint8_t {name}[{len(data)}] = {{")
    for i in range(0, len(data), 20):
        print("    " + " ".join(f"{b}," for b in data[i:i + 20]))
    print("};\n")


def saved(save, *args, **kwargs):
    f = io.BytesIO()
    save(f, *args, **kwargs)
    return f.getvalue()


def fake_class(module, name):
    cls = type(name, (object,), {"__module__": module})
    parts = module.split(".")
    for i in range(1, len(parts) + 1):
        sys.modules.setdefault(".".join(parts[:i]), types.ModuleType(".".join(parts[:i])))
    setattr(sys.modules[module], name, cls)
    return cls


class Evil:
    def __reduce__(self):
        return os.system, ("echo owned",)


def everything():
    return {
        "a": np.arange(6.0).reshape(2, 3),
        "f": np.asfortranarray(np.arange(6, dtype=">i4").reshape(2, 3)),
        "none": None, "tuple": (1, 2, 3, 4), "set": {1}, "frozen": frozenset([2.5]),
        "int": -5, "long": 2**40, "least": -2**63, "float": 1e-3, "str": "é€", "bytes": b"\xff\x00a",
        "scalar": np.float32(1.5), "bool": np.array([True, False]), "text": np.array(["ab", "é"]),
        "ordered": collections.OrderedDict(a=1), "default": collections.defaultdict(list, {"b": [2]}),
        "empty": [], "true": True, "zero": np.zeros((0, 3)),
    }


def expressions():
    Ch, Select = fake_class("chumpy.ch", "Ch"), fake_class("chumpy.reordering", "Select")
    Transpose = fake_class("chumpy.reordering", "transpose")
    ch, select, turned = Ch(), Select(), Transpose()
    ch.x = np.arange(12.0).reshape(2, 2, 3)
    ch._dirty_vars = set()
    select.a, select.idxs, select.preferred_shape = ch, np.array([0, 1, 3, 4, 6, 7, 9, 10]), (2, 2, 2)
    turned.a, turned.axes = ch, (2, 0, 1)
    m = np.array([[0, 1.5, 0], [2, 0, -3]])
    return {
        "ch": ch, "select": select, "turned": turned, "csc": scipy.sparse.csc_matrix(m),
        "csr": scipy.sparse.csr_matrix(m), "coo": scipy.sparse.coo_matrix(m),
    }


def images():
    gray = np.arange(35, dtype=np.uint8).reshape(5, 7) * 7
    rgb = np.stack([gray, 255 - gray, gray // 2], -1)
    yield "png_gray", saved(Image.fromarray(gray).save, "png")
    yield "png_deep", saved(Image.fromarray(gray.astype(np.uint16) * 257 + 1).save, "png")
    yield "png_bits", saved(Image.fromarray(gray > 100).save, "png")
    yield "png_rgb", saved(Image.fromarray(rgb).save, "png")
    yield "png_palette", saved(Image.fromarray(rgb).quantize(8).save, "png")
    yield "png_gray_alpha", saved(Image.fromarray(np.stack([gray, gray], -1), "LA").save, "png")
    yield "bmp_rgb", saved(Image.fromarray(rgb).save, "bmp")
    yield "jpeg_gray", saved(Image.fromarray(gray).save, "jpeg", quality=90)
    cmyk = saved(Image.fromarray(rgb).convert("CMYK").save, "jpeg")
    yield "jpeg_cmyk", cmyk
    yield "jpeg_cmyk_rgb", np.asarray(Image.open(io.BytesIO(cmyk)).convert("RGB")).tobytes()
    big = np.add.outer(np.arange(24) * 5, np.arange(32) * 3).astype(np.uint8)
    big = np.stack([big, 255 - big, big // 2], -1)
    progressive = saved(Image.fromarray(big).save, "jpeg", progressive=True)
    yield "jpeg_progressive", progressive
    yield "jpeg_progressive_rgb", np.asarray(Image.open(io.BytesIO(progressive))).tobytes()


def main():
    print("/* SPDX-License-Identifier: Apache-2.0 */")
    print("/* Files made by Python, NumPy, SciPy and Pillow: scripts/vectors/io.py > tests/io/io_vectors.h */")
    print("#ifndef TESTS_IO_VECTORS_H\n#define TESTS_IO_VECTORS_H\n\n#include <stdint.h>\n")
    for protocol in range(6):
        emit(f"pickle_{protocol}", pickle.dumps(everything(), protocol))
    emit("pickle_expressions", pickle.dumps(expressions(), 2))
    for protocol in (0, 2, 4):
        emit(f"pickle_evil_{protocol}", pickle.dumps(Evil(), protocol))
    loop = []
    loop.append(loop)
    emit("pickle_loop", pickle.dumps(loop))
    emit("pickle_objects", pickle.dumps(np.array([None, 1], dtype=object)))
    arrays = {"a": np.arange(6.0).reshape(2, 3).T, "o": np.array([None, 1], dtype=object),
              "u": np.array("synthetic"), "e": np.zeros((0, 7), "f2"), "be": np.arange(4, dtype=">i4")}
    emit("npz_deflated", saved(np.savez_compressed, **arrays))
    emit("npz_stored", saved(np.savez, **{"x": np.float32([1.5, -2.0])}))
    emit("npy_fortran", saved(np.lib.format.write_array, np.asfortranarray(np.arange(24, dtype="<i2").reshape(2, 3, 4))))
    emit("npy_v2", saved(np.lib.format.write_array, np.arange(3, dtype=">f8"), version=(2, 0)))
    emit("npy_v3", saved(np.lib.format.write_array, np.arange(3, dtype="u1"), version=(3, 0)))
    emit("npy_complex", saved(np.save, np.zeros(2, "c16")))
    emit("npy_struct", saved(np.save, np.zeros(2, [("a", "i4"), ("b", "f4")])))
    for name, data in images():
        emit(name, data)
    print("#endif")


main()
