# SPDX-License-Identifier: Apache-2.0
"""Single layers in PyTorch, as palmar bench --layer has them: attention, deformable_attention, layer_norm,
roi_align, hand.

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


def deformable_core(value, offset, logit, heads, h, w):
    """The core of multi_scale_deformable_attn_pytorch on one scale: value (B, h w, C), offset (B, T, 2 heads points)
    in cells from each query's own cell, logit (B, T, heads points)"""
    (B, S, C), T, P = value.shape, logit.shape[1], logit.shape[2] // heads
    maps = value.view(B, S, heads, C // heads).permute(0, 2, 3, 1).reshape(B * heads, C // heads, h, w)
    x, y = torch.arange(w, dtype=value.dtype), torch.arange(h, dtype=value.dtype)
    own = torch.stack((x.repeat(h), y.repeat_interleave(w)), 1)
    at = offset.view(B, T, heads, P, 2) + own[None, :, None, None]
    places = (2 * at + 1) / torch.tensor([w, h], dtype=value.dtype) - 1
    seen = nn.functional.grid_sample(maps, places.permute(0, 2, 1, 3, 4).reshape(B * heads, T, P, 2), mode="bilinear",
                                     padding_mode="zeros", align_corners=False)
    share = torch.softmax(logit.view(B, T, heads, P), 3).permute(0, 2, 1, 3).reshape(B * heads, 1, T, P)
    return (seen * share).sum(3).view(B, C, T).transpose(1, 2)


class DeformableAttention(nn.Module):
    copies = 4

    def __init__(self, heads, hw):
        super().__init__()
        self.heads, self.hw = heads, hw

    def forward(self, value, offset, logit):
        for _ in range(self.copies):
            value = deformable_core(value, offset, logit, self.heads, self.hw, self.hw)
        return value


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
    if kind == "deformable_attention":
        c = dict({"hw": 28, "c": 128, "heads": 8, "points": 4}, **given)
        T, places = c["hw"] ** 2, c["heads"] * c["points"]
        return DeformableAttention(c["heads"], c["hw"]), {
            "value": torch.rand(batch, T, c["c"]), "offset": 4 * torch.rand(batch, T, 2 * places) - 2,
            "logit": torch.rand(batch, T, places)}
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
