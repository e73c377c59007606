"""Effects of the calibrated run, carried over to the run of a recording.

Most effects belong to the cell and act as they were found. Those that follow the course of a run need a rule where the
recording is another run than the calibrated one:

- `backlash` follows the recording's own path; where in its play each joint stood at first is not known: in the middle.
- what warms up follows the recording's thermometer, where both runs have one; else, and for a bracket that creeps, the
  end of the calibrated run is taken for the whole recording.
- `base_shift`: the cell is as it was after the shift.
- effects of the target say nothing about a scan; `stripe_bias` needs the tilt of the surface, which only the points of
  a data set tell.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points
from robolaser.geometry.rigid_motion import exp_so3
from robolaser.model.effects.backlash import Backlash
from robolaser.model.effects.base_shift import BaseShift
from robolaser.model.effects.course import temperature
from robolaser.model.effects.effect import Effect
from robolaser.model.effects.hand_eye_drift import HandEyeDrift
from robolaser.model.effects.joint_compliance import JointCompliance
from robolaser.model.effects.laser_drift import LaserDrift
from robolaser.model.effects.run import Run
from robolaser.model.effects.stripe_bias import StripeBias
from robolaser.model.effects.thermal_drift import ThermalDrift
from robolaser.model.stages import Stage
from robolaser.scan.calibrated import Calibrated
from robolaser.scan.scanner_model import Sight
from robolaser.scan.sensitivity import levers

TILT_RAD = np.radians(30.0)  # of an ordinary surface: sizes of what depends on the tilt are told for it
TELLING_M = 1e-6  # below this nothing moves that anybody would see
CLEAR = 99.0  # percentile of sizes that is told for the largest
BEYOND = 0.1  # of the calibrated rise of temperature: so far it may be continued without a word


def carried_over(calibrated: Calibrated, recording: Dataset, probe: Points) -> tuple[Sight, tuple[str, ...]]:
    """What the scanner sees in a recording, and what the user should know about it.

    Args:
        calibrated: The scanner.
        recording: Where it was taken to, as `Calibrated.fitted_to` gives it.
        probe: Some pixels of the stripe, by which the sizes of doubts are told.
    """
    sight = sight_of(calibrated, recording)
    doubts = _acting(calibrated.effects, recording)[1]
    bare = Sight(recording, calibrated.values)
    notes = [_left_out(effect, why, bare, probe) for effect, why in doubts]
    if not _is_its_own(calibrated, recording):
        notes += _doubts(sight, probe, by_thermometer=_read_in_both(calibrated.run, recording))
    return sight, tuple(notes)


def sight_of(calibrated: Calibrated, recording: Dataset) -> Sight:
    """What the scanner sees in a recording, as `Calibrated.fitted_to` gives it."""
    effects, _ = _acting(calibrated.effects, recording)
    if _is_its_own(calibrated, recording):
        return Sight(recording, calibrated.values, effects)
    effects = tuple(_now(effect, calibrated.run, recording) for effect in effects)
    return Sight(recording, calibrated.values, effects, _course(calibrated.run, recording))


def _is_its_own(calibrated: Calibrated, recording: Dataset) -> bool:
    """Whether the recording is the data set that the scanner was calibrated from."""
    if calibrated.run is None:
        return calibrated.name == recording.name and len(recording.points) > 0
    return calibrated.run == Run.of(recording)


def _acting(effects: tuple[Effect, ...], recording: Dataset) -> tuple[tuple[Effect, ...], list[tuple[Effect, str]]]:
    """The effects that a recording lets act, and those that it does not, each with the reason."""
    acting: list[Effect] = []
    doubts: list[tuple[Effect, str]] = []
    for effect in effects:
        if effect.stage is Stage.TARGET:
            continue
        why = ""
        if isinstance(effect, StripeBias):
            known = recording.points.xyz is not None and not effect.missing(recording)
            why = "" if known else "the tilt of the surface is not known"
        elif effect.stage is Stage.JOINTS:
            why = effect.missing(recording)
        if why:
            doubts.append((effect, why))
        else:
            acting.append(effect)
    return tuple(acting), doubts


def _left_out(effect: Effect, why: str, bare: Sight, probe: Points) -> str:
    """A warning, with the size where it can be told."""
    said = f"{effect.name} at {effect.where} is left out: {why}."
    poses, robot = bare.dataset.poses, bare.dataset.robot
    if isinstance(effect, StripeBias):
        sizes = float(abs(effect.slope[0]) * np.tan(TILT_RAD)) * bare.slope(probe)
        return f"{said} On a surface tilted by {np.degrees(TILT_RAD):.0f}° points are off by {_most(sizes)}."
    if isinstance(effect, Backlash) and robot is not None and poses.q is not None:
        places = bare.in_base(bare.at_poses)
        lever = levers(robot, poses.q, places)[:, robot.chain.index(robot.joints.index(effect.where))]
        return f"{said} Points are off by up to {_most(float(abs(effect.lost_motion[0])) / 2 * lever)}."
    return said


def _course(run: Run | None, recording: Dataset) -> dict[str, Any]:
    """The end of the calibrated run for all poses, or what the recording's thermometer says."""
    n = len(recording.poses)
    course: dict[str, Any] = {"progress": np.ones(n), "rise": None}
    if run is not None and run.temperature_c is not None and run.temperature_c[1] > run.temperature_c[0]:
        low, high = run.temperature_c
        read = temperature(recording.poses)
        course["rise"] = np.ones(n) if read is None else (read - low) / (high - low)
    return course


def _read_in_both(run: Run | None, recording: Dataset) -> bool:
    return run is not None and run.temperature_c is not None and temperature(recording.poses) is not None


def _now(effect: Effect, run: Run | None, recording: Dataset) -> Effect:
    """The effect as it acts in another run."""
    if isinstance(effect, Backlash):
        return replace(effect, start=np.zeros(1))
    if isinstance(effect, BaseShift) and run is not None:  # it turned about the middle of the other run
        apart = recording.flange()[:, :3, 3].mean(axis=0) - np.array(run.middle_m)
        turn = exp_so3(np.stack([effect.turn_x, effect.turn_y, effect.turn_z], axis=-1))[0]
        x, y, z = (turn - np.eye(3)) @ apart
        return replace(effect, x=effect.x + x, y=effect.y + y, z=effect.z + z)
    return effect


def _doubts(sight: Sight, probe: Points, *, by_thermometer: bool) -> Iterator[str]:
    """What is not known about the effects in this run, and how much that may be."""
    rise = sight.course["rise"]
    for effect in sight.effects:
        others: tuple[Sight, ...] = ()
        drifts = isinstance(effect, LaserDrift | ThermalDrift) and not by_thermometer
        if drifts or isinstance(effect, HandEyeDrift):
            others = (replace(sight, effects=tuple(one for one in sight.effects if one is not effect)),)
            what = (
                "how far it has come in this recording is not known; it is taken as at the end of the calibrated run,"
                " warmed up. If it was not"
            )
        elif isinstance(effect, Backlash):
            others = tuple(_with(sight, effect, replace(effect, start=np.array([end]))) for end in (-1.0, 1.0))
            what = "where in its play the joint stood before the first pose is not known; until it has turned round"
        elif isinstance(effect, JointCompliance) and effect.hardening[0] != 0:
            others = (_with(sight, effect, replace(effect, hardening=np.zeros(1))),)
            what = "its hardening counts from the largest load of the poses, which here are others than the calibrated"
        elif isinstance(effect, BaseShift):
            yield f"{effect.name}: the cell is taken as it was after the shift. If it was moved again, calibrate anew."
        if others:
            moved = np.max([_apart(sight, other, probe) for other in others], axis=0)
            tells = moved > TELLING_M
            if tells.any():
                few = len(np.unique(probe.pose[tells]))
                where = f" in {few} of {len(np.unique(probe.pose))} poses" if isinstance(effect, Backlash) else ""
                yield f"{effect.name} at {effect.where}: {what}, points are off by up to {_most(moved)}{where}."
    if by_thermometer and rise is not None and ((rise < -BEYOND) | (rise > 1 + BEYOND)).any():
        yield "The recording is colder or warmer than the calibrated run ever was: its drift is continued in a line."


def _with(sight: Sight, effect: Effect, instead: Effect) -> Sight:
    return replace(sight, effects=tuple(instead if one is effect else one for one in sight.effects))


def _apart(one: Sight, other: Sight, probe: Points) -> Array:
    """How far the two put each probe from one another, (m,) [m]; zero where either does not see it."""
    return np.asarray(np.nan_to_num(np.linalg.norm(one.in_base(probe) - other.in_base(probe), axis=-1)))


def _most(sizes: Array) -> str:
    """The largest but for stray ones that a grazing ray makes, among those that anybody would see, [m] -> in words."""
    told = sizes[np.isfinite(sizes) & (sizes > TELLING_M)]
    return f"{1e3 * float(np.percentile(told, CLEAR)):.2g} mm" if len(told) else f"less than {1e3 * TELLING_M:g} mm"
