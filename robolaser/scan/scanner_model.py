"""Model of a calibrated scanner in a recording: the camera at each pose, and the point of a pixel.

Effects are transferred to another run by `Effect.carried_to`. Effects of the target do not influence a scan.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points
from robolaser.duals import Dual
from robolaser.geometry.rigid_motion import apply
from robolaser.model.effects.effect import CarryOver, Effect, Run, perturb_with
from robolaser.model.effects.run import Course, RunSummary, continued
from robolaser.model.sensors.scanner_geometry import in_camera, mount
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values
from robolaser.scan.calibrated import Calibrated

FARTHEST_M = 10.0  # from the camera: beyond, rays are nearly parallel to the laser plane
VISIBLE_M = 1e-6  # smaller shifts are negligible
CLEAR = 99.0  # percentile of sizes that is reported as the largest
BEYOND = 0.1  # of the calibrated rise of temperature: largest extrapolation without a warning


@final
@dataclass(frozen=True)
class ScannerModel:
    """The poses of a recording by a calibrated scanner and its effects."""

    dataset: Dataset  # the recording, with the calibrated scanner and its arm
    values: Values  # the fourteen parameters, (1,) each
    effects: tuple[Effect, ...] = ()  # the active ones, in order
    course: Course | None = None  # share of the run at each pose, where the recording does not start at its beginning

    def perturb(self, points: Points) -> Perturbation:
        """The effects on given points of the recording."""
        return perturb_with(self.effects, Run(replace(self.dataset, points=points), self.course))

    @cached_property
    def at_poses(self) -> Points:
        """The principal point in every pose."""
        n = len(self.dataset.poses)
        centre = np.column_stack([self.values["u_0"], self.values["v_0"]])
        return Points(np.arange(n), (), pixel=np.repeat(centre, n, axis=0))

    @cached_property
    def flange(self) -> Array:
        """T_base_flange at each pose, (n, 4, 4)."""
        perturb, robot, q = self.perturb(self.at_poses), self.dataset.robot, self.dataset.poses.q
        if robot is None or q is None:
            T_base_flange = self.dataset.flange()[None]
        else:
            placements = perturb(Stage.LINKS, robot.placements[None, None])
            T_base_flange = robot.forward(perturb(Stage.JOINTS, q[None]), placements)
        return np.asarray(perturb(Stage.FLANGE, T_base_flange)[0])

    @cached_property
    def camera(self) -> Array:
        """T_base_camera at each pose, (n, 4, 4)."""
        return np.asarray(self.flange @ mount(self.dataset, self.values, self.perturb(self.at_poses))[0])

    def in_camera(self, points: Points) -> Array:
        """Intersections of pixels' rays with the laser plane, in the camera frame, (m, 3) [m].

        NaN where there is none in front of the camera within FARTHEST_M.
        """
        return self._in_front(self._seen(points, points["pixel"]))

    def _seen(self, points: Points, pixel: Array) -> Array:
        seen: Array = in_camera(pixel[None], self.values, self.perturb(points), self.dataset.stripe_axis)[0]
        return seen

    def _in_front(self, seen: Array, of: Array | None = None) -> Array:
        in_front = (seen[:, 2] > 0) & (seen[:, 2] < FARTHEST_M)
        return np.where(in_front[:, None], seen if of is None else of, np.nan)

    def in_base(self, points: Points) -> Array:
        """The same in the base frame."""
        return apply(self.camera[points.pose], self.in_camera(points))

    def slope(self, points: Points) -> Array:
        """Sensitivity of a point to a shift of its pixel across the stripe, (m,) [m/px]."""
        across = np.array([0.0, 1.0] if self.dataset.stripe_axis == "u" else [1.0, 0.0])
        pixel = Dual(points["pixel"], np.broadcast_to(across, (1, len(points), 2)), (0,))
        seen: Any = self._seen(points, cast("Array", pixel))
        return np.asarray(np.linalg.norm(self._in_front(seen.value, seen.slopes[0]), axis=-1))


def carried_over(calibrated: Calibrated, recording: Dataset, probe: Points) -> tuple[ScannerModel, tuple[str, ...]]:
    """The scanner's model in a recording from `Calibrated.fitted_to`, and warnings for the user.

    Some pixels of the stripe probe the sizes of possible errors.
    """
    run = _run_of(calibrated, recording)
    of_scanner = [effect for effect in calibrated.effects if effect.stage is not Stage.TARGET]
    carried = [(effect, CarryOver.of(effect, run, calibrated.run)) for effect in of_scanner]
    acting = tuple(one.effect for _, one in carried if one.effect is not None)
    scanner = ScannerModel(run.dataset, calibrated.values, acting, run.course)
    bare = replace(scanner, effects=())
    notes = []
    for effect, one in carried:
        reference = bare if one.effect is None else scanner
        others = [_instead(reference, one.effect, alternative) for alternative in one.alternatives]
        if one.doubt and (note := _note(effect, one, [_apart(reference, other, probe) for other in others], probe)):
            notes.append(note)
    rise = run.course.rise if run.course is not None and run.course.by_thermometer else None
    if rise is not None and ((rise < -BEYOND) | (rise > 1 + BEYOND)).any():
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


def _instead(scanner: ScannerModel, effect: Effect | None, alternative: Effect | None) -> ScannerModel:
    """The same with an alternative instead of an effect; None is no effect."""
    if effect is None:
        return scanner if alternative is None else replace(scanner, effects=(*scanner.effects, alternative))
    changed = (alternative if one is effect else one for one in scanner.effects)
    return replace(scanner, effects=tuple(one for one in changed if one is not None))


def _note(effect: Effect, carried: CarryOver, moves: list[Array], probe: Points) -> str:
    """A sentence on a possible error, with its size; "" where it is negligible."""
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


def _apart(one: ScannerModel, other: ScannerModel, probe: Points) -> Array:
    """Distance between the two models' points of each probe, (m,) [m]; zero where either has none."""
    return np.asarray(np.nan_to_num(np.linalg.norm(one.in_base(probe) - other.in_base(probe), axis=-1)))


def _largest(moves: Array) -> str:
    """The largest of the visible moves, except for stray ones at grazing rays, [m] -> in words."""
    visible = moves[np.isfinite(moves) & (moves > VISIBLE_M)]
    size = f"{1e3 * float(np.percentile(visible, CLEAR)):.2g}" if len(visible) else f"less than {1e3 * VISIBLE_M:g}"
    return f"{size} mm"
