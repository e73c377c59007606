"""The stripe's chain in compiled loops: from the paper's fourteen, and what effects make of them, to residuals."""

from functools import partial
from types import ModuleType
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.compiled import share_out
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import carry, common_length, from_quaternion, inverse
from robolaser.model.sensors.scanner_geometry import in_image
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

SCANNER = ("f", "s_u", "s_v", "u_0", "v_0", "k", "b", "theta", "w", "phi", "psi", "t_x", "t_y", "t_z")
"""The paper's fourteen, in its order (eq. 15)."""

AT_ONCE = 100_000
"""Candidates times rows that a thread takes at a time, a tenth of a millisecond: for less no other is woken up."""
ROWS_AT_ONCE = 40_000  # rows whose squares are summed apart: sums must not depend on the number of threads
ARM_STANDS = np.eye(4)[None, None]


@final
class Chain:
    """A stripe's data set laid out for the compiler.

    Args:
        dataset: What was measured.
    """

    def __init__(self, dataset: Dataset) -> None:
        points = dataset.points
        self._pixel, self._pose = points["pixel"][None], points.pose
        self._along_u = dataset.stripe_axis == "u"
        self._bracket, self._zyz = from_quaternion(np.array(dataset.bracket_quat)), dataset.angles == "zyz"
        self._image = self._along_axes(self._pixel)
        self._runs = runs_of(points.pose)
        self._xyz = points["xyz"][None]
        self._last: tuple[Array, Array] | None = None

    @property
    def _loops(self) -> ModuleType:
        from robolaser.model.sensors import stripe_loops  # noqa: PLC0415 - loads numba

        return stripe_loops

    def costs(self, own: Array, T_base_flange: Array) -> Array:
        """J for a placed target and an arm that stands the same for all candidates, (c, 14) -> (c,) [m²].

        The target is carried to the flange frame once for all: distances stay what they are, and no pose is left in
        the loop.
        """
        known = self._in_flange(T_base_flange)
        c, m = len(own), known.shape[2]
        if m > ROWS_AT_ONCE:
            return self._run(dict(zip(SCANNER, own.T, strict=True)), ARM_STANDS, Perturbation(), known, store=False)[1]
        J = np.empty(c)
        given = np.ascontiguousarray(own), self._bracket, self._zyz, self._along_u, self._image, known, J
        if c * m <= AT_ONCE:
            self._loops.costs(0, c, *given)
        else:
            part = -(-AT_ONCE // m)
            share_out(partial(self._loops.costs, i, min(i + part, c), *given) for i in range(0, c, part))
        return J

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation, known: Array) -> Array:
        """Known points less predicted ones in the base frame, (c, m, 3) [m].

        Args:
            values: The fourteen, one for each candidate or one for all.
            T_base_flange: (c or 1, n, 4, 4).
            perturb: Effects; none of them at the light.
            known: Target points in the base frame, (c or 1, m, 3) [m].
        """
        return self._run(values, T_base_flange, perturb, _by_axis(known), store=True)[0]

    def squares(self, values: Values, T_base_flange: Array, perturb: Perturbation, known: Array) -> Array:
        """J for the same, (c,) [m²]; residuals are not kept."""
        return self._run(values, T_base_flange, perturb, _by_axis(known), store=False)[1]

    def _run(
        self, values: Values, T_base_flange: Array, perturb: Perturbation, known: Array, *, store: bool
    ) -> tuple[Array, Array]:
        own = np.empty((common_length(*(values[name] for name in SCANNER)), len(SCANNER)))
        for column, name in enumerate(SCANNER):
            own[:, column] = values[name]
        camera, sheet, mount = self._loops.unpacked(own, self._bracket, self._zyz, self._along_u)
        sheet, mount = perturb(Stage.LASER_PLANE, sheet), perturb(Stage.MOUNT, mount)
        image = self._image
        if perturb.touches(Stage.PIXELS, Stage.IMAGE):
            image = self._along_axes(in_image(self._pixel, values, perturb))
            camera[:, :5] = 0.0, 0.0, 1.0, -1.0 if self._along_u else 1.0, 0.0  # takes metric points as they are
        c, m = common_length(camera, sheet, mount, T_base_flange), known.shape[2]
        E = np.empty((c, m, 3) if store else (0, 0, 0))
        blocks = range(0, m, ROWS_AT_ONCE)
        J = np.empty((len(blocks), c))
        given = camera, *map(np.ascontiguousarray, (sheet, mount, T_base_flange)), self._runs, image, known, E
        part = -(-AT_ONCE // min(m, ROWS_AT_ONCE))
        share_out(
            partial(self._loops.residuals, i, min(i + part, c), top, min(top + ROWS_AT_ONCE, m), *given, sums)
            for top, sums in zip(blocks, J, strict=True)
            for i in range(0, c, part)
        )
        return E, J.sum(axis=0)

    def _along_axes(self, image: Array) -> Array:
        """Image points (c, m, 2) in the order of the camera's x and y, (2, c, m)."""
        return _by_axis(image[..., ::-1] if self._along_u else image)

    def _in_flange(self, T_base_flange: Array) -> Array:
        """Target points in the flange frame, (3, 1, m) [m]; kept, since the nominal arm comes again and again."""
        if self._last is None or self._last[0] is not T_base_flange:
            there = carry(inverse(T_base_flange), self._pose, self._xyz)
            self._last = T_base_flange, _by_axis(there)
        return self._last[1]


def runs_of(pose: Ints) -> Ints:
    """Rows that follow one another in one pose, (m,) -> (r, 3): the pose, the first row, the one after the last."""
    starts = np.flatnonzero(np.diff(pose, prepend=-1))
    return np.column_stack([pose[starts], starts, np.append(starts[1:], len(pose))])


def _by_axis(points: Array) -> Array:
    """(c, m, axes) -> (axes, c, m): long rows make vector code."""
    return np.ascontiguousarray(np.moveaxis(points, -1, 0))
