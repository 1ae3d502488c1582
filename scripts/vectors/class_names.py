#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checkpoints that name classes: /usr/bin/python3 class_names.py > tests/estimate/class_names_vectors.h

As ultralytics leaves them: a module of its class, whose names are a dict by number. Of its weights there is one.
"""
import io
import sys
import types

import torch
from torch import nn


def emit(name, data):
    print(f"static const uint8_t {name}[{len(data)}] = {{")
    for i in range(0, len(data), 20):
        print("    " + " ".join(f"{b}," for b in data[i:i + 20]))
    print("};\n")


def fake_class(module, name, base):
    cls = type(name, (base,), {"__module__": module})
    parts = module.split(".")
    for i in range(1, len(parts) + 1):
        sys.modules.setdefault(".".join(parts[:i]), types.ModuleType(".".join(parts[:i])))
    setattr(sys.modules[module], name, cls)
    return cls


def named(names):
    m = fake_class("ultralytics.nn.tasks", "SegmentationModel", nn.Module)()
    m.head = nn.Linear(2, len(names))
    m.names = names
    m.stride = torch.tensor([8.0, 16.0, 32.0])
    return m


def saved(**value):
    f = io.BytesIO()
    torch.save(value, f)
    return f.getvalue()


print("/* SPDX-License-Identifier: Apache-2.0 */")
print("/* Made by scripts/vectors/class_names.py; do not edit. */")
print("#include <stdint.h>\n")
emit("names_by_number", saved(epoch=-1, model=named({1: "hand", 0: "person", 2: "cup, or mug"}), ema=None))
emit("names_in_order", saved(epoch=3, model=None, ema=named(["left_hand", "right_hand"])))
emit("names_none", saved(model=named([]).state_dict()))
