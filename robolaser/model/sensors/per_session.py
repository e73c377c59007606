"""A sensor in several sessions: where things were put is each session's own, the sensor itself is shared."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.sessions import OWN, Sessions
from robolaser.errors import DataError
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.sensors.composite import Composite, Part
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.stages import Perturbation
from robolaser.parameters import Parameter, Parameters, Values


@final
class PerSession(Composite):
    """A sensor of any kind for a data set of several sessions.

    Its parameters are those of the kind, some of them once for each session: `base.x@SESSION`. Each session's rows are
    those of an ordinary sensor that sees only them.
    """

    def __init__(self, dataset: Dataset, kind: type[Sensor], sessions: Sessions) -> None:
        super().__init__(dataset, list(_parts(dataset, kind, sessions)))
        self.__dict__.update(
            format=kind.format,
            stages=kind.stages,
            whole_pose_errors=kind.whole_pose_errors,
            task=kind.task,
            row_point=kind.row_point,
            frame=kind.frame,
            closed_form=kind.closed_form,
            no_start=kind.no_start,
            has_laser_plane=kind.has_laser_plane,
        )
        self._sessions = sessions
        self.dataset = replace(dataset, parameters=dict(self._given()))

    def _given(self) -> Iterator[tuple[str, Parameter]]:
        """What the data set says of parameters: of `base.x` for all sessions, of `base.x@SESSION` for one."""
        given = self.dataset.parameters
        plain = {name for part in self._parts for name in part.parameters if self._sessions.is_own(name)}
        for name, item in given.items():
            if name not in plain:
                yield name, item
            for own in (self._sessions.named(name, session) for session in self._sessions.names if name in plain):
                if own not in given:
                    yield own, replace(item, name=own)

    @property
    def conditionally_linear(self) -> tuple[str, ...]:
        """The kind's; what sessions share is found in the one with the most rows."""
        return self._names(lambda sensor: sensor.conditionally_linear)

    def spans(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """The kind's, in each session."""
        found: dict[str, float] = {}
        for part in self._parts:
            found |= part.of_whole(part.sensor.spans(part.values(values)))
        return found

    def parameters(self, T_base_flange: Array, perturb: Perturbation) -> Parameters:
        """As for any sensor.

        Raises:
            DataError: Also where `[sessions] own` names what this sensor does not have.
        """
        known = {name for part in self._parts for name in part.parameters}
        if self._sessions.own != OWN:
            for pattern in self._sessions.own:
                if not any(replace(self._sessions, own=(pattern,)).is_own(name) for name in known):
                    groups = {name.partition(".")[0] + ".*" if "." in name else name for name in known}
                    raise DataError(
                        f"dataset.toml, [sessions] own: '{pattern}' matches no parameter of this sensor, which has"
                        f" {', '.join(sorted(groups))}.",
                        file="dataset.toml",
                        column="[sessions] own",
                    )
        return super().parameters(T_base_flange, perturb)

    def fix_gauge(self, values: Values) -> Values:
        """The kind's, in each session."""
        fixed = [part.of_whole(part.sensor.fix_gauge(part.values(values))) for part in self._parts]
        return {**values, **{name: value for own in fixed for name, value in own.items()}}

    def start(self, known: Mapping[str, float], T_base_flange: Array) -> Mapping[str, float]:
        """What sessions share from the one with the most rows, the rest with it."""
        found = dict(known)
        for part in self._largest_first:
            own = part.values(found)
            if own.keys() >= set(part.sensor.free):
                values = {name: np.array([value]) for name, value in own.items()}
                derived = part.sensor.initialize(values, T_base_flange, Perturbation())
                started: Mapping[str, float] = {name: float(value[0]) for name, value in derived.items()}
            else:
                started = part.sensor.start(own, T_base_flange)
            found = part.of_whole(started) | found
        return found

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """From each session's rows; what sessions share, from the one with the most rows."""
        found: dict[str, Array] = {}
        for part in self._largest_first:
            known = part.values({**values, **found})
            found = part.of_whole(part.sensor.initialize(known, T_base_flange, self._perturbed(part, perturb))) | found
        return found

    def solve_conditional(
        self, values: Values, T_base_flange: Array, perturb: Perturbation, bounds: Mapping[str, Parameter]
    ) -> Values:
        """What sessions share fits best to the one with the most rows, the rest with it."""
        linear: dict[str, Array] = {}
        for part in self._largest_first:
            wanted = {part.named[name]: name for name in part.sensor.conditionally_linear}
            if wanted.keys() <= linear.keys():
                continue
            own = part.sensor.solve_conditional(
                part.values(values), T_base_flange, self._perturbed(part, perturb), part.values(bounds)
            )
            linear = {**{whole: own[name] for whole, name in wanted.items()}, **linear}
        if not self.derived:
            return linear
        return {**linear, **self.initialize({**values, **linear}, T_base_flange, perturb)}

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """The kind's; no row shares its errors with one of another session."""
        parts = self._each(lambda part, *at: part.sensor.row_errors(*at), values, T_base_flange, perturb)
        return [self._source([part[i] for part in parts]) for i in range(len(parts[0]))]

    def _source(self, parts: Sequence[ErrorSource]) -> ErrorSource:
        before, groups = 0, []
        for part in parts:
            groups.append(part.group + before)
            before += int(part.group.max()) + 1
        if all(part.isotropic for part in parts):
            effect = along_each_axis(len(self.dataset.points), parts[0].effect.shape[1])
        else:
            effect = self._together([part.effect for part in parts], axis=0)
        return replace(parts[0], effect=effect, group=self._together(groups, axis=0))

    def moved_with_pose(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> tuple[Array, Array]:
        """Each session's."""
        parts = self._each(lambda part, *at: part.sensor.moved_with_pose(*at), values, T_base_flange, perturb)
        shifts, turns = zip(*parts, strict=True)
        return self._together(shifts, axis=0), self._together(turns, axis=0)

    def mount(self, values: Values, perturb: Perturbation) -> Array | None:
        """At each pose as in its session."""
        parts = [part.sensor.mount(part.values(values), perturb) for part in self._parts]
        mounts = [own for own in parts if own is not None]
        if not mounts or all(np.array_equal(mounts[0], other) for other in mounts[1:]):
            return mounts[0] if mounts else None
        of_pose = self.dataset.session_of_pose
        mount = np.broadcast_to(mounts[0], (len(mounts[0]), len(of_pose), 4, 4)).copy()
        for part, own in zip(self._parts, mounts, strict=True):
            here = of_pose == self._sessions.names.index(part.name)
            mount[:, here] = np.broadcast_to(own, mount.shape)[:, here]
        return mount

    @property
    def published_frames(self) -> tuple[str, ...]:
        """The kind's, as they are in the first session."""
        return self._parts[0].sensor.published_frames

    def _frame_of_part(self, name: str, part: Part) -> str:
        return f"{name}_{part.name}"

    def prefix_of(self, name: str) -> str | None:
        """The kind's, without the name of a session."""
        return next((prefix for part in self._parts if (prefix := part.sensor.prefix_of(name)) is not None), None)

    def squares(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The sum over sessions."""
        parts = self._each(lambda part, *at: part.sensor.squares(*at), values, T_base_flange, perturb)
        return np.asarray(np.sum(parts, axis=0))

    def seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools] | None:
        """What would be measured with things as they are in the last session."""
        last = self._parts[-1]
        return last.sensor.seen_from(last.values(values), T_base_flange)

    def aims(self, values: Values, T_base_flange: Array) -> tuple[Array, Array] | None:
        """Likewise."""
        last = self._parts[-1]
        return last.sensor.aims(last.values(values), T_base_flange)

    def undetermined(self, T_base_flange: Array) -> str:
        """Sessions share the sensor: one that tells where it sits is enough for all."""
        reasons = [part.sensor.undetermined(T_base_flange) for part in self._parts]
        return reasons[0] if all(reasons) else ""

    @property
    def description(self) -> dict[str, Any]:
        """The kind's."""
        return self._parts[0].sensor.description

    @property
    def held_out_groups(self) -> Ints | None:
        """The kind's, none of them in two sessions."""
        groups, before = [], 0
        for part in self._parts:
            own = part.sensor.held_out_groups
            if own is None:
                return None
            groups.append(own + before)
            before += int(own.max()) + 1
        return self._together(groups, axis=0)

    def located_apart(self, errors: Array) -> Array:
        """The kind's, in each session."""
        return self._together([part.sensor.located_apart(errors[part.rows]) for part in self._parts], axis=0)


def _parts(dataset: Dataset, kind: type[Sensor], sessions: Sessions) -> Iterator[Part]:
    """Each session that has points, with a sensor of that kind for its rows and all poses."""
    of_row = dataset.session_of_pose[dataset.points.pose]
    for number, name in enumerate(sessions.names):
        rows = np.flatnonzero(of_row == number)
        if len(rows):
            sensor = kind(replace(dataset, points=dataset.points.take(rows), sessions=None))
            yield Part(name, rows, sensor, {own: sessions.named(own, name) for own in sensor.free + sensor.derived})
