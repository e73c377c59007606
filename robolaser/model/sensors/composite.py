"""A sensor made of parts: each sees some of the rows and knows the parameters by names of its own."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar, cast, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.duals import is_dual
from robolaser.model.sensors.camera_view import CameraView
from robolaser.model.sensors.known_distances import KnownDistances
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

T = TypeVar("T")
A = TypeVar("A", bound=np.ndarray[Any, Any])


@final
@dataclass(frozen=True, eq=False)
class Part:
    """One of the parts."""

    name: str  # of the sensor, or of the session
    rows: Ints  # which of the whole's rows it saw, (m,)
    sensor: Sensor  # as for a data set of its own
    named: Mapping[str, str]  # names of parameters in the whole by its own
    scale: float = 1.0  # what a unit of its residuals counts for in the whole's

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of its parameters by its own."""
        return self.sensor.free + self.sensor.derived

    @property
    def numbers(self) -> int:
        """Of a row."""
        return self.sensor.format.numbers

    def values(self, values: Mapping[str, T]) -> dict[str, T]:
        """Those that it has, by its own names."""
        return {own: values[whole] for own, whole in self.named.items() if whole in values}

    def of_whole(self, values: Mapping[str, T]) -> dict[str, T]:
        """Its values by their names in the whole."""
        return {self.named[own]: value for own, value in values.items() if own in self.named}


class Composite(Sensor, registered=False):
    """A sensor whose rows are those of its parts, each as its part has them.

    Where a row has fewer numbers than the widest part's, those beyond are zero.
    """

    def __init__(self, dataset: Dataset, parts: Sequence[Part]) -> None:
        super().__init__(dataset)
        self._parts = tuple(parts)

    def _names(self, of: Callable[[Sensor], Sequence[str]]) -> tuple[str, ...]:
        return tuple(dict.fromkeys(part.named[name] for part in self._parts for name in of(part.sensor)))

    @property
    def free(self) -> tuple[str, ...]:
        """Those that one of the parts has."""
        return self._names(lambda sensor: sensor.free)

    @property
    def derived(self) -> tuple[str, ...]:
        """Those that no part has among its free ones."""
        free = set(self.free)
        return tuple(name for name in self._names(lambda sensor: sensor.derived) if name not in free)

    @property
    def fixed(self) -> tuple[str, ...]:
        """Those of all parts."""
        return self._names(lambda sensor: sensor.fixed)

    @property
    def put_anew(self) -> tuple[str, ...]:
        """Those of all parts."""
        return self._names(lambda sensor: sensor.put_anew)

    @property
    def _largest_first(self) -> list[Part]:
        return sorted(self._parts, key=lambda part: -len(part.rows))

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Each part's, times its scale."""
        return self._together(
            self._each(lambda part, *at: part.scale * part.sensor.residuals(*at), values, T_base_flange, perturb)
        )

    def _own_rows(self, residuals: Array, part: Part) -> Array:
        """Rows of one part as it has them, (..., m, k) -> (..., its rows, its numbers) [its unit]."""
        return np.asarray(residuals[..., part.rows, : part.numbers] / part.scale)

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Each part's own rows at the places of their points."""
        return self._together(
            self._each(
                lambda part, *at: part.sensor.in_metres(self._own_rows(residuals, part), *at),
                values,
                T_base_flange,
                perturb,
            )
        )

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Each part's; None where one has none."""
        return self._or_none(lambda part, *at: part.sensor.known(*at), values, T_base_flange, perturb)

    def in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Each part's; None where one has none."""
        return self._or_none(lambda part, *at: part.sensor.in_base(*at), values, T_base_flange, perturb)

    def in_view(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Bools:
        """Each part's."""
        parts = self._each(lambda part, *at: part.sensor.in_view(*at), values, T_base_flange, perturb)
        return self._together(parts, axis=0)

    def camera(self, values: Values, perturb: Perturbation) -> CameraView | None:
        """That of the first part that has one."""
        cameras = (part.sensor.camera(part.values(values), self._perturbed(part, perturb)) for part in self._parts)
        return next((camera for camera in cameras if camera is not None), None)

    def flange_frames(self, values: Values, perturb: Perturbation) -> dict[str, Array]:
        """Those of all parts; with the part's name where one differs from an earlier one of that name."""
        return self._frames(lambda part, *at: part.sensor.flange_frames(*at), values, perturb)

    def base_frames(self, values: Values, perturb: Perturbation) -> dict[str, Array]:
        """Likewise."""
        return self._frames(lambda part, *at: part.sensor.base_frames(*at), values, perturb)

    def _frames(
        self, of: Callable[[Part, Values, Perturbation], dict[str, Array]], values: Values, perturb: Perturbation
    ) -> dict[str, Array]:
        frames: dict[str, Array] = {}
        for part in self._parts:
            for name, pose in of(part, part.values(values), self._perturbed(part, perturb)).items():
                if not np.array_equal(frames.setdefault(name, pose), pose):
                    frames[self._frame_of_part(name, part)] = pose
        return frames

    def _frame_of_part(self, name: str, part: Part) -> str:
        return f"{part.name}_{name}"

    @property
    def known_distances(self) -> KnownDistances | None:
        """Those of all parts, each once."""
        rows, noise = {}, self.dataset.noise
        for part in self._parts:
            own = part.sensor.known_distances
            if own is not None:
                noise = part.sensor.dataset.noise
                for first, second, distance in zip(own.first, own.second, own.known.tolist(), strict=True):
                    key = (tuple(part.named[name] for name in first), tuple(part.named[name] for name in second))
                    rows[key] = distance
        return KnownDistances.of([(*key, distance) for key, distance in rows.items()], noise) if rows else None

    def _perturbed(self, part: Part, perturb: Perturbation) -> Perturbation:
        return perturb.of_rows(part.rows, len(self.dataset.points))

    def _each(self, what: Callable[..., T], values: Values, T_base_flange: Array, perturb: Perturbation) -> list[T]:
        """What each part says."""
        return [what(part, part.values(values), T_base_flange, self._perturbed(part, perturb)) for part in self._parts]

    def _or_none(
        self, what: Callable[..., Array | None], values: Values, T_base_flange: Array, perturb: Perturbation
    ) -> Array | None:
        parts = [part for part in self._each(what, values, T_base_flange, perturb) if part is not None]
        return self._together(parts) if len(parts) == len(self._parts) else None

    def _together(self, parts: Sequence[A], axis: int = 1) -> A:
        """Rows of the parts in the order of the whole's; candidates may be one for all in some of them."""
        before = np.broadcast_shapes(*(own.shape[:axis] for own in parts))
        after = np.max([own.shape[axis + 1 :] for own in parts], axis=0).astype(int)
        like = next((own for own in parts if is_dual(own)), parts[0])
        whole = np.zeros_like(like, shape=(*before, len(self.dataset.points), *after))
        for part, own in zip(self._parts, parts, strict=True):
            whole[(slice(None),) * axis + (part.rows, *(slice(size) for size in own.shape[axis + 1 :]))] = own
        return cast("A", whole)
