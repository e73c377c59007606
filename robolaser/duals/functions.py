"""Rules for duals of NumPy's functions of whole arrays; importing this module registers them."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.duals.dual import FUNCTIONS, Dual, Indices, after, bare, bilinear, joined, padded, union


def _concatenate(parts: Sequence[Any], axis: int = 0) -> Dual:
    value = np.concatenate([bare(part) for part in parts], axis=axis)
    lengths = [part.shape[axis] for part in parts]
    ends = np.cumsum(lengths).tolist()
    places = [slice(end - length, end) for end, length in zip(ends, lengths, strict=True)]
    return _side_by_side(value, parts, places, axis)


def _stack(parts: Sequence[Any], axis: int = 0) -> Dual:
    return _side_by_side(np.stack([bare(part) for part in parts], axis=axis), parts, range(len(parts)), axis)


def _side_by_side(value: Array, parts: Sequence[Any], places: Sequence[int | slice], axis: int) -> Dual:
    """A dual with its parts at positions along an axis."""
    of: Indices = ()
    for part in parts:
        if isinstance(part, Dual):
            of = union(of, part.of)[0]
    slopes = np.zeros((len(of), *value.shape))
    along = np.moveaxis(slopes, after(axis), 1)
    for place, part in zip(places, parts, strict=True):
        if isinstance(part, Dual):
            own = part.slopes if isinstance(place, int) else np.moveaxis(part.slopes, after(axis), 1)
            along[union(of, part.of)[2], place] = own
    return Dual(value, slopes, of)


def _where(condition: Any, one: Any, other: Any) -> Any:
    condition = np.asarray(bare(condition), dtype=bool)
    value = np.where(condition, bare(one), bare(other))
    terms = [
        (part.of, np.where(condition == chosen, padded(part.slopes, value.ndim), 0.0))
        for part, chosen in ((one, True), (other, False))
        if isinstance(part, Dual)
    ]
    return joined(value, terms) if terms else value


def _einsum(subscripts: str, *operands: Any) -> Dual:
    inputs, arrow, output = subscripts.replace(" ", "").partition("->")
    if not arrow:
        raise TypeError(f'np.einsum of arrays with derivatives needs "->" and its output, too, not only "{inputs}".')
    value = np.einsum(subscripts, *(bare(one) for one in operands))
    terms = []
    for i, one in enumerate(operands):
        if isinstance(one, Dual):
            at = [one.slopes if i == j else bare(other) for j, other in enumerate(operands)]
            names = ",".join(f"Z{name}" if i == j else name for j, name in enumerate(inputs.split(",")))
            terms.append((one.of, np.einsum(f"{names}->Z{output}", *at)))
    return joined(value, terms)


def _norm(array: Dual, *, axis: int, keepdims: bool = False) -> Dual:
    length = np.linalg.norm(array.value, axis=axis, keepdims=True)
    unit = array.value / np.where(length > 0.0, length, 1.0)
    slopes = (unit * array.slopes).sum(axis=after(axis), keepdims=keepdims)
    return Dual(length if keepdims else length.squeeze(axis), slopes, array.of)


def _inv(array: Dual) -> Dual:
    value = np.asarray(np.linalg.inv(array.value), dtype=np.float64)
    return Dual(value, -value @ array.slopes @ value, array.of)


def _sinc(array: Dual) -> Dual:
    value, flat = np.asarray(np.sinc(array.value), dtype=np.float64), array.value == 0.0
    at = np.where(flat, 1.0, array.value)
    return joined(value, [(array.of, np.where(flat, 0.0, (np.cos(np.pi * at) - value) / at) * array.slopes)])


def _zeros_like(array: Any, dtype: Any = float, shape: Any = None) -> Dual:
    shape = array.shape if shape is None else shape
    return Dual.constant(np.zeros(shape, dtype))


def _take_along_axis(array: Dual, indices: Ints, axis: int = -1) -> Dual:
    value = np.take_along_axis(array.value, indices, axis=axis)
    return Dual(value, np.take_along_axis(array.slopes, indices[None], axis=after(axis)), array.of)


def _diff(array: Dual, n: int = 1, axis: int = -1) -> Dual:
    return Dual(np.diff(array.value, n, axis), np.diff(array.slopes, n, after(axis)), array.of)


def _insert(array: Dual, where: Any, constants: Any, axis: int) -> Dual:
    value = np.insert(array.value, where, constants, axis)
    return Dual(value, np.insert(array.slopes, where, 0.0, after(axis)), array.of)


def _broadcast_to(array: Dual, shape: tuple[int, ...]) -> Dual:
    value = np.broadcast_to(array.value, shape)
    return joined(value, [(array.of, padded(array.slopes, value.ndim))])


RULES: dict[Any, Callable[..., Any]] = {
    np.concatenate: _concatenate,
    np.stack: _stack,
    np.where: _where,
    np.einsum: _einsum,
    np.linalg.norm: _norm,
    np.linalg.inv: _inv,
    np.sinc: _sinc,
    np.cross: lambda *args, **options: bilinear(np.cross, *args, **options),
    np.zeros_like: _zeros_like,
    np.empty_like: _zeros_like,
    np.broadcast_to: _broadcast_to,
    np.diff: _diff,
    np.insert: _insert,
    np.swapaxes: Dual.swapaxes,
    np.take: Dual.take,
    np.take_along_axis: _take_along_axis,
    np.reshape: Dual.reshape,
    np.clip: lambda array, low, high: np.minimum(np.maximum(array, low), high),
    np.max: Dual.max,
    np.sum: Dual.sum,
    np.mean: Dual.mean,
    np.copy: Dual.copy,
}

FUNCTIONS.update(RULES)
