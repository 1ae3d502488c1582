# SPDX-License-Identifier: Apache-2.0
"""EfficientNet-B0 in PyTorch: the twin of models/backbones/efficientnet.c, torchvision's names.

Source: Tan and Le 2019, "EfficientNet", table 1.
"""
import torch
import torch.nn.functional as F
from torch import nn

#         expand k stride out blocks
STAGES = ((1, 3, 1, 16, 1), (6, 3, 2, 24, 2), (6, 5, 2, 40, 2), (6, 3, 2, 80, 3),
          (6, 5, 1, 112, 3), (6, 5, 2, 192, 4), (6, 3, 1, 320, 1))


def conv_bn(channels, out, k, stride=1, groups=1, act=True):
    layers = [nn.Conv2d(channels, out, k, stride, (k - 1) // 2, groups=groups, bias=False), nn.BatchNorm2d(out)]
    return nn.Sequential(*layers, *([nn.SiLU(inplace=True)] if act else []))


class Gate(nn.Module):
    def __init__(self, channels, narrow):
        super().__init__()
        self.fc1 = nn.Conv2d(channels, narrow, 1)
        self.fc2 = nn.Conv2d(narrow, channels, 1)

    def forward(self, x):
        return x * torch.sigmoid(self.fc2(F.silu(self.fc1(F.adaptive_avg_pool2d(x, 1)))))


class Block(nn.Module):
    def __init__(self, channels, expand, k, stride, out, drop):
        super().__init__()
        hidden = expand * channels
        parts = [conv_bn(channels, hidden, 1)] if expand > 1 else []
        parts += [conv_bn(hidden, hidden, k, stride, hidden), Gate(hidden, max(1, channels // 4)),
                  conv_bn(hidden, out, 1, act=False)]
        self.block = nn.Sequential(*parts)
        self.residual = stride == 1 and channels == out
        self.drop = drop

    def forward(self, x):
        y = self.block(x)
        if not self.residual:
            return y
        if self.training and self.drop:
            keep = torch.rand(len(x), 1, 1, 1, dtype=x.dtype) >= self.drop
            y = y * (keep / (1 - self.drop))
        return y + x


class EfficientNetB0(nn.Module):
    """image (B, 3, H, W) -> logits (B, classes)"""

    def __init__(self, classes=1000, dropout=0.2, stochastic_depth=0.2):
        super().__init__()
        features, channels, first = [conv_bn(3, 32, 3, 2)], 32, 0
        for expand, k, stride, out, n in STAGES:
            stage = []
            for i in range(n):
                drop = stochastic_depth * (first + i) / 16
                stage.append(Block(channels, expand, k, 1 if i else stride, out, drop))
                channels = out
            features.append(nn.Sequential(*stage))
            first += n
        self.features = nn.Sequential(*features, conv_bn(channels, 1280, 1))
        self.classifier = nn.Sequential(nn.Dropout(dropout), nn.Linear(1280, classes))

    def forward(self, image):
        return self.classifier(self.features(image).mean((2, 3)))

    def loss(self, image, target):
        return F.mse_loss(self(image), target)
