"""Writes a trained network as ONNX with its sidecar, and proves that the file answers the same."""

import argparse
import json
import os
import pathlib

import numpy as np
import onnx
import onnxruntime
import torch

from network import Segmenter, folded, multiplications, parameters

OPSET = 17
VERSION = "2.1"
# Tensors of at least so many numbers are stored in 16 bits and widened when the model is loaded.
LARGE = 256
LICENCE = "Apache-2.0"


def sidecar(size, calibration):
    """The description that travels with the model, inside it and beside it."""
    return {
        "format": 1,
        "name": "boscage-segmenter",
        "version": VERSION,
        "licence": LICENCE,
        "input": {
            "name": "image",
            "size": [size, size],
            "channels": ["r", "g", "b", "a", "has_alpha"],
            "mean": [0.0, 0.0, 0.0, 0.0, 0.0],
            "std": [1.0, 1.0, 1.0, 1.0, 1.0],
            "padding": "zero",
        },
        "output": {
            "name": "logits",
            "classes": ["background", "trunk", "crown"],
            "activation": "logits",
        },
        "calibration": calibration,
    }


def write_atomically(path, data):
    """Writes bytes so that a reader never sees half of them."""
    part = path.with_suffix(path.suffix + ".part")
    part.write_bytes(data)
    os.replace(part, path)


def rounded(net):
    """The network with its large tensors as 16 bits hold them."""
    for p in net.parameters():
        p.requires_grad_(False)
        if p.numel() >= LARGE:
            p.data = p.data.half().float()
            assert torch.isfinite(p.data).all(), "too large for 16 bits"
    return net


def fuse_paddings(graph):
    """Lets convolutions pad for themselves, unevenly if need be, and drops what nothing needs then."""
    pads = {node.output[0]: node for node in graph.node if node.op_type == "Pad"}
    for node in graph.node:
        if node.op_type != "Conv" or node.input[0] not in pads:
            continue
        attributes = {a.name: a for a in node.attribute}
        total = attributes["kernel_shape"].ints[0] - attributes["strides"].ints[0]
        before = total // 2
        attributes["pads"].ints[:] = [before, before, total - before, total - before]
        node.input[0] = pads[node.input[0]].input[0]
    nodes, needed = [], {output.name for output in graph.output}
    for node in reversed(graph.node):
        if needed.intersection(node.output):
            nodes.insert(0, node)
            needed.update(node.input)
    del graph.node[:]
    graph.node.extend(nodes)
    kept = [tensor for tensor in graph.initializer if tensor.name in needed]
    del graph.initializer[:]
    graph.initializer.extend(kept)


def halve(graph):
    """Stores large tensors in 16 bits, each with a Cast that widens it."""
    casts = []
    for tensor in graph.initializer:
        values = onnx.numpy_helper.to_array(tensor)
        if values.dtype == np.float32 and values.size >= LARGE:
            name = tensor.name
            tensor.CopyFrom(onnx.numpy_helper.from_array(values.astype(np.float16), name + ".half"))
            casts.append(onnx.helper.make_node("Cast", [tensor.name], [name], to=onnx.TensorProto.FLOAT))
    nodes = list(graph.node)
    del graph.node[:]
    graph.node.extend(casts + nodes)


def export(net, size, calibration, folder):
    """Writes segmenter.onnx and segmenter.json into `folder`."""
    folder = pathlib.Path(folder)
    net = rounded(folded(net)).to(memory_format=torch.contiguous_format)
    work = folder / "segmenter.work"
    torch.onnx.export(
        net,
        (torch.zeros(1, 5, size, size),),
        work,
        input_names=["image"],
        output_names=["logits"],
        opset_version=OPSET,
        dynamo=False,
    )
    model = onnx.load(work)
    work.unlink()
    fuse_paddings(model.graph)
    halve(model.graph)
    text = json.dumps(sidecar(size, calibration), indent=2) + "\n"
    onnx.helper.set_model_props(model, {"boscage": text})
    model.producer_name, model.producer_version = "boscage", VERSION
    onnx.checker.check_model(model)
    write_atomically(folder / "segmenter.onnx", model.SerializeToString())
    write_atomically(folder / "segmenter.json", text.encode())
    check(net, size, folder / "segmenter.onnx")


def check(net, size, path):
    """Fails unless ONNX Runtime gives the logits that PyTorch gives."""
    generator = np.random.default_rng(1)
    image = generator.random((1, 5, size, size), dtype=np.float32)
    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    ours = session.run(["logits"], {"image": image})[0]
    with torch.no_grad():
        theirs = net(torch.from_numpy(image)).numpy()
    assert np.abs(ours - theirs).max() < 1e-2 * max(1.0, np.abs(theirs).max()), "the file answers differently"
    print(f"{path}: {path.stat().st_size} bytes, operators {sorted({n.op_type for n in onnx.load(path).graph.node})}")


def main():
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("weights", type=pathlib.Path)
    flags.add_argument("--calibration", type=pathlib.Path, required=True)
    flags.add_argument("--size", type=int, default=256)
    flags.add_argument("--out", type=pathlib.Path, required=True)
    options = flags.parse_args()
    net = Segmenter()
    net.load_state_dict(torch.load(options.weights, weights_only=True))
    net.eval()
    print(f"{parameters(net)} parameters, {multiplications(net, options.size) / 1e6:.0f} M multiply-adds")
    export(net, options.size, json.loads(options.calibration.read_text()), options.out)


if __name__ == "__main__":
    main()
