# SPDX-License-Identifier: Apache-2.0
"""ResNet with bottlenecks in PyTorch: the twin of models/backbones/resnet.c, torchvision's names.

Source: He et al. 2016, "Deep residual learning", table 1; stride on the 3x3 convolution.
"""
import torch.nn.functional as F
from torch import nn


class Bottleneck(nn.Module):
    def __init__(self, channels, planes, stride, slope):
        super().__init__()
        self.slope = slope
        self.conv1 = nn.Conv2d(channels, planes, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(planes)
        self.conv2 = nn.Conv2d(planes, planes, 3, stride, 1, bias=False)
        self.bn2 = nn.BatchNorm2d(planes)
        self.conv3 = nn.Conv2d(planes, 4 * planes, 1, bias=False)
        self.bn3 = nn.BatchNorm2d(4 * planes)
        self.downsample = None
        if stride != 1 or channels != 4 * planes:
            self.downsample = nn.Sequential(nn.Conv2d(channels, 4 * planes, 1, stride, bias=False),
                                            nn.BatchNorm2d(4 * planes))

    def act(self, x):
        return F.leaky_relu_(x, self.slope) if self.slope else F.relu_(x)

    def forward(self, x):
        y = self.act(self.bn1(self.conv1(x)))
        y = self.act(self.bn2(self.conv2(y)))
        return self.act(self.bn3(self.conv3(y)) + (self.downsample(x) if self.downsample else x))


class Trunk(nn.Module):
    """image (B, 3, H, W) -> maps at strides 4, 8, 16, 32"""

    def __init__(self, width=64, blocks=(3, 4, 6, 3), slope=0.0):
        super().__init__()
        self.slope = slope
        self.conv1 = nn.Conv2d(3, width, 7, 2, 3, bias=False)
        self.bn1 = nn.BatchNorm2d(width)
        channels = width
        for s, n in enumerate(blocks):
            planes, stage = width << s, []
            for i in range(n):
                stage.append(Bottleneck(channels, planes, 2 if s and not i else 1, slope))
                channels = 4 * planes
            setattr(self, "layer%d" % (s + 1), nn.Sequential(*stage))
        self.channels = [4 * width << s for s in range(4)]

    def maps(self, image):
        x = self.bn1(self.conv1(image))
        x = F.leaky_relu_(x, self.slope) if self.slope else F.relu_(x)
        x = F.max_pool2d(x, 3, 2, 1)
        out = []
        for s in range(4):
            x = getattr(self, "layer%d" % (s + 1))(x)
            out.append(x)
        return out


class ResNet50(Trunk):
    """image (B, 3, H, W) -> logits (B, classes)"""

    def __init__(self, width=64, blocks=(3, 4, 6, 3), classes=1000):
        super().__init__(width, blocks)
        self.fc = nn.Linear(self.channels[3], classes)

    def forward(self, image):
        return self.fc(self.maps(image)[3].mean((2, 3)))

    def loss(self, image, target):
        return F.mse_loss(self(image), target)
