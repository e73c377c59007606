"""A sensor in several sessions: where things were put is each session's own, the sensor itself is shared."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar, cast, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.sessions import OWN, Sessions
from robolaser.errors import DataError
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.sensors.camera_view import CameraView
from robolaser.model.sensors.known_distances import KnownDistances
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.sensors.session_parts import SessionPart, session_parts
from robolaser.model.stages import Perturbation
from robolaser.model.tangents import ChainRule, Tangent
from robolaser.parameters import Parameter, Parameters, Values

T = TypeVar("T")
A = TypeVar("A", bound=np.ndarray[Any, Any])


@final
class PerSession(Sensor):
    """A sensor of any kind for a data set of several sessions.

    Its parameters are those of the kind, some of them once for each session: `base.x@SESSION`. Each session's rows are
    those of an ordinary sensor that sees only them.
    """

    def __init__(self, dataset: Dataset, kind: type[Sensor], sessions: Sessions) -> None:
        super().__init__(dataset)
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
        self._every = tuple(session_parts(dataset, kind, sessions))
        self.dataset = replace(dataset, parameters=dict(self._given()))

    def _given(self) -> Iterator[tuple[str, Parameter]]:
        """What the data set says of parameters: of `base.x` for all sessions, of `base.x@SESSION` for one."""
        given = self.dataset.parameters
        plain = {name for one in self._every for name in one.parameters if self._sessions.is_own(name)}
        for name, item in given.items():
            if name not in plain:
                yield name, item
            for own in (self._sessions.named(name, session) for session in self._sessions.names if name in plain):
                if own not in given:
                    yield own, replace(item, name=own)

    @property
    def free(self) -> tuple[str, ...]:
        """The kind's."""
        return self._names(lambda sensor: sensor.free)

    @property
    def derived(self) -> tuple[str, ...]:
        """The kind's."""
        return self._names(lambda sensor: sensor.derived)

    @property
    def fixed(self) -> tuple[str, ...]:
        """The kind's."""
        return self._names(lambda sensor: sensor.fixed)

    @property
    def conditionally_linear(self) -> tuple[str, ...]:
        """The kind's; what sessions share is found in the one with the most rows."""
        return self._names(lambda sensor: sensor.conditionally_linear)

    def spans(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """The kind's, in each session."""
        found: dict[str, float] = {}
        for one in self._every:
            named = {name: self._sessions.named(name, one.name) for name in one.parameters}
            own = one.sensor.spans({name: values[whole] for name, whole in named.items() if whole in values})
            found |= {named[name]: span for name, span in own.items() if name in named}
        return found

    def _names(self, of: Callable[[Sensor], Sequence[str]]) -> tuple[str, ...]:
        named = (self._sessions.named(name, one.name) for one in self._every for name in of(one.sensor))
        return tuple(dict.fromkeys(named))

    def _values(self, one: SessionPart, values: Values) -> dict[str, Array]:
        """A session's values by the names that they have without sessions."""
        named = {name: self._sessions.named(name, one.name) for name in one.parameters}
        return {name: values[own] for name, own in named.items() if own in values}

    def _of_whole(self, one: SessionPart, values: Values) -> dict[str, Array]:
        return {self._sessions.named(name, one.name): value for name, value in values.items()}

    @property
    def _largest_first(self) -> list[SessionPart]:
        return sorted(self._every, key=lambda one: -len(one.rows))

    def parameters(self, T_base_flange: Array, perturb: Perturbation) -> Parameters:
        """As for any sensor.

        Raises:
            DataError: Also where `[sessions] own` names what this sensor does not have.
        """
        known = {name for one in self._every for name in one.parameters}
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
        fixed = [self._of_whole(one, one.sensor.fix_gauge(self._values(one, values))) for one in self._every]
        return {**values, **{name: value for one in fixed for name, value in one.items()}}

    def start(self, known: Mapping[str, float], T_base_flange: Array) -> Mapping[str, float]:
        """What sessions share from the one with the most rows, the rest with it."""
        found = dict(known)
        for one in self._largest_first:
            named = {name: self._sessions.named(name, one.name) for name in one.parameters}
            own = {name: found[whole] for name, whole in named.items() if whole in found}
            if own.keys() >= set(one.sensor.free):
                values = {name: np.array([value]) for name, value in own.items()}
                derived = one.sensor.initialize(values, T_base_flange, Perturbation())
                started: Mapping[str, float] = {name: float(value[0]) for name, value in derived.items()}
            else:
                started = one.sensor.start(own, T_base_flange)
            found = {named[name]: value for name, value in started.items() if name in named} | found
        return found

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """From each session's rows; what sessions share, from the one with the most rows."""
        found: dict[str, Array] = {}
        for one in self._largest_first:
            known = self._values(one, {**values, **found})
            own = one.sensor.initialize(known, T_base_flange, self._perturbed(one, perturb))
            found = {**self._of_whole(one, own), **found}
        return found

    def solve_conditional(
        self, values: Values, T_base_flange: Array, perturb: Perturbation, bounds: Mapping[str, Parameter]
    ) -> Values:
        """What sessions share fits best to the one with the most rows, the rest with it."""
        linear: dict[str, Array] = {}
        for one in self._largest_first:
            wanted = {self._sessions.named(name, one.name): name for name in one.sensor.conditionally_linear}
            if wanted.keys() <= linear.keys():
                continue
            inside = {name: bounds[self._sessions.named(name, one.name)] for name in one.parameters}
            part = self._perturbed(one, perturb)
            own = one.sensor.solve_conditional(self._values(one, values), T_base_flange, part, inside)
            linear = {**{whole: own[name] for whole, name in wanted.items()}, **linear}
        if not self.derived:
            return linear
        return {**linear, **self.initialize({**values, **linear}, T_base_flange, perturb)}

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Each session's."""
        return self._together(self._each(lambda sensor, *at: sensor.residuals(*at), values, T_base_flange, perturb))

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Each session's."""
        return self._or_none(lambda sensor, *at: sensor.known(*at), values, T_base_flange, perturb)

    def in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Each session's."""
        return self._or_none(lambda sensor, *at: sensor.in_base(*at), values, T_base_flange, perturb)

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Each session's."""
        parts = [
            one.sensor.in_metres(
                residuals[:, one.rows], self._values(one, values), T_base_flange, self._perturbed(one, perturb)
            )
            for one in self._every
        ]
        return self._together(parts)

    def in_view(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Bools:
        """Each session's."""
        parts = self._each(lambda sensor, *at: sensor.in_view(*at)[None], values, T_base_flange, perturb)
        seen: Bools = self._together(parts)[0]
        return seen

    def jacobian(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Derivatives by `free`, then `derived`, (c, m, k, d): none of a row's by another session's own."""
        parts = self._each(lambda sensor, *at: sensor.jacobian(*at), values, T_base_flange, perturb)
        names = self.free + self.derived
        slopes: Array | None = None
        for one, part in zip(self._every, parts, strict=True):
            if part is None:
                return None
            if slopes is None:
                slopes = np.zeros((len(part), len(self.dataset.points), part.shape[2], len(names)))
            columns = [names.index(self._sessions.named(name, one.name)) for name in one.parameters]
            slopes[:, one.rows[:, None, None], np.arange(part.shape[2])[:, None], columns] = part
        return slopes

    def slopes(self, flange: Tangent, chain: ChainRule) -> Array | None:
        """Each session's."""
        parts = []
        for one in self._every:
            named = {name: self._sessions.named(name, one.name) for name in one.parameters}
            part = one.sensor.slopes(flange, chain.of_rows(named, one.rows, len(self.dataset.points)))
            if part is None:
                return None
            parts.append(part)
        return self._together(parts, axis=2)

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """The kind's; no row shares its errors with one of another session."""
        parts = self._each(lambda sensor, *at: sensor.row_errors(*at), values, T_base_flange, perturb)
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
        parts = self._each(lambda sensor, *at: sensor.moved_with_pose(*at), values, T_base_flange, perturb)
        shifts, turns = zip(*parts, strict=True)
        return self._together(shifts, axis=0), self._together(turns, axis=0)

    def camera(self, values: Values, perturb: Perturbation) -> CameraView | None:
        """As it is in the first session."""
        first = self._every[0]
        return first.sensor.camera(self._values(first, values), perturb)

    def mount(self, values: Values, perturb: Perturbation) -> Array | None:
        """At each pose as in its session."""
        parts = [one.sensor.mount(self._values(one, values), perturb) for one in self._every]
        mounts = [part for part in parts if part is not None]
        if not mounts or all(np.array_equal(mounts[0], other) for other in mounts[1:]):
            return mounts[0] if mounts else None
        of_pose = self.dataset.session_of_pose
        mount = np.broadcast_to(mounts[0], (len(mounts[0]), len(of_pose), 4, 4)).copy()
        for one, part in zip(self._every, mounts, strict=True):
            here = of_pose == self._sessions.names.index(one.name)
            mount[:, here] = np.broadcast_to(part, mount.shape)[:, here]
        return mount

    def flange_frames(self, values: Values, perturb: Perturbation) -> dict[str, Array]:
        """Those of all sessions; with the session's name where one differs from the first's of that name."""
        return self._frames(lambda sensor, own: sensor.flange_frames(own, perturb), values)

    @property
    def published_frames(self) -> tuple[str, ...]:
        """The kind's, as they are in the first session."""
        return self._every[0].sensor.published_frames

    def base_frames(self, values: Values, perturb: Perturbation) -> dict[str, Array]:
        """Likewise."""
        return self._frames(lambda sensor, own: sensor.base_frames(own, perturb), values)

    def _frames(self, of: Callable[[Sensor, Values], dict[str, Array]], values: Values) -> dict[str, Array]:
        frames: dict[str, Array] = {}
        for one in self._every:
            for name, T in of(one.sensor, self._values(one, values)).items():
                if not np.array_equal(frames.setdefault(name, T), T):
                    frames[f"{name}_{one.name}"] = T
        return frames

    def prefix_of(self, name: str) -> str | None:
        """The kind's, without the name of a session."""
        return next((prefix for one in self._every if (prefix := one.sensor.prefix_of(name)) is not None), None)

    @property
    def known_distances(self) -> KnownDistances | None:
        """Each session's, those between places that sessions share only once."""
        known = [(one.name, own) for one in self._every if (own := one.sensor.known_distances) is not None]
        rows = [
            (tuple(self._sessions.named(part, name) for part in first),
             tuple(self._sessions.named(part, name) for part in second), distance)
            for name, own in known
            for first, second, distance in zip(own.first, own.second, own.known.tolist(), strict=True)
        ]  # fmt: skip
        return KnownDistances.of(list(dict.fromkeys(rows)), self.dataset.noise) if rows else None

    def squares(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The sum over sessions."""
        parts = self._each(lambda sensor, *at: sensor.squares(*at), values, T_base_flange, perturb)
        return np.asarray(np.sum(parts, axis=0))

    def seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools] | None:
        """What would be measured with things as they are in the last session."""
        last = self._every[-1]
        return last.sensor.seen_from(self._values(last, values), T_base_flange)

    def aims(self, values: Values, T_base_flange: Array) -> tuple[Array, Array] | None:
        """Likewise."""
        last = self._every[-1]
        return last.sensor.aims(self._values(last, values), T_base_flange)

    def undetermined(self, T_base_flange: Array) -> str:
        """Sessions share the sensor: one that tells where it sits is enough for all."""
        reasons = [one.sensor.undetermined(T_base_flange) for one in self._every]
        return reasons[0] if all(reasons) else ""

    @property
    def description(self) -> dict[str, Any]:
        """The kind's."""
        return self._every[0].sensor.description

    @property
    def held_out_groups(self) -> Ints | None:
        """The kind's, none of them in two sessions."""
        groups, before = [], 0
        for one in self._every:
            own = one.sensor.held_out_groups
            if own is None:
                return None
            groups.append(own + before)
            before += int(own.max()) + 1
        return self._together(groups, axis=0)

    def located_apart(self, errors: Array) -> Array:
        """The kind's, in each session."""
        return self._together([one.sensor.located_apart(errors[one.rows]) for one in self._every], axis=0)

    def _perturbed(self, one: SessionPart, perturb: Perturbation) -> Perturbation:
        return perturb.of_rows(one.rows, len(self.dataset.points))

    def _each(self, what: Callable[..., T], values: Values, T_base_flange: Array, perturb: Perturbation) -> list[T]:
        """What each session's sensor says."""
        return [
            what(one.sensor, self._values(one, values), T_base_flange, self._perturbed(one, perturb))
            for one in self._every
        ]

    def _or_none(
        self, what: Callable[..., Array | None], values: Values, T_base_flange: Array, perturb: Perturbation
    ) -> Array | None:
        parts = [part for part in self._each(what, values, T_base_flange, perturb) if part is not None]
        return self._together(parts) if len(parts) == len(self._every) else None

    def _together(self, parts: Sequence[A], axis: int = 1) -> A:
        """Rows of the sessions in the order of points.csv; candidates may be one for all in some of them."""
        shape = list(np.broadcast_shapes(*(part.shape[:axis] for part in parts)))
        whole = np.empty((*shape, len(self.dataset.points), *parts[0].shape[axis + 1 :]), dtype=parts[0].dtype)
        for one, part in zip(self._every, parts, strict=True):
            whole[(slice(None),) * axis + (one.rows,)] = part
        return cast("A", whole)
