#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""ONNX files that are not ours, for tests/io/test_onnx: of PyTorch's exporter and of python3-onnx's helpers.

    /usr/bin/python3 scripts/vectors/onnx_models.py          writes tests/vectors/onnx/*.onnx and *.npz

NAME.npz has the inputs, and the outputs: of PyTorch 1.13 in float64 for networks, of ONNX Runtime for operators (the
npm package onnxruntime-node, as scripts/bench-peers fetches it).
"""
import json
import os
import subprocess
import tempfile
import warnings

import numpy as np
import onnx
import torch
import torch.nn as nn
import torch.nn.functional as F
from onnx import TensorProto, helper, numpy_helper
from torchvision.models.efficientnet import EfficientNet, MBConvConfig
from torchvision.models.mobilenetv2 import MobileNetV2
from torchvision.models.mobilenetv3 import InvertedResidualConfig, MobileNetV3
from torchvision.models.resnet import BasicBlock, Bottleneck, ResNet
from torchvision.models.vision_transformer import VisionTransformer

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


# ---- torchvision's networks, thin -----------------------------------------------------------------------------------

class ThinResNet(ResNet):
    def __init__(self, block):
        super().__init__(block, [1, 1, 1, 1])
        self.fc = nn.Linear(32 * block.expansion, 5)

    def _make_layer(self, block, planes, blocks, stride=1, dilate=False):
        return super()._make_layer(block, planes // 16, blocks, stride, dilate)


def thin_networks():
    """name, network, operator set, size, whether the exporter computes what is constant"""
    mb = [MBConvConfig(1, 3, 1, 8, 8, 1, 1, 1), MBConvConfig(4, 5, 2, 8, 12, 2, 1, 1)]
    v3 = [InvertedResidualConfig(8, 3, 8, 8, True, "RE", 2, 1, 1),
          InvertedResidualConfig(8, 5, 24, 12, True, "HS", 2, 1, 1)]
    vit = dict(image_size=16, patch_size=8, num_layers=1, num_heads=2, hidden_dim=16, mlp_dim=32, num_classes=5)
    yield "resnet-11", ThinResNet(BasicBlock), 11, 64, True
    yield "resnet-17", ThinResNet(Bottleneck), 17, 64, False
    yield "mobilenet_v2-12", MobileNetV2(5, .25, [[1, 8, 1, 1], [6, 8, 2, 2]]), 12, 32, True
    yield ("efficientnet-14", EfficientNet(mb, .2, num_classes=5, norm_layer=lambda n: nn.BatchNorm2d(n, 1e-3)), 14, 32,
           False)
    yield "mobilenet_v3-13", MobileNetV3(v3, 32, 5), 13, 32, True
    yield "mobilenet_v3-16", MobileNetV3(v3, 32, 5), 16, 32, False
    yield "vit-11", VisionTransformer(**vit), 11, 16, True
    yield "vit-13", VisionTransformer(**vit), 13, 16, False
    yield "vit-17", VisionTransformer(**vit), 17, 16, True


def settle(net, size):
    """Statistics that a trained network would have: those of what it sees"""
    net.train()
    for m in net.modules():
        if isinstance(m, nn.BatchNorm2d):
            m.momentum = None
            nn.init.normal_(m.weight, 1, .1)
            nn.init.normal_(m.bias, 0, .1)
    if isinstance(net, VisionTransformer):
        nn.init.normal_(net.heads.head.weight, 0, .1)
    with torch.no_grad():
        for _ in range(4):
            net(torch.randn(16, 3, size, size))
    return net.eval()


def networks():
    torch.manual_seed(7)
    for name, net, opset, size, fold in thin_networks():
        settle(net, size)
        image = torch.randn(2, 3, size, size)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            torch.onnx.export(net, image, os.path.join(OUT, name + ".onnx"), opset_version=opset, input_names=["image"],
                              output_names=["scores"], do_constant_folding=fold,
                              dynamic_axes={"image": {0: "batch"}, "scores": {0: "batch"}})
        with torch.no_grad():
            scores = net.double()(image.double())
        np.savez(os.path.join(OUT, name + ".npz"), image=image.numpy(), scores=scores.numpy())


# ---- operators, each by itself --------------------------------------------------------------------------------------

RUN = """
const ort = require("onnxruntime-node"), fs = require("fs"), folder = process.argv[1];
(async () => {
    const session = await ort.InferenceSession.create(folder + "/model.onnx", { graphOptimizationLevel: "disabled" });
    const feeds = {}, out = {};
    for (const [name, dims] of Object.entries(JSON.parse(process.argv[2]))) {
        const bytes = fs.readFileSync(folder + "/" + name + ".f32");
        const numbers = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
        feeds[name] = new ort.Tensor("float32", numbers, dims);
    }
    for (const [name, t] of Object.entries(await session.run(feeds))) {
        const bytes = Buffer.from(t.data.buffer, t.data.byteOffset, t.data.byteLength);
        fs.writeFileSync(folder + "/" + name + ".out", bytes);
        out[name] = t.dims;
    }
    console.log(JSON.stringify(out));
})();
"""
MODULES = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "palmar-peers/node_modules")


def runtime(model, inputs):
    """What ONNX Runtime makes of it"""
    with tempfile.TemporaryDirectory() as folder:
        onnx.save(model, os.path.join(folder, "model.onnx"))
        for name, x in inputs.items():
            x.tofile(os.path.join(folder, name + ".f32"))
        shapes = json.dumps({n: x.shape for n, x in inputs.items()})
        said = subprocess.run(["node", "-e", RUN, folder, shapes], check=True, env=dict(os.environ, NODE_PATH=MODULES),
                              stdout=subprocess.PIPE, text=True).stdout
        return {n: np.fromfile(os.path.join(folder, n + ".out"), "<f4").reshape(d) for n, d in json.loads(said).items()}


class Sheet:
    """Many small graphs in one: each ends in an output of its own"""

    def __init__(self, opset):
        self.opset, self.nodes, self.tensors, self.outputs = opset, [], [], []

    def of(self, op, *inputs, n_out=1, **attrs):
        """A node's result, or results; arrays among its inputs are constants of the file"""
        names = []
        for x in inputs:
            if isinstance(x, (list, np.ndarray, np.generic)):
                name = "k%d" % len(self.tensors)
                x = np.array(x, "i8") if isinstance(x, list) else np.array(x)
                self.tensors.append(numpy_helper.from_array(x, name))
                x = name
            names.append(x)
        out = ["v%d_%d" % (len(self.nodes), i) for i in range(n_out)]
        self.nodes.append(helper.make_node(op, names, out, name="n%d" % len(self.nodes), **attrs))
        return out[0] if n_out == 1 else out

    def show(self, value):
        self.outputs.append(self.of("Mul", value, np.float32(1)))

    def save(self, name, inputs):
        values = [helper.make_tensor_value_info(n, TensorProto.FLOAT, x.shape) for n, x in inputs.items()]
        outs = [helper.make_tensor_value_info(n, TensorProto.FLOAT, None) for n in self.outputs]
        graph = helper.make_graph(self.nodes, name, values, outs, self.tensors)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", self.opset)])
        model.ir_version = 7
        onnx.save(model, os.path.join(OUT, name + ".onnx"))
        np.savez(os.path.join(OUT, name + ".npz"), **inputs, **runtime(model, inputs))


def f(*x):
    return np.array(x, "f4")


def old_sheet(s):
    """As sets 11 and 12 say it: axes and lengths are attributes"""
    s.show(s.of("Squeeze", s.of("Unsqueeze", "x", axes=[0, -1]), axes=[0]))
    s.show(s.of("ReduceMean", "x", axes=[2, 3], keepdims=0))
    s.show(s.of("ReduceMean", "x", axes=[-1]))
    s.show(s.of("ReduceMean", "x"))
    s.show(s.of("ReduceSum", "x", axes=[1, 3]))
    s.show(s.of("Softmax", "x"))
    s.show(s.of("Softmax", "x", axis=2))
    for piece in s.of("Split", "x", axis=3, split=[2, 1, 2], n_out=3):
        s.show(piece)
    for piece in s.of("Split", "x", axis=2, n_out=2):
        s.show(piece)
    s.show(s.of("Dropout", "x", ratio=.3) if s.opset < 12 else s.of("Dropout", "x", np.float32(.3), n_out=2)[0])
    s.show(s.of("Pow", "m", np.float32(2)))
    s.show(s.of("Clip", "x", "", np.float32(.5)))


def window_sheet(s):
    """Maps: what is said though it is the default, borders that differ, and those that a file leaves to count"""
    w = np.linspace(-1, 1, 2 * 3 * 3 * 3, dtype="f4").reshape(2, 3, 3, 3)
    s.show(s.of("Conv", "x", w, f(1, 2), dilations=[1, 1], group=1, kernel_shape=[3, 3], pads=[1, 1, 1, 1],
                strides=[1, 1], auto_pad="NOTSET"))
    s.show(s.of("Conv", "x", w, pads=[1, 0, 2, 1], strides=[2, 2]))
    s.show(s.of("Conv", "x", w, auto_pad="SAME_UPPER", strides=[2, 2]))
    s.show(s.of("Conv", "x", w, auto_pad="SAME_LOWER", strides=[2, 2]))
    s.show(s.of("Conv", "x", w, auto_pad="VALID"))
    s.show(s.of("ConvTranspose", "x", w.transpose(1, 0, 2, 3), dilations=[1, 1], group=1, output_padding=[0, 0],
                auto_pad="NOTSET", strides=[2, 2]))
    s.show(s.of("MaxPool", "x", kernel_shape=[3, 3], strides=[2, 2], dilations=[1, 1], storage_order=0, ceil_mode=0,
                pads=[1, 1, 1, 1], auto_pad="NOTSET"))
    s.show(s.of("MaxPool", "x", kernel_shape=[2, 2], strides=[2, 2], auto_pad="SAME_UPPER"))
    s.show(s.of("MaxPool", "x", kernel_shape=[3, 3], strides=[2, 2], pads=[0, 1, 2, 0]))
    if s.opset >= 13:
        s.show(s.of("Resize", "x", "", f(1, 1, 2, 3), mode="linear",
                    coordinate_transformation_mode="pytorch_half_pixel", cubic_coeff_a=-.75,
                    nearest_mode="floor", exclude_outside=0, extrapolation_value=0.))
        s.show(s.of("Resize", "x", "", "", [2, 3, 7, 3], mode="linear", coordinate_transformation_mode="half_pixel"))
        s.show(s.of("Resize", "x", "", "", [2, 3, 8, 10], coordinate_transformation_mode="asymmetric",
                    nearest_mode="floor"))
    s.show(s.of("Pad", "x", [0, 0, 1, 2, 0, 0, 0, 1], np.float32(7)))
    s.show(s.of("Pad", "x", [0, 1, 0, -1, 0, 0, -1, 2], mode="constant"))
    s.show(s.of("Pad", "x", [0, 0, 2, 3, 0, 0, 1, 4], mode="reflect"))
    s.show(s.of("Pad", "x", [1, 0, 2, 0, 0, 0, 0, 6], mode="edge"))


def product_sheet(s):
    b, column, row = (np.linspace(-1, 1, n, dtype="f4") for n in (3 * 5 * 2, 5, 4))
    s.show(s.of("MatMul", "x", b.reshape(3, 5, 2)))
    s.show(s.of("MatMul", b.reshape(3, 2, 5), s.of("Transpose", "x", perm=[0, 1, 3, 2])))
    s.show(s.of("MatMul", s.of("Slice", "x", [0], [1], [1]), b.reshape(1, 3, 5, 2)))
    s.show(s.of("MatMul", "x", column))
    s.show(s.of("MatMul", row, "x"))
    s.show(s.of("MatMul", column, column))
    a = s.of("Reshape", "x", [6, 20], **({"allowzero": 1} if s.opset >= 14 else {}))
    w = np.linspace(-1, 1, 60, dtype="f4").reshape(20, 3)
    s.show(s.of("Gemm", a, w, f(1, 2, 3).reshape(1, 3), alpha=1., beta=1., transA=0, transB=0))
    s.show(s.of("Gemm", a, w, np.float32(2), alpha=.5, beta=3.))
    s.show(s.of("Gemm", a, w, np.arange(18, dtype="f4").reshape(6, 3), beta=.5))
    s.show(s.of("Gemm", s.of("Transpose", a), w, f(1, 2, 3, 4, 5, 6).reshape(6, 1), transA=1, alpha=2.))
    s.show(s.of("Gemm", a, w.T, f(1), transB=1))


def element_sheet(s):
    s.show(s.of("Max", "x", "y", np.float32(0)))
    s.show(s.of("Min", "x", "y", "m"))
    s.show(s.of("Sum", "x", "y", "m"))
    s.show(s.of("Max", "x"))
    s.show(s.of("Clip", "x", np.float32(-.5), np.float32(.5)))
    s.show(s.of("Clip", "x"))
    s.show(s.of("HardSigmoid", "x", alpha=1 / 6))
    s.show(s.of("HardSigmoid", "x", beta=.25))
    s.show(s.of("HardSwish", s.of("Mul", "x", np.float32(3))))
    s.show(s.of("Pow", "m", np.float32(2)))
    s.show(s.of("Pow", s.of("Mul", "m", "m"), f(.5)))
    s.show(s.of("Pow", "x", f(1, 2, 3, 0, 2)))
    s.show(s.of("Where", s.of("Equal", s.of("Cast", "x", to=TensorProto.INT64), np.int64(0)), "x", np.float32(9)))
    s.show(s.of("Where", np.array([[[True]], [[False]], [[True]]]), "m", "x"))
    s.show(s.of("Cast", s.of("Cast", s.of("Max", "x", np.float32(0)), to=TensorProto.BOOL), to=TensorProto.FLOAT))
    s.show(s.of("Softmax", "x", axis=1))
    if s.opset >= 17:
        s.show(s.of("LayerNormalization", "x", f(1, 2, 3, 4, 5), axis=-1, stash_type=1, epsilon=1e-5))
        s.show(s.of("LayerNormalization", "x", np.linspace(0, 1, 20, dtype="f4").reshape(4, 5),
                    np.linspace(1, 2, 20, dtype="f4").reshape(4, 5), axis=2))


def shape_sheet(s):
    """What exporters count with: sizes that come of sizes"""
    one = s.of("Constant", value=numpy_helper.from_array(np.array(1)))
    n = s.of("Gather", s.of("Shape", "x"), one, axis=0)
    minus_six = s.of("Div", s.of("Constant", value_int=20), s.of("Constant", value_int=-3))
    some = [s.of("Unsqueeze", v, [0]) for v in (n, minus_six)]
    six = s.of("Mul", some[1], [-1])
    s.show(s.of("Reshape", "x", s.of("Concat", some[0], [4], s.of("Sub", six, s.of("Add", [0], [1])), [2], axis=0)))
    minus = s.of("Mul", s.of("ConstantOfShape", [4], value=helper.make_tensor("v", TensorProto.INT64, [1], [1])), [-1])
    wish = s.of("Constant", value_ints=[-1, -1, 4, 5])
    ones = s.of("ConstantOfShape", s.of("Shape", wish), value=helper.make_tensor("v", TensorProto.INT64, [1], [1]))
    s.show(s.of("Expand", "m", s.of("Where", s.of("Equal", wish, minus), ones, wish)))
    s.show(s.of("Expand", "x", s.of("Max", [3, 1, 1, 1, 1], s.of("Min", [1], [9]))))
    s.show(s.of("Add", "x", s.of("ConstantOfShape", [4, 1])))
    s.show(s.of("Add", "x", s.of("ConstantOfShape", [5], value=helper.make_tensor("v", TensorProto.FLOAT, [1], [1.5]))))
    s.show(s.of("Add", "x", s.of("Constant", value_floats=[1., 2., 3., 4., 5.])))
    s.show(s.of("Mul", "x", s.of("Constant", value_float=.5)))
    s.show(s.of("Reshape", "x", s.of("Slice", s.of("Concat", s.of("Shape", "x"), [-1], axis=0), [0], [9], [0], [4])))
    three = s.of("Range", np.int64(0), np.int64(3), np.int64(1))
    s.show(s.of("Cast", s.of("Expand", three, [2, 3]), to=TensorProto.FLOAT))
    s.show(s.of("Squeeze", s.of("Unsqueeze", "x", [1, -1]), [1]))
    s.show(s.of("Gather", "x", np.int64(-1), axis=2))
    s.show(s.of("Gather", "x", np.array([[0, 1], [-1, 2]]), axis=1))
    s.show(s.of("Slice", "x", [0, 0], [4, 5], [2, 3], [1, 1]))
    s.show(s.of("Slice", "x", [0], [5], [3], [2]))
    s.show(s.of("Slice", "x", [-1, 9], [-9, 0], [2, 3], [-1, -3]))
    s.show(s.of("Flatten", "x", axis=0))
    s.show(s.of("Flatten", "x", axis=-1))
    s.show(s.of("Flatten", "x", axis=4))
    s.show(s.of("ReduceSum", "x", keepdims=0))
    s.show(s.of("ReduceSum", "x", noop_with_empty_axes=1))
    s.show(s.of("ReduceSum", "x", [-1, 1], noop_with_empty_axes=0))
    for piece in s.of("Split", "x", [1, 3], axis=2, n_out=2):
        s.show(piece)
    if s.opset < 20:
        s.show(s.of("ReduceMean", "x", axes=[-1, -2], keepdims=1))
        return
    s.show(s.of("ReduceMean", "x", [-1, -2], keepdims=1, noop_with_empty_axes=0))
    for piece in s.of("Split", "x", axis=3, num_outputs=3, n_out=3):
        s.show(piece)
    s.show(s.of("Pad", "x", [1, 2, 0, 1], np.float32(1), [3, 1]))
    s.show(s.of("Gelu", "x", approximate="none"))


def operators():
    rng = np.random.default_rng(8)
    sizes = {"x": (2, 3, 4, 5), "y": (2, 3, 4, 5), "m": (4, 5)}
    inputs = {n: rng.normal(size=size).astype("f4") for n, size in sizes.items()}
    for opset, sheets in ((11, (old_sheet, window_sheet)), (12, (old_sheet, )),
                          (13, (window_sheet, product_sheet, shape_sheet)), (14, (element_sheet, )),
                          (17, (window_sheet, product_sheet, element_sheet, shape_sheet)),
                          (20, (shape_sheet, ))):
        s = Sheet(opset)
        for sheet in sheets:
            sheet(s)
        s.save("operators-%d" % opset, inputs)


if __name__ == "__main__":
    os.makedirs(OUT, exist_ok=True)
    exported()
    by_hand()
    networks()
    operators()
