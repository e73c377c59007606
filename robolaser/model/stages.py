"""The stages at which effects can perturb a value on its way from encoder and image to a residual."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from enum import Enum
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Ints


class Stage(Enum):
    """The stages that a value passes on its way from encoder and image to a residual, in this order.

    What passes, for c candidates, n poses, j joints and m rows of points:
    """

    JOINTS = "joint angles as read, (c, n, j) [rad or m]"
    LINKS = "placement of each joint on the link before it, (c, n or 1, j, 4, 4)"
    FLANGE = "T_base_flange, (c, n, 4, 4)"
    MOUNT = "T_flange_camera, or T_flange_target of a camera in the cell, (c, n or 1, 4, 4)"
    PIXELS = "pixels as read, (c, m, 2) [px]"
    IMAGE = "metric image coordinates, distortion taken off, (c, m, 2) [m]"
    LASER_PLANE = "laser plane for each row, (n, d) with n · P = d in the camera frame, (c, m or 1, 4)"
    POINTS = "points where the viewing rays meet the laser plane, camera frame, (c, m, 3) [m]"
    TARGET = "target points as given, (c, m, 3) [m]"


OF_ROWS = frozenset({Stage.PIXELS, Stage.IMAGE, Stage.LASER_PLANE, Stage.POINTS, Stage.TARGET})
"""Stages whose values have an entry for each row of points, not for each pose."""


@final
@dataclass(frozen=True)
class Perturbation:
    """Passes a value through all effects at a stage; called with both."""

    # the change by each effect, and its stage; those at one stage act in this order
    steps: tuple[tuple[Stage, Callable[[Array], Array]], ...] = ()
    of_run: Collection[Callable[[Array], Array]] = ()  # changes that depend on other rows or poses of a run

    def __call__(self, stage: Stage, value: Array) -> Array:
        """The value after a stage."""
        for at, act in self.steps:
            if at is stage:
                value = act(value)
        return value

    def touches(self, *stages: Stage) -> bool:
        """Whether any effect is at one of these stages."""
        return any(at in stages for at, _ in self.steps)

    @property
    def of_lens(self) -> "Perturbation":
        """Without effects that depend on other rows or poses: for pixels of no row, as on a grid over the image."""
        return Perturbation(tuple((at, act) for at, act in self.steps if act not in self.of_run))

    def of_rows(self, rows: Ints, count: int) -> "Perturbation":
        """The same for a sensor that sees only some rows (m,) of as many as there are, and all poses."""
        acts = {act: on_rows(at, act, rows, count) for at, act in self.steps}
        return Perturbation(tuple((at, acts[act]) for at, act in self.steps), [acts[act] for act in self.of_run])


def on_rows(stage: Stage, act: Callable[..., Array], rows: Ints, count: int) -> Callable[..., Array]:
    """A change of values of all rows, applied to values of some rows (m,) of all.

    Values of no row, as an image's on a grid, pass as if they were of these rows, m at a time.
    """
    if stage not in OF_ROWS:
        return act
    index_among_rows = np.zeros(count, dtype=np.int64)
    index_among_rows[rows] = np.arange(len(rows))

    def act_on_rows(value: Array, *more: Any) -> Array:
        count, each = value.shape[1], len(rows)
        if count not in (1, each):
            starts = range(0, count, each)
            pieces = [act_on_rows(value.take(range(at, at + each), axis=1, mode="wrap"), *more) for at in starts]
            return np.concatenate(pieces, axis=1)[:, :count]
        out = act(value if value.shape[1] == 1 else value[:, index_among_rows], *more)
        return out if out.shape[1] == 1 else out[:, rows]

    return act_on_rows
