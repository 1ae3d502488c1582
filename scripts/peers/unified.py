# SPDX-License-Identifier: Apache-2.0
"""The unified RGB-D estimator in PyTorch: the twin of models/unified, full variant, with its parameter names."""
import torch
import torch.nn.functional as F
from torch import nn

from efficientnet import STAGES, Block, conv_bn
from hocat import POINTS, Bottleneck, Hand, Mano, ObjectHead, hand_object_loss
from layers import deformable_core

MARGIN = 2


class Stream(nn.Module):
    """EfficientNet-B0's first stages, the last of them without its stride: (B, 80, S / 8, S / 8)"""

    def __init__(self, channels, stochastic_depth):
        super().__init__()
        features, width, first = [conv_bn(channels, 32, 3, 2)], 32, 0
        for s, (expand, k, stride, out, n) in enumerate(STAGES[:4]):
            stage = []
            for i in range(n):
                stage.append(Block(width, expand, k, 1 if i or s == 3 else stride, out, stochastic_depth * (first + i) / 16))
                width = out
            features.append(nn.Sequential(*stage))
            first += n
        self.features = nn.Sequential(*features)

    def forward(self, x):
        return self.features(x)


class AdaptiveAttention(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.channel = nn.Linear(channels, channels, bias=False)
        self.spatial = nn.Conv2d(channels, 1, 3, 1, 1)

    def forward(self, x):
        return x * torch.sigmoid(self.channel(x.mean((2, 3))))[:, :, None, None] * self.spatial(F.relu(x))


class EncoderLayer(nn.Module):
    def __init__(self, width, heads, points, cells, dropout):
        super().__init__()
        self.heads, self.cells, self.dropout = heads, cells, dropout
        self.offsets, self.weights = nn.Linear(width, 2 * heads * points), nn.Linear(width, heads * points)
        self.value, self.output = nn.Linear(width, width), nn.Linear(width, width)
        self.norm1, self.norm2 = nn.LayerNorm(width), nn.LayerNorm(width)
        self.linear1, self.linear2 = nn.Linear(width, 4 * width), nn.Linear(4 * width, width)

    def drop(self, x):
        return F.dropout(x, self.dropout, self.training)

    def forward(self, x):
        seen = deformable_core(self.value(x), self.offsets(x), self.weights(x), self.heads, self.cells, self.cells)
        x = self.norm1(x + self.drop(self.output(seen)))
        return self.norm2(x + self.drop(self.linear2(self.drop(F.relu(self.linear1(x))))))


class DeformableEncoder(nn.Module):
    def __init__(self, cells, channels, width, layers, heads, points, dropout):
        super().__init__()
        self.position = nn.Parameter(0.02 * torch.randn(cells * cells, channels))
        self.embed = nn.Linear(channels, 2 * width)
        self.layers = nn.ModuleList(EncoderLayer(2 * width, heads, points, cells, dropout) for _ in range(layers))
        self.head1, self.head2 = nn.Linear(2 * width, 2 * width), nn.Linear(2 * width, width)
        self.norm = nn.LayerNorm(width)

    def forward(self, tokens):
        x = self.embed(tokens + self.position)
        for layer in self.layers:
            x = layer(x)
        return self.norm(self.head2(F.relu(self.head1(x))))


class CrossSide(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.q, self.k, self.v = (nn.Linear(width, width) for _ in range(3))


class CrossAttention(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.hand, self.object = CrossSide(width), CrossSide(width)

    @staticmethod
    def see(own, x, its, other):
        scores = torch.softmax(own.q(x) @ its.k(other).transpose(1, 2) * x.shape[2] ** -0.5, 2)
        return scores @ its.v(other) + x

    def forward(self, h, o):
        return self.see(self.hand, h, self.object, o), self.see(self.object, o, self.hand, h)


class ConvNorm(nn.Module):
    def __init__(self, conv):
        super().__init__()
        self.conv, self.bn = conv, nn.BatchNorm2d(conv.out_channels)

    def forward(self, x):
        return F.relu(self.bn(self.conv(x)))


class Hourglass(nn.Module):
    def __init__(self, cells, c):
        super().__init__()
        self.cells = cells
        for i in range(3):
            setattr(self, "conv%d" % (i + 1), ConvNorm(nn.Conv2d(c << i, c << i, 3, 1, 1, bias=False)))
            setattr(self, "down%d" % (i + 1), ConvNorm(nn.Conv2d(c << i, c << i + 1, 1, bias=False)))
        self.bottleneck = Bottleneck(8 * c)
        self.up1 = ConvNorm(nn.ConvTranspose2d(8 * c, 4 * c, 3 if cells // 4 % 2 else 4, 2, 1, bias=False))
        self.up2 = ConvNorm(nn.ConvTranspose2d(4 * c, 2 * c, 4, 2, 1, bias=False))
        self.up3 = nn.ConvTranspose2d(2 * c, POINTS, 6, 2)
        self.temperature = nn.Parameter(torch.ones(POINTS))

    def forward(self, x):
        """encoding, heat maps, places (B, 21, 2) in units of the map without its margin"""
        kept = []
        for i in (1, 2, 3):
            kept.append(getattr(self, "conv%d" % i)(x))
            x = getattr(self, "down%d" % i)(F.max_pool2d(kept[-1], 2, ceil_mode=True))
        x = self.up1(self.bottleneck(x)) + kept[2]
        encoding = self.up2(x) + kept[1]
        logits = self.up3(encoding)
        heat = torch.softmax(logits.flatten(2) * self.temperature[:, None], 2).view(logits.shape)
        cell = (torch.arange(logits.shape[3], dtype=x.dtype) + 0.5 - MARGIN) / self.cells
        return encoding, heat, torch.stack([(heat.sum(2) * cell).sum(2), (heat.sum(3) * cell).sum(2)], 2)


class MeshEncoder(nn.Module):
    def __init__(self, cells, c):
        super().__init__()
        self.heatmap_conv = nn.Conv2d(POINTS, c, 6, 2)
        self.mix = nn.Conv2d(3 * c, 4 * c, 1)
        levels, side = 0, cells // 2
        while side > 2:
            levels, side = levels + 1, (side + 1) // 2
        self.reg = nn.ModuleList(nn.Sequential(Bottleneck(4 * c), Bottleneck(4 * c)) for _ in range(levels))

    def forward(self, heat, encoding):
        x = self.mix(torch.cat([encoding, self.heatmap_conv(heat)], 1))
        for level in self.reg:
            x = F.max_pool2d(level(x), 2, ceil_mode=True)
        return x.flatten(1)


class Unified(nn.Module):
    """image (B, 3, S, S), depth (B, 1, S, S) -> joints2d, rotation, beta, vertices, joints, conf, x, y"""

    def __init__(self, size=224, width=64, layers=3, heads=8, points=4, dropout=0.1, stochastic_depth=0.2, hand=None):
        super().__init__()
        self.cells = cells = size // 8
        self.rgb, self.depth = Stream(3, stochastic_depth), Stream(1, stochastic_depth)
        self.aaf = nn.ModuleDict({"rgb": AdaptiveAttention(80), "depth": AdaptiveAttention(80)})
        self.hand_encoder, self.object_encoder = (
            DeformableEncoder(cells, 80, width, layers, heads, points, dropout) for _ in range(2))
        self.cross = CrossAttention(width)
        self.hourglass = Hourglass(cells, width)
        self.mesh_encoder = MeshEncoder(cells, width)
        self.mano = Mano(16 * width, 16 * width, 8 * width)
        self.object_head = ObjectHead(width, 3)
        self.hand = Hand(hand)

    def to_map(self, tokens):
        return tokens.transpose(1, 2).reshape(len(tokens), -1, self.cells, self.cells)

    def forward(self, image, depth):
        mean, deviation = (torch.tensor(v, dtype=image.dtype)[:, None, None]
                           for v in ((0.485, 0.456, 0.406), (0.229, 0.224, 0.225)))
        fused = self.aaf["rgb"](self.rgb((image - mean) / deviation)) + self.aaf["depth"](self.depth(depth))
        tokens = fused.flatten(2).transpose(1, 2)
        h, o = self.cross(self.hand_encoder(tokens), self.object_encoder(tokens))
        encoding, heat, joints2d = self.hourglass(self.to_map(h))
        rotation, beta = self.mano(self.mesh_encoder(heat, encoding))
        vertices, joints = self.hand(rotation, beta)
        return (joints2d, rotation, beta, vertices, joints) + self.object_head(self.to_map(o))

    def loss(self, image, depth, *truth):
        return hand_object_loss(self.hand, self(image, depth), *truth)
