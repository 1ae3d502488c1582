# SPDX-License-Identifier: Apache-2.0
"""Single layers in PyTorch, as palmar bench --layer has them: attention, layer_norm, roi_align, hand.

Short ones come as a chain of equal layers, so that a call's own cost is shared out.
"""
import math

import torch
from torch import nn

from hocat import Hand, roi_align


class Attention(nn.Module):
    copies = 4

    def __init__(self, heads):
        super().__init__()
        self.heads = heads

    def split(self, x):
        B, T, C = x.shape
        return x.view(B, T, self.heads, C // self.heads).transpose(1, 2)

    def forward(self, q, k, v):
        k, v = self.split(k), self.split(v)
        for _ in range(self.copies):
            rows = self.split(q)
            scores = torch.softmax(rows @ k.transpose(2, 3) * (1 / math.sqrt(rows.shape[3])), 3)
            q = (scores @ v).transpose(1, 2).reshape(q.shape)
        return q


class LayerNorms(nn.Sequential):
    copies = 32

    def __init__(self, channels):
        super().__init__(*(nn.LayerNorm(channels) for _ in range(self.copies)))


class RoiAlign(nn.Module):
    copies = 1

    def __init__(self, out):
        super().__init__()
        self.out = out

    def forward(self, x, boxes):
        return roi_align(x, boxes, self.out, 0.25)


class HandLayer(Hand):
    copies = 1


def layer(text, batch):
    """The module, and its inputs by name"""
    kind, _, pairs = text.partition(":")
    given = {k: int(v) for k, v in (p.split("=") for p in pairs.split(",") if p)}
    if kind == "attention":
        c = dict({"tokens": 1024, "c": 256, "heads": 4}, **given)
        return Attention(c["heads"]), {n: torch.rand(batch, c["tokens"], c["c"]) for n in ("q", "k", "v")}
    if kind == "layer_norm":
        c = dict({"c": 256, "rows": 1024}, **given)
        return LayerNorms(c["c"]), {"input": torch.rand(batch * c["rows"], c["c"])}
    if kind == "roi_align":
        c = dict({"c": 256, "hw": 64, "out": 32}, **given)
        S = 4 * c["hw"]
        box = torch.tensor([[0.2 * S, 0.25 * S, 0.7 * S, 0.75 * S]]).repeat(batch, 1)
        return RoiAlign(c["out"]), {"x": torch.rand(batch, c["c"], c["hw"], c["hw"]), "boxes": box}
    if kind == "hand":
        return HandLayer(), {"R": torch.rand(batch, 16, 3, 3), "beta": torch.rand(batch, 10)}
    raise SystemExit("no layer %s here" % kind)
