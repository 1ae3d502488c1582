# SPDX-License-Identifier: Apache-2.0
"""CLIP's image tower in PyTorch: the twin of models/backbones/vit.c, with its parameter names.

Source: Radford et al. 2021; openai/CLIP clip/model.py.
"""
import torch
import torch.nn.functional as F
from torch import nn

#        image  patch width layers heads
SIZES = {"b32": (224, 32, 768, 12, 12), "s16": (224, 16, 384, 12, 6), "tiny": (112, 16, 192, 6, 3)}


class Attention(nn.Module):
    def __init__(self, width, heads):
        super().__init__()
        self.heads = heads
        self.q, self.k, self.v, self.out = (nn.Linear(width, width) for _ in range(4))

    def forward(self, x):
        B, T, C = x.shape
        q, k, v = (l(x).view(B, T, self.heads, -1).transpose(1, 2) for l in (self.q, self.k, self.v))
        y = torch.softmax(q @ k.transpose(2, 3) * (C // self.heads) ** -0.5, 3) @ v
        return self.out(y.transpose(1, 2).reshape(B, T, C))


class Block(nn.Module):
    def __init__(self, width, heads):
        super().__init__()
        self.norm1, self.norm2 = nn.LayerNorm(width), nn.LayerNorm(width)
        self.attn = Attention(width, heads)
        self.mlp = nn.ModuleDict({"fc1": nn.Linear(width, 4 * width), "fc2": nn.Linear(4 * width, width)})

    def forward(self, x):
        x = x + self.attn(self.norm1(x))
        h = self.mlp["fc1"](self.norm2(x))
        return x + self.mlp["fc2"](h * torch.sigmoid(1.702 * h))


class Embed(nn.Module):
    def __init__(self, image, patch, width):
        super().__init__()
        self.patch = nn.Conv2d(3, width, patch, patch, bias=False)
        self.class_token = nn.Parameter(0.02 * torch.randn(width))
        self.position = nn.Parameter(0.02 * torch.randn(1 + (image // patch) ** 2, width))

    def forward(self, x):
        x = self.patch(x).flatten(2).transpose(1, 2)
        return torch.cat([self.class_token.expand(len(x), 1, -1), x], 1) + self.position


class Vit(nn.Module):
    """image (B, 3, S, S) -> feature (B, C), patches (B, cells^2, C)"""

    def __init__(self, variant="b32"):
        super().__init__()
        image, patch, width, layers, heads = SIZES[variant]
        self.embed = Embed(image, patch, width)
        self.norm_pre = nn.LayerNorm(width)
        self.blocks = nn.Sequential(*[Block(width, heads) for _ in range(layers)])
        self.norm = nn.LayerNorm(width)

    def forward(self, image):
        x = self.blocks(self.norm_pre(self.embed(image)))
        return self.norm(x[:, 0]), x[:, 1:]

    def loss(self, image, target):
        return F.mse_loss(self(image)[0], target)
