"""Detection limits of motions, by their commands alone: the least visible size of an effect, and its rivals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import DataError
from robolaser.motion.effect import At, Number
from robolaser.motion.effects import MOTION_EFFECTS
from robolaser.motion.gap import medians
from robolaser.motion.kind_diagnosis import FOLLOWS_RAD, follows_nm
from robolaser.motion.linear_rows import LinearRows, candidates_of
from robolaser.motion.log import ENCODER_RAD, MotionLog, filled
from robolaser.motion.quantities import LEAST_NM, quantities
from robolaser.motion.result_json import motion_between
from robolaser.motion.selection import INDISTINGUISHABLE, WORTH_ADDING
from robolaser.motion.tracking import TrackingRows

MEMORY_S = 5.0  # time between independent values: residuals of a real hobby arm have a memory of 0.1 to 12 s
TRACKED_RAD = 2e-4  # residual of a good arm's servo model, where no resolution is stated. A judgement
SIZES = np.geomspace(0.003, 30.0, 21)  # tried sizes, in usual sizes, or reversed, as shares of the fastest command
SHOWS = 1.28  # standard deviations above an effect's penalty, at which it is found nine times in ten
BETWEEN = (0.75, 1.33)  # factors on a signature that is not linear in its size, between the tried sizes
NONLINEAR = ("dead_time", "clock_shift", "lag", "dead_zone", "play", "speed_limit")
UNPLANNED = ("range_limit", "gear_ripple")
"""Effects that commands do not predict: the position of a limit, and the period of a gear's error."""


@final
@dataclass(frozen=True, eq=False)
class _Signatures:
    """Errors by an effect in the rows of each joint, at each size."""

    at: At
    number: int  # index of the varied number, the first that acts
    sizes: Array  # increasing, (s,)
    of: Sequence[Mapping[int, Array]]  # errors of the rows of each joint by each number, (n, k), at each size


@final
@dataclass(frozen=True, eq=False)
class MotionLimit:
    """The least size at which some motions show an effect, and its rivals there."""

    at: At
    number: Number  # the first that acts in these motions
    size: float | None  # None: no size is visible
    alike: tuple[At, ...]  # indistinguishable in these motions at twice that size


@final
@dataclass(frozen=True, eq=False)
class MotionPlan:
    """Detection limits of some motions."""

    log: MotionLog
    limits: tuple[MotionLimit, ...]
    untestable: Mapping[str, str]

    def to_dict(self) -> dict[str, Any]:
        """The output of `--json`."""
        return {
            "dataset": self.log.name,
            "kind": "motion",
            "limits": [
                {"effect": one.at.effect.name, "where": one.at.where, "rows": one.at.effect.rows,
                 "number": one.number.name, "unit": one.number.unit, "size": one.size,
                 "indistinguishable_from": [rival.pair for rival in one.alike]}
                for one in self.limits
            ],
            "next_motions": self.next_motions,
            "not_testable": [{"effect": name, "reason": why} for name, why in sorted(self.untestable.items())],
        }  # fmt: skip

    @property
    def next_motions(self) -> list[str]:
        """Motions that would distinguish what these do not."""
        return motion_between((one.at, rival) for one in self.limits for rival in one.alike)


def plan_motion(log: MotionLog) -> MotionPlan:
    """Determine which effects the motions of a log could show, whatever the readings.

    Torques are taken as recorded, and a second encoder where the log has one.

    Raises:
        DataError: There are no commands.
    """
    if not log.has("command").any():
        raise DataError("There is nothing to plan: motion.csv has no column command_<joint>.", file="motion.csv")
    ideal = _followed(log)
    rows, found = TrackingRows(ideal), []
    candidates, untestable = rows.candidates(MOTION_EFFECTS)
    for at in (at for of_joint in candidates for at in of_joint):
        if not at.effect.form and at.effect.name not in UNPLANNED:
            sizes = _sizes(at, ideal)
            of = [{at.joint: errors[:, None]} for errors in rows.errors_of(at, sizes)]
            found.append(_Signatures(at, 0, sizes, of))
    seconds = sum(ideal.time_s[part.stop - 1] - ideal.time_s[part.start] for part in ideal.rows_of_runs)
    values = max(1.0, seconds / MEMORY_S)
    step = (log.encoder_step_rad or 0.0) / np.sqrt(12.0)
    same = np.ones(len(log.joints))
    limits = _limits(found, max(TRACKED_RAD, step) * same, FOLLOWS_RAD * same, values)
    for kind in ("torque", "load"):
        if kind == "load" and not log.has("load").any():
            untestable |= {one.name: "no encoder behind the gear" for one in MOTION_EFFECTS if one.rows == kind}
            continue
        of_kind = quantities(ideal if kind == "torque" else replace(ideal, tau=np.full_like(ideal.q, np.nan)), kind)
        found, missing = _linear(of_kind, kind)
        untestable |= missing
        model = np.maximum(follows_nm(of_kind.rigid), LEAST_NM)
        noise, follows = (model, model) if kind == "torque" else (max(ENCODER_RAD, step) * same, 0.0 * same)
        limits += _limits(found, noise, follows, values)
    best: dict[tuple[str, ...], MotionLimit] = {}  # a clock shows at every joint
    for one in sorted(limits, key=lambda one: np.inf if one.size is None else one.size):
        best.setdefault((one.at.effect.rows, *one.at.pair), one)
    named = {one.at.effect.name for one in limits}
    kept = tuple(one for one in limits if one in best.values())
    return MotionPlan(log, kept, {name: why for name, why in untestable.items() if name not in named})


def _followed(log: MotionLog) -> MotionLog:
    """The log of an ideal arm with the same commands."""
    has = log.has("command")
    q = np.where(has, filled(log.command), np.nan_to_num(medians(log.q)))
    command = np.where(has, q, np.nan)
    return replace(log, command=command, q=q, tau=np.zeros_like(q), load=q.copy(), torque_unit="Nm", torque_signed=True)


def _sizes(at: At, log: MotionLog) -> Array:
    number = at.effect.numbers[0]
    if at.effect.name != "speed_limit":
        return number.usual * SIZES
    speed = np.abs(np.diff(log.command[:, at.joint]))[np.diff(log.run) == 0] / log.step_s
    return np.asarray(np.nanmax(speed) * np.linspace(1.0, 0.05, len(SIZES)))


def _linear(of: Any, kind: str) -> tuple[list[_Signatures], dict[str, str]]:
    """Signatures in rows that are linear in numbers."""
    candidates, missing = candidates_of(of, MOTION_EFFECTS, kind)
    candidates = [at for at in candidates if at.effect.name not in UNPLANNED]
    rows = LinearRows(of, of.measured, candidates)
    found = []
    for at in candidates:
        columns = rows.columns(at, 0)
        number = int(np.any(columns != 0.0, axis=(0, 1)).argmax())
        sizes = at.effect.numbers[number].usual * SIZES
        joints = np.flatnonzero(np.any(columns != 0.0, axis=(0, 2))).tolist()
        there = {joint: np.isfinite(of.measured[:, joint]) for joint in joints}
        errors = [{joint: size * columns[there[joint], joint] for joint in joints} for size in sizes]
        found.append(_Signatures(at, number, sizes, errors))
    return found, missing


def _limits(found: Sequence[_Signatures], noise: Array, follows: Array, values: float) -> list[MotionLimit]:
    """Limits of all effects on rows of one kind, by their signatures.

    Noise and usual error are by joint, (j,); the effective sample size is that of each joint's rows.
    """

    def gain(errors: Mapping[int, Array]) -> float:
        return sum(values * float(np.log1p(np.mean(one**2) / noise[joint] ** 2)) for joint, one in errors.items())

    limits = []
    for one in found:
        number = one.at.effect.numbers[one.number]
        first = [{joint: errors[:, one.number] for joint, errors in each.items()} for each in one.of]
        price = WORTH_ADDING + len(one.at.effect.numbers) * np.log(max(values, np.e)) + one.at.effect.rarity
        enough = (np.sqrt(price) + SHOWS) ** 2
        gains = np.array([gain(each) if _is_gap(each, follows) else 0.0 for each in first])
        gains[one.sizes < number.least] = 0.0
        shows = np.flatnonzero(gains >= enough)
        size = None if not len(shows) else _crossing(one.sizes, gains, int(shows[0]), enough)
        alike: tuple[At, ...] = ()
        if len(shows):
            at = min(int(shows[0]) + 1, len(first) - 1)
            alike = tuple(
                other.at
                for other in found
                if other is not one
                and (one.at.effect.site != "joint" or other.at.where == one.at.where)
                and min(map(gain, _rests(first[at], other))) < INDISTINGUISHABLE
            )
        limits.append(MotionLimit(one.at, number, size, alike))
    return limits


def _is_gap(errors: Mapping[int, Array], follows: Array) -> bool:
    return any(float(np.mean(one**2)) > follows[joint] ** 2 for joint, one in errors.items())


def _crossing(sizes: Array, gains: Array, at: int, enough: float) -> float:
    """Size at which a gain is sufficient, between two tried sizes."""
    if at == 0 or gains[at - 1] == 0.0:
        return float(sizes[at])
    return float(np.interp(np.log(enough), np.log(gains[at - 1 : at + 1]), sizes[at - 1 : at + 1]))


def _rests(errors: Mapping[int, Array], other: _Signatures) -> list[Mapping[int, Array]]:
    """Residuals of errors after another effect, at each of its sizes."""
    joints = [joint for joint in errors if joint in other.of[0]]
    if not joints:
        return [errors]
    wanted = np.concatenate([errors[joint] for joint in joints])
    rests: list[Mapping[int, Array]] = []
    is_linear = other.at.effect.name not in NONLINEAR
    for each in other.of[:1] if is_linear else other.of:
        columns = np.concatenate([each[joint] for joint in joints])
        if not columns.any():
            continue
        x = np.linalg.lstsq(columns, wanted, rcond=1e-9)[0]
        left = wanted - columns @ (x if is_linear else np.clip(x, *BETWEEN))
        ends = np.cumsum([len(errors[joint]) for joint in joints])[:-1]
        rests.append({**errors, **dict(zip(joints, np.split(left, ends), strict=True))})
    return rests or [errors]
