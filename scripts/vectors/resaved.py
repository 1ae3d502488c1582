#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Arrays as people save them again: /usr/bin/python3 resaved.py > tests/io/resaved_vectors.h

One matrix in every sparse format of SciPy, as a numpy.matrix, an array of objects, a list, and what may stand beside
it that nobody needs. SciPy 1.10 and NumPy 1.24 made the file; the names and members of other versions are put
in by hand, after their sources.
"""
import io
import pickle
import sys
import types

import numpy as np
import scipy.sparse

M = np.array([[0, 1.5, 0, 0, 0, 0], [2, 0, -3, 0, 0, 0], [0, 0, 0, 0, 0, 0.25], [0, 0, 0, 0, 7, 0]])


def emit(name, data):
    print(f"static const uint8_t {name}[{len(data)}] = {{")
    for i in range(0, len(data), 20):
        print("    " + " ".join(f"{b}," for b in data[i:i + 20]))
    print("};\n")


def saved(save, *args, **kwargs):
    f = io.BytesIO()
    save(f, *args, **kwargs)
    return f.getvalue()


def fake_class(module, name, base=object):
    cls = type(name, (base,), {"__module__": module})
    parts = module.split(".")
    for i in range(1, len(parts) + 1):
        sys.modules.setdefault(".".join(parts[:i]), types.ModuleType(".".join(parts[:i])))
    setattr(sys.modules[module], name, cls)
    return cls


def with_state(module, name, **state):
    x = fake_class(module, name)()
    x.__dict__.update(state)
    return x


class Loop:
    """A configuration whose parts know the whole, and which has a list of itself."""

    def __init__(self):
        self.child = {"parent": self}
        self.all = [self]


Loop.__module__ = "config"
fake_class("config", "Loop")
sys.modules["config"].Loop = Loop


def matrices():
    for form in ("bsr", "coo", "csc", "csr", "dia", "dok", "lil"):
        for kind in ("matrix", "array"):
            yield f"{form}_{kind}", getattr(scipy.sparse, f"{form}_{kind}")(M)
    yield "bsr_blocks", scipy.sparse.bsr_matrix(M, blocksize=(2, 3))
    csr, coo = scipy.sparse.csr_matrix(M), scipy.sparse.coo_matrix(M)
    members = {k: getattr(csr, k) for k in ("data", "indices", "indptr")}
    yield "csr_before_1_8", with_state("scipy.sparse.csr", "csr_matrix", _shape=(4, 6), maxprint=50, **members)
    yield "csr_since_1_11", with_state("scipy.sparse._csr", "csr_array", _shape=(4, 6), maxprint=50, **members)
    yield "coo_since_1_13", with_state("scipy.sparse._coo", "coo_array", _shape=(4, 6), coords=(coo.row, coo.col),
                                       data=coo.data, has_canonical_format=False)
    yield "dok_since_1_12", with_state("scipy.sparse._dok", "dok_array", _shape=(4, 6), dtype=np.dtype("f8"),
                                       _dict={(int(r), int(c)): v for r, c, v in zip(coo.row, coo.col, coo.data)})
    yield "twice", scipy.sparse.coo_matrix((np.r_[coo.data, coo.data] / 2, (np.r_[coo.row, coo.row],
                                                                            np.r_[coo.col, coo.col])), M.shape)
    yield "numpy_matrix", np.matrix(M)
    yield "subclass", M.view(fake_class("somebody", "Array", np.ndarray))
    yield "objects", M.astype(object)
    yield "objects_turned", np.asfortranarray(M.astype(object))
    one = np.empty((), object)
    one[()] = csr
    yield "object_of_no_dimension", one
    yield "list", M.tolist()
    yield "tuple_of_arrays_of_one", tuple(tuple(np.float32(x) for x in row) for row in M)


def beside():
    """What nobody needs: each of these once refused a whole file."""
    yield "unknown", with_state("config", "Config", lr=0.1)
    yield "loop", Loop()
    yield "complex", 1 + 2j
    yield "complex_array", np.zeros(2, "c16")
    yield "structures", np.zeros(2, [("a", "i4"), ("b", "f4")])
    yield "dates", np.zeros(2, "M8[us]")
    yield "random_state", np.random.RandomState(0)
    yield "generator", np.random.default_rng(0)
    yield "masked", np.ma.masked_array([1.0, 2.0], [True, False])
    yield "function", np.sum
    yield "exception", ValueError("x")


print("/* SPDX-License-Identifier: Apache-2.0 */\n/* Made by scripts/vectors/resaved.py; do not edit. */")
print("#ifndef TESTS_RESAVED_VECTORS_H\n#define TESTS_RESAVED_VECTORS_H\n\n#include <stdint.h>\n")
everything = {**dict(matrices()), "beside": dict(beside())}
emit("resaved_pickle", pickle.dumps(everything, 4))
emit("resaved_npz", saved(np.savez_compressed, plain=M, sparse=scipy.sparse.csc_matrix(M), objects=M.astype(object),
                          config=with_state("config", "Config", lr=0.1), complex=np.zeros(2, "c16")))
emit("resaved_npy", saved(np.save, {"plain": M, "sparse": scipy.sparse.csc_matrix(M), "name": "x"}))
print("#endif")
