#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Files of weights as training programs leave them: /usr/bin/python3 field_weights.py tests/field/weights

Each holds bn1.weight of a ResNet-50, 0 to 63, under names and beside things that have been met in the wild, or may be
next year. PyTorch 1.13 and NumPy 1.24 wrote them; 8-bit floats and safetensors are packed by hand.
"""
import collections
import functools
import json
import pathlib
import struct
import sys
import types

import numpy as np
import torch
from torch import nn

out = pathlib.Path(sys.argv[1])
weight = torch.arange(64, dtype=torch.float32)


def fake(module, name, base=object):
    cls = type(name, (base,), {"__module__": module})
    parts = module.split(".")
    for i in range(1, len(parts) + 1):
        sys.modules.setdefault(".".join(parts[:i]), types.ModuleType(".".join(parts[:i])))
    setattr(sys.modules[module], name, cls)
    return cls


def made(where, name, **state):
    x = fake(where, name)()
    x.__dict__.update(state)
    return x


def safetensors(arrays):
    """arrays: name -> (dtype, shape, bytes)"""
    header, data = {}, b""
    for name, (dtype, shape, raw) in arrays.items():
        header[name] = {"dtype": dtype, "shape": shape, "data_offsets": [len(data), len(data) + len(raw)]}
        data += raw
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + data


def network(where, name):
    """A whole network of somebody's own class, whose trunk has the layer."""
    trunk = nn.Module()
    trunk.bn1 = nn.BatchNorm2d(64)
    with torch.no_grad():
        trunk.bn1.weight.copy_(weight)
    top = fake(where, name, nn.Module)()
    top.trunk = trunk
    return top


plan = made("my.training", "Plan", lr=0.1)
plan.whole = {"plan": plan}
torch.save({"epoch": 3, "state_dict": collections.OrderedDict({"net.encoder.bn1.weight": weight}),
            "hyper_parameters": plan, "callbacks": {functools.partial: functools.partial(print, 1)},
            "phase": 1 + 2j, "spectrum": torch.zeros(2, dtype=torch.complex64),
            "eye": torch.eye(2).to_sparse(), "rng": [np.random.RandomState(1), torch.get_rng_state()[:8]]},
           out / "lightning.ckpt")
torch.save({"state_dict": {"module.encoder_q.bn1.weight": weight, "module.encoder_k.bn1.weight": weight + 1,
                           "module.queue": torch.zeros(2, 3)}}, out / "two_encoders.pth.tar")
torch.save(network("my.nets", "Classifier"), out / "whole_network.pt")
torch.save((7, {"ema": made("my.training", "Average", decay=0.9, module={"_orig_mod.bn1.weight": weight})}),
           out / "tuple.pth", _use_new_zipfile_serialization=False)
whole = (out / "tuple.pth").read_bytes()
(out / "cut.pth").write_bytes(whole[:2 * len(whole) // 3])
torch.save({"layer.kernel": weight, "layer.scale": weight}, out / "of_another_network.pth")

raw = weight.numpy().tobytes()
(out / "model.safetensors.index.json").write_text(json.dumps({"metadata": {"total_size": 516}, "weight_map": {
    "bert.bn1.weight": "model-00001-of-00002.safetensors", "bert.scale": "model-00002-of-00002.safetensors"}}))
(out / "model-00001-of-00002.safetensors").write_bytes(safetensors({"bert.bn1.weight": ("F32", [64], raw)}))
(out / "model-00002-of-00002.safetensors").write_bytes(safetensors({"bert.scale": ("F8_E5M2", [4], b"\0" * 4)}))
(out / "wanted_in_8_bits.safetensors").write_bytes(safetensors({"bn1.weight": ("F8_E4M3", [64], b"\0" * 64)}))
