"""Diagnosis of each kind of rows in a log."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from robolaser.arrays import Array, Bools, Ints, Progress
from robolaser.errors import DataError
from robolaser.estimation.certainty import EVEN
from robolaser.motion.checking import comparable
from robolaser.motion.cut_off import cut_rows, cuts
from robolaser.motion.effect import UNKNOWN, At, MotionEffect, RowKind
from robolaser.motion.effects.dynamics import TORQUE_CONSTANT
from robolaser.motion.effects.servo import CLOCK, ONE_CLOCK_S, is_one_clock
from robolaser.motion.effects.unknown import FUNCTIONS
from robolaser.motion.evidence import Fitted
from robolaser.motion.gap import KindGap, folds, less_means, resolution, root_mean_squares, where_lower, white_noise
from robolaser.motion.kind_diagnosis import FOLLOWS_RAD, IS_NOISE, KindDiagnosis, follows_nm
from robolaser.motion.linear_rows import LinearRows, candidates_of
from robolaser.motion.log import OTHER_UNIT, MotionLog
from robolaser.motion.misread import follows_rigid_arm
from robolaser.motion.patterns import Patterns
from robolaser.motion.quantities import Quantities, quantities
from robolaser.motion.selection import INDISTINGUISHABLE, EffectSearch, SelectedEffect, Selection, side_by_side
from robolaser.motion.series_clocks import SeriesClocks
from robolaser.motion.tracking import MORE_ROUNDS, TrackingRows

SEARCHED_ROWS = 24_000
LEAST_SHARE: dict[RowKind, float] = {"tracking": 0.002, "torque": 0.005, "load": 0.02}
"""Share of an ideal arm's squares that an effect must explain: less may be another one's form. A judgement."""
PASSES, CLOCK_PASSES = 2, 4
MOST_NOISE_RAD = 0.02
"""Largest noise of a joint's readings: larger jumps are a gap, whatever their cause. A judgement: 1.1°."""


Searching = Callable[[Sequence[At], float, Array | float, tuple[At, ...]], EffectSearch]
"""Choice of effects: from candidates, the least share of squares that each must explain, the squares that arms
usually leave, and a start."""


def parts_of(
    log: MotionLog, library: Sequence[MotionEffect], searching: Searching, progress: Progress
) -> tuple[list[KindDiagnosis], dict[str, str], list[str]]:
    """Diagnose each kind of rows.

    Returns:
        The diagnoses, reasons why effects cannot be tested, and remarks.
    """
    every = (*library, *FUNCTIONS)
    parts: list[KindDiagnosis] = []
    missing: dict[str, str] = {}
    remarks: list[str] = []
    reasons, log = comparable(log), log.as_read
    if not reasons["tracking"]:
        progress("tracking", 0.1)
        sent = _as_sent(log, library)
        if sent is not log:
            remarks.append("Commands are written more slowly than rows: between them they are interpolated.")
        parts.append(_tracking(sent, every, missing, searching))
    elif log.has("command").any():
        remarks.append(f"Tracking rows are set aside: {reasons['tracking']}.")
    linear: tuple[tuple[RowKind, str, str, float], ...] = (
        ("torque", "tau", "torques", 0.6), ("load", "load", "encoders", 0.8),
    )  # fmt: skip
    for kind, recorded, what, share in linear:
        if not reasons[kind]:
            progress(what, share)
            of = quantities(log, kind)
            factor = follows_rigid_arm(of) if kind == "torque" and not of.lacking else 1.0
            so_large = f"torques are {factor:.2g} times those of the URDF's rigid arm: are"
            reasons[kind] = of.lacking
            if not 1.0 / OTHER_UNIT < abs(factor) < OTHER_UNIT:
                reasons[kind] = f"{so_large} they in Nm at the joints, and are their signs and the masses right"
            elif factor < 0.0:
                remarks.append(f"{so_large.replace('torques', 'Torques')} their signs, the masses and `gravity` right?")
            if not reasons[kind]:
                parts.append(_linear(of, every, kind, missing, searching))
        if reasons[kind] and log.has(recorded).any():
            remarks.append(f"{kind.capitalize()} rows are set aside: {reasons[kind]}.")
    if not parts:
        raise DataError(
            " ".join((*remarks, "motion.csv has nothing to compare readings with: neither commands, nor torques in Nm"
            " with their signs, nor a second encoder. Record command_<joint>, tau_<joint> or load_<joint>.")),
            file="motion.csv",
        )  # fmt: skip
    there = {one.name for one in library if not reasons[one.rows]}
    lacking = {one.name: reasons[one.rows] for one in library if one.name not in there}
    missing = {name: reason for name, reason in missing.items() if name in there}
    return parts, lacking | missing, remarks


def _tracking(
    log: MotionLog, library: Sequence[MotionEffect], missing: dict[str, str], searching: Searching
) -> KindDiagnosis:
    clocks = None
    even, place = log.evened()
    rows, candidates, starts = _begun(even, library, missing)
    for _ in range(CLOCK_PASSES if CLOCK in library else 0):
        fits = rows.fit(list(enumerate(starts)))
        more = SeriesClocks.of(rows.lateness(fits), clocks)
        if more is not None and rows.used < len(even):
            whole, fits = _of_all_runs(even, rows, fits)
            more = SeriesClocks.of(whole.lateness(fits), more)
        if more is None:
            break
        clocks, even = more.beside(clocks), more.corrected(even)
        rows, candidates, starts = _begun(even, library, missing)
    selected = _selected(rows, candidates, starts, searching)
    if not _agree([one.model for one in selected]):
        candidates = [[at for at in each if at.effect is not CLOCK] for each in candidates]
        selected = _selected(rows, candidates, rows.usual(candidates), searching)
    whole, refined = _of_all_runs(even, rows, [one.model for one in selected])
    ideal = log.q - log.command
    ideal[:, ~np.isin(np.arange(log.q.shape[1]), rows.joints)] = np.nan
    counted = np.where(whole.counted[place, None], ideal, np.nan)
    calibrated = less_means(counted, log.run) if log.offset_per_series else counted

    @cache
    def unseen(effects: frozenset[At]) -> tuple[Bools, Array]:
        kept = [tuple(at for at in one.effects if at in effects) for one in refined]
        models = whole.fit(list(enumerate(kept)), MORE_ROUNDS)

        def errors(held_out: Bools) -> Array:
            part = whole.without(held_out)
            return even.q - part.predicted(part.refined(models, whole))

        after = np.where(np.isfinite(counted), _held_out(even.run, errors)[place], np.nan)
        after = less_means(after, log.run) if log.offset_per_series else after
        return where_lower(after, calibrated, log.run, LEAST_SHARE["tracking"])

    better, after = unseen(frozenset(at for one in refined for at in one.effects))
    if clocks is not None and not better[rows.joints].all():  # a clock shifts all joints
        return _tracking(log, [one for one in library if one is not CLOCK], missing, searching)
    nominal, before, then = map(root_mean_squares, (ideal, calibrated, after))
    step = log.encoder_step_rad or resolution(log.q)
    holding = log.robot.gravity_torques(np.nan_to_num(log.q))
    patterns = Patterns(log.run, log.time_s, np.nan_to_num(log.command), holding)
    floor, places = _left(after, white_noise(after, log.run, step), patterns, log.joints)
    findings = []
    for number, (joint, one) in enumerate(zip(rows.joints.tolist(), selected, strict=True)):
        if not better[joint]:
            continue
        deviations = whole.deviations(refined[number], joint)
        count = max(1.0, rows.count(joint))
        found = [_fitted(each, refined[number], deviations, one.model, count) for each in one.findings]
        findings += [_with_twin(each, candidates[number], log) for each in found]
    findings = _distinguished_from_clocks(findings, len(rows.joints))
    if clocks is not None:
        findings.append(clocks.finding(log, rows.joints))
    gap = KindGap("tracking", "rad", nominal, before, then, np.minimum(floor, MOST_NOISE_RAD), len(log))
    enough = np.full(len(log.joints), FOLLOWS_RAD)
    tested = tuple(at for each in candidates for at in each if at.effect.cause != UNKNOWN)
    diagnosis = KindDiagnosis(gap, tested, tuple(findings), log.run, calibrated, after, places, enough)
    return replace(diagnosis, named=unseen(diagnosis.shown_at)[1])


def _as_sent(log: MotionLog, library: Sequence[MotionEffect]) -> MotionLog:
    """The log without commands that only repeat the row above: those between were not written.

    Unchanged where that fits better by half: then the arm received them that rarely.
    """
    between = log.less_repeated("command")
    if np.array_equal(np.isfinite(between.command), np.isfinite(log.command)):
        return log
    left = []
    for one, place in (log.evened(), between.evened()):
        one.q[place] = log.q
        rows, _, starts = _begun(one, library, {})
        fits = rows.fit(list(enumerate(starts)))
        left.append(np.mean([np.log(max(fit.squares.sum(), 1e-24)) for fit in fits]))
    return log if left[0] < left[1] + np.log(EVEN) else between


def _of_all_runs(log: MotionLog, rows: TrackingRows, models: Sequence[Fitted]) -> tuple[TrackingRows, list[Fitted]]:
    """All rows of a log, and their models, which were found in some of its runs."""
    whole = TrackingRows(log)
    whole.joints = rows.joints
    whole.independent = rows.independent * len(log) / max(1, rows.used)
    return whole, whole.refined(models, rows)


def _selected(
    rows: TrackingRows, candidates: Sequence[Sequence[At]], starts: Sequence[tuple[At, ...]], searching: Searching
) -> list[Selection]:
    """The model of each joint, from some effects on."""
    for _ in range(PASSES):  # residuals of a better model are less correlated
        selected = side_by_side(
            rows.fit,
            [
                searching(each, LEAST_SHARE["tracking"], rows.count(joint) * FOLLOWS_RAD**2, start)
                for joint, each, start in zip(rows.joints.tolist(), candidates, starts, strict=True)
            ],
        )
        starts = [one.model.effects for one in selected]
        rows.count_memory()
    return selected


def _agree(models: Sequence[Fitted]) -> bool:
    """Whether all joints have the same clock, or none has one: else it imitates another effect."""
    delays = [
        float(values[0])
        for model in models
        for at, values in zip(model.effects, model.numbers, strict=True)
        if at.effect is CLOCK
    ]
    return not delays or (len(delays) == len(models) and is_one_clock(np.array(delays)))


def _begun(
    log: MotionLog, library: Sequence[MotionEffect], missing: dict[str, str]
) -> tuple[TrackingRows, list[list[At]], list[tuple[At, ...]]]:
    """Rows for the search, the candidates at each joint, and the usual effects of its servo."""
    rows = TrackingRows(log, _some_runs(log))
    if not len(rows.joints):
        raise DataError("motion.csv: commands and readings of a joint meet only in rows at the ends of series.")
    candidates, absent = rows.candidates(library)
    missing |= absent
    candidates = rows.with_one_clock(candidates)
    return rows, candidates, rows.usual(candidates)


def _linear(
    of: Quantities, library: Sequence[MotionEffect], kind: RowKind, missing: dict[str, str], searching: Searching
) -> KindDiagnosis:
    values = of.measured - of.rigid if kind == "torque" else of.measured
    candidates, absent = candidates_of(of, library, kind)
    missing |= absent
    enough = follows_nm(of.measured) if kind == "torque" else np.zeros(values.shape[1])
    limits = cuts(of) if kind == "torque" else []
    cut = cut_rows(of, limits)
    rows = LinearRows(of, values, candidates, ~cut, form=enough / 2.0)
    rows.count_memory()
    least, usual = LEAST_SHARE[kind], rows.rows * enough**2
    (selected,) = side_by_side(rows.fit, [searching(candidates, least, usual, ())])
    if rows.has_scaled_masses(selected.model):
        rows.is_scaled = True  # masses imitate scales of single joints, and one by one these help little
        every = tuple(
            at for at in candidates if at.effect.name in (TORQUE_CONSTANT.name, "payload") and not at.effect.form
        )
        starts = (selected.model.effects, every)
        others = side_by_side(rows.fit, [searching(candidates, least, usual, start) for start in starts])
        best = min(others, key=lambda one: one.model.score)
        rows.is_scaled = best.model.score < selected.model.score + INDISTINGUISHABLE
        selected = best if rows.is_scaled else selected
    ideal = rows.residuals(selected.ideal)
    shapes = dict(zip(selected.model.effects, selected.model.shapes, strict=True))

    @cache
    def unseen(effects: frozenset[At]) -> tuple[Bools, Array]:
        kept = {at: shape for at, shape in shapes.items() if at in effects}

        def errors(held_out: Bools) -> Array:
            part = LinearRows(of, values, tuple(kept), ~held_out[:, None] & ~cut, rows)
            return rows.residuals(part.fitted(tuple(kept), tuple(kept.values())), of_part=part)

        return where_lower(_held_out(of.run, errors), ideal, of.run, least)

    better, after = unseen(frozenset(shapes))
    nominal, before, then = map(root_mean_squares, (values, ideal, after))
    white = white_noise(after, of.run, None)
    patterns = Patterns(of.run, of.time_s, of.q, of.rigid, size_by_speed_only=kind == "torque")
    white = np.hypot(white, of.torque_noise) if kind == "torque" else white
    floor, places = _left(after, white, patterns, of.log.joints)
    deviations = rows.deviations(selected.model)
    findings = [
        _with_shape(_with_twin(one, candidates, of.log), selected.model, of)
        for found in selected.findings
        for one in [_fitted(found, selected.model, deviations, selected.model, np.maximum(rows.rows, 1.0))]
        if _helps(one, before, better)
    ]
    gap = KindGap(kind, "Nm" if kind == "torque" else "rad", nominal, before, then, floor, len(of.q))
    remarks = tuple(map(str, limits))
    tested = tuple(at for at in candidates if at.effect.cause != UNKNOWN)
    diagnosis = KindDiagnosis(gap, tested, tuple(findings), of.run, ideal, after, places, enough, cut, remarks)
    return replace(diagnosis, named=unseen(diagnosis.shown_at)[1])


def _held_out(run: Ints, errors: Callable[[Bools], Array]) -> Array:
    """Errors (n, j) of rows, each by a model without its fold: `errors` of a model without some rows, (n,)."""
    fold = folds(run)
    by_fold = np.stack([errors(fold == number) for number in range(fold.max() + 1)])
    return np.asarray(by_fold[fold, np.arange(len(fold))])


def _left(after: Array, white: Array, patterns: Patterns, names: Sequence[str]) -> tuple[Array, dict[str, str]]:
    """Noise (j,) of errors (n, j): white noise, or all of an error without a pattern; and the patterns' coordinates."""
    size = root_mean_squares(after)
    is_noise = [bool(size[j] > IS_NOISE * white[j]) and patterns.is_noise(after[:, j], j) for j in range(len(size))]
    places = {name: patterns.coordinate(after[:, j], j) for j, name in enumerate(names) if np.isfinite(size[j])}
    return np.minimum(np.where(is_noise, size, white), size), places


def _fitted(
    one: SelectedEffect, fitted: Fitted, deviations: Sequence[Array], model: Fitted, count: Array | float
) -> SelectedEffect:
    """An effect with its numbers and the squares that it explains."""
    at = fitted.effects.index(one.at)
    numbers = {
        number.name: (float(value), float(deviation), number.unit)
        for number, value, deviation in zip(one.at.effect.numbers, fitted.numbers[at], deviations[at], strict=True)
    }
    gained = np.maximum(one.without.squares - model.squares, 0.0) / count
    return replace(one, numbers=numbers, gained=gained)


def _with_shape(one: SelectedEffect, model: Fitted, of: Quantities) -> SelectedEffect:
    """The finding with the value of its shape, such as the cycles of its wave."""
    if one.at.effect.shape is None:
        return one
    name, unit, values = one.at.effect.shape(of, one.at.joint)
    value = float(values[model.shapes[model.effects.index(one.at)]])
    return replace(one, numbers={**one.numbers, name: (value, np.nan, unit)})


def _helps(one: SelectedEffect, before: Array, better: Bools) -> bool:
    """Whether an effect acts mostly at joints whose unseen motions the model predicts better, by errors (j,) before."""
    share = np.nan_to_num(one.gained / before**2)
    return bool(share[better].sum() >= share[~better].sum())


def _with_twin(one: SelectedEffect, candidates: Sequence[At], log: MotionLog) -> SelectedEffect:
    """The finding, no likelier than another effect of which no such rows distinguish it.

    These are a dead time, of a lag that passes within two rows; a dead zone, of play, which the loop's own encoder does
    not show; and a payload, of the last link's masses: both are one body.
    """
    name = one.at.effect.name
    is_short = name == "lag" and one.numbers["time"][0] < 2.0 * log.step_s
    is_last = name == "link_inertia" and one.at.joint == log.robot.chain[-1]
    twin = {"play": "dead_zone"}.get(name, "dead_time" if is_short else "payload" if is_last else "")
    twins = [at for at in candidates if at.effect.name == twin]
    return one.beside(twins, EVEN) if twins else one


def _distinguished_from_clocks(findings: Sequence[SelectedEffect], joints: int) -> list[SelectedEffect]:
    """Findings without a clock that does not shift all joints that follow their commands better with it.

    The clock is a rival of all dead times, or of none where the delays of joints differ.
    """
    clocks = [one for one in findings if one.at.effect is CLOCK]
    if len(clocks) < joints:
        findings = [one for one in findings if one not in clocks]
    late = [one for one in findings if one.at.effect.name == "dead_time"]
    delays = np.array([one.numbers["delay"][:2] for one in late]).reshape(-1, 2)
    if len(late) == joints and np.ptp(delays[:, 0]) <= max(ONE_CLOCK_S, 3.0 * delays[:, 1].max()):
        least = min(late, key=lambda one: one.probability)
        clock = [one for one in least.rivals if one.effect.name == "clock_shift"]
        return [one.beside(clock, least.probability) if one in late else one for one in findings]
    return [one.less("clock_shift") if one in late else one for one in findings]


def _some_runs(log: MotionLog) -> Ints:
    """Runs in which effects are searched: of a long log, evenly spaced whole runs."""
    share = max(1, round(len(log) / SEARCHED_ROWS))
    runs = np.arange(len(log.series), dtype=np.int64)
    if len(runs) < 4 * share:
        return runs
    command = np.nan_to_num(log.command)
    extremes = {int(log.run[row]) for row in (*command.argmin(axis=0), *command.argmax(axis=0))}
    return np.array(sorted({*runs[::share].tolist(), *extremes}), dtype=np.int64)
