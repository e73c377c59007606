"""Several sensors in one data set: the rows of all of them, with the parameters that they share once."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.several_sensors import with_points_of
from robolaser.errors import EstimationError
from robolaser.model.error_source import ErrorSource
from robolaser.model.sensors.composite import Composite, Part
from robolaser.model.sensors.pose_motions import pose_centroids
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.sensors.shared_names import shared_names
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Parameter, Parameters, Values


@final
class Several(Composite):
    """All sensors of a data set as one: a row of the whole is a row of one of them, in metres.

    Numbers beyond a row's own count for nothing. A unit that is no metre counts for `Member.metres_per_unit`: a
    corner's pixel for what it typically shows on the target.

    Args:
        dataset: With `members`.
        sensor_of: The sensor of each part.
    """

    def __init__(self, dataset: Dataset, sensor_of: Callable[[Dataset, int], Sensor]) -> None:
        bare = [sensor_of(part, number) for number, part in enumerate(dataset.parts)]
        named = shared_names(dataset.members, [sensor.free + sensor.derived for sensor in bare])
        self._sensor_of = sensor_of
        parts = [
            Part(
                member.name,
                np.flatnonzero(dataset.points.sensor == number),
                sensor_of(replace(dataset.parts[number], parameters=_given(dataset.parameters, named[number])), number),
                named[number],
                member.metres_per_unit,
            )
            for number, member in enumerate(dataset.members)
        ]
        super().__init__(dataset, parts)
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

    @property
    def seen(self) -> tuple[tuple[Ints, Dataset], ...]:
        """Rows of each sensor and what it saw, with its parameters by its own names."""
        return tuple((part.rows, part.sensor.dataset) for part in self._parts)

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
            knowing = self._sensor_of(
                replace(part.sensor.dataset, parameters=_given(found, part.named)), self._parts.index(part)
            )
            own = knowing.parameters(T_base_flange, self._perturbed(part, perturb))
            found |= {part.named[item.name]: replace(item, name=part.named[item.name]) for item in own.items}
        return Parameters(tuple(found[name] for name in self.free + self.derived))

    def _by_knowledge(self) -> list[Part]:
        """Sensors whose free parameters are given, then those that start from a closed form, laser planes last."""
        given = self.dataset.parameters

        def rank(part: Part) -> tuple[bool, bool]:
            return any(part.named[name] not in given for name in part.sensor.free), part.sensor.has_laser_plane()

        return sorted(self._parts, key=rank) if any(rank(part)[0] for part in self._parts) else list(self._parts)

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """Each sensor's, those with the most rows first; the others leave what it found.

        Raises:
            EstimationError: What one could not find no other did.
        """
        found: dict[str, Array] = {}
        failed: list[EstimationError] = []
        for part in self._largest_first:
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

    @property
    def row_numbers(self) -> Ints:
        """Numbers of each row, (m,)."""
        return self._together([np.full(len(part.rows), part.numbers) for part in self._parts], axis=0)

    @property
    def stages_of_rows(self) -> Sequence[tuple[Ints, frozenset[Stage]]]:
        """Each sensor's."""
        return [(part.rows, part.sensor.stages) for part in self._parts]

    @property
    def kinds_of_rows(self) -> dict[str, tuple[Ints, str, int]]:
        """Each sensor's, by its name."""
        formats = ((part, part.sensor.format) for part in self._parts)
        return {part.name: (part.rows, declared.unit, declared.angles) for part, declared in formats}

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """Each sensor's, named `SENSOR.pixel`; rows of other sensors they do not move."""
        every = self._each(lambda part, *at: part.sensor.row_errors(*at), values, T_base_flange, perturb)
        return [self._source(part, source) for part, own in zip(self._parts, every, strict=True) for source in own]

    def _source(self, part: Part, source: ErrorSource) -> ErrorSource:
        m = len(self.dataset.points)
        effect = np.zeros((m, self.format.numbers, source.effect.shape[2]))
        effect[part.rows, : part.numbers] = part.scale * source.effect
        of_pose = self.dataset.points.pose
        if np.array_equal(source.group, of_pose[part.rows]):
            group = of_pose
        else:
            group = np.arange(m)
            _, group[part.rows] = np.unique(source.group, return_inverse=True)
            others = np.setdiff1d(np.arange(m), part.rows)
            group[others] = len(part.rows) + np.arange(len(others))
        return replace(source, name=f"{part.name}.{source.name}", effect=effect, group=group)

    def own_rows(self, residuals: Array, kind: str) -> Array:
        """Rows of one sensor as it has them, (..., m, k) -> (..., its rows, its numbers) [its unit]."""
        return self._own_rows(residuals, next(part for part in self._parts if part.name == kind))

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

    def mount(self, values: Values, perturb: Perturbation) -> Array | None:
        """Of the first camera on the flange, else of the first sensor."""
        on_flange = (part for part in self._parts if Stage.MOUNT in part.sensor.stages)
        part = next(on_flange, self._parts[0])
        return part.sensor.mount(part.values(values), self._perturbed(part, perturb))

    @property
    def published_frames(self) -> tuple[str, ...]:
        """Those of all sensors."""
        return tuple(name for part in self._parts for name in part.sensor.published_frames)

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


def _given(parameters: Mapping[str, Parameter], named: Mapping[str, str]) -> dict[str, Parameter]:
    """What the data set says of a sensor's parameters, by the sensor's own names; without a session's, for all."""
    own = {whole.partition("@")[0]: name.partition("@")[0] for name, whole in named.items()}
    own |= {whole: name for name, whole in named.items()}
    return {own[name]: replace(item, name=own[name]) for name, item in parameters.items() if name in own}
