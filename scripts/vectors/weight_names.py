#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Names of state_dict() in torchvision and in twins of timm's, efficientnet_pytorch's, HFL-Net's and ULIP's modules, in
one order each, so that the i-th names the same tensor: /usr/bin/python3 weight_names.py > tests/estimate/weight_names.h
"""
import io
import os
import sys

import torch
import torchvision
from torch import nn

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../peers"))
from pointnet2 import PointNet2     # noqa: E402

STAGES = [(1, 1), (6, 2), (6, 2), (6, 3), (6, 3), (6, 4), (6, 1)]


def emit(name, names):
    names = [n for n in names if not n.endswith("num_batches_tracked")]
    print(f"static const char *const {name}[{len(names)}] = {{")
    for n in names:
        print(f'    "{n}",')
    print("};\n")


def module(**children):
    m = nn.Module()
    for name, child in children.items():
        m.add_module(name, child)
    return m


def conv(bias=False):
    return nn.Conv2d(1, 1, 1, bias=bias)


def bn():
    return nn.BatchNorm2d(1)


def timm():
    def block(expand):
        se = module(conv_reduce=conv(True), conv_expand=conv(True))
        if expand == 1:
            return module(conv_dw=conv(), bn1=bn(), se=se, conv_pw=conv(), bn2=bn())
        return module(conv_pw=conv(), bn1=bn(), conv_dw=conv(), bn2=bn(), se=se, conv_pwl=conv(), bn3=bn())
    stages = nn.Sequential(*[nn.Sequential(*[block(e) for _ in range(n)]) for e, n in STAGES])
    return module(conv_stem=conv(), bn1=bn(), blocks=stages, conv_head=conv(), bn2=bn(), classifier=nn.Linear(1, 1))


def lukemelas():
    def block(expand):
        first = {} if expand == 1 else {"_expand_conv": conv(), "_bn0": bn()}
        return module(**first, _depthwise_conv=conv(), _bn1=bn(), _se_reduce=conv(True), _se_expand=conv(True),
                      _project_conv=conv(), _bn2=bn())
    blocks = nn.ModuleList([block(e) for e, n in STAGES for _ in range(n)])
    return module(_conv_stem=conv(), _bn0=bn(), _blocks=blocks, _conv_head=conv(), _bn1=bn(), _fc=nn.Linear(1, 1))


def hfl(resnet):
    layers = {"layer0_h": nn.Sequential(resnet.conv1, resnet.bn1)}
    layers.update({f"layer{i}_h": nn.Sequential(getattr(resnet, f"layer{i}")) for i in (1, 2, 3, 4)})
    return module(honet=module(module=module(base_net=module(**layers))))


resnet = torchvision.models.resnet50()
print("/* SPDX-License-Identifier: Apache-2.0 */\n/* Made by scripts/vectors/weight_names.py; do not edit. */\n")
emit("names_resnet50", resnet.state_dict())
emit("names_resnet50_hfl", hfl(resnet).state_dict())
emit("names_efficientnet", torchvision.models.efficientnet_b0().state_dict())
emit("names_efficientnet_timm", timm().state_dict())
emit("names_efficientnet_lukemelas", lukemelas().state_dict())
emit("names_pointnet2", PointNet2().state_dict())
emit("names_pointnet2_ulip", ["module.point_encoder." + name for name in PointNet2().state_dict()])

# The beginning of a ResNet of width 8 as a training program saves it.
f = io.BytesIO()
weight = (torch.arange(8 * 3 * 49, dtype=torch.float32) / 8).half().view(8, 3, 7, 7)
torch.save({"epoch": 7, "state_dict": {"module.conv1.weight": weight, "module.bn1.weight": torch.arange(8.0),
            "module.bn1.running_var": torch.full((8,), 2.0), "module.bn1.num_batches_tracked": torch.tensor(5),
            "module.head.weight": torch.zeros(3)}}, f)
print(f"static const unsigned char resnet_stem[{len(f.getvalue())}] = {{")
for i in range(0, len(f.getvalue()), 20):
    print("    " + " ".join(f"{b}," for b in f.getvalue()[i:i + 20]))
print("};")
