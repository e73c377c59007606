"""All blocks of a problem: its rows and parameters, combined from its blocks, and the distances known beside them."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Any, TypeVar, cast, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.several_sensors import with_points_of
from robolaser.duals import Dual, is_dual, slopes_of
from robolaser.model.blocks.block import Block, blocks_of
from robolaser.model.sensors.sensor import Seen, Sensor
from robolaser.model.stages import Perturbation
from robolaser.parameters import Parameter, Values

T = TypeVar("T")
A = TypeVar("A", bound=np.ndarray[Any, Any])
USUAL_M = 5e-5  # standard deviation where `[noise] distance_m` does not state one: a plate from a milling machine


@final
@dataclass(frozen=True, eq=False)
class KnownDistances:
    """Distances between named points: rows of every fit that belong to no pose and to no point of points.csv."""

    ends: tuple[tuple[str, str], ...]  # names of each row's points, (r,)
    # parameters of its first point, such as `socket.a.x`, `.y` and `.z`, (r,)
    first: tuple[tuple[str, ...], ...]
    second: tuple[tuple[str, ...], ...]  # of its second, (r,)
    known: Array  # the distances, (r,) [m]
    sigma_m: float  # their standard deviation

    def __len__(self) -> int:
        return len(self.known)

    def residuals(self, values: Values) -> Array:
        """Known distance less the model's, (c, r) [m]."""
        left: Array = self.known - np.linalg.norm(self._apart(values), axis=-1)
        return left

    def jacobian(self, values: Values, names: Sequence[str]) -> Array:
        """Derivatives of the residuals by the named parameters, (c, r, len(names)); zero except by points."""
        moving = {name: Dual.parameter(values[name], i) for i, name in enumerate(names) if name in values}
        slopes = slopes_of(self.residuals(cast("Values", {**values, **moving})), len(names))
        return np.ascontiguousarray(np.moveaxis(slopes, 0, -1))

    def _apart(self, values: Values) -> Array:
        """From each row's first point to its second, (c, r, 3) [m]."""
        parts = [
            np.stack([values[b] - values[a] for a, b in zip(first, second, strict=True)], axis=-1)
            for first, second in zip(self.first, self.second, strict=True)
        ]
        return np.stack(parts, axis=1)


@final
class Blocks:
    """The blocks of a data set, in the order of its sensors and their sessions.

    A row of the problem is a row of one block, as its sensor has it. Where sensors differ, rows are in metres (pixels
    by their typical size on the target), padded with zeros to the longest row.
    """

    def __init__(self, dataset: Dataset) -> None:
        self.dataset = dataset
        self._blocks = blocks_of(dataset)

    def __iter__(self) -> Iterator[Block]:
        return iter(self._blocks)

    def __len__(self) -> int:
        return len(self._blocks)

    @property
    def sensor(self) -> Sensor:
        """The sensor of the first block, which stands for all in texts."""
        return self._blocks[0].sensor

    @cached_property
    def by_sensor(self) -> tuple[tuple[Block, ...], ...]:
        """The blocks of each sensor, one a session."""
        return tuple(tuple(blocks) for _, blocks in groupby(self._blocks, lambda block: block.name))

    @property
    def one_sensor(self) -> Sequence[Block]:
        """The blocks where there is one sensor; none where there are several.

        For properties that several sensors do not share: groups of rows beyond poses, linear parameters, aims.
        """
        return self._blocks if len(self.by_sensor) == 1 else ()

    def names(self, of: Callable[[Sensor], Sequence[str]]) -> tuple[str, ...]:
        """The problem's names of some parameters of every sensor, each once."""
        return tuple(dict.fromkeys(block.named[name] for block in self for name in of(block.sensor)))

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Parameters that must be given, or start from closed forms, in one of the blocks."""
        return self.names(lambda sensor: sensor.parameters.free)

    @cached_property
    def derived(self) -> tuple[str, ...]:
        """Parameters that follow from the others, and are free in no block."""
        free = set(self.free)
        return tuple(name for name in self.names(lambda sensor: sensor.parameters.derived) if name not in free)

    @cached_property
    def fixed(self) -> tuple[str, ...]:
        """Parameters that stay at their nominal values because a sensor has a freedom that no data can fix."""
        return self.names(lambda sensor: sensor.parameters.fixed)

    @cached_property
    def held(self) -> tuple[str, ...]:
        """All parameters that stay at their nominal values: `fixed`, and those that the data set fixes."""
        stated = [name for name in self.free + self.derived if name in self.given and self.given[name].fixed]
        return tuple(dict.fromkeys((*self.fixed, *stated)))

    @cached_property
    def given(self) -> Mapping[str, Parameter]:
        """The data set's parameters, by the problem's names: `base.x` for every session that has one."""
        given: dict[str, Parameter] = {}
        for block in self:
            for own, whole in block.named.items():
                if own in block.sensor.dataset.parameters and whole not in given:
                    given[whole] = block.sensor.dataset.parameters[own].renamed(whole)
        return given

    @property
    def setup_parameters(self) -> tuple[str, ...]:
        """Parameters of placements and mounts, which differ between campaigns."""
        return self.names(lambda sensor: sensor.setup_parameters)

    @property
    def has_laser_plane(self) -> bool:
        """Whether any sensor has one."""
        return any(block.sensor.has_laser_plane() for block in self)

    @cached_property
    def numbers(self) -> int:
        """Numbers of a row of residuals: the most of any sensor."""
        return max(block.numbers for block in self)

    @cached_property
    def row_numbers(self) -> Ints:
        """How many numbers each row has, (m,)."""
        return self.together([np.full(len(block.rows), block.numbers) for block in self], axis=0)

    @property
    def unit(self) -> str:
        """Unit of the residuals."""
        return self.dataset.format.unit

    @cached_property
    def kinds_of_rows(self) -> dict[str, tuple[Ints, str, int]]:
        """Rows (m,) of each sensor by its name in results, their unit, and how many of their numbers are angles."""
        kinds = {}
        for blocks in self.by_sensor:
            declared, rows = blocks[0].sensor.format, np.sort(np.concatenate([block.rows for block in blocks]))
            kinds[blocks[0].name or declared.kind] = rows, declared.unit, declared.angles
        return kinds

    def own_rows(self, residuals: Array, kind: str) -> Array:
        """The rows of one of these kinds in their unit, (..., m, k) -> (..., its rows, its numbers)."""
        rows, *_ = self.kinds_of_rows[kind]
        block = next(block for block in self if kind == (block.name or block.sensor.format.kind))
        return block.unscaled(residuals if block.is_whole else residuals[..., rows, :])

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Measured or known less predicted, (c, m, k) [`unit`]; arguments as for `Sensor.residuals`."""
        at = values, T_base_flange, perturb
        return self.together([block.scaled(block.sensor.residuals(*block.at(*at))) for block in self])

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Residuals (c, m, k) in metres at the point, (c, m, j)."""
        at = values, T_base_flange, perturb
        own = [block.unscaled(residuals if block.is_whole else residuals[..., block.rows, :]) for block in self]
        return self.together(
            [block.sensor.in_metres(rows, *block.at(*at)) for block, rows in zip(self, own, strict=True)]
        )

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Known or measured position of each row's point, (c, m, 3) [m]; None where rows are no points."""
        return self.or_none([block.sensor.known(*block.at(values, T_base_flange, perturb)) for block in self])

    def ranges(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Distance from the sensor at which each row was measured, one candidate, (m,) [m]; None: some have none."""
        return self.or_none([block.sensor.ranges(*block.at(values, T_base_flange, perturb)) for block in self], axis=0)

    def in_view(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Bools:
        """Whether the sensor could see each row's known point at its stated position, one candidate, (m,)."""
        at = values, T_base_flange, perturb
        return self.together([block.sensor.in_view(*block.at(*at)) for block in self], axis=0)

    def fix_gauge(self, values: Values) -> Values:
        """An equivalent model for any data, with the fixed parameters at their nominal values."""
        for block in self:
            values = {**values, **block.of_problem(block.sensor.parameters.fix_gauge(block.values(values)))}
        return values

    @property
    def held_out_groups(self) -> Ints | None:
        """Group of each row, (m,), where cross-validation holds out more than poses together; None: whole poses.

        Several sensors share only poses.
        """
        groups, before = [], 0
        for block in self.one_sensor:
            own = block.sensor.new_poses.fold_groups
            if own is None:
                return None
            groups.append(own + before)
            before += int(own.max()) + 1
        return self.together(groups, axis=0) if groups else None

    def relocated(self, errors: Array) -> Array:
        """Errors of held-out rows (m, k) after a refit of the parameters that only they determine."""
        parts = [block.sensor.new_poses.relocated(errors[block.rows]) for block in self.one_sensor]
        return self.together(parts, axis=0) if parts else errors

    def seen_from(self, values: Values, T_base_flange: Array) -> Seen:
        """Measurements at other poses (p, 4, 4), see `NewPoses`, placements as in the last session."""
        last = [of_sensor[-1] for of_sensor in self.by_sensor]
        each = [one.sensor.new_poses.seen_from(one.values(values), T_base_flange) for one in last]
        seen = [one for one in each if one is not None]
        if len(seen) < len(last):
            return None
        if len(seen) == 1:
            return seen[0]
        points = with_points_of(self.dataset, [points for points, _ in seen]).points
        order = np.argsort(points.pose, kind="stable")
        return points.take(order), np.logical_and.reduce([good for _, good in seen])

    def aims(self, values: Values, T_base_flange: Array) -> tuple[Array, Array] | None:
        """Points on the flange, (a, 3), and where each must be for the only sensor to see something; None: anywhere."""
        last = self.one_sensor[-1:]
        return last[0].sensor.new_poses.aims(last[0].values(values), T_base_flange) if last else None

    @cached_property
    def known_distances(self) -> KnownDistances | None:
        """The stated distances between named points, each once; None where there are none."""
        rows, noise = {}, self.dataset.noise
        for block in self:
            for one, other, distance in block.sensor.dataset.distances_m:
                first, second = _coordinate_names(block, one), _coordinate_names(block, other)
                if first and second:
                    rows[first, second], noise = ((one, other), distance), block.sensor.dataset.noise
        if not rows:
            return None
        firsts, seconds = zip(*rows, strict=True)
        sigma_m = USUAL_M if noise.distance_m is None else noise.distance_m
        ends, known = zip(*rows.values(), strict=True)
        return KnownDistances(ends, firsts, seconds, np.array(known), sigma_m)

    @property
    def description(self) -> dict[str, Any]:
        """The entries of calibration.json under `model`: of the first sensor; if there are several, of each."""
        first = [blocks[0] for blocks in self.by_sensor]
        every = [{"name": one.name, "kind": one.sensor.format.kind, **one.sensor.description} for one in first]
        return {**self.sensor.description, **({"sensors": every} if len(every) > 1 else {})}

    def together(self, parts: Sequence[A], axis: int = 1) -> A:
        """Rows of the blocks in the data set's order; some may have one candidate for all."""
        if len(self) == 1:
            return parts[0]
        before = np.broadcast_shapes(*(own.shape[:axis] for own in parts))
        after = np.max([own.shape[axis + 1 :] for own in parts], axis=0).astype(int)
        like = next((own for own in parts if is_dual(own)), parts[0])
        whole = np.zeros_like(like, shape=(*before, len(self.dataset.points), *after))
        for block, own in zip(self, parts, strict=True):
            whole[(slice(None),) * axis + (block.rows, *(slice(size) for size in own.shape[axis + 1 :]))] = own
        return cast("A", whole)

    def or_none(self, parts: Collection[Array | None], axis: int = 1) -> Array | None:
        """The same; None where a block has none."""
        known = [part for part in parts if part is not None]
        return self.together(known, axis) if len(known) == len(parts) else None


def _coordinate_names(block: Block, point: str) -> tuple[str, ...]:
    """The problem's names of a named point's coordinates; none where it has no such point."""
    own = (f"{block.sensor.format.named_points}.{point}.{part}" for part in "xyz")
    return tuple(block.named[name] for name in own if name in block.named)
