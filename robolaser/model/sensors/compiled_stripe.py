"""J of populations of stripe scanners in a compiled loop, for searches by cost alone on large data."""

from functools import partial
from types import ModuleType
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled import share_out
from robolaser.data.dataset import Dataset
from robolaser.geometry.camera import laser_plane
from robolaser.geometry.rigid_motion import carry, inverse
from robolaser.model.sensors.scanner_geometry import mount
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

AT_ONCE = 100_000
"""Candidates times rows that a thread takes at a time, a tenth of a millisecond: for less no other is woken up."""


@final
class CompiledStripe:
    """A stripe's data set with a placed target, laid out for the compiler.

    Args:
        dataset: What was measured.
    """

    def __init__(self, dataset: Dataset) -> None:
        self._dataset, self._along_u = dataset, dataset.stripe_axis == "u"
        pixel = dataset.points["pixel"]
        self._image = np.ascontiguousarray((pixel[:, ::-1] if self._along_u else pixel).T)
        self._last: tuple[Array, Array] | None = None

    @property
    def _loops(self) -> ModuleType:
        from robolaser.model.sensors import stripe_loops  # noqa: PLC0415 - loads numba

        return stripe_loops

    def costs(self, values: Values, T_base_flange: Array) -> Array:
        """J without effects, (c,) [m²].

        The target is carried to the flange frame once for all candidates: distances stay what they are, and no pose is
        left in the loop.

        Args:
            values: The scanner's parameters, (c,) each.
            T_base_flange: Of the arm that is the same for all candidates, (1, n, 4, 4).
        """
        J = np.empty(len(values["f"]))
        c, m = len(J), self._image.shape[1]
        plane, held = laser_plane(values)[:, 0], mount(self._dataset, values, Perturbation())[:, 0]
        given = (
            self._lens(values),
            *map(np.ascontiguousarray, (plane, held)),
            self._image,
            self._in_flange(T_base_flange),
        )
        part = max(1, AT_ONCE // m)
        share_out(partial(self._loops.costs, i, min(i + part, c), *given, J) for i in range(0, c, part))
        return J

    def _lens(self, values: Values) -> Array:
        """What `costs` of the loop needs of the camera, (c, 6): x goes along v and y against u, or along u and v."""
        v = values
        if self._along_u:
            return np.column_stack([v["v_0"], v["u_0"], v["s_v"], -v["s_u"], v["k"], v["f"]])
        return np.column_stack([v["u_0"], v["v_0"], v["s_u"], v["s_v"], v["k"], v["f"]])

    def _in_flange(self, T_base_flange: Array) -> Array:
        """Target points in the flange frame, (3, m) [m]; kept, since the nominal arm comes again and again."""
        if self._last is None or self._last[0] is not T_base_flange:
            points = self._dataset.points
            there = carry(inverse(T_base_flange), points.pose, points["xyz"][None])[0]
            self._last = T_base_flange, np.ascontiguousarray(there.T)
        return self._last[1]
