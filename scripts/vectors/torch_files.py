#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checkpoints as PyTorch writes them: /usr/bin/python3 torch_files.py > tests/io/torch_vectors.h

The tar archive is put together here after torch/serialization.py, for no PyTorch writes them any more;
torch.load reads it back. So is the file in the other byte order. ultralytics is not needed: a class of its
name pickles the same way.
"""
import argparse
import collections
import io
import pathlib
import pickle
import struct
import sys
import tarfile
import tempfile
import types
import zipfile

import numpy as np
import torch
from torch import nn


def emit(name, data):
    print(f"static const uint8_t {name}[{len(data)}] = {{")
    for i in range(0, len(data), 20):
        print("    " + " ".join(f"{b}," for b in data[i:i + 20]))
    print("};\n")


def saved(value, **kwargs):
    f = io.BytesIO()
    torch.save(value, f, **kwargs)
    return f.getvalue()


def fake_class(module, name, base=object):
    cls = type(name, (base,), {"__module__": module})
    parts = module.split(".")
    for i in range(1, len(parts) + 1):
        sys.modules.setdefault(".".join(parts[:i]), types.ModuleType(".".join(parts[:i])))
    setattr(sys.modules[module], name, cls)
    return cls


def everything():
    base = torch.arange(12, dtype=torch.float32)
    return collections.OrderedDict(
        float=base, turned=base[:6].view(2, 3).t(), window=base[4:8].view(2, 2), every_third=base[1::3],
        double=torch.tensor([1.5, -2.0], dtype=torch.float64), half=torch.tensor([1.0, -2.5, 0.1, 65504.0]).half(),
        bfloat=torch.tensor([1.0, -2.5, 0.1]).bfloat16(), long=torch.tensor([-1, 1 << 40]),
        int=torch.tensor([-7], dtype=torch.int32), short=torch.tensor([-300], dtype=torch.int16),
        char=torch.tensor([-5], dtype=torch.int8), byte=torch.tensor([200], dtype=torch.uint8),
        bool=torch.tensor([True, False]), scalar=torch.tensor(3.25), empty=torch.zeros(0, 4),
        expanded=torch.tensor([2.0, 3.0]).view(2, 1).expand(2, 3), parameter=nn.Parameter(torch.tensor([9.0])),
    )


def wrapped():
    return {"epoch": 3, "state_dict": {"module.fc.weight": torch.tensor([[1.0, 2.0]])}, "best": torch.tensor(0.5),
            "args": argparse.Namespace(lr=0.1, path=pathlib.PurePosixPath("/tmp/x")), "np": np.float64(2.5),
            "optimizer": {"state": {0: {"step": torch.tensor(1.0)}}, "param_groups": [{"lr": 0.1}]}}


class Block(nn.Module):
    def __init__(self):
        super().__init__()
        self.conv = nn.Conv2d(1, 2, 1, bias=False)
        self.bn = nn.BatchNorm2d(2)
        self.act = nn.SiLU()
        self.register_buffer("hidden", torch.tensor([5.0]), persistent=False)
        nn.init.constant_(self.conv.weight, 0.5)


def module():
    Block.__module__ = "ultralytics.nn.modules.conv"
    Block.__qualname__ = "Conv"
    fake_class("ultralytics.nn.modules.conv", "Conv")
    sys.modules["ultralytics.nn.modules.conv"].Conv = Block
    return {"model": nn.Sequential(Block(), nn.Identity()).half(), "train_args": {"imgsz": 640}, "ema": None}


def other_order():
    """The zip of a big-endian machine: the same pickle, the elements turned around."""
    out = io.BytesIO()
    inp = zipfile.ZipFile(io.BytesIO(saved({"x": torch.tensor([1.5, -2.0]), "n": torch.tensor([258])})))
    with zipfile.ZipFile(out, "w") as z:
        for name in inp.namelist():
            data = inp.read(name)
            if "/data/" in name:
                size = len(data) if len(data) == 8 and data[:2] == b"\x02\x01" else 4
                data = b"".join(data[i:i + size][::-1] for i in range(0, len(data), size))
            z.writestr(zipfile.ZipInfo(name), data)
        z.writestr(zipfile.ZipInfo("archive/byteorder"), b"big")
    return out.getvalue()


class TarPickler(pickle.Pickler):
    def __init__(self, f, keys):
        super().__init__(f, protocol=2)
        self.keys = keys

    def persistent_id(self, obj):
        return str(self.keys[id(obj)]) if id(obj) in self.keys else None


def tar():
    """As torch 0.1.9 wrote it: storages, tensors, pickle."""
    a, b = torch.arange(6, dtype=torch.float32), torch.tensor([7, 8])
    storages, tensors, value = io.BytesIO(), io.BytesIO(), io.BytesIO()
    dump = lambda x, f: pickle.dump(x, f, protocol=2)
    dump(2, storages)
    for key, cls, x in ((101, torch.FloatStorage, a), (102, torch.LongStorage, b)):
        dump((key, "cpu", cls), storages)
        storages.write(struct.pack("<q", x.numel()) + x.numpy().tobytes())
    dump([(103, 101, 2, 3)], storages)
    dump(3, tensors)
    for key, storage, cls, size, stride, offset in ((201, 101, torch.FloatTensor, (3, 2), (1, 3), 0),
                                                    (202, 102, torch.LongTensor, (2,), (1,), 0),
                                                    (203, 103, torch.FloatTensor, (2,), (1,), 1)):
        dump((key, storage, cls), tensors)
        tensors.write(struct.pack(f"<ii{2 * len(size) + 1}q", len(size), 0, *size, *stride, offset))
    x, y, z = object(), object(), object()
    TarPickler(value, {id(x): 201, id(y): 202, id(z): 203}).dump({"x": x, "y": y, "z": z})
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w", format=tarfile.USTAR_FORMAT) as t:
        for name, f in (("storages", storages), ("tensors", tensors), ("pickle", value)):
            info = tarfile.TarInfo(name)
            info.size = len(f.getvalue())
            t.addfile(info, io.BytesIO(f.getvalue()))
    with tempfile.NamedTemporaryFile() as f:            # torch.load wants a file of the system's for these
        f.write(out.getvalue())
        f.flush()
        back = torch.load(f.name)
    assert back["x"].tolist() == [[0, 3], [1, 4], [2, 5]] and back["y"].tolist() == [7, 8]
    return out.getvalue().rstrip(b"\0") + b"\0" * 1024


torch.manual_seed(1)
torch.serialization.get_source_lines_and_file = lambda obj, *_: (["pass"], 1, "x.py")
print("/* SPDX-License-Identifier: Apache-2.0 */\n/* Made by scripts/vectors/torch_files.py; do not edit. */\n"
      "#include <stdint.h>\n")
emit("torch_zip", saved(everything()))
emit("torch_stream", saved(everything(), _use_new_zipfile_serialization=False))
emit("torch_wrapped", saved(wrapped(), _use_new_zipfile_serialization=False))
emit("torch_module", saved(module()))
emit("torch_module_stream", saved(module(), _use_new_zipfile_serialization=False))
emit("torch_tar", tar())
emit("torch_other_order", other_order())
emit("torch_bomb", saved({"x": torch.zeros(1).expand(23456, 23456)}))
emit("torch_sparse", saved({"x": torch.eye(2).to_sparse()}, _use_new_zipfile_serialization=False))
emit("torch_complex", saved({"x": torch.zeros(2, dtype=torch.complex64)}, _use_new_zipfile_serialization=False))
f = io.BytesIO()
torch.jit.save(torch.jit.script(nn.Linear(1, 1)), f)
emit("torch_script", f.getvalue())
