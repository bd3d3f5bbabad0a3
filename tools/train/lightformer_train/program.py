"""Programs: a network as a list of operations on named values (lightformer/net/README.md).

`check` infers domain, level, channels and stage of every value and the shape of every weight, or raises ProgramError
with one line. The table of inputs is lightformer/net/inputs.inc itself.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]

Operation = dict  # {"op": "linear", "in": [...], "out": "...", ...} as in the file

OUTPUTS = ("unshadowed", "direct", "indirect")
ROWS = ("vpl", "texel")
PICTURES = ("pixel", "view")
OF_A_LIGHT = ("light", "vpl", "texel", "view")

ACTIVATIONS = ("none", "relu", "leaky", "sigmoid", "softplus", "tanh")
UNARY = ("relu", "leaky", "sigmoid", "softplus", "tanh", "exp", "log", "log1p", "sqrt", "abs")
BINARY = ("add", "sub", "mul", "div", "min", "max")

# Operation -> its parameters and their types; True where it must be given.
PARAMETERS = {
    "linear": {"name": (str, True), "channels": (int, True), "act": (str, False)},
    "conv": {"name": (str, True), "channels": (int, True), "act": (str, False)},
    "slice": {"from": (int, True), "to": (int, True)},
    "affine": {"scale": (float, True), "offset": (float, True)},
    "clamp": {"low": (float, True), "high": (float, True)},
    "attend": {"heads": (int, True), "gate": (str, True)},
}


class ProgramError(ValueError):
    """A program that breaks the contract; the message names the value."""


@dataclass(frozen=True)
class Value:
    """What is known of a value before any number is."""

    domain: str
    channels: int
    level: int = 0
    gather: bool = False  # belongs to the gather, not to a light's encoding


@dataclass(frozen=True)
class Input(Value):
    """A line of inputs.inc."""

    name: str = ""


def read_inputs(path: Path = ROOT / "lightformer/net/inputs.inc") -> dict[str, Input]:
    """The table of inputs by name, in its order."""
    pattern = re.compile(r'^LF_INPUT\(\w+, "([\w.]+)", (\w+), (\d+), (\w+)\)', re.MULTILINE)
    rows = pattern.findall(path.read_text(encoding="utf-8"))
    return {
        name: Input(domain.lower(), int(channels), 0, when == "GATHER", name) for name, domain, channels, when in rows
    }


def read_inputs_version(path: Path = ROOT / "lightformer/net/inputs.inc") -> str:
    """Of what the table says."""
    found = re.search(r'^#define LF_INPUTS_VERSION "(\w+)"', path.read_text(encoding="utf-8"), re.MULTILINE)
    return found[1] if found else ""


INPUTS = read_inputs()
INPUTS_VERSION = read_inputs_version()


@dataclass
class Checked:
    """A program whose every value and weight is known to fit."""

    operations: list[Operation]
    values: dict[str, Value]
    weights: dict[str, tuple[int, ...]] = field(default_factory=dict)
    inputs: list[str] = field(default_factory=list)  # that it reads

    @property
    def parameters(self) -> int:
        """How many numbers are learned."""
        total = 0
        for shape in self.weights.values():
            count = 1
            for size in shape:
                count *= size
            total += count
        return total


def merge_domains(domains: list[str]) -> str | None:
    """Where an operation on values of these domains lives; None if they do not meet."""
    found = set(domains) - {"frame"}
    if not found:
        return "frame"
    for rows in ROWS:
        if rows in found:
            return rows if found <= {rows, "light"} else None
    if found == {"pixel"} or found == {"light"}:
        return found.pop()
    return "view"


def check(operations: list[Operation]) -> Checked:
    """Infers everything about a program. ProgramError if it is not one."""
    checked = Checked(operations, {})
    for operation in operations:
        try:
            _check_operation(checked, operation)
        except ProgramError as error:
            raise ProgramError(f'operation for "{operation.get("out")}": {error}') from None
    for name in OUTPUTS:
        value = checked.values.get(name)
        if value is None or (value.domain, value.level, value.channels) != ("pixel", 0, 3):
            raise ProgramError(f'output "{name}" must be a picture of 3 channels at level 0')
    return checked


def _check_operation(checked: Checked, operation: Operation) -> None:
    kind, out = operation.get("op"), operation.get("out")
    handler = _HANDLERS.get(kind)
    if handler is None:
        raise ProgramError(f'unknown operation "{kind}"')
    _check_parameters(operation)
    if not isinstance(out, str) or out in checked.values or out in INPUTS:
        raise ProgramError("a value needs a name of its own")
    names = operation.get("in") or []
    if not names:
        raise ProgramError("it reads nothing")
    inputs = [_find(checked, name) for name in names]
    value = handler(checked, operation, inputs)
    gather = value.gather or any(i.gather for i in inputs)
    if gather and value.domain in ROWS:
        raise ProgramError("rows cannot be made of what only the gather knows")
    checked.values[out] = Value(value.domain, value.channels, value.level, gather)


def _check_parameters(operation: Operation) -> None:
    known = PARAMETERS.get(operation["op"], {})
    for key, value in operation.items():
        if key in ("op", "in", "out"):
            continue
        if key not in known:
            raise ProgramError(f'"{operation["op"]}" has no parameter "{key}"')
        accepted = (int, float) if known[key][0] is float else known[key][0]
        if not isinstance(value, accepted) or isinstance(value, bool):
            raise ProgramError(f'parameter "{key}" must be of type {known[key][0].__name__}')
    for key, (_, needed) in known.items():
        if needed and key not in operation:
            raise ProgramError(f'parameter "{key}" is missing')


def _find(checked: Checked, name: str) -> Value:
    value = checked.values.get(name)
    if value is None and name in INPUTS:
        value = INPUTS[name]
        if name not in checked.inputs:
            checked.inputs.append(name)
    if value is None:
        raise ProgramError(f'"{name}" is not written before')
    return value


def _meet(inputs: list[Value]) -> tuple[str, int]:
    """Domain and level of an operation on these."""
    domain = merge_domains([i.domain for i in inputs])
    if domain is None:
        raise ProgramError(f'domains {", ".join(i.domain for i in inputs)} do not meet')
    levels = {i.level for i in inputs if i.domain in PICTURES}
    if len(levels) > 1:
        raise ProgramError(f"levels {sorted(levels)} do not meet")
    return domain, levels.pop() if levels else 0


def _arity(inputs: list[Value], *accepted: int) -> None:
    if len(inputs) not in accepted:
        raise ProgramError(f"it reads {len(inputs)} values, not {' or '.join(map(str, accepted))}")


def _picture(value: Value) -> Value:
    if value.domain not in PICTURES:
        raise ProgramError(f"a picture is needed, not a value of domain {value.domain}")
    return value


def _weights(checked: Checked, operation: Operation, shape: tuple[int, ...]) -> int:
    name, channels = operation["name"], operation["channels"]
    if operation.get("act", "none") not in ACTIVATIONS:
        raise ProgramError(f'unknown activation "{operation["act"]}"')
    if channels < 1 or f"{name}.weight" in checked.weights:
        raise ProgramError(f'weights "{name}" need a name of their own and a channel or more')
    checked.weights[f"{name}.weight"] = (channels, *shape)
    checked.weights[f"{name}.bias"] = (channels,)
    return channels


def _linear(checked: Checked, operation: Operation, inputs: list[Value]) -> Value:
    domain, level = _meet(inputs)
    return Value(domain, _weights(checked, operation, (sum(i.channels for i in inputs),)), level)


def _conv(checked: Checked, operation: Operation, inputs: list[Value]) -> Value:
    domain, level = _meet([_picture(i) for i in inputs])
    return Value(domain, _weights(checked, operation, (sum(i.channels for i in inputs), 3, 3)), level)


def _concat(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    domain, level = _meet(inputs)
    return Value(domain, sum(i.channels for i in inputs), level)


def _slice(_: Checked, operation: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1)
    if not 0 <= operation["from"] < operation["to"] <= inputs[0].channels:
        raise ProgramError(f'channels {operation["from"]} to {operation["to"]} of {inputs[0].channels}')
    return Value(inputs[0].domain, operation["to"] - operation["from"], inputs[0].level)


def _binary(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 2)
    domain, level = _meet(inputs)
    a, b = (i.channels for i in inputs)
    if a != b and 1 not in (a, b):
        raise ProgramError(f"{a} channels do not meet {b}")
    return Value(domain, max(a, b), level)


def _unary(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1)
    return inputs[0]


def _dot(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 2)
    domain, level = _meet(inputs)
    if inputs[0].channels != inputs[1].channels:
        raise ProgramError(f"{inputs[0].channels} channels do not meet {inputs[1].channels}")
    return Value(domain, 1, level)


def _length(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1)
    return Value(inputs[0].domain, 1, inputs[0].level)


def _mean(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1)
    if inputs[0].domain not in ROWS:
        raise ProgramError(f"rows are needed, not a value of domain {inputs[0].domain}")
    return Value("light", inputs[0].channels)


def _pool(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1)
    value = _picture(inputs[0])
    return Value(value.domain, value.channels, value.level + 1)


def _pack(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1)
    value = _picture(inputs[0])
    return Value(value.domain, 4 * value.channels, value.level + 1)


def _finer(value: Value) -> int:
    if _picture(value).level == 0:
        raise ProgramError("nothing is finer than level 0")
    return value.level - 1


def _up(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1)
    return Value(inputs[0].domain, inputs[0].channels, _finer(inputs[0]))


def _unpack(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1)
    if inputs[0].channels % 4:
        raise ProgramError(f"{inputs[0].channels} channels are not four times some")
    return Value(inputs[0].domain, inputs[0].channels // 4, _finer(inputs[0]))


def _check_weight(value: Value) -> None:
    if (value.domain, value.channels) != ("light", 1):
        raise ProgramError("a weight is one number a light")


def _sum(_: Checked, __: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 1, 2)
    for weight in inputs[1:]:
        _check_weight(weight)
    value = inputs[0]
    if value.domain not in ("light", "view"):
        raise ProgramError(f"a sum over lights needs a value of a light, not of domain {value.domain}")
    return Value("pixel" if value.domain == "view" else "frame", value.channels, value.level, True)


def _attend(_: Checked, operation: Operation, inputs: list[Value]) -> Value:
    _arity(inputs, 3, 4)
    for weight in inputs[3:]:
        _check_weight(weight)
    domain, level = _meet(inputs)
    query, key, value = inputs[:3]
    if domain != "view":
        raise ProgramError("query, key and value must meet in a picture of each light")
    if operation["gate"] not in ("sigmoid", "softmax"):
        raise ProgramError(f'unknown gate "{operation["gate"]}"')
    heads = operation["heads"]
    if heads < 1 or query.channels != key.channels or query.channels % heads or value.channels % heads:
        raise ProgramError(f"{query.channels}, {key.channels} and {value.channels} channels do not make {heads} heads")
    return Value("pixel", value.channels, level, True)


_HANDLERS = {
    "linear": _linear,
    "conv": _conv,
    "concat": _concat,
    "slice": _slice,
    "affine": _unary,
    "clamp": _unary,
    "dot": _dot,
    "length": _length,
    "normalize": _unary,
    "mean": _mean,
    "pool": _pool,
    "pack": _pack,
    "up": _up,
    "unpack": _unpack,
    "sum": _sum,
    "attend": _attend,
    **{name: _unary for name in UNARY},
    **{name: _binary for name in BINARY},
}


@dataclass
class Cost:
    """Multiply-adds: of a pixel once a frame, of a pixel for each light, of a row, of a light."""

    pixel: float = 0
    view: float = 0
    vpl: float = 0
    texel: float = 0
    light: float = 0

    def per_pixel(self, lights: int) -> float:
        """Of a pixel of a frame with so many lights."""
        return self.pixel + lights * self.view


def cost(checked: Checked) -> Cost:
    """Counts the matrix products and the attention; what belongs to a narrower domain is computed once there."""
    total = Cost()
    for operation in checked.operations:
        kind = operation["op"]
        inputs = [checked.values.get(name) or INPUTS[name] for name in operation["in"]]
        out = checked.values[operation["out"]]
        if kind in ("linear", "conv"):
            taps = 9 if kind == "conv" else 1
            for value in inputs:
                _add(total, value.domain, taps * value.channels * out.channels / 4**value.level)
        elif kind == "attend":
            _add(total, "view", (inputs[0].channels + inputs[2].channels) / 4**out.level)
    return total


def _add(total: Cost, domain: str, macs: float) -> None:
    if domain != "frame":
        setattr(total, domain, getattr(total, domain) + macs)
