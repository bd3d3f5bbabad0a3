"""Operations whose gradients PyTorch takes slowly on CPUs, and their gradients by hand.

Pictures are channels-last throughout, so that a picture is a matrix of pixels by channels, and a batch a matrix of
frames (or lights) by all that a frame has; neither costs a copy.
"""

from functools import lru_cache

import torch
import torch.nn.functional as F
from torch import Tensor

PARTS = 64  # of products over all pixels of a batch


def is_channels_last(x: Tensor) -> bool:
    """Whether the channels of a pixel lie one after another, as products leave them; false if both orders are one."""
    return x.dim() == 4 and not x.is_contiguous() and x.is_contiguous(memory_format=torch.channels_last)


def planes(x: Tensor) -> Tensor:
    """In fp32, channel after channel: what is computed outside of products is fastest so."""
    return x.contiguous().float()


def rows_of(x: Tensor) -> Tensor:
    """[B, C, h, w] as [B h w, C]."""
    return x.permute(0, 2, 3, 1).reshape(-1, x.shape[1])


def multiply(x: Tensor, weight: Tensor, bias: Tensor | None) -> Tensor:
    """1 x 1 or 3 x 3 convolution of pictures in channels-last order."""
    if weight.dim() == 2:
        return _Multiply.apply(x, weight, bias)
    return F.conv2d(x, weight.contiguous(memory_format=torch.channels_last), bias, padding=weight.shape[-1] // 2)


class _Multiply(torch.autograd.Function):
    """Forward as a convolution, which is faster than a matrix product; backward as matrix products, which are faster
    than its gradients."""

    @staticmethod
    def forward(ctx, x: Tensor, weight: Tensor, bias: Tensor | None) -> Tensor:
        ctx.save_for_backward(x, weight)
        return F.conv2d(x, weight[:, :, None, None], bias)

    @staticmethod
    def backward(ctx, gradient: Tensor) -> tuple[Tensor | None, ...]:
        x, weight = ctx.saved_tensors
        of_x = of_weight = of_bias = None
        rows = rows_of(gradient)
        if ctx.needs_input_grad[0]:
            of_x = torch.mm(rows, weight).view(x.shape[0], *x.shape[2:], -1).permute(0, 3, 1, 2)
        if ctx.needs_input_grad[1]:
            of_weight = _sum_of_products(rows, rows_of(x))
        if ctx.needs_input_grad[2]:
            of_bias = rows.sum(0)
        return of_x, of_weight, of_bias


def _sum_of_products(a: Tensor, b: Tensor) -> Tensor:
    """The transpose of a times b, of many rows: in parts, which stay in the cache."""
    if len(a) % PARTS or len(a) < PARTS * 256:
        return torch.mm(a.t(), b)
    a, b = (x.view(PARTS, -1, x.shape[1]) for x in (a, b))
    return torch.bmm(a.transpose(1, 2), b).float().sum(0).to(a.dtype)


def of_lights(x: Tensor, owner: Tensor) -> Tensor:
    """Each light's frame's value: [B, ...] to [N, ...]."""
    return _OfLights.apply(x, owner)


def over_lights(x: Tensor, owner: Tensor, frames: int) -> Tensor:
    """The sum over each frame's lights: [N, ...] to [B, ...]."""
    return _OverLights.apply(x, owner, frames)


class _OfLights(torch.autograd.Function):
    @staticmethod
    def forward(ctx, x: Tensor, owner: Tensor) -> Tensor:
        ctx.owner, ctx.frames = owner, len(x)
        return _select(x, owner)

    @staticmethod
    def backward(ctx, gradient: Tensor) -> tuple[Tensor, None]:
        return _add_up(gradient, ctx.owner, ctx.frames), None


class _OverLights(torch.autograd.Function):
    @staticmethod
    def forward(ctx, x: Tensor, owner: Tensor, frames: int) -> Tensor:
        ctx.owner = owner
        return _add_up(x, owner, frames)

    @staticmethod
    def backward(ctx, gradient: Tensor) -> tuple[Tensor, None, None]:
        return _select(gradient, ctx.owner), None, None


def _select(x: Tensor, owner: Tensor) -> Tensor:
    flat, shape = _flatten(x)
    return _unflatten(flat.index_select(0, owner), shape)


def _add_up(x: Tensor, owner: Tensor, frames: int) -> Tensor:
    flat, shape = _flatten(x)
    return _unflatten(flat.new_zeros(frames, flat.shape[1]).index_add_(0, owner, flat), shape)


def _flatten(x: Tensor) -> tuple[Tensor, tuple[tuple[int, ...], bool]]:
    """As a matrix, in the order of memory, and what undoes it."""
    last = is_channels_last(x)
    if last:
        x = x.permute(0, 2, 3, 1)
    return x.reshape(len(x), -1), (x.shape[1:], last)


def _unflatten(flat: Tensor, shape: tuple[tuple[int, ...], bool]) -> Tensor:
    x = flat.view(len(flat), *shape[0])
    return x.permute(0, 3, 1, 2) if shape[1] else x


def double(x: Tensor) -> Tensor:
    """Twice the size, bilinear."""
    return _Double.apply(x)


class _Double(torch.autograd.Function):
    """The gradient as two products with small matrices, one of rows and one of columns."""

    @staticmethod
    def forward(ctx, x: Tensor) -> Tensor:
        return F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)

    @staticmethod
    def backward(ctx, gradient: Tensor) -> Tensor:
        batch, channels, height, width = gradient.shape
        by_rows, by_columns = (_halving(size, gradient.dtype, gradient.device) for size in (height, width))
        x = gradient.permute(0, 2, 3, 1).reshape(batch, height, width * channels)
        x = torch.matmul(by_rows, x).view(batch * height // 2, width, channels)
        x = torch.matmul(by_columns, x).view(batch, height // 2, width // 2, channels)
        return x.permute(0, 3, 1, 2)


@lru_cache(maxsize=64)
def _halving(size: int, dtype: torch.dtype, device: torch.device) -> Tensor:
    """[size / 2, size]: the transpose of bilinear doubling."""
    doubled = F.interpolate(torch.eye(size // 2)[None], scale_factor=2, mode="linear", align_corners=False)
    return doubled[0].to(device, dtype)


def halve(x: Tensor) -> Tensor:
    """Means of 2 x 2, at odd edges of what is there."""
    if is_channels_last(x):
        return F.avg_pool2d(x, 2, ceil_mode=True, count_include_pad=False)
    return _Halve.apply(pad_to_even(x, "replicate"))


class _Halve(torch.autograd.Function):
    """Of planes: sums of every other row and column."""

    @staticmethod
    def forward(ctx, x: Tensor) -> Tensor:
        rows = x[..., 0::2, :] + x[..., 1::2, :]
        return (rows[..., 0::2] + rows[..., 1::2]).mul_(0.25)

    @staticmethod
    def backward(ctx, gradient: Tensor) -> Tensor:
        quarter = (gradient * 0.25)[..., :, None, :, None]
        return quarter.expand(*gradient.shape[:-1], 2, gradient.shape[-1], 2).flatten(-2).flatten(-3, -2)


def pad_to_even(x: Tensor, mode: str = "constant") -> Tensor:
    height, width = x.shape[-2:]
    return F.pad(x, (0, width % 2, 0, height % 2), mode) if height % 2 or width % 2 else x


def pack(x: Tensor) -> Tensor:
    """2 x 2 pixels into channels, each channel's four one after another."""
    x = pad_to_even(x)
    batch, channels, height, width = x.shape
    blocks = x.reshape(batch, channels, height // 2, 2, width // 2, 2)
    return blocks.permute(0, 1, 3, 5, 2, 4).reshape(batch, 4 * channels, height // 2, width // 2)


def unpack_blocks(x: Tensor) -> Tensor:
    """The inverse of `pack` where the channels of each of the four pixels lie one after another: rows of pixels are
    copied whole."""
    batch, channels, height, width = x.shape
    pairs = x.permute(0, 2, 3, 1).reshape(batch, height, width, 2, channels // 2)
    rows = pairs.permute(0, 1, 3, 2, 4).reshape(batch, 2 * height, 2 * width, channels // 4)
    return rows.permute(0, 3, 1, 2)
