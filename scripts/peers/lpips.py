# SPDX-License-Identifier: Apache-2.0
"""LPIPS with AlexNet in PyTorch: the twin of models/backbones/lpips.c, with the names of the published files.

Source: Zhang et al. 2018, version 0.1; richzhang/PerceptualSimilarity.
"""
import torch
import torch.nn.functional as F
from torch import nn

TAPS = (0, 3, 6, 8, 10)


class Lpips(nn.Module):
    """image, truth (B, 3, H, W) in [0, 1] -> (B)"""

    def __init__(self):
        super().__init__()
        conv = {"0": nn.Conv2d(3, 64, 11, 4, 2), "3": nn.Conv2d(64, 192, 5, 1, 2), "6": nn.Conv2d(192, 384, 3, 1, 1),
                "8": nn.Conv2d(384, 256, 3, 1, 1), "10": nn.Conv2d(256, 256, 3, 1, 1)}
        self.features = nn.ModuleDict(conv)
        for i, c in enumerate(conv.values()):
            lin = nn.Conv2d(c.out_channels, 1, 1, bias=False)
            self.add_module("lin%d" % i, nn.ModuleDict({"model": nn.ModuleDict({"1": lin})}))
        for p in self.parameters():
            p.requires_grad_(False)

    def taps(self, x, sym):
        shift, scale = (torch.tensor(v, dtype=x.dtype)[:, None, None]
                        for v in ((-.030, -.088, -.188), (.458, .448, .450)))
        x = ((2 * x - 1 if sym else x) - shift) / scale
        out = []
        for i, place in enumerate(TAPS):
            if i in (1, 2):
                x = F.max_pool2d(x, 3, 2)
            x = F.relu(self.features[str(place)](x))
            out.append(x / (x.square().sum(1, keepdim=True).sqrt() + 1e-10))
        return out

    def forward(self, image, truth, sym=True):
        y = 0
        for i, (u, v) in enumerate(zip(self.taps(image, sym), self.taps(truth, sym))):
            lin = getattr(self, "lin%d" % i)["model"]["1"]
            y = y + lin((u - v) ** 2).mean((1, 2, 3))
        return y

    def loss(self, image, truth):
        return self(image, truth).sum()
