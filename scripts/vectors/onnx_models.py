#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""ONNX files that are not ours, for tests/io/test_onnx: of PyTorch's exporter and of python3-onnx's helpers.

    /usr/bin/python3 scripts/vectors/onnx_models.py          writes tests/vectors/onnx/*.onnx and *.npz

NAME.npz has the inputs, and the outputs of PyTorch in float64.
"""
import os
import warnings

import numpy as np
import onnx
import torch
import torch.nn as nn
import torch.nn.functional as F
from onnx import TensorProto, helper

OUT = os.path.join(os.path.dirname(__file__), "../../tests/vectors/onnx")


class Net(nn.Module):
    """What an exporter writes for a small convolutional network with attention"""

    def __init__(self):
        super().__init__()
        self.conv = nn.Conv2d(3, 4, 3, stride=2, padding=1)
        self.bn = nn.BatchNorm2d(4)
        self.depthwise = nn.Conv2d(4, 4, 3, padding=1, groups=4, bias=False)
        self.fc = nn.Linear(4, 5)

    def forward(self, image):
        x = F.leaky_relu(self.bn(self.conv(image)), 0.1)
        x = x + torch.sigmoid(self.depthwise(x))
        x = F.max_pool2d(x, 2, 2)
        x = F.elu(x) * torch.tanh(x)
        x = F.adaptive_avg_pool2d(x, 1)
        return torch.softmax(self.fc(torch.flatten(x, 1)), -1)


def exported():
    torch.manual_seed(5)
    net = Net().eval()
    for p in net.bn.buffers():
        if p.dtype.is_floating_point:
            p.copy_(torch.rand_like(p) + 0.5)
    image = torch.randn(2, 3, 12, 16)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(net, image, os.path.join(OUT, "torch.onnx"), opset_version=16, input_names=["image"],
                          output_names=["scores"], do_constant_folding=True,
                          training=torch.onnx.TrainingMode.PRESERVE,
                          dynamic_axes={"image": {0: "n"}, "scores": {0: "n"}})
    with torch.no_grad():
        scores = net.double()(image.double())
    np.savez(os.path.join(OUT, "torch.npz"), image=image.numpy(), scores=scores.numpy())


def by_hand():
    """Numbers as float_data and int64_data, which other writers use instead of raw_data"""
    rng = np.random.default_rng(6)
    w, x = rng.normal(size=(4, 3)).astype("f4"), rng.normal(size=(2, 2, 3)).astype("f4")
    nodes = [helper.make_node("Transpose", ["w"], ["wt"], perm=[1, 0]),
             helper.make_node("MatMul", ["x", "wt"], ["y"]),
             helper.make_node("Reshape", ["y", "shape"], ["z"]),
             helper.make_node("Slice", ["z", "starts", "ends", "axes"], ["s"]),
             helper.make_node("Gather", ["s", "index"], ["g"], axis=-1),
             helper.make_node("ReduceSum", ["g", "axes"], ["r"], keepdims=0),
             helper.make_node("Div", ["r", "two"], ["out"])]
    tensors = [helper.make_tensor("w", TensorProto.FLOAT, [4, 3], w.ravel().tolist()),
               helper.make_tensor("shape", TensorProto.INT64, [2], [0, -1]),
               helper.make_tensor("starts", TensorProto.INT64, [1], [1]),
               helper.make_tensor("ends", TensorProto.INT64, [1], [2 ** 62]),
               helper.make_tensor("axes", TensorProto.INT64, [1], [1]),
               helper.make_tensor("index", TensorProto.INT64, [3], [-1, 0, 2]),
               helper.make_tensor("two", TensorProto.FLOAT, [], [2.0])]
    graph = helper.make_graph(nodes, "hand", [helper.make_tensor_value_info("x", TensorProto.FLOAT, [2, 2, 3])],
                              [helper.make_tensor_value_info("out", TensorProto.FLOAT, [2])], tensors)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    onnx.checker.check_model(model, full_check=True)
    onnx.save(model, os.path.join(OUT, "helper.onnx"))
    z = (x.astype("f8") @ w.astype("f8").T).reshape(2, -1)[:, 1:]
    np.savez(os.path.join(OUT, "helper.npz"), x=x, out=z[:, [-1, 0, 2]].sum(1) / 2)


if __name__ == "__main__":
    os.makedirs(OUT, exist_ok=True)
    exported()
    by_hand()
