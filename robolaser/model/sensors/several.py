"""Several sensors in one data set: the rows of all of them, with the parameters that they share once."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.several_sensors import with_points_of
from robolaser.errors import EstimationError
from robolaser.model.error_source import ErrorSource
from robolaser.model.sensors.camera_view import CameraView
from robolaser.model.sensors.known_distances import KnownDistances
from robolaser.model.sensors.pose_motions import pose_centroids
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.sensors.shared_names import shared_names
from robolaser.model.stages import Perturbation, Stage
from robolaser.model.tangents import ChainRule, Tangent
from robolaser.parameters import Parameter, Parameters, Values


@final
@dataclass(frozen=True, eq=False)
class _Part:
    """One of the sensors.

    Attributes:
        number: Among the sensors.
        name: Of the sensor.
        rows: Which of the whole's rows it saw, (m,).
        sensor: As for a data set of its own.
        scale: What a unit of its residuals counts for [m].
        named: Names of parameters in the whole by its own.
    """

    number: int
    name: str
    rows: Ints
    sensor: Sensor
    scale: float
    named: Mapping[str, str]

    @property
    def numbers(self) -> int:
        """Of a row."""
        return self.sensor.format.numbers

    def values(self, values: Values) -> dict[str, Array]:
        """Those that it has, by its own names."""
        return {own: values[whole] for own, whole in self.named.items() if whole in values}

    def of_whole(self, values: Values) -> dict[str, Array]:
        """Its values by their names in the whole."""
        return {self.named[own]: value for own, value in values.items()}


@final
class Several(Sensor):
    """All sensors of a data set as one: a row of the whole is a row of one of them, in metres.

    Where a row has fewer numbers than the widest sensor's, those beyond are zero and count for nothing. A unit that is
    no metre counts for `Member.metres_per_unit`: a corner's pixel for what it typically shows on the target.

    Args:
        dataset: With `members`.
        sensor_of: The sensor of each part.
    """

    def __init__(self, dataset: Dataset, sensor_of: Callable[[Dataset, int], Sensor]) -> None:
        super().__init__(dataset)
        bare = [sensor_of(part, number) for number, part in enumerate(dataset.parts)]
        named = shared_names(dataset.members, [sensor.free + sensor.derived for sensor in bare])
        self._sensor_of = sensor_of
        self._parts = tuple(
            _Part(
                number,
                member.name,
                np.flatnonzero(dataset.points.sensor == number),
                sensor_of(replace(dataset.parts[number], parameters=_given(dataset.parameters, named[number])), number),
                member.metres_per_unit,
                named[number],
            )
            for number, member in enumerate(dataset.members)
        )
        first = self._parts[0].sensor
        self.__dict__.update(
            format=dataset.format,
            stages=frozenset(stage for part in self._parts for stage in part.sensor.stages),
            whole_pose_errors=any(part.sensor.whole_pose_errors for part in self._parts),
            task=first.task,
            row_point=first.row_point,
            frame=first.frame,
            has_laser_plane=lambda: any(part.sensor.has_laser_plane() for part in self._parts),
        )

    def _names(self, of: Callable[[Sensor], Sequence[str]]) -> tuple[str, ...]:
        return tuple(dict.fromkeys(part.named[name] for part in self._parts for name in of(part.sensor)))

    @property
    def free(self) -> tuple[str, ...]:
        """Those that one of the sensors has."""
        return self._names(lambda sensor: sensor.free)

    @property
    def derived(self) -> tuple[str, ...]:
        """Those that no sensor has among its free ones."""
        free = set(self.free)
        return tuple(name for name in self._names(lambda sensor: sensor.derived) if name not in free)

    @property
    def fixed(self) -> tuple[str, ...]:
        """Those of all sensors."""
        return self._names(lambda sensor: sensor.fixed)

    def fix_gauge(self, values: Values) -> Values:
        """Each sensor's, one after the other."""
        for part in self._parts:
            values = {**values, **part.of_whole(part.sensor.fix_gauge(part.values(values)))}
        return values

    def parameters(self, T_base_flange: Array, perturb: Perturbation) -> Parameters:
        """Each sensor's, one after the other: what one has found is known to the next.

        Raises:
            DataError: The data set gives one that no sensor has, or not all free ones of a sensor.
        """
        self.check_given()
        found = dict(self.dataset.parameters)
        for part in self._by_knowledge():
            knowing = self._sensor_of(replace(part.sensor.dataset, parameters=_given(found, part.named)), part.number)
            own = knowing.parameters(T_base_flange, self._perturbed(part, perturb))
            found |= {part.named[item.name]: replace(item, name=part.named[item.name]) for item in own.items}
        return Parameters(tuple(found[name] for name in self.free + self.derived))

    def _by_knowledge(self) -> list[_Part]:
        """Sensors whose free parameters are given, then those that start from a closed form, laser planes last."""
        given = self.dataset.parameters

        def rank(part: _Part) -> tuple[bool, bool]:
            return any(part.named[name] not in given for name in part.sensor.free), part.sensor.has_laser_plane()

        return sorted(self._parts, key=rank) if any(rank(part)[0] for part in self._parts) else list(self._parts)

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """Each sensor's, those with the most rows first; the others leave what it found.

        Raises:
            EstimationError: What one could not find no other did.
        """
        found: dict[str, Array] = {}
        failed: list[EstimationError] = []
        for part in sorted(self._parts, key=lambda part: -len(part.rows)):
            try:
                own = part.sensor.initialize(
                    part.values({**values, **found}), T_base_flange, self._perturbed(part, perturb)
                )
            except EstimationError as error:  # few rows of it, as of a sample: another sensor may find the same
                failed.append(error)
                continue
            found = {**part.of_whole(own), **found}
        if failed and not all(name in found for name in self.derived):
            raise failed[0]
        return {name: value for name, value in found.items() if name in self.derived}

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Each sensor's, in metres, (c, m, k) [m]."""
        every = self._each(lambda part, *at: part.scale * part.sensor.residuals(*at), values, T_base_flange, perturb)
        return self._together(every, self.format.numbers)

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Each sensor's own rows at the places of their points."""
        every = []
        for part in self._parts:
            own = self.own_rows(residuals, part.name)
            every.append(part.sensor.in_metres(own, part.values(values), T_base_flange, self._perturbed(part, perturb)))
        return self._together(every, max(one.shape[-1] for one in every))

    @property
    def row_numbers(self) -> Ints:
        """Numbers of each row, (m,)."""
        numbers = np.empty(len(self.dataset.points), dtype=np.int64)
        for part in self._parts:
            numbers[part.rows] = part.numbers
        return numbers

    @property
    def stages_of_rows(self) -> Sequence[tuple[Ints, frozenset[Stage]]]:
        """Each sensor's."""
        return [(part.rows, part.sensor.stages) for part in self._parts]

    @property
    def kinds_of_rows(self) -> dict[str, tuple[Ints, str, int]]:
        """Each sensor's, by its name."""
        formats = ((part, part.sensor.format) for part in self._parts)
        return {part.name: (part.rows, declared.unit, declared.angles) for part, declared in formats}

    def own_rows(self, residuals: Array, kind: str) -> Array:
        """Rows of one sensor as it has them, (..., m, k) -> (..., its rows, its numbers) [its unit]."""
        part = next(part for part in self._parts if part.name == kind)
        return np.asarray(residuals[..., part.rows, : part.numbers] / part.scale)

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Each sensor's."""
        return self._or_none(lambda part, *at: part.sensor.known(*at), values, T_base_flange, perturb)

    def in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Each sensor's."""
        return self._or_none(lambda part, *at: part.sensor.in_base(*at), values, T_base_flange, perturb)

    def in_view(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Bools:
        """Each sensor's."""
        seen = np.ones(len(self.dataset.points), dtype=bool)
        every = self._each(lambda part, *at: part.sensor.in_view(*at), values, T_base_flange, perturb)
        for part, own in zip(self._parts, every, strict=True):
            seen[part.rows] = own
        return seen

    def jacobian(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Derivatives by `free`, then `derived`, (c, m, k, d); None where one sensor does not know them all."""
        every = self._each(lambda part, *at: part.sensor.jacobian(*at), values, T_base_flange, perturb)
        if any(own is None for own in every):
            return None
        column = {name: place for place, name in enumerate(self.free + self.derived)}
        c = max(len(own) for own in every if own is not None)
        slopes = np.zeros((c, len(self.dataset.points), self.format.numbers, len(column)))
        for part, own in zip(self._parts, every, strict=True):
            assert own is not None  # as was seen above
            of = [column[part.named[name]] for name in part.sensor.free + part.sensor.derived]
            slopes[:, part.rows[:, None, None], np.arange(part.numbers)[:, None], of] = part.scale * own
        return slopes

    def slopes(self, flange: Tangent, chain: ChainRule) -> Array | None:
        """Each sensor's by all parameters, by its own as its `jacobian` has them, if it has."""
        c = len(next(iter(chain.values.values())))
        slopes = np.zeros((c, chain.count, len(self.dataset.points), self.format.numbers))
        for part in self._parts:
            of_part = chain.of_rows(part.named, part.rows, len(self.dataset.points))
            own = part.sensor.slopes(flange, of_part)
            if own is None:
                return None
            known = part.sensor.jacobian(part.values(chain.values), flange.value, of_part.perturbation)
            if known is not None:
                own = np.broadcast_to(own, (c, *own.shape[1:])).copy()
                own[:, chain.columns(tuple(part.named[name] for name in part.sensor.free + part.sensor.derived))] = (
                    np.moveaxis(known, -1, 1)
                )
            slopes[:, :, part.rows, : part.numbers] = part.scale * own
        return slopes

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """Each sensor's, named `SENSOR.pixel`; rows of other sensors they do not move."""
        every = self._each(lambda part, *at: part.sensor.row_errors(*at), values, T_base_flange, perturb)
        return [self._source(part, source) for part, own in zip(self._parts, every, strict=True) for source in own]

    def _source(self, part: _Part, source: ErrorSource) -> ErrorSource:
        m = len(self.dataset.points)
        effect = np.zeros((m, self.format.numbers, source.effect.shape[2]))
        effect[part.rows, : part.numbers] = part.scale * source.effect
        group = np.arange(m)
        _, group[part.rows] = np.unique(source.group, return_inverse=True)
        others = np.setdiff1d(np.arange(m), part.rows)
        group[others] = len(part.rows) + np.arange(len(others))
        return replace(source, name=f"{part.name}.{source.name}", effect=effect, group=group)

    def pivots(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The middle of the points that are known in the base frame at each pose; else the flange, (n, 3) [m]."""
        pivot: Array = T_base_flange[0, :, :3, 3].copy()
        points, of_pose = [np.empty((0, 3))], [np.empty(0, dtype=np.int64)]
        for part in self._parts:
            known = part.sensor.known(part.values(values), T_base_flange, self._perturbed(part, perturb))
            if known is not None and part.sensor.frame == Sensor.frame:
                points.append(known[0])
                of_pose.append(part.sensor.dataset.points.pose)
        number = np.concatenate(of_pose)
        middle = pose_centroids(np.concatenate(points), number, len(pivot))
        seen = np.bincount(number, minlength=len(pivot)) > 0
        pivot[seen] = middle[seen]
        return pivot

    def _optical(self) -> _Part:
        """The first with a camera on the flange; the first of all where there is none."""
        return next((part for part in self._parts if Stage.MOUNT in part.sensor.stages), self._parts[0])

    def camera(self, values: Values, perturb: Perturbation) -> CameraView | None:
        """The first sensor's that has one."""
        cameras = (part.sensor.camera(part.values(values), self._perturbed(part, perturb)) for part in self._parts)
        return next((camera for camera in cameras if camera is not None), None)

    def mount(self, values: Values, perturb: Perturbation) -> Array | None:
        """Of the first camera."""
        part = self._optical()
        return part.sensor.mount(part.values(values), self._perturbed(part, perturb))

    def flange_frames(self, values: Values, perturb: Perturbation) -> dict[str, Array]:
        """Those of all sensors; with the sensor's name where one differs from an earlier one of that name."""
        return self._frames(lambda sensor, *at: sensor.flange_frames(*at), values, perturb)

    @property
    def published_frames(self) -> tuple[str, ...]:
        """Those of all sensors."""
        return tuple(name for part in self._parts for name in part.sensor.published_frames)

    def base_frames(self, values: Values, perturb: Perturbation) -> dict[str, Array]:
        """Likewise."""
        return self._frames(lambda sensor, *at: sensor.base_frames(*at), values, perturb)

    def _frames(
        self, of: Callable[[Sensor, Values, Perturbation], dict[str, Array]], values: Values, perturb: Perturbation
    ) -> dict[str, Array]:
        frames: dict[str, Array] = {}
        for part in self._parts:
            own = of(part.sensor, part.values(values), self._perturbed(part, perturb))
            for name, T in own.items():
                if not np.array_equal(frames.setdefault(name, T), T):
                    frames[f"{part.name}_{name}"] = T
        return frames

    @property
    def known_distances(self) -> KnownDistances | None:
        """Those of all sensors, each once."""
        rows, noise = {}, self.dataset.noise
        for part in self._parts:
            own = part.sensor.known_distances
            if own is not None:
                noise = part.sensor.dataset.noise
                for first, second, distance in zip(own.first, own.second, own.known.tolist(), strict=True):
                    key = (tuple(part.named[name] for name in first), tuple(part.named[name] for name in second))
                    rows[key] = distance
        return KnownDistances.of([(*key, distance) for key, distance in rows.items()], noise) if rows else None

    def seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools] | None:
        """What all sensors would measure; a pose counts where all see theirs. None where one cannot tell."""
        found = [part.sensor.seen_from(part.values(values), T_base_flange) for part in self._parts]
        if any(one is None for one in found):
            return None
        seen = [one for one in found if one is not None]
        points = with_points_of(self.dataset, [points for points, _ in seen]).points
        order = np.argsort(points.pose, kind="stable")
        return points.take(order), np.logical_and.reduce([good for _, good in seen])

    @property
    def description(self) -> dict[str, Any]:
        """The first sensor's, and what each of them is."""
        every = [
            {"name": part.name, "kind": part.sensor.format.kind, **part.sensor.description} for part in self._parts
        ]
        return {**self._parts[0].sensor.description, "sensors": every}

    def _perturbed(self, part: _Part, perturb: Perturbation) -> Perturbation:
        return perturb.of_rows(part.rows, len(self.dataset.points))

    def _each(self, what: Callable[..., Any], values: Values, T_base_flange: Array, perturb: Perturbation) -> list[Any]:
        """What each sensor says."""
        return [what(part, part.values(values), T_base_flange, self._perturbed(part, perturb)) for part in self._parts]

    def _or_none(
        self, what: Callable[..., Any], values: Values, T_base_flange: Array, perturb: Perturbation
    ) -> Array | None:
        every = self._each(what, values, T_base_flange, perturb)
        return None if any(own is None for own in every) else self._together(every, 3)

    def _together(self, every: Sequence[Array], numbers: int) -> Array:
        """Rows (c or 1, m, k) of the sensors in the order of the whole's; numbers that a row does not have are zero."""
        c = max(len(own) for own in every)
        whole = np.zeros((c, len(self.dataset.points), numbers))
        for part, own in zip(self._parts, every, strict=True):
            whole[:, part.rows, : own.shape[-1]] = own
        return whole


def _given(parameters: Mapping[str, Parameter], named: Mapping[str, str]) -> dict[str, Parameter]:
    """What the data set says of a sensor's parameters, by the sensor's own names; without a session's, for all."""
    own = {whole.partition("@")[0]: name.partition("@")[0] for name, whole in named.items()}
    own |= {whole: name for name, whole in named.items()}
    return {own[name]: replace(item, name=own[name]) for name, item in parameters.items() if name in own}
