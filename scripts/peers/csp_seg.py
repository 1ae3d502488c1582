# SPDX-License-Identifier: Apache-2.0
"""The detector csp_seg in PyTorch: the twin of models/detect, with its parameter names.

Losses are written over tables of all cells, by the functions that scripts/vectors/ops.py checks the ops with.
"""
import torch
from torch import nn

SILU = nn.SiLU()


class Conv(nn.Module):
    def __init__(self, i, o, k=1, s=1):
        super().__init__()
        self.conv = nn.Conv2d(i, o, k, s, k // 2, bias=False)
        self.bn = nn.BatchNorm2d(o, 1e-3, 0.03)

    def forward(self, x):
        return SILU(self.bn(self.conv(x)))


class Bottleneck(nn.Module):
    def __init__(self, c, shortcut):
        super().__init__()
        self.cv1, self.cv2, self.shortcut = Conv(c, c, 3), Conv(c, c, 3), shortcut

    def forward(self, x):
        return self.cv2(self.cv1(x)) + (x if self.shortcut else 0)


class C2f(nn.Module):
    def __init__(self, i, o, n, shortcut):
        super().__init__()
        self.cv1, self.cv2 = Conv(i, o), Conv((2 + n) * o // 2, o)
        self.m = nn.ModuleList(Bottleneck(o // 2, shortcut) for _ in range(n))

    def forward(self, x):
        parts = list(self.cv1(x).chunk(2, 1))
        for m in self.m:
            parts.append(m(parts[-1]))
        return self.cv2(torch.cat(parts, 1))


class Sppf(nn.Module):
    def __init__(self, c):
        super().__init__()
        self.cv1, self.cv2, self.pool = Conv(c, c // 2), Conv(2 * c, c), nn.MaxPool2d(5, 1, 2)

    def forward(self, x):
        parts = [self.cv1(x)]
        for _ in range(3):
            parts.append(self.pool(parts[-1]))
        return self.cv2(torch.cat(parts, 1))


class Proto(nn.Module):
    def __init__(self):
        super().__init__()
        self.cv1, self.upsample = Conv(64, 64, 3), nn.ConvTranspose2d(64, 64, 2, 2)
        self.cv2, self.cv3 = Conv(64, 64, 3), Conv(64, 32)

    def forward(self, x):
        return self.cv3(self.cv2(self.upsample(self.cv1(x))))


class Dfl(nn.Module):
    """16 numbers that nothing learns"""

    def __init__(self):
        super().__init__()
        self.conv = nn.Module()
        self.conv.weight = nn.Parameter(torch.arange(16.).view(1, 16, 1, 1))


def branches(middle, out):
    return nn.ModuleList(nn.Sequential(Conv(c, middle, 3), Conv(middle, middle, 3), nn.Conv2d(middle, out, 1))
                         for c in (64, 128, 256))


class Head(nn.Module):
    def __init__(self, classes):
        super().__init__()
        self.box, self.mask, self.proto, self.dfl = branches(64, 64), branches(32, 32), Proto(), Dfl()
        self.add_module("class", branches(max(64, min(classes, 100)), classes))

    def forward(self, p):
        of = [m[i](x) for m in (self.box, getattr(self, "class"), self.mask) for i, x in enumerate(p)]
        return tuple(of) + (self.proto(p[0]),)


class CspSeg(nn.Module):
    """image (B, 3, S, S) -> boxes, classes, masks of strides 8, 16, 32; prototypes"""

    def __init__(self, classes=23):
        super().__init__()
        self.backbone = nn.ModuleList([Conv(3, 16, 3, 2), Conv(16, 32, 3, 2), C2f(32, 32, 1, True), Conv(32, 64, 3, 2),
                                       C2f(64, 64, 2, True), Conv(64, 128, 3, 2), C2f(128, 128, 2, True),
                                       Conv(128, 256, 3, 2), C2f(256, 256, 1, True), Sppf(256)])
        self.neck = nn.ModuleDict({"12": C2f(384, 128, 1, False), "15": C2f(192, 64, 1, False),
                                   "16": Conv(64, 64, 3, 2), "18": C2f(192, 128, 1, False), "19": Conv(128, 128, 3, 2),
                                   "21": C2f(384, 256, 1, False)})
        self.head, self.up = Head(classes), nn.Upsample(scale_factor=2)

    def forward(self, x):
        c = []
        for i, m in enumerate(self.backbone):
            x = m(x)
            if i in (4, 6, 9):
                c.append(x)
        n = self.neck
        down = n["12"](torch.cat([self.up(c[2]), c[1]], 1))
        p3 = n["15"](torch.cat([self.up(down), c[0]], 1))
        p4 = n["18"](torch.cat([n["16"](p3), down], 1))
        p5 = n["21"](torch.cat([n["19"](p4), c[2]], 1))
        return self.head([p3, p4, p5])
