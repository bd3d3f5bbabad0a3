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
        self.weights = nn.ParameterDict()
        self.last_use = _last_uses(checked.operations)
        for name, shape in checked.weights.items():
            self.weights[_key(name)] = nn.Parameter(torch.empty(shape))
        self.reset()

    def reset(self) -> None:
        """Random weights, as torch.nn.Conv2d begins: uniform within 1 / sqrt(inputs of a channel)."""
        for name, shape in self.checked.weights.items():
            if name.endswith(".weight"):
                bound = math.prod(shape[1:]) ** -0.5
                for part in (name, name.removesuffix("weight") + "bias"):
                    nn.init.uniform_(self.weights[_key(part)], -bound, bound)

    def tensors(self) -> dict[str, Tensor]:
        """Weights by the names of the file."""
        return {name: self.weights[_key(name)].detach().cpu() for name in self.checked.weights}

    def load(self, tensors: Mapping[str, Tensor]) -> None:
        """Takes weights of the file's names; all must be there, of the right shape."""
        self.load_state_dict({f"weights.{_key(name)}": value for name, value in tensors.items()})

    def forward(self, inputs: Mapping[str, Tensor], lights: Lights) -> dict[str, Tensor]:
        """The outputs, in fp32, by name. `inputs` has at least what the program reads, and "pixel.mask"."""
        values: dict[str, Tensor] = {name: inputs[name] for name in self.checked.inputs}
        height, width = inputs["pixel.mask"].shape[-2:]
        if len(lights.owner) == 0:  # black, by contract
            return {name: inputs["pixel.mask"].new_zeros(lights.frames, 3, height, width) for name in OUTPUTS}
        for index, operation in enumerate(self.checked.operations):
            value = self._run(operation, values, lights)
            if operation["op"] in ("up", "unpack"):
                level = self.checked.values[operation["out"]].level
                value = value[..., : _halved(height, level), : _halved(width, level)]
            values[operation["out"]] = value
            for name in self.last_use.get(index, ()):
                del values[name]
        return {name: values[name].float() for name in OUTPUTS}

    def _run(self, operation: Operation, values: Mapping[str, Tensor], lights: Lights) -> Tensor:
        kind = operation["op"]
        inputs = [values[name] for name in operation["in"]]
        domains = [self._domain(name) for name in operation["in"]]
        out = self._domain(operation["out"])
        if kind in ("linear", "conv"):
            return self._product(operation, inputs, domains, out, lights)
        if kind == "mean":
            return _mean(inputs[0], lights.rows.get(domains[0]))
        if kind == "sum":
            return _sum(inputs[0], inputs[1] if len(inputs) > 1 else None, lights)
        if kind == "attend":
            return _attend(operation, inputs, domains, lights)
        if kind in ("concat", "dot", *BINARY):
            return _combine(kind, [_repeat(x, domain, out, lights) for x, domain in zip(inputs, domains)])
        return _TRANSFORMS[kind](inputs[0], operation)

    def _domain(self, name: str) -> str:
        return (self.checked.values.get(name) or INPUTS[name]).domain

    def _product(
        self, operation: Operation, inputs: list[Tensor], domains: list[str], out: str, lights: Lights
    ) -> Tensor:
        weight = self.weights[_key(operation["name"] + ".weight")].to(self.precision)
        bias = self.weights[_key(operation["name"] + ".bias")].to(self.precision)
        columns = weight.split([x.shape[1] for x in inputs], 1)
        inputs, domains = _widen_narrow(inputs, domains, out, lights)
        total = None
        for domain in dict.fromkeys(domains):
            of_domain = [i for i, other in enumerate(domains) if other == domain]
            x = _join([inputs[i].to(self.precision) for i in of_domain])
            part = _multiply(x, _join([columns[i] for i in of_domain]), bias if domain == out else None)
            part = _repeat(part, domain, out, lights)
            total = part if total is None else total + part
        if out not in domains:
            total = total + bias.reshape(-1, *(1,) * (total.dim() - 2))
        return _activate(total, operation.get("act", "none"))


def _key(name: str) -> str:
    """Names of parameters of a module hold no dots."""
    return name.replace(".", "/")


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
    if weight.dim() == 2:
        weight = weight[:, :, None, None]
    x = x.contiguous(memory_format=torch.channels_last)
    weight = weight.contiguous(memory_format=torch.channels_last)
    return F.conv2d(x, weight, bias, padding=weight.shape[-1] // 2)


def _activate(x: Tensor, name: str) -> Tensor:
    if name == "none":
        return x
    if name == "relu":
        return F.relu(x)
    if name == "leaky":
        return F.leaky_relu(x, 0.01)
    return {"sigmoid": torch.sigmoid, "softplus": _softplus, "tanh": torch.tanh}[name](x)


def _softplus(x: Tensor) -> Tensor:
    return F.softplus(x, threshold=EXP_CEILING)


def _repeat(x: Tensor, domain: str, out: str, lights: Lights) -> Tensor:
    """A value as one of a wider domain."""
    if domain == out:
        return x
    if out in ("light", "view", *ROWS) and domain in ("frame", "pixel"):
        x = x.index_select(0, lights.owner)
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
    return x.new_zeros(lights.frames, *x.shape[1:]).index_add(0, lights.owner, x)


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


def _pad_to_even(x: Tensor) -> Tensor:
    height, width = x.shape[-2:]
    return F.pad(x, (0, width % 2, 0, height % 2)) if height % 2 or width % 2 else x


def _length(x: Tensor) -> Tensor:
    x = x.float()
    return torch.sqrt((x * x).sum(1, keepdim=True) + 1e-12)


_TRANSFORMS: dict[str, Callable[[Tensor, Operation], Tensor]] = {
    "slice": lambda x, operation: x[:, operation["from"] : operation["to"]],
    "affine": lambda x, operation: x.float() * operation["scale"] + operation["offset"],
    "clamp": lambda x, operation: x.clamp(operation["low"], operation["high"]),
    "relu": lambda x, _: F.relu(x),
    "leaky": lambda x, _: F.leaky_relu(x, 0.01),
    "sigmoid": lambda x, _: torch.sigmoid(x.float()),
    "softplus": lambda x, _: _softplus(x.float()),
    "tanh": lambda x, _: torch.tanh(x.float()),
    "exp": lambda x, _: torch.exp(x.float().clamp_max(EXP_CEILING)),
    "log": lambda x, _: torch.log(x.float().clamp_min(LOG_FLOOR)),
    "log1p": lambda x, _: torch.log1p(x.float()),
    "sqrt": lambda x, _: torch.sqrt(x.float().clamp_min(LOG_FLOOR)),
    "abs": lambda x, _: x.abs(),
    "length": lambda x, _: _length(x),
    "normalize": lambda x, _: x.float() / _length(x),
    "pool": lambda x, _: F.avg_pool2d(x, 2, ceil_mode=True, count_include_pad=False),
    "pack": lambda x, _: F.pixel_unshuffle(_pad_to_even(x), 2),
    "up": lambda x, _: F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False),
    "unpack": lambda x, _: F.pixel_shuffle(x, 2),
}
