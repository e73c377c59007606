"""Dual numbers: arrays that carry their derivatives by parameters through NumPy code.

Forward accumulation (Griewank and Walther 2008, Evaluating Derivatives, ch. 3). Code that is written for arrays runs on
duals unchanged if it builds arrays from others: by arithmetic, functions, indices, `np.stack` and the like. The result
of `np.zeros_like(x, shape=...)` of a dual x can be filled with duals; a plain `np.zeros` cannot.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, final

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from robolaser.arrays import Array, Ints

Indices = tuple[int, ...]

FUNCTIONS: dict[Any, Callable[..., Any]] = {}  # functions of arrays with their own rule for duals
LINEAR = frozenset(
    {np.cumsum, np.expand_dims, np.flip, np.moveaxis, np.ravel, np.repeat, np.roll, np.squeeze, np.tile, np.transpose}
)  # functions that act on each derivative as on the value
VALUES_ONLY = frozenset(
    {np.equal, np.not_equal, np.less, np.less_equal, np.greater, np.greater_equal, np.isfinite, np.isnan, np.sign}
    | {np.floor, np.rint, np.signbit, np.ones_like, np.shape, np.ndim, np.size, np.argmax, np.argmin, np.all, np.any}
)  # functions without derivative, or only zero


def _one(value: Array, *at: Array) -> None:
    """A partial derivative that is 1, returned as None so that nothing is multiplied."""
    return


PARTIALS: dict[np.ufunc, tuple[Callable[..., Any], ...]] = {
    np.add: (_one, _one),
    np.subtract: (_one, lambda *_: -1.0),
    np.multiply: (lambda _, a, b: b, lambda _, a, b: a),
    np.divide: (lambda _, a, b: 1.0 / b, lambda v, a, b: -v / b),
    np.negative: (lambda *_: -1.0,),
    np.positive: (_one,),
    np.absolute: (lambda _, a: np.sign(a),),
    np.square: (lambda _, a: 2.0 * a,),
    np.sqrt: (lambda v, _: 0.5 / v,),
    np.power: (lambda _, a, b: b * a ** (b - 1.0), lambda v, a, b: v * np.log(a)),
    np.exp: (lambda v, _: v,),
    np.expm1: (lambda v, _: v + 1.0,),
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
"""Partial derivatives of each function by its arguments, from its value and its arguments; None means 1."""


@final
class Dual(NDArrayOperatorsMixin):
    """An array with its derivatives by some parameters, usable in place of the array.

    Args:
        value: Of any shape.
        slopes: Its derivatives, one after the other, (q, *its shape).
        of: Numbers of their parameters, each once, (q,).
    """

    __slots__ = ("of", "slopes", "value")

    def __init__(self, value: Array, slopes: Array, of: Indices) -> None:
        self.value, self.slopes, self.of = value, slopes, of

    @classmethod
    def parameter(cls, value: Array, number: int) -> "Dual":
        """A parameter of this number."""
        return cls(value, np.ones((1, *value.shape)), (number,))

    @classmethod
    def constant(cls, value: Array) -> "Dual":
        """A constant that may be filled with numbers that depend on parameters."""
        return cls(value, np.zeros((0, *value.shape)), ())

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
            return bilinear(np.matmul, *inputs)
        if ufunc not in PARTIALS:
            raise _unknown(ufunc)
        at = [bare(one) for one in inputs]
        value = np.asarray(ufunc(*at))
        terms = []
        for one, partial in zip(inputs, PARTIALS[ufunc], strict=True):
            if isinstance(one, Dual):
                by = partial(value, *at)
                slopes = padded(one.slopes, value.ndim)
                terms.append((one.of, slopes if by is None else by * slopes))
        return joined(value, terms)

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
        """Shape of the value."""
        return self.value.shape

    @property
    def ndim(self) -> int:
        """Number of axes of the value."""
        return self.value.ndim

    @property
    def size(self) -> int:
        """Number of elements of the value."""
        return self.value.size

    @property
    def dtype(self) -> Any:
        """Type of the value."""
        return self.value.dtype

    def __len__(self) -> int:
        return len(self.value)

    def __getitem__(self, key: Any) -> "Dual":
        value, key = self.value[key], key if isinstance(key, tuple) else (key,)
        if _splits_axes(key):
            return Dual(value, _each(lambda slope: slope[key], self.slopes, value.shape), self.of)
        return Dual(value, self.slopes[(slice(None), *key)], self.of)

    def __setitem__(self, key: Any, item: Any) -> None:
        keys = key if isinstance(key, tuple) else (key,)
        if isinstance(item, Dual):
            self._grow(item.of)
            where, slopes = union(self.of, item.of)[2], padded(item.slopes, self.value[key].ndim)
            if any(isinstance(one, (np.ndarray, list)) for one in keys):
                for number, slope in zip(item.of, slopes, strict=True):
                    self.slopes[self.of.index(number)][key] = slope
            else:
                self.slopes[(slice(None), *keys)][where] = slopes
        elif len(self.of):
            self._grow(self.of)
            self.slopes[(slice(None), *keys)] = 0.0
        self.value[key] = bare(item)

    def _grow(self, of: Indices) -> None:
        """Allocate the derivatives by these parameters."""
        every, own, _ = union(self.of, of)
        if every != self.of or not self.slopes.flags.writeable:
            slopes = np.zeros((len(every), *self.value.shape))
            slopes[own] = self.slopes
            self.slopes, self.of = slopes, every

    def swapaxes(self, one: int, other: int) -> "Dual":
        """As of arrays."""
        return Dual(self.value.swapaxes(one, other), self.slopes.swapaxes(after(one), after(other)), self.of)

    def repeat(self, count: int, axis: int) -> "Dual":
        """As of arrays, along one axis."""
        return Dual(self.value.repeat(count, axis=axis), self.slopes.repeat(count, axis=after(axis)), self.of)

    def take(self, which: Ints, axis: int, mode: Any = "raise") -> "Dual":
        """As of arrays."""
        value = self.value.take(which, axis=axis, mode=mode)
        return Dual(value, self.slopes.take(which, axis=after(axis), mode=mode), self.of)

    def reshape(self, *shape: Any) -> "Dual":
        """As of arrays."""
        value = self.value.reshape(*shape)
        return Dual(value, self.slopes.reshape(-1, *value.shape), self.of)

    def sum(self, axis: int, *, keepdims: bool = False) -> "Dual":
        """As of arrays, along one axis."""
        value = self.value.sum(axis=axis, keepdims=keepdims)
        return Dual(value, self.slopes.sum(axis=after(axis), keepdims=keepdims), self.of)

    def mean(self, axis: int, *, keepdims: bool = False) -> "Dual":
        """As of arrays, along one axis."""
        value = self.value.mean(axis=axis, keepdims=keepdims)
        return Dual(value, self.slopes.mean(axis=after(axis), keepdims=keepdims), self.of)

    def max(self, axis: int, *, keepdims: bool = False) -> "Dual":
        """As of arrays, along one axis."""
        at = np.expand_dims(self.value.argmax(axis=axis), axis)
        value, slopes = (
            np.take_along_axis(each, where, axis=along)
            for each, where, along in ((self.value, at, axis), (self.slopes, at[None], after(axis)))
        )
        most = Dual(value, slopes, self.of)
        return most if keepdims else most.sum(axis)

    def copy(self) -> "Dual":
        """A copy that shares no memory."""
        return Dual(self.value.copy(), self.slopes.copy(), self.of)


def bare(array: Any) -> Any:
    """The value of a dual; anything else unchanged."""
    return array.value if isinstance(array, Dual) else array


def _become(out: Any, result: Any) -> Any:
    """Store the result of `out += other` and the like in `out`."""
    if not isinstance(out, Dual):
        return result.__array__()  # raises the error
    out.value, out.slopes, out.of = result.value, result.slopes, result.of
    return out


def is_dual(array: Any) -> bool:
    """Whether an array carries derivatives."""
    return isinstance(array, Dual)


def slopes_of(array: Any, count: int) -> Array:
    """Derivatives of an array by the first so many parameters, (count, *shape); zero of a plain one."""
    slopes = np.zeros((count, *array.shape))
    if isinstance(array, Dual):
        slopes[list(array.of)] = array.slopes
    return slopes


def _unknown(function: Any) -> TypeError:
    return TypeError(
        f"np.{function.__name__} has no derivative here: residuals may use"
        f" {', '.join(sorted({one.__name__ for one in (*PARTIALS, *FUNCTIONS, *LINEAR)}))}."
    )


def after(axis: int) -> int:
    """The axis of the slopes for an axis of the value."""
    return axis if axis < 0 else axis + 1


def _splits_axes(key: tuple[Any, ...]) -> bool:
    """Whether an index has several entries of which some are arrays: NumPy may put their axis first."""
    chosen = [one for one in key if not (one is None or one is Ellipsis or isinstance(one, slice))]
    return len(chosen) > 1 and not all(isinstance(one, (int, np.integer)) for one in chosen)


def _each(function: Callable[[Array], Array], slopes: Array, shape: tuple[int, ...]) -> Array:
    return np.stack([function(slope) for slope in slopes]) if len(slopes) else np.zeros((0, *shape))


def padded(slopes: Array, ndim: int) -> Array:
    """Slopes with axes inserted for a value that is broadcast to `ndim` axes."""
    lacking = ndim + 1 - slopes.ndim
    return slopes.reshape(slopes.shape[0], *(1,) * lacking, *slopes.shape[1:]) if lacking > 0 else slopes


@lru_cache(maxsize=4096)
def union(one: Indices, other: Indices) -> tuple[Indices, Any, Any]:
    """All of two lists of parameters, and the indices of each list among them."""
    every = one + tuple(number for number in other if number not in one)
    place = {number: i for i, number in enumerate(every)}
    own = [place[number] for number in other]
    in_a_row = own == list(range(own[0], own[0] + len(own))) if own else True
    return every, slice(len(one)), slice(own[0], own[-1] + 1) if own and in_a_row else own


def joined(value: Array, terms: Sequence[tuple[Indices, Array]]) -> Dual:
    """A dual whose slopes are the sum of terms, each by some parameters and broadcast to the value."""
    of: Indices = ()
    for other, _ in terms:
        of = union(of, other)[0]
    slopes = np.zeros((len(of), *value.shape))
    for other, part in terms:
        slopes[union(of, other)[2]] += part
    return Dual(value, slopes, of)


def bilinear(function: Callable[..., Array], one: Any, other: Any, **options: Any) -> Dual:
    """A product that may sum over axes, as of matrices; factors have two axes or more."""
    a, b = bare(one), bare(other)
    value = function(a, b, **options)
    terms = []
    if isinstance(one, Dual):
        terms.append((one.of, function(padded(one.slopes, value.ndim), b, **options)))
    if isinstance(other, Dual):
        terms.append((other.of, function(a, padded(other.slopes, value.ndim), **options)))
    return joined(value, terms)


def _linear(function: Callable[..., Array], array: Dual, *args: Any, **options: Any) -> Dual:
    value = function(array.value, *args, **options)
    return Dual(value, _each(lambda slope: function(slope, *args, **options), array.slopes, value.shape), array.of)
