"""Runs a program in PyTorch: what lightformer/net does in C, for batches of frames, with gradients.

The lights of all frames of a batch lie one after another; `Lights.owner` says whose each is, so frames of a batch may
have any number of lights and nothing is computed for lights that do not exist. Shapes, by domain (B frames, N lights
in all, P rows):

    frame [B, C]   light [N, C]   vpl, texel [N, C, P, 1]   pixel [B, C, h, w]   view [N, C, h, w]

Products run in the type of `precision`, as 1 x 1 or 3 x 3 convolutions in channels-last order (on CPUs several times
faster than matrix products by torch.nn.Linear); what is of a narrower domain is multiplied once there and then
repeated. What only passes features on (activations of products, pool, up, pack, add, sum, ...) keeps the type that it
gets, all else is fp32; so is what is made of inputs alone.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from . import kernels
from .program import BINARY, INPUTS, OUTPUTS, PICTURES, ROWS, Checked, Operation

LOG_FLOOR = 1e-12
EXP_CEILING = 30.0
NARROW = 8  # channels


@dataclass
class Lights:
    """Which frame each light belongs to, and which rows of it exist."""

    frames: int
    owner: Tensor  # [N], of type long, not descending
    rows: Mapping[str, Tensor]  # "vpl", "texel" -> [N, 1, P, 1] of 0 and 1; none: all exist


class Network(nn.Module):
    """A checked program with weights."""

    def __init__(self, checked: Checked, precision: torch.dtype = torch.float32) -> None:
        super().__init__()
        self.checked = checked
        self.precision = precision
        self.last_use = _last_uses(checked.operations)
        self.unpacked = _products_to_unpack(checked)
        self.cuts = _cuts(checked)
        self.parameter = nn.Parameter(torch.empty(checked.parameters))
        self.reset()

    def split(self, parameter: Tensor) -> dict[str, Tensor]:
        """The weights in the one parameter, or in what is like it."""
        shapes = self.checked.weights
        parts = parameter.split([math.prod(shape) for shape in shapes.values()])
        return {name: part.view(shape) for (name, shape), part in zip(shapes.items(), parts)}

    def reset(self) -> None:
        """Random weights, as torch.nn.Conv2d begins: uniform within 1 / sqrt(inputs of a channel)."""
        weights = self.split(self.parameter.data)
        for name, shape in self.checked.weights.items():
            if name.endswith(".weight"):
                bound = math.prod(shape[1:]) ** -0.5
                for part in (name, name.removesuffix("weight") + "bias"):
                    weights[part].uniform_(-bound, bound)

    def tensors(self) -> dict[str, Tensor]:
        """Weights by the names of the file."""
        return self.split(self.parameter.detach().cpu())

    def load(self, tensors: Mapping[str, Tensor]) -> None:
        """Takes weights of the file's names; all must be there, of the right shape."""
        shapes = {name: tuple(value.shape) for name, value in tensors.items()}
        if shapes != self.checked.weights:
            wrong = sorted(shapes.items() ^ self.checked.weights.items())
            raise ValueError(f'weight "{wrong[0][0]}" is missing, not of the program, or of another shape')
        for name, value in self.split(self.parameter.data).items():
            value.copy_(tensors[name])

    def forward(self, inputs: Mapping[str, Tensor], lights: Lights) -> dict[str, Tensor]:
        """The outputs, in fp32, by name. `inputs` has at least what the program reads, and "pixel.mask"."""
        values: dict[str, Tensor] = {name: inputs[name] for name in self.checked.inputs}
        height, width = inputs["pixel.mask"].shape[-2:]
        if len(lights.owner) == 0:  # black, by contract
            return {name: inputs["pixel.mask"].new_zeros(lights.frames, 3, height, width) for name in OUTPUTS}
        weights = self.split(self.parameter.to(self.precision))
        self._cut(values, self.checked.inputs)
        for index, operation in enumerate(self.checked.operations):
            value = self._run(operation, values, weights, lights)
            if operation["op"] in ("up", "unpack"):
                level = self.checked.values[operation["out"]].level
                value = value[..., : _halved(height, level), : _halved(width, level)]
            values[operation["out"]] = value
            self._cut(values, [operation["out"]])
            for name in self.last_use.get(index, ()):
                del values[name]
        return {name: values[name].float() for name in OUTPUTS}

    def _run(
        self, operation: Operation, values: Mapping[str, Tensor], weights: Mapping[str, Tensor], lights: Lights
    ) -> Tensor:
        kind = operation["op"]
        inputs = [values[name] for name in operation["in"]]
        domains = [self._domain(name) for name in operation["in"]]
        out = self._domain(operation["out"])
        if kind in ("linear", "conv"):
            return self._product(operation, weights, inputs, domains, lights)
        if kind == "unpack" and operation["in"][0] in self.unpacked:
            return kernels.unpack_blocks(inputs[0])
        if kind == "slice":
            return values[_piece(operation["in"][0], operation["from"], operation["to"])]
        if kind == "mean":
            return _mean(inputs[0], lights.rows.get(domains[0]))
        if kind == "sum":
            return _sum(inputs[0], inputs[1] if len(inputs) > 1 else None, lights)
        if kind == "attend":
            return _attend(operation, inputs, domains, lights)
        if kind in ("concat", "dot", *BINARY):
            return _combine(kind, [_repeat(x, domain, out, lights) for x, domain in zip(inputs, domains)])
        return _TRANSFORMS[kind](inputs[0], operation)

    def _cut(self, values: dict[str, Tensor], names: list[str]) -> None:
        """Adds all slices of values at once, so that their gradients are joined once."""
        for name in names:
            spans = self.cuts.get(name, ())
            if not spans:
                continue
            x = kernels.planes(values[name])
            ends = sorted({0, x.shape[1], *(end for span in spans for end in span)})
            parts = dict(zip(zip(ends, ends[1:]), x.split([b - a for a, b in zip(ends, ends[1:])], 1)))
            for first, last in spans:
                values[_piece(name, first, last)] = parts.get((first, last), x[:, first:last])

    def _domain(self, name: str) -> str:
        return (self.checked.values.get(name) or INPUTS[name]).domain

    def _product(
        self,
        operation: Operation,
        weights: Mapping[str, Tensor],
        inputs: list[Tensor],
        domains: list[str],
        lights: Lights,
    ) -> Tensor:
        weight, bias = (weights[f"{operation['name']}.{part}"] for part in ("weight", "bias"))
        if operation["out"] in self.unpacked:
            weight, bias = (x.unflatten(0, (-1, 4)).transpose(0, 1).flatten(0, 1) for x in (weight, bias))
        out = self._domain(operation["out"])
        columns = weight.split([x.shape[1] for x in inputs], 1)
        inputs, domains = _widen_narrow(inputs, domains, out, lights)
        total = None
        for (domain, _), alike in _alike(inputs, domains).items():
            x = _join([inputs[i].to(self.precision) for i in alike])
            part = _multiply(x, _join([columns[i] for i in alike]), bias if domain == out else None)
            bias = None if domain == out else bias  # added once
            part = _repeat(part, domain, out, lights)
            total = part if total is None else total + part
        if bias is not None:
            total = total + bias.reshape(-1, *(1,) * (total.dim() - 2))
        return _activate(total, operation.get("act", "none"))


def _halved(size: int, level: int) -> int:
    return -(-size // 2**level)


def _join(parts: list[Tensor]) -> Tensor:
    """One after another by channel."""
    if len(parts) == 1:
        return parts[0]
    if parts[0].dim() == 4:
        size = torch.broadcast_shapes(*(part.shape[2:] for part in parts))
        parts = [part.expand(*part.shape[:2], *size) for part in parts]
    return torch.cat(parts, 1)


def _products_to_unpack(checked: Checked) -> set[str]:
    """Results of products that are only unpacked: rows of their weights are put in the order that makes this a copy of
    whole pixels."""
    readers: dict[str, list[str]] = {}
    for operation in checked.operations:
        for name in operation["in"]:
            readers.setdefault(name, []).append(operation["op"])
    return {
        operation["out"]
        for operation in checked.operations
        if operation["op"] == "linear" and readers.get(operation["out"]) == ["unpack"]
    }


def _cuts(checked: Checked) -> dict[str, list[tuple[int, int]]]:
    """What is sliced of which values."""
    cuts: dict[str, list[tuple[int, int]]] = {}
    for operation in checked.operations:
        if operation["op"] == "slice":
            cuts.setdefault(operation["in"][0], []).append((operation["from"], operation["to"]))
    return cuts


def _piece(name: str, first: int, last: int) -> str:
    return f"{name}[{first}:{last}]"


def _alike(inputs: list[Tensor], domains: list[str]) -> dict[tuple[str, bool], list[int]]:
    """Inputs that are multiplied together: of one domain, and channels-last or not, since to bring these together costs
    more than another product."""
    alike: dict[tuple[str, bool], list[int]] = {}
    for i, (x, domain) in enumerate(zip(inputs, domains)):
        alike.setdefault((domain, kernels.is_channels_last(x)), []).append(i)
    return alike


def _last_uses(operations: list[Operation]) -> dict[int, list[str]]:
    """After which operation a value may be forgotten."""
    last = {name: index for index, operation in enumerate(operations) for name in (*operation["in"], operation["out"])}
    uses: dict[int, list[str]] = {}
    for name, index in last.items():
        if name not in OUTPUTS:
            uses.setdefault(index, []).append(name)
    return uses


def _widen_narrow(inputs: list[Tensor], domains: list[str], out: str, lights: Lights) -> tuple[list[Tensor], list[str]]:
    """A few channels of pixels are repeated for each light before the product: cheaper than a product of their own,
    whose result would be repeated and added."""
    channels = sum(x.shape[1] for x, domain in zip(inputs, domains) if domain == "pixel")
    if out != "view" or "view" not in domains or channels > NARROW:
        return inputs, domains
    inputs = [_repeat(x, domain, out, lights) if domain == "pixel" else x for x, domain in zip(inputs, domains)]
    return inputs, ["view" if domain == "pixel" else domain for domain in domains]


def _multiply(x: Tensor, weight: Tensor, bias: Tensor | None) -> Tensor:
    if x.dim() == 2:
        return F.linear(x, weight, bias)
    if x.shape[2] == 0:  # no row
        return x.new_zeros(x.shape[0], weight.shape[0], 0, 1)
    return kernels.multiply(x.contiguous(memory_format=torch.channels_last), weight, bias)


def _activate(x: Tensor, name: str) -> Tensor:
    """Of a sum of products, which nothing else reads."""
    if name == "none":
        return x
    if name == "relu":
        return F.relu_(x)
    if name == "leaky":
        return F.leaky_relu_(x, 0.01)
    return {"sigmoid": torch.sigmoid, "softplus": _softplus, "tanh": torch.tanh}[name](x)


def _softplus(x: Tensor) -> Tensor:
    return F.softplus(x, threshold=EXP_CEILING)


def _repeat(x: Tensor, domain: str, out: str, lights: Lights) -> Tensor:
    """A value as one of a wider domain."""
    if domain == out:
        return x
    if out in ("light", "view", *ROWS) and domain in ("frame", "pixel"):
        x = kernels.of_lights(x, lights.owner)
    if x.dim() == 2 and out in (*PICTURES, *ROWS):
        x = x[:, :, None, None]
    return x


def _combine(kind: str, inputs: list[Tensor]) -> Tensor:
    if kind == "concat":
        return _join(inputs)
    a, b = inputs
    if kind == "dot":
        return (a.float() * b.float()).sum(1, keepdim=True)
    return _BINARY[kind](a, b)


_BINARY = {
    "add": torch.add,
    "sub": torch.sub,
    "mul": torch.mul,
    "div": torch.div,
    "min": torch.minimum,
    "max": torch.maximum,
}


def _mean(x: Tensor, exists: Tensor | None) -> Tensor:
    """Over the rows; of no row: 0."""
    x = x.float()
    if exists is None:
        return x.sum((2, 3)) / max(x.shape[2], 1)
    return (x * exists).sum((2, 3)) / exists.sum((2, 3)).clamp_min(1)


def _sum(x: Tensor, weight: Tensor | None, lights: Lights) -> Tensor:
    """Over the lights of each frame."""
    if weight is not None:
        x = x * weight.reshape(-1, *(1,) * (x.dim() - 1)).to(x.dtype)
    return kernels.over_lights(x, lights.owner, lights.frames)


def _attend(operation: Operation, inputs: list[Tensor], domains: list[str], lights: Lights) -> Tensor:
    query, key, value = (_repeat(x, d, "view", lights).float() for x, d in zip(inputs[:3], domains[:3]))
    heads = operation["heads"]
    scores = _heads(query, heads) * _heads(key, heads)
    scores = scores.sum(2) / math.sqrt(query.shape[1] // heads)  # [N, heads, h, w]
    gate = torch.sigmoid(scores) if operation["gate"] == "sigmoid" else torch.exp(scores - _largest(scores, lights))
    if len(inputs) > 3:
        gate = gate * inputs[3][:, :, None, None]
    if operation["gate"] == "softmax":
        gate = gate / _sum(gate, None, lights).clamp_min(1e-30)[lights.owner]
    weighted = _heads(value, heads) * gate[:, :, None]
    return _sum(weighted.flatten(1, 2), None, lights)


def _heads(x: Tensor, heads: int) -> Tensor:
    return x.reshape(x.shape[0], heads, -1, *x.shape[2:])


def _largest(scores: Tensor, lights: Lights) -> Tensor:
    """Of each frame's lights, for each of them."""
    counts = torch.bincount(lights.owner, minlength=lights.frames).tolist()
    parts = [part.amax(0, keepdim=True).expand_as(part) for part in scores.detach().split(counts) if len(part)]
    return torch.cat(parts) if parts else scores


def _affine(x: Tensor, scale: float, offset: float) -> Tensor:
    x = kernels.planes(x) * scale if scale != 1 else kernels.planes(x)
    return x + offset if offset else x


def _length(x: Tensor) -> Tensor:
    x = kernels.planes(x)
    return torch.sqrt((x * x).sum(1, keepdim=True) + 1e-12)


_TRANSFORMS: dict[str, Callable[[Tensor, Operation], Tensor]] = {
    "affine": lambda x, operation: _affine(x, operation["scale"], operation["offset"]),
    "clamp": lambda x, operation: x.clamp(operation["low"], operation["high"]),
    "relu": lambda x, _: F.relu(x),
    "leaky": lambda x, _: F.leaky_relu(x, 0.01),
    "sigmoid": lambda x, _: torch.sigmoid(kernels.planes(x)),
    "softplus": lambda x, _: _softplus(kernels.planes(x)),
    "tanh": lambda x, _: torch.tanh(kernels.planes(x)),
    "exp": lambda x, _: torch.exp(kernels.planes(x).clamp_max(EXP_CEILING)),
    "log": lambda x, _: torch.log(kernels.planes(x).clamp_min(LOG_FLOOR)),
    "log1p": lambda x, _: torch.log1p(kernels.planes(x)),
    "sqrt": lambda x, _: torch.sqrt(kernels.planes(x).clamp_min(LOG_FLOOR)),
    "abs": lambda x, _: x.abs(),
    "length": lambda x, _: _length(x),
    "normalize": lambda x, _: kernels.planes(x) / _length(x),
    "pool": lambda x, _: kernels.halve(x),
    "pack": lambda x, _: kernels.pack(x),
    "up": lambda x, _: kernels.double(x),
    "unpack": lambda x, _: F.pixel_shuffle(x, 2),
}
