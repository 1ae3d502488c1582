# SPDX-License-Identifier: Apache-2.0
"""The re-identification network reid in PyTorch: the twin of models/reid, with its parameter names; tf: as TensorFlow
has it, which pads a stride of 2 over an even map behind, and flattens the channels of each cell."""
import torch
from torch import nn
from torch.nn import functional as F


class Conv(nn.Module):
    def __init__(self, i, o, s=1, tf=False):
        super().__init__()
        self.conv, self.bn, self.tf = nn.Conv2d(i, o, 3, s, 1, bias=False), nn.BatchNorm2d(o), tf

    def forward(self, x):
        if self.tf and self.conv.stride == (2, 2) and x.shape[2] % 2 == 0:
            return F.elu(self.bn(F.conv2d(F.pad(x, (0, 1, 0, 1)), self.conv.weight, None, 2)))
        return F.elu(self.bn(self.conv(x)))


class Plain(nn.Module):
    def __init__(self, c):
        super().__init__()
        self.conv = nn.Conv2d(c, c, 3, 1, 1)


class Unit(nn.Module):
    def __init__(self, i, o, first, dropout, tf):
        super().__init__()
        if not first:
            self.pre = nn.BatchNorm2d(i)
        self.add_module("1", Conv(i, o, 1 if i == o else 2, tf))
        self.add_module("2", Plain(o))
        if i != o:
            self.projection = nn.Conv2d(i, o, 1, 2, bias=False)
        self.dropout = dropout

    def forward(self, x):
        n = dict(self.named_children())
        y = n["1"](F.elu(self.pre(x)) if "pre" in n else x)
        y = n["2"].conv(F.dropout(y, self.dropout, self.training))
        return y + (self.projection(x) if "projection" in n else x)


class Fc(nn.Module):
    def __init__(self):
        super().__init__()
        self.weight = nn.Parameter(torch.empty(128, 16384).uniform_(-1 / 128, 1 / 128))
        self.bn = nn.BatchNorm1d(128)

    def forward(self, x):
        return F.elu(self.bn(F.linear(x, self.weight)))


class CosineSoftmax(nn.Module):
    def __init__(self, identities):
        super().__init__()
        self.weight, self.scale = nn.Parameter(torch.randn(identities, 128)), nn.Parameter(torch.zeros(1, 1))

    def forward(self, r):
        return F.softplus(self.scale) * F.linear(r, F.normalize(self.weight))


class Reid(nn.Module):
    def __init__(self, identities=0, dropout=0.4, tf=False):
        super().__init__()
        self.conv1_1, self.conv1_2 = Conv(3, 32), Conv(32, 32)
        for k, (name, i, o) in enumerate((("conv2_1", 32, 32), ("conv2_3", 32, 32), ("conv3_1", 32, 64),
                                          ("conv3_3", 64, 64), ("conv4_1", 64, 128), ("conv4_3", 128, 128))):
            self.add_module(name, Unit(i, o, k == 0, dropout, tf))
        self.fc1, self.ball = Fc(), nn.BatchNorm1d(128)
        if identities:
            self.softmax = CosineSoftmax(identities)
        self.dropout, self.tf = dropout, tf
        for m in self.modules():
            if tf and isinstance(m, (nn.BatchNorm1d, nn.BatchNorm2d)):
                m.eps = 1e-3

    def forward(self, image):
        x = F.max_pool2d(self.conv1_2(self.conv1_1(255 * image)), 3, 2, 0 if self.tf else 1)
        for m in (self.conv2_1, self.conv2_3, self.conv3_1, self.conv3_3, self.conv4_1, self.conv4_3):
            x = m(x)
        x = x.permute(0, 2, 3, 1) if self.tf else x
        x = F.dropout(x.flatten(1), self.dropout, self.training)
        return F.normalize(self.ball(self.fc1(x)))

    def loss(self, image, identity, weight):
        rows = -(identity * F.log_softmax(self.softmax(self(image)), 1)).sum(1)
        return (rows * weight).sum() / weight.sum()
