"""Writes programs: each method appends one operation and returns the name of its result."""

from .program import Operation


class Builder:
    """A program in the making. Results are named after their weights or by number."""

    def __init__(self) -> None:
        self.operations: list[Operation] = []

    def apply(self, op: str, *inputs: str, out: str | None = None, **parameters: object) -> str:
        """Any operation."""
        out = out or parameters.get("name") or f"v{len(self.operations)}"
        self.operations.append({"op": op, "in": list(inputs), "out": out, **parameters})
        return str(out)

    def linear(self, name: str, inputs: list[str], channels: int, act: str = "leaky") -> str:
        return self.apply("linear", *inputs, name=name, channels=channels, act=act)

    def conv(self, name: str, inputs: list[str], channels: int, act: str = "leaky") -> str:
        return self.apply("conv", *inputs, name=name, channels=channels, act=act)

    def mlp(self, name: str, inputs: list[str], widths: list[int], last: str = "leaky", act: str = "leaky") -> str:
        """Linear layers of these widths, the last with an activation of its own."""
        for index, width in enumerate(widths):
            final = index == len(widths) - 1
            inputs = [self.linear(f"{name}.{index}", inputs, width, last if final else act)]
        return inputs[0]

    def affine(self, x: str, scale: float = 1.0, offset: float = 0.0) -> str:
        return self.apply("affine", x, scale=scale, offset=offset)

    def log_radiance(self, x: str, unit: float) -> str:
        """log(1 + x / unit)."""
        return self.apply("log1p", self.affine(x, 1 / unit))

    def pool(self, x: str, times: int = 1) -> str:
        for _ in range(times):
            x = self.apply("pool", x)
        return x

    def up(self, x: str, times: int = 1) -> str:
        for _ in range(times):
            x = self.apply("up", x)
        return x
