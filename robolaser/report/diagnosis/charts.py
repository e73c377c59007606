"""Charts of a diagnosis: the gap step by step, and the error that each effect explains and leaves."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.subsampling import evenly
from robolaser.diagnosis.cause_words import named, sentence_case
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.pose_coordinates import (
    TIME,
    Coordinate,
    angle_of,
    hanging,
    motion_of,
    of_run,
    overturning,
    torque_of,
)
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.stage_derivatives import stage_derivatives
from robolaser.model.effects.effect import CandidateEffect, perturb_with
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.run import Run
from robolaser.model.stages import OF_ROWS, Stage
from robolaser.report.chart import (
    FITTED,
    HELD_OUT,
    INK,
    LINES,
    MUTED,
    NOISE,
    Chart,
    chart,
    colours,
    hover,
    layer,
    named_rows,
    quantity,
    records,
    rule,
)
from robolaser.report.digits import human, millimetres

MOST_STEPS = 7  # effects with a step of their own
LEAST = 1e-6  # gaps below this are drawn as this [mm]
STEP_PX, AROUND_PX = 34, 70

LEFT = "left on new poses"


@final
@dataclass(frozen=True)
class Step:
    """A dot: from one gap to another [mm], or a gap by itself."""

    label: str
    colour: str
    before: float | None
    after: float


def steps(diagnosis: Diagnosis) -> list[Step]:
    """The dots, from the top."""
    gap, shown = diagnosis.gap, diagnosis.findings[:MOST_STEPS]
    found = [] if gap.nominal_m is None else [Step("nominal model", MUTED, None, _mm(gap.nominal_m))]
    found.append(Step("parameters fitted", MUTED, found[0].after if found else None, _mm(gap.calibrated_m)))
    found += [Step(named(one.candidate_effect), FITTED, _mm(one.gap_before_m), _mm(one.gap_after_m)) for one in shown]
    if (more := len(diagnosis.model.effects) - len(shown)) > 0:
        found.append(Step(f"and {more} more", FITTED, found[-1].after, _mm(gap.after_m)))
    ends = Step(LEFT, HELD_OUT, None, _mm(gap.after_m)), Step("noise alone", NOISE, None, _mm(gap.noise_floor_m))
    return [*found, *ends]


def _mm(length_m: float) -> float:
    """A length as drawn, on a logarithmic axis [mm]."""
    return max(LEAST, 1e3 * length_m)


def waterfall(diagnosis: Diagnosis) -> Chart:
    """Each step's dot is at the gap after it, with a line from the gap before."""
    rows = steps(diagnosis)
    data = records(
        step=[row.label for row in rows],
        series=[row.label for row in rows],
        after=[row.after for row in rows],
        before=[row.after if row.before is None else row.before for row in rows],
        said=["< 1 nm" if row.after == LEAST else millimetres(row.after / 1e3) for row in rows],
    )
    x = quantity("after", "error on new poses, RMS [mm]", log=True)
    x["scale"] |= {"padding": AROUND_PX}  # room for the numbers
    x["axis"] |= {"titleAnchor": "end"}  # beside long names there is little room
    y = named_rows("step")
    colour = colours({row.label: row.colour for row in rows}, shows_legend=False)
    hint = hover("step", before="gap before [mm]", after="gap after [mm]")
    low, high = map(_mm, diagnosis.gap.after_ci95_m)
    gap = diagnosis.gap
    first, begin = (
        ("There is no nominal model: from the ordinary parameters fitted, through", gap.calibrated_m)
        if gap.nominal_m is None
        else ("From the nominal model, through the ordinary parameters fitted and", gap.nominal_m)
    )
    return chart(
        "How far the gap shrinks",
        f"{first} each effect added, to the error that remains; each number is the error on held-out poses."
        f" Black line: its 95 % interval. Dashed: noise alone. The axis is logarithmic.",
        f"The gap falls from {millimetres(begin)} to {millimetres(diagnosis.gap.after_m)}; noise"
        f" alone gives {millimetres(diagnosis.gap.noise_floor_m)}.",
        [
            layer({"type": "rule", "strokeWidth": 3, "opacity": 0.45}, data, tooltip=hint,
                  x=x | {"field": "before"}, x2={"field": "after"}, y=y, color=colour),
            layer(rule(color=NOISE), records(after=rows[-1].after), x=x),
            layer({"type": "point", "size": 110, "opacity": 1}, data, tooltip=hint, x=x, y=y, color=colour),
            layer({"type": "rule", "color": INK, "strokeWidth": 1.6}, records(step=LEFT, low=low, high=high),
                  tooltip=hover(low="95 % from [mm]", high="to [mm]"),
                  x=x | {"field": "low"}, x2={"field": "high"}, y=y),
            layer({"type": "text", "dy": -13}, data, x=x, y=y, text={"field": "said"}),
        ],
        height=AROUND_PX + STEP_PX * len(rows),
        zoomable=False,
    )  # fmt: skip


BINS: Final = 8  # ranges of a coordinate, whose means measure how much of an effect it shows
SEEN: Final = 1e-3  # share of the usual information on a joint, below which a pose is not used for it
TELLING: Final = 0.5  # least share of an effect's variance that a coordinate shows; else the axis is the effect itself
MOST_ROWS: Final = 600  # dots of an effect: more only cover each other
ELASTICITY: Final = "elasticity"  # the class of effects that grow with a load
FORESEEN: Final = "error by the effect"
AXES: Final = {1: ("",), 2: (" along u", " along v"), 3: (" along x", " along y", " along z")}
"""A row's numbers in metres, in words."""


@final
@dataclass(frozen=True, eq=False)
class ExplainedError:
    """An effect, pose by pose or row by row."""

    candidate_effect: CandidateEffect  # which, and where
    coordinate: Coordinate  # the coordinate it depends on most
    x: Array  # of it, (n,)
    of: str  # the part with the error, in words
    unit: str  # of the error: "rad" or "m"
    moves: Array  # the error by the effect, (n,)
    left: Array  # the remaining error, (n,): the sum is the error without the effect
    pose: Ints  # numbers of these poses, (n,)
    rival: tuple[CandidateEffect, Array] | None  # the most probable alternative, and its remaining error, (n,)


def explained_error(fit: Fit, one: EffectEvidence) -> ExplainedError:
    """The error that an effect of the final model explains."""
    dataset, candidate = fit.model.dataset, one.candidate_effect
    turns = candidate.where in moving_joints(dataset.robot) and candidate.effect.stage_in(dataset) is Stage.JOINTS
    return _of_joint(fit, one) if turns else _of_rows(fit, one)


def _of_joint(fit: Fit, one: EffectEvidence) -> ExplainedError:
    """As the error of the joint at each informative pose."""
    joint, run, (robot, q) = one.candidate_effect.where, fit.model.run, fit.model.dataset.arm
    column, poses = robot.joints.index(joint), len(q)
    values = fit.problem.parameters.values(fit.x[None])
    moves = (perturb_with((one.candidate_effect.at(values),), run)(Stage.JOINTS, q[None]) - q)[0, :, column]
    by_joint = stage_derivatives(fit).by_motion(Stage.JOINTS, joint)[:, 0]
    own = np.bincount(fit.pose_of_number, by_joint**2, minlength=poses)
    seen = np.flatnonzero(own > SEEN * np.median(own[own > 0.0]))

    def left(other: Fit) -> Array:
        white = fit.noise.whiten(other.model.residuals(other.x[None]))[0]
        return np.asarray(-np.bincount(fit.pose_of_number, by_joint * white, minlength=poses)[seen] / own[seen])

    known = (angle_of(run, joint), *torque_of(run, joint), *motion_of(run, joint), *of_run(run))
    coordinate, x = _axis(one, [(each, each.values[seen, 0]) for each in known], moves[seen])
    unit, other = "m" if robot.prismatic[column] else "rad", _rival(one)
    rival = other and (other[0], left(other[1]))
    return ExplainedError(one.candidate_effect, coordinate, x, joint, unit, moves[seen], left(fit), seen, rival)


def _of_rows(fit: Fit, one: EffectEvidence) -> ExplainedError:
    """As the error of each row in space, along the axis in which the effect moves points most."""
    model, pose = fit.model, fit.model.dataset.points.pose
    others = tuple(each for each in fit.effects if each != one.candidate_effect)
    held = np.isin(fit.problem.parameters.names, one.candidate_effect.parameters.names)
    without = model.with_effects(others).residuals(fit.x[None, ~held])[0]

    def left_by(other: Fit) -> Array:
        return np.asarray(fit.in_metres(other.model.residuals(other.x[None])[0]))

    left = left_by(fit)
    by_effect = fit.in_metres(without) - left
    axis = int(np.square(by_effect).sum(axis=0).argmax())
    rows = np.arange(len(left))[evenly(len(left), MOST_ROWS)]
    moves = by_effect[rows, axis]
    bends = one.candidate_effect.effect.cause == ELASTICITY
    at_pose = ((each, i) for each in _of_poses(model.run, bends=bends) for i in range(each.values.shape[1]))
    known = [(each, each.values[pose[rows], i]) for each, i in at_pose]
    if one.candidate_effect.effect.stage_in(model.dataset) in OF_ROWS:
        known = [(each, each.values[rows, 0]) for each in _of_points(model.run)] + known
    coordinate, x = _axis(one, known, moves)
    other = _rival(one)
    rival = other and (other[0], left_by(other[1])[rows, axis])
    of = f"the points{AXES[left.shape[1]][axis]}"
    return ExplainedError(one.candidate_effect, coordinate, x, of, "m", moves, left[rows, axis], pose[rows], rival)


def _rival(one: EffectEvidence) -> tuple[CandidateEffect, Fit] | None:
    """The most probable effect that these data do not distinguish from an effect, and the model with it instead."""
    return max(one.alternatives, key=lambda pair: one.weights.get(pair[0], 0.0), default=None)


def _of_poses(run: Run, *, bends: bool) -> Iterator[Coordinate]:
    """Coordinates that effects on whole poses may depend on; loads for elastic ones."""
    yield from of_run(run)
    if run.dataset.sessions is not None and run.poses.time_s is not None:
        yield Coordinate("time, one session after the other", run.progress_of_all[:, None])
    for joint in moving_joints(run.dataset.robot):
        yield from (angle_of(run, joint), *(torque_of(run, joint) if bends else ()))
    yield from hanging(run)
    if bends:
        yield from overturning(run)


def _of_points(run: Run) -> Iterator[Coordinate]:
    """Coordinates that effects on single rows may depend on."""
    pixel, xyz = run.points.pixel, run.points.xyz
    if pixel is not None:
        yield from (Coordinate(f"pixel {name}", pixel[:, [i]], "px") for i, name in enumerate("uv"))
        apart = np.linalg.norm(pixel - pixel.mean(axis=0), axis=1, keepdims=True)
        yield Coordinate("distance from the middle of the image", apart, "px")
    if pixel is not None and xyz is not None:
        yield from (Coordinate(f"position on the target, {name}", xyz[:, [i]], "m") for i, name in enumerate("xy"))


def _axis(one: EffectEvidence, known: Sequence[tuple[Coordinate, Array]], moves: Array) -> tuple[Coordinate, Array]:
    """The coordinate that shows most of an effect, and its values; time only if the effect may depend on it."""
    if not one.candidate_effect.effect.depends_on_trajectory:
        known = [pair for pair in known if not pair[0].name.startswith(TIME)] or known
    if np.ptp(moves) == 0.0:
        return known[0]
    shown, (coordinate, x) = max(((_shown(x, moves), (one, x)) for one, x in known), key=lambda each: each[0])
    return (coordinate, x) if shown > TELLING else (Coordinate(FORESEEN, moves[:, None], "m"), moves)


def _shown(x: Array, moves: Array) -> float:
    """Share of an effect's variance in its means over ranges of a coordinate."""
    ends = np.unique(np.quantile(x, np.linspace(0.0, 1.0, BINS + 1)[1:-1]))
    bins = np.searchsorted(ends, x, side="right")
    counts = np.maximum(np.bincount(bins), 1)
    means = (np.bincount(bins, moves) / counts)[bins]
    return float(means.var() / moves.var())


MOST_EFFECTS: Final = 6  # effects with a chart on the page, the first findings
SIDES: Final = (-1.3, 1.3)  # of an axis that has -1 and 1 only
BEFORE, AFTER, EFFECT = "without it", "left with it", "the effect"


def effect_charts(diagnosis: Diagnosis) -> Iterator[Chart]:
    """Charts of the effects found."""
    final, names = diagnosis.weighed.final, diagnosis.weighed.final.model.dataset.poses.names
    evidence = {one.candidate_effect: one for one in diagnosis.weighed.evidence}
    for finding in diagnosis.findings[:MOST_EFFECTS]:
        if found := evidence.get(finding.candidate_effect):
            yield _chart(explained_error(final, found), names)


def _chart(one: ExplainedError, names: tuple[str, ...]) -> Chart:
    scale, unit = human(1.0, one.unit)
    is_sign = one.coordinate.unit == "sign"
    length, per, second = one.coordinate.unit.partition("/s")
    along, of = human(1.0, "" if is_sign else length)
    x, y = along * one.x, scale * one.moves
    series = {BEFORE: y + scale * one.left, EFFECT: y, AFTER: scale * one.left}
    looks = {BEFORE: (HELD_OUT, 40, False), EFFECT: (INK, 26, True), AFTER: (FITTED, 26, True)}
    if one.rival is not None:
        rival, left = one.rival
        name = f"left with {named(rival)}"
        series[name], looks[name] = scale * left, (LINES[3], 26, False)
    pose = [names[i] for i in one.pose]
    across = quantity(
        "x", f"{one.coordinate.name}{f' [{of}{per}{second}]' if of else ''}", domain=SIDES if is_sign else None
    )
    up = quantity("error", f"error of {one.of} [{unit}]")
    in_two_rows = {"columns": 2, "labelLimit": 320} if one.rival is not None else None
    colour = colours({name: looks[name][0] for name in series}, legend=in_two_rows)
    hint = hover("pose", "series", error=f"error [{unit}]")
    before, after = (float(np.sqrt(np.square(series[name]).mean())) for name in (BEFORE, AFTER))
    no_other = one.coordinate.name == FORESEEN
    each = "pose" if one.of == one.candidate_effect.where else "row"
    return chart(
        sentence_case(named(one.candidate_effect)),
        f"The error of {one.of} in each {each}, without this effect and with it; all others are in the model. If"
        " the dots follow those of the effect, and nothing of that shape remains, the effect has the right form."
        + (" It depends on several coordinates, so the axis is the effect itself." if no_other else "")
        + (" The other effect cannot be distinguished from it with these poses." if one.rival is not None else ""),
        f"The error of {one.of} falls from {before:.2g} {unit} to {after:.2g} {unit} RMS over {len(pose)} {each}s.",
        [
            layer({"type": "point", "size": size, "filled": filled, "strokeWidth": 1.4},
                  records(x=x, error=series[name], pose=pose, series=name), tooltip=hint, x=across, y=up, color=colour)
            for name, (_, size, filled) in looks.items()
        ],
    )  # fmt: skip
