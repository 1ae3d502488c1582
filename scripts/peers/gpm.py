# SPDX-License-Identifier: Apache-2.0
"""G-PM's encoder with its heads in PyTorch, on tokens: what palmar bench --model gpm --variant encoder times."""
from torch import nn


class Gpm(nn.Module):
    def __init__(self, width=435, heads=5, ffn=1024, layers=3):
        super().__init__()
        layer = nn.TransformerEncoderLayer(width, heads, ffn, 0., "relu", batch_first=True)
        self.encoder = nn.TransformerEncoder(layer, layers).layers
        self.norm = nn.LayerNorm(width)
        self.translation, self.rotation = self.head(width, 3), self.head(width, 9)

    @staticmethod
    def head(width, out):
        return nn.Sequential(nn.Linear(width, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(),
                             nn.Linear(width, out))

    def forward(self, tokens):
        for layer in self.encoder:
            tokens = layer(tokens)
        tokens = self.norm(tokens)
        return self.translation(tokens).mean(1), self.rotation(tokens).mean(1)
