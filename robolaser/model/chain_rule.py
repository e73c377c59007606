"""Derivatives of the values that pass the stages: the chain rule, one stage after the other.

At each stage the effects there, and no more than these, are differentiated numerically; between the stages sensors pass
duals on. So the derivative by one number of one effect costs one stage, and not the whole model.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.duals import Dual
from robolaser.finite_differences import central_quotients
from robolaser.geometry.rigid_motion import common_length
from robolaser.model.stages import Perturbation, Stage, on_rows
from robolaser.parameters import Values


@final
@dataclass(frozen=True, eq=False)
class Acting:
    """An effect of the model, as the chain rule sees it."""

    stage: Stage  # where it acts
    names: Sequence[str]  # its parameters
    act: Callable[[Array, Values], Array]  # what it makes of a value (c or 1, ...) with its parameters (c,) each


@final
class ChainRule:
    """Stands in for the perturbation of a model: passes duals, and arrays that nothing moved so far, through effects.

    Args:
        effects: Those of the model, in the order in which they act.
        values: All parameters, (c,) each; derivatives are by their numbers in this order.
        steps: Of the numerical derivative by each number, (d or more,).
    """

    def __init__(self, effects: Sequence[Acting], values: Values, steps: Array) -> None:
        self._effects, self._values, self._steps = effects, values, steps
        self._number = {name: number for number, name in enumerate(values)}

    @classmethod
    def of(cls, perturb: Perturbation, steps: Array) -> "ChainRule":
        """The same for effects whose own numbers stay as they are.

        Args:
            perturb: The effects.
            steps: Of the numerical derivative by each number that moves what they act on, (q,).
        """
        return cls(tuple(Acting(stage, (), _of_value(act)) for stage, act in perturb.steps), {}, steps)

    def of_rows(self, rows: Ints, count: int) -> "ChainRule":
        """The same for a sensor that sees only some rows (m,) of as many as there are, and all poses."""
        effects = tuple(replace(one, act=on_rows(one.stage, one.act, rows, count)) for one in self._effects)
        return ChainRule(effects, self._values, self._steps)

    def touches(self, *stages: Stage) -> bool:
        """Whether any effect is at one of these stages."""
        return any(effect.stage in stages for effect in self._effects)

    def __call__(self, stage: Stage, passing: Any) -> Any:
        """What comes out of a stage."""
        for effect in self._effects:
            if effect.stage is stage:
                links = stage is Stage.LINKS and isinstance(passing, Dual)
                passing = self._past_other_links(effect, passing) if links else self._through(effect, passing)
        return passing

    def _past_other_links(self, effect: Acting, passing: Dual) -> Dual:
        """The same for an effect that moves a joint's placement: those of other joints do not matter to it."""
        changed = effect.act(passing.value, {name: self._values[name] for name in effect.names}) != passing.value
        matters = np.asarray(passing.slopes[:, :, :, changed.any(axis=(0, 1, 3, 4))].any(axis=(1, 2, 3, 4, 5)))
        here, past = _some(passing, matters), _some(passing, ~matters)
        out: Dual = self._through(effect, here)
        slopes = np.broadcast_to(past.slopes, (len(past.of), *out.shape))
        return Dual(out.value, np.concatenate([out.slopes, slopes]), out.of + past.of)

    def _through(self, effect: Acting, passing: Any) -> Any:
        """An effect, differentiated numerically by its own parameters and by those that move what it acts on."""
        values = {name: self._values[name] for name in effect.names}
        at = passing if isinstance(passing, Dual) else Dual(passing, np.empty((0, *passing.shape)), ())
        value = effect.act(at.value, values)
        of = (*(self._number[name] for name in effect.names), *at.of)
        if not of:
            return value
        c, q, steps = common_length(at.value, *values.values()), len(of), self._steps[list(of)]
        moved = {name: np.repeat(numbers, 2 * q).reshape(c, q, 2) for name, numbers in values.items()}
        for column, name in enumerate(effect.names):
            moved[name][:, column] += steps[column] * np.array([1.0, -1.0])
        ends = effect.act(_shifted(at, q, c, steps), {name: numbers.ravel() for name, numbers in moved.items()})
        slopes = central_quotients(ends.reshape(c, q, 2, *ends.shape[1:]), steps)
        return Dual(np.broadcast_to(value, (c, *value.shape[1:])), slopes.swapaxes(0, 1), of)


def _of_value(act: Callable[[Array], Array]) -> Callable[[Array, Values], Array]:
    return lambda value, _: act(value)


def _some(dual: Dual, which: Bools) -> Dual:
    """The same, moved by some of its parameters alone."""
    return Dual(dual.value, dual.slopes[which], tuple(np.array(dual.of, dtype=np.int64)[which].tolist()))


def _shifted(passing: Dual, q: int, c: int, steps: Array) -> Array:
    """A value for each end of each difference, (c q 2, ...): directions before its own leave it where it is.

    A value that is the same for all, and that nothing moves, stays (1, ...).
    """
    if not passing.of and len(passing.value) == 1:
        return passing.value
    at = np.empty((c, q, 2, *passing.value.shape[1:]))
    at[:] = passing.value[:, None, None]
    own = q - len(passing.of)
    shift = passing.slopes.swapaxes(0, 1) * steps[own:].reshape(-1, *(1,) * (passing.slopes.ndim - 2))
    at[:, own:, 0] += shift
    at[:, own:, 1] -= shift
    return at.reshape(-1, *at.shape[3:])
