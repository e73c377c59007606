"""Dual numbers: arrays that carry their derivatives by parameters through NumPy code.

Forward accumulation (Griewank and Walther 2008, Evaluating Derivatives, ch. 3). Code that is written for arrays runs on
duals as it stands, as far as it builds arrays from others: by arithmetic, functions, indices, `np.stack` and the like.
What it makes by `np.zeros_like(x, shape=...)` of a dual x can be filled with duals; a bare `np.zeros` cannot.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, final

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from robolaser.arrays import Array, Ints

Numbers = tuple[int, ...]


@final
class Dual(NDArrayOperatorsMixin):
    """An array and how it moves with some parameters; it stands in for the array.

    Args:
        value: Of any shape.
        slopes: Its derivatives, one after the other, (q, *its shape).
        of: Numbers of the parameters that they are by, each once, (q,).
    """

    __slots__ = ("of", "slopes", "value")

    def __init__(self, value: Array, slopes: Array, of: Numbers) -> None:
        self.value, self.slopes, self.of = value, slopes, of

    @classmethod
    def parameter(cls, value: Array, number: int) -> "Dual":
        """A parameter of this number."""
        return cls(value, np.ones((1, *value.shape)), (number,))

    def __repr__(self) -> str:
        return f"Dual({self.value!r}, by parameters {self.of})"

    def __array__(self, *_: object, **__: object) -> Array:
        raise TypeError(
            "An array with derivatives cannot become a plain one: write np.stack, np.concatenate or np.where instead of"
            " filling np.zeros, or make the array by np.zeros_like(x, shape=...) of one that depends on parameters; and"
            " leave np.asarray and np.array out."
        )

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or not options.keys() <= {"out"}:
            raise _unknown(ufunc)
        if "out" in options:
            return _become(options["out"][0], ufunc(*inputs))
        if ufunc in VALUES_ONLY:
            return ufunc(*(bare(one) for one in inputs))
        if ufunc is np.matmul:
            return _bilinear(np.matmul, *inputs)
        if ufunc not in PARTIALS:
            raise _unknown(ufunc)
        at = [bare(one) for one in inputs]
        value = np.asarray(ufunc(*at))
        terms = []
        for one, partial in zip(inputs, PARTIALS[ufunc], strict=True):
            if isinstance(one, Dual):
                by = partial(value, *at)
                slopes = _padded(one.slopes, value.ndim)
                terms.append((one.of, slopes if by is None else by * slopes))
        return _joined(value, terms)

    def __array_function__(self, function: Callable[..., Any], _: object, args: Any, options: Any) -> Any:
        if function in FUNCTIONS:
            return FUNCTIONS[function](*args, **options)
        if function in LINEAR:
            return _linear(function, *args, **options)
        if function in VALUES_ONLY:
            return function(*(bare(one) for one in args), **options)
        raise _unknown(function)

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the value."""
        return self.value.shape

    @property
    def ndim(self) -> int:
        """Of the value."""
        return self.value.ndim

    @property
    def size(self) -> int:
        """Of the value."""
        return self.value.size

    @property
    def dtype(self) -> Any:
        """Of the value."""
        return self.value.dtype

    def __len__(self) -> int:
        return len(self.value)

    def __getitem__(self, key: Any) -> "Dual":
        value, key = self.value[key], key if isinstance(key, tuple) else (key,)
        if _apart(key):
            return Dual(value, _each(lambda slope: slope[key], self.slopes, value.shape), self.of)
        return Dual(value, self.slopes[(slice(None), *key)], self.of)

    def __setitem__(self, key: Any, item: Any) -> None:
        keys = key if isinstance(key, tuple) else (key,)
        if isinstance(item, Dual):
            self._grow(item.of)
            where, slopes = _union(self.of, item.of)[2], _padded(item.slopes, self.value[key].ndim)
            if any(isinstance(one, (np.ndarray, list)) for one in keys):
                for number, slope in zip(item.of, slopes, strict=True):
                    self.slopes[self.of.index(number)][key] = slope
            else:
                self.slopes[(slice(None), *keys)][where] = slopes
        elif len(self.of):
            self._grow(self.of)
            self.slopes[(slice(None), *keys)] = 0.0
        self.value[key] = bare(item)

    def _grow(self, of: Numbers) -> None:
        """Make room for the derivatives by these parameters."""
        every, own, _ = _union(self.of, of)
        if every != self.of or not self.slopes.flags.writeable:
            slopes = np.zeros((len(every), *self.value.shape))
            slopes[own] = self.slopes
            self.slopes, self.of = slopes, every

    def swapaxes(self, one: int, other: int) -> "Dual":
        """As of arrays."""
        return Dual(self.value.swapaxes(one, other), self.slopes.swapaxes(_after(one), _after(other)), self.of)

    def take(self, which: Ints, axis: int) -> "Dual":
        """As of arrays."""
        return Dual(self.value.take(which, axis=axis), self.slopes.take(which, axis=_after(axis)), self.of)

    def reshape(self, *shape: Any) -> "Dual":
        """As of arrays."""
        value = self.value.reshape(*shape)
        return Dual(value, self.slopes.reshape(-1, *value.shape), self.of)

    def sum(self, axis: int, *, keepdims: bool = False) -> "Dual":
        """As of arrays, along one axis."""
        value = self.value.sum(axis=axis, keepdims=keepdims)
        return Dual(value, self.slopes.sum(axis=_after(axis), keepdims=keepdims), self.of)

    def mean(self, axis: int, *, keepdims: bool = False) -> "Dual":
        """As of arrays, along one axis."""
        value = self.value.mean(axis=axis, keepdims=keepdims)
        return Dual(value, self.slopes.mean(axis=_after(axis), keepdims=keepdims), self.of)

    def copy(self) -> "Dual":
        """One of its own."""
        return Dual(self.value.copy(), self.slopes.copy(), self.of)


def bare(array: Any) -> Any:
    """The value of a dual; anything else as it is."""
    return array.value if isinstance(array, Dual) else array


def _become(out: Any, result: Any) -> Any:
    """What is left in `out` of `out += other` and the like."""
    if not isinstance(out, Dual):
        return result.__array__()  # says why it cannot be
    out.value, out.slopes, out.of = result.value, result.slopes, result.of
    return out


def is_dual(array: Any) -> bool:
    """Whether an array carries derivatives."""
    return isinstance(array, Dual)


def _unknown(function: Any) -> TypeError:
    return TypeError(
        f"np.{function.__name__} has no derivative here: residuals may use"
        f" {', '.join(sorted({one.__name__ for one in (*PARTIALS, *FUNCTIONS, *LINEAR)}))}."
    )


def _after(axis: int) -> int:
    """Where an axis of the value is among those of the slopes."""
    return axis if axis < 0 else axis + 1


def _apart(key: tuple[Any, ...]) -> bool:
    """Whether an index has several entries of which some are arrays: NumPy may put their axis first."""
    chosen = [one for one in key if not (one is None or one is Ellipsis or isinstance(one, slice))]
    return len(chosen) > 1 and not all(isinstance(one, (int, np.integer)) for one in chosen)


def _each(function: Callable[[Array], Array], slopes: Array, shape: tuple[int, ...]) -> Array:
    return np.stack([function(slope) for slope in slopes]) if len(slopes) else np.zeros((0, *shape))


def _padded(slopes: Array, ndim: int) -> Array:
    """Slopes whose value has as many axes as it is broadcast to."""
    lacking = ndim + 1 - slopes.ndim
    return slopes.reshape(slopes.shape[0], *(1,) * lacking, *slopes.shape[1:]) if lacking > 0 else slopes


@lru_cache(maxsize=4096)
def _union(one: Numbers, other: Numbers) -> tuple[Numbers, Any, Any]:
    """All of two lists of parameters, and where each list's are among them."""
    every = one + tuple(number for number in other if number not in one)
    place = {number: i for i, number in enumerate(every)}
    own = [place[number] for number in other]
    in_a_row = own == list(range(own[0], own[0] + len(own))) if own else True
    return every, slice(len(one)), slice(own[0], own[-1] + 1) if own and in_a_row else own


def _joined(value: Array, terms: Sequence[tuple[Numbers, Array]]) -> Dual:
    """A dual whose slopes are the sum of terms, each by some parameters and broadcast to the value."""
    of, slopes = terms[0]
    if len(terms) == 1:
        if slopes.shape[1:] != value.shape:
            slopes = np.broadcast_to(slopes, (len(of), *value.shape))
        return Dual(value, slopes, of)
    if all(other == of for other, _ in terms[1:]):
        total = terms[0][1] + terms[1][1]
        for _, more in terms[2:]:
            total = total + more
        return _joined(value, [(of, total)])
    for other, _ in terms[1:]:
        of = _union(of, other)[0] if other else of
    slopes = np.zeros((len(of), *value.shape))
    for other, part in terms:
        if other:
            slopes[_union(of, other)[2]] += part
    return Dual(value, slopes, of)


def _bilinear(function: Callable[..., Array], one: Any, other: Any, **options: Any) -> Dual:
    """A product that may reach over axes, as of matrices; factors have two axes or more."""
    a, b = bare(one), bare(other)
    value = function(a, b, **options)
    terms = []
    if isinstance(one, Dual):
        terms.append((one.of, function(_padded(one.slopes, value.ndim), b, **options)))
    if isinstance(other, Dual):
        terms.append((other.of, function(a, _padded(other.slopes, value.ndim), **options)))
    return _joined(value, terms)


def _linear(function: Callable[..., Array], array: Dual, *args: Any, **options: Any) -> Dual:
    value = function(array.value, *args, **options)
    return Dual(value, _each(lambda slope: function(slope, *args, **options), array.slopes, value.shape), array.of)


def _concatenate(parts: Sequence[Any], axis: int = 0) -> Dual:
    value = np.concatenate([bare(part) for part in parts], axis=axis)
    of: Numbers = ()
    for part in parts:
        if isinstance(part, Dual) and part.of:
            of = _union(of, part.of)[0]
    slopes = np.zeros((len(of), *value.shape))
    along, start = np.moveaxis(slopes, _after(axis), 1), 0
    for part in parts:
        end = start + part.shape[axis]
        if isinstance(part, Dual) and part.of:
            along[_union(of, part.of)[2], start:end] = np.moveaxis(part.slopes, _after(axis), 1)
        start = end
    return Dual(value, slopes, of)


def _stack(parts: Sequence[Any], axis: int = 0) -> Dual:
    value = np.stack([bare(part) for part in parts], axis=axis)
    of: Numbers = ()
    for part in parts:
        if isinstance(part, Dual) and part.of:
            of = _union(of, part.of)[0]
    slopes = np.zeros((len(of), *value.shape))
    along = np.moveaxis(slopes, _after(axis), 1)
    for i, part in enumerate(parts):
        if isinstance(part, Dual) and part.of:
            along[_union(of, part.of)[2], i] = part.slopes
    return Dual(value, slopes, of)


def _where(condition: Any, one: Any, other: Any) -> Any:
    condition = bare(condition)
    value = np.where(condition, bare(one), bare(other))
    terms = [
        (part.of, np.where(condition == chosen, _padded(part.slopes, value.ndim), 0.0))
        for part, chosen in ((one, True), (other, False))
        if isinstance(part, Dual)
    ]
    return _joined(value, terms) if terms else value


def _einsum(subscripts: str, *operands: Any) -> Dual:
    inputs, _, output = subscripts.replace(" ", "").partition("->")
    value = np.einsum(subscripts, *(bare(one) for one in operands))
    terms = []
    for i, one in enumerate(operands):
        if isinstance(one, Dual):
            at = [one.slopes if i == j else bare(other) for j, other in enumerate(operands)]
            names = ",".join(f"Z{name}" if i == j else name for j, name in enumerate(inputs.split(",")))
            terms.append((one.of, np.einsum(f"{names}->Z{output}", *at)))
    return _joined(value, terms)


def _norm(array: Dual, axis: int = -1, *, keepdims: bool = False) -> Dual:
    length = np.linalg.norm(array.value, axis=axis, keepdims=True)
    unit = array.value / np.where(length > 0.0, length, 1.0)
    slopes = (unit * array.slopes).sum(axis=_after(axis), keepdims=keepdims)
    return Dual(length if keepdims else length.squeeze(axis), slopes, array.of)


def _inv(array: Dual) -> Dual:
    value = np.asarray(np.linalg.inv(array.value), dtype=np.float64)
    return Dual(value, -value @ array.slopes @ value, array.of)


def _sinc(array: Dual) -> Dual:
    value, flat = np.asarray(np.sinc(array.value), dtype=np.float64), array.value == 0.0
    at = np.where(flat, 1.0, array.value)
    return _joined(value, [(array.of, np.where(flat, 0.0, (np.cos(np.pi * at) - value) / at) * array.slopes)])


def _zeros_like(array: Any, dtype: Any = float, shape: Any = None) -> Dual:
    shape = array.shape if shape is None else shape
    return Dual(np.zeros(shape, dtype), np.zeros((0, *shape)), ())


def _take_along_axis(array: Dual, indices: Ints, axis: int = -1) -> Dual:
    value = np.take_along_axis(array.value, indices, axis=axis)
    return Dual(value, np.take_along_axis(array.slopes, indices[None], axis=_after(axis)), array.of)


def _broadcast_to(array: Dual, shape: tuple[int, ...]) -> Dual:
    value = np.broadcast_to(array.value, shape)
    return _joined(value, [(array.of, _padded(array.slopes, value.ndim))])


def _first(value: Array, *at: Array) -> None:
    """A partial derivative of one."""
    return


PARTIALS: dict[np.ufunc, tuple[Callable[..., Any], ...]] = {
    np.add: (_first, _first),
    np.subtract: (_first, lambda *_: -1.0),
    np.multiply: (lambda _, a, b: b, lambda _, a, b: a),
    np.divide: (lambda _, a, b: 1.0 / b, lambda v, a, b: -v / b),
    np.negative: (lambda *_: -1.0,),
    np.positive: (_first,),
    np.absolute: (lambda _, a: np.sign(a),),
    np.square: (lambda _, a: 2.0 * a,),
    np.sqrt: (lambda v, _: 0.5 / v,),
    np.power: (lambda _, a, b: b * a ** (b - 1.0), lambda v, a, b: v * np.log(a)),
    np.exp: (lambda v, _: v,),
    np.log: (lambda _, a: 1.0 / a,),
    np.sin: (lambda _, a: np.cos(a),),
    np.cos: (lambda _, a: -np.sin(a),),
    np.tan: (lambda v, _: 1.0 + v * v,),
    np.arcsin: (lambda _, a: 1.0 / np.sqrt(1.0 - a * a),),
    np.arccos: (lambda _, a: -1.0 / np.sqrt(1.0 - a * a),),
    np.arctan: (lambda _, a: 1.0 / (1.0 + a * a),),
    np.arctan2: (lambda _, a, b: b / (a * a + b * b), lambda _, a, b: -a / (a * a + b * b)),
    np.hypot: (lambda v, a, b: a / v, lambda v, a, b: b / v),
    np.maximum: (lambda _, a, b: a >= b, lambda _, a, b: a < b),
    np.minimum: (lambda _, a, b: a <= b, lambda _, a, b: a > b),
}
"""Partial derivatives of each function by its arguments, from its value and these; None is one."""

FUNCTIONS: dict[Any, Callable[..., Any]] = {
    np.concatenate: _concatenate,
    np.stack: _stack,
    np.where: _where,
    np.einsum: _einsum,
    np.linalg.norm: _norm,
    np.linalg.inv: _inv,
    np.sinc: _sinc,
    np.cross: lambda *args, **options: _bilinear(np.cross, *args, **options),
    np.zeros_like: _zeros_like,
    np.empty_like: _zeros_like,
    np.broadcast_to: _broadcast_to,
    np.swapaxes: Dual.swapaxes,
    np.take: Dual.take,
    np.take_along_axis: _take_along_axis,
    np.reshape: Dual.reshape,
    np.sum: Dual.sum,
    np.mean: Dual.mean,
    np.copy: Dual.copy,
}

LINEAR = frozenset(
    {np.cumsum, np.diff, np.expand_dims, np.flip, np.insert, np.moveaxis, np.ravel, np.repeat, np.roll, np.squeeze}
    | {np.tile, np.transpose}
)  # functions that act on each derivative as on the value

VALUES_ONLY = frozenset(
    {np.equal, np.not_equal, np.less, np.less_equal, np.greater, np.greater_equal, np.isfinite, np.isnan, np.sign}
    | {np.floor, np.rint, np.signbit, np.shape, np.ndim, np.size, np.argmax, np.argmin, np.all, np.any}
)  # what has no derivative, or none but zero
