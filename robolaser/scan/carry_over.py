"""Effects of the calibrated run, carried over to the run of a recording.

Each effect says what becomes of it in another run (`Effect.carried_to`). Effects of the target do not matter to a scan.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points
from robolaser.model.effects.effect import CarryOver, Effect, Run
from robolaser.model.effects.run_summary import RunSummary, continued
from robolaser.model.stages import Stage
from robolaser.scan.calibrated import Calibrated
from robolaser.scan.scanner_model import ScannerModel

VISIBLE_M = 1e-6  # smaller moves matter to nobody
CLEAR = 99.0  # percentile of sizes that is reported as the largest
BEYOND = 0.1  # of the calibrated rise of temperature: so far it may be extrapolated without a warning


def carried_over(calibrated: Calibrated, recording: Dataset, probe: Points) -> tuple[ScannerModel, tuple[str, ...]]:
    """What the scanner sees in a recording, and what the user should know about it.

    Args:
        calibrated: The scanner.
        recording: Where it was taken to, as `Calibrated.fitted_to` gives it.
        probe: Some pixels of the stripe, for which the sizes of doubts are worked out.
    """
    run = _run_of(calibrated, recording)
    carried = tuple(_carried(calibrated, run))
    scanner = _scanner_model(calibrated, run, (one.effect for _, one in carried))
    bare = _scanner_model(calibrated, run, ())
    notes = []
    for effect, one in carried:
        reference = bare if one.effect is None else scanner
        others = [_instead(reference, one.effect, alternative) for alternative in one.alternatives]
        if one.doubt and (note := _note(effect, one, [_apart(reference, other, probe) for other in others], probe)):
            notes.append(note)
    if run.course is not None and run.course.by_thermometer and _extrapolates(run.course.rise):
        notes.append(
            "The recording is colder or warmer than the calibrated run ever was: its drift is extrapolated linearly."
        )
    return scanner, tuple(notes)


def _run_of(calibrated: Calibrated, recording: Dataset) -> Run:
    """The recording's run: the calibrated one itself, or a later part of it."""
    if calibrated.run is None:
        same = calibrated.name == recording.name and len(recording.points) > 0
    else:
        same = calibrated.run == RunSummary.of(recording)
    return Run(recording) if same else continued(calibrated.run, recording)


def _carried(calibrated: Calibrated, run: Run) -> Iterable[tuple[Effect, CarryOver]]:
    for effect in calibrated.effects:
        if effect.stage is not Stage.TARGET:
            as_found = run.course is None and not effect.hindrance(run)
            yield effect, CarryOver(effect) if as_found else effect.carried_to(run, calibrated.run)


def _scanner_model(calibrated: Calibrated, run: Run, effects: Iterable[Effect | None]) -> ScannerModel:
    acting = tuple(effect for effect in effects if effect is not None)
    return ScannerModel(run.dataset, calibrated.values, acting, run.course)


def _instead(scanner: ScannerModel, effect: Effect | None, alternative: Effect | None) -> ScannerModel:
    """The same with an alternative instead of an effect; None stands for no effect."""
    if effect is None:
        return scanner if alternative is None else replace(scanner, effects=(*scanner.effects, alternative))
    changed = (alternative if one is effect else one for one in scanner.effects)
    return replace(scanner, effects=tuple(one for one in changed if one is not None))


def _note(effect: Effect, carried: CarryOver, moves: list[Array], probe: Points) -> str:
    """A sentence on a doubt, with its size; "" where nobody would see it."""
    name = f"{effect.name} at {effect.where}"
    if carried.effect is None:
        left_out = f"{name} is left out: {carried.doubt}."
        points = f"{carried.assumption} points" if carried.assumption else "Points"
        return f"{left_out} {points} are off by up to {_largest(np.max(moves, axis=0))}." if moves else left_out
    if not moves:
        return f"{name}: {carried.doubt}."
    move = np.max(moves, axis=0)
    affected, poses = (len(np.unique(pose)) for pose in (probe.pose[move > VISIBLE_M], probe.pose))
    where = f" in {affected} of {poses} poses" if affected < poses else ""
    return f"{name}: {carried.doubt}, points are off by up to {_largest(move)}{where}." if affected else ""


def _extrapolates(rise: Array | None) -> bool:
    return rise is not None and bool(((rise < -BEYOND) | (rise > 1 + BEYOND)).any())


def _apart(one: ScannerModel, other: ScannerModel, probe: Points) -> Array:
    """How far the two put each probe from one another, (m,) [m]; zero where either does not see it."""
    return np.asarray(np.nan_to_num(np.linalg.norm(one.in_base(probe) - other.in_base(probe), axis=-1)))


def _largest(moves: Array) -> str:
    """The largest of the visible moves, except for stray ones at grazing rays, [m] -> in words."""
    visible = moves[np.isfinite(moves) & (moves > VISIBLE_M)]
    size = f"{1e3 * float(np.percentile(visible, CLEAR)):.2g}" if len(visible) else f"less than {1e3 * VISIBLE_M:g}"
    return f"{size} mm"
