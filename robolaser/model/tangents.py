"""How what passes the stages moves with the parameters: the chain rule, one stage after the other.

Forward accumulation (Griewank and Walther 2008, Evaluating Derivatives, ch. 3): a value goes on together with its
derivatives. At each stage the effects there, and no more than these, are differentiated numerically; what is linear
between the stages is passed on in closed form. So the derivative by one number of one effect costs one stage, and not
the whole model.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.finite_differences import central_quotients
from robolaser.geometry.rigid_motion import carry
from robolaser.model.stages import Perturbation, Stage, on_rows
from robolaser.parameters import Values


@final
@dataclass(frozen=True, eq=False)
class Tangent:
    """A value and how it moves."""

    value: Array  # (c or 1, ...)
    slopes: Array  # its derivatives by some of the parameters, (c or 1, q, ...)
    of: Ints  # numbers of these parameters, (q,)

    @classmethod
    def constant(cls, value: Array) -> "Tangent":
        """A value that nothing moves."""
        return cls(value, np.empty((len(value), 0, *value.shape[1:])), np.empty(0, dtype=np.int64))


@final
@dataclass(frozen=True, eq=False)
class Acting:
    """An effect of the model, as the chain rule sees it."""

    stage: Stage  # where it acts
    names: Sequence[str]  # its parameters
    act: Callable[[Array, Values], Array]  # what it makes of a value (c or 1, ...) with its parameters (c,) each


@final
class ChainRule:
    """Passes values and their derivatives through the effects at each stage.

    Args:
        effects: Those of the model, in the order in which they act.
        values: All parameters, (c,) each.
        steps: Of the numerical derivative by each parameter, (d,).
    """

    def __init__(self, effects: Sequence[Acting], values: Values, steps: Array) -> None:
        self._effects, self.values, self._steps = effects, values, steps
        self._column = {name: column for column, name in enumerate(values)}
        self._candidates = len(next(iter(values.values())))

    def of_rows(self, named: Mapping[str, str], rows: Ints, count: int) -> "ChainRule":
        """The same for a sensor that sees only some rows, and knows some parameters by other names.

        Args:
            named: Names of parameters by what the sensor calls them.
            rows: The rows, (m,).
            count: How many there are in all.
        """
        effects = tuple(replace(one, act=on_rows(one.stage, one.act, rows, count)) for one in self._effects)
        values = {**self.values, **{own: self.values[whole] for own, whole in named.items()}}
        other = ChainRule(effects, values, self._steps)
        other._column = {**self._column, **{own: self._column[whole] for own, whole in named.items()}}
        return other

    @property
    def perturbation(self) -> Perturbation:
        """What the effects do to values alone."""
        return Perturbation(tuple((one.stage, self._bound(one)) for one in self._effects))

    def _bound(self, one: Acting) -> Callable[[Array], Array]:
        values = {name: self.values[name] for name in one.names}
        return lambda value: one.act(value, values)

    @property
    def count(self) -> int:
        """By how many parameters derivatives are."""
        return len(self._steps)

    def columns(self, names: Sequence[str]) -> Ints:
        """Numbers of some parameters, (q,)."""
        return np.array([self._column[name] for name in names], dtype=np.int64)

    def moves(self, *stages: Stage) -> bool:
        """Whether an effect acts at one of these stages."""
        return any(effect.stage in stages for effect in self._effects)

    def __call__(self, stage: Stage, passing: Tangent) -> Tangent:
        """What comes out of a stage."""
        for effect in self._effects:
            if effect.stage is Stage.LINKS is stage:
                passing = self._past_other_links(effect, passing)
            elif effect.stage is stage:
                passing = self.through(effect.act, effect.names, passing)
        return passing

    def _past_other_links(self, effect: Acting, passing: Tangent) -> Tangent:
        """The same for an effect that moves a joint's placement: those of other joints do not matter to it."""
        changed = effect.act(passing.value, {name: self.values[name] for name in effect.names}) != passing.value
        through = passing.slopes[:, :, :, changed.any(axis=(0, 1, 3, 4))].any(axis=(0, 2, 3, 4, 5))
        out = self.through(
            effect.act, effect.names, Tangent(passing.value, passing.slopes[:, through], passing.of[through])
        )
        past = np.broadcast_to(
            passing.slopes[:, ~through], (len(out.slopes), int((~through).sum()), *out.slopes.shape[2:])
        )
        return Tangent(out.value, np.concatenate([out.slopes, past], axis=1), np.append(out.of, passing.of[~through]))

    def through(self, function: Callable[[Array, Values], Array], names: Sequence[str], passing: Tangent) -> Tangent:
        """A function of a value and of some parameters, differentiated numerically by both.

        Args:
            function: Values (c, ...) and the parameters (c,) each -> (c, ...).
            names: Its parameters.
            passing: Its value.
        """
        values = {name: self.values[name] for name in names}
        value = function(passing.value, values)
        own = self.columns(names)
        of = np.append(own, passing.of)
        c, q, steps = self._candidates, len(of), self._steps[of]
        if not q:
            return Tangent.constant(value)
        at = _shifted(passing, len(own), c, steps)
        moved = {name: np.repeat(numbers, 2 * q).reshape(c, q, 2) for name, numbers in values.items()}
        for column, name in enumerate(names):
            moved[name][:, column] += steps[column] * np.array([1.0, -1.0])
        ends = function(at, {name: numbers.ravel() for name, numbers in moved.items()})
        return Tangent(value, central_quotients(ends.reshape(c, q, 2, *ends.shape[1:]), steps), of)


def _shifted(passing: Tangent, own: int, c: int, steps: Array) -> Array:
    """A value for each end of each difference, (c q 2, ...): the first few directions leave it where it is.

    A value that is the same for all, and that nothing moves, stays (1, ...).
    """
    if not len(passing.of) and len(passing.value) == 1:
        return passing.value
    at = np.empty((c, len(steps), 2, *passing.value.shape[1:]))
    at[:] = passing.value[:, None, None]
    shift = passing.slopes * steps[own:].reshape(-1, *(1,) * (passing.slopes.ndim - 2))
    at[:, own:, 0] += shift
    at[:, own:, 1] -= shift
    return at.reshape(-1, *at.shape[3:])


def carried(T: Tangent, of_row: Ints, points: Array) -> Array:
    """How points move with the motions that carry them, (c, q, m, 3).

    Args:
        T: T_a_b, (c or 1, n, 4, 4).
        of_row: Which of the n is each row's, (m,).
        points: In frame b, (c or 1, m or 1, 3) [m].
    """
    c, q = max(len(T.slopes), len(points)), len(T.of)
    moves = np.broadcast_to(T.slopes, (c, *T.slopes.shape[1:])).reshape(-1, *T.slopes.shape[2:])
    at = points if len(points) == 1 else np.repeat(points, q, axis=0)
    return carry(moves, of_row, at).reshape(c, q, len(of_row), 3)
