"""The cell in space by a model that was fitted: arm, sensor, light and points in each pose, and what errs how."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.result import rms
from robolaser.diagnosis.cause_words import place
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.blocks import Block
from robolaser.model.blocks.cell_frames import camera_of, mount_of
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.sensor_sites import kind_of_site
from robolaser.model.forward_model import Model
from robolaser.model.sensors.mounting import stands
from robolaser.model.sensors.placements import motion, vector
from robolaser.parameters import Values
from robolaser.report.chart import FITTED, HELD_OUT, INK, MUTED
from robolaser.report.digits import millimetres
from robolaser.report.error_analysis import known_points, lengths_mm, point_names, some_rows
from robolaser.report.pose_photos import photos
from robolaser.report.scene import Scene, Shape, arrows, dots, labels, magnification, path
from robolaser.robot.collision_bodies import link_radius

MOST_FRAMES: Final = 60
MOST_POINTS: Final = 500
"""Of the target, and errors of each kind, that a scene carries."""
LIGHT_POINTS: Final = 16
"""Of the stripe, between which the laser plane is filled."""
COLOURS: Final = (FITTED, HELD_OUT)
BODY: Final = "var(--body)"
AXES: Final = ("#d6453d", "#3a9a4e", "#3d74c9")
AXIS: Final = 0.18
"""Length of the axes of the base frame as a share of the arm's."""
SENSOR: Final = 0.12
"""Length of the drawn sensor as a share of the arm's."""


@final
@dataclass(frozen=True)
class CellPoses:
    """The cell in some poses (n), in the base frame [m].

    Attributes:
        model: Fitted.
        x: Its parameters.
        frames: Numbers of the poses, (n,).
    """

    model: Model
    x: Array
    frames: Ints

    @cached_property
    def values(self) -> Values:
        """The parameters, (1,) each."""
        return self.model.parameters.values(self.x[None])

    @cached_property
    def flanges(self) -> Array:
        """T_base_flange of all poses, (p, 4, 4)."""
        flange = self.model.flange(self.values, self.model.perturb(self.values))[0]
        return np.broadcast_to(flange, (len(self.model.dataset.poses), 4, 4))

    @property
    def rides(self) -> bool:
        """Is the camera on the flange, if there is one?"""
        return not stands(self.model.blocks.sensor.dataset)

    @cached_property
    def cameras(self) -> Array | None:
        """T_base_camera of all poses, (p, 4, 4); None where there is no camera."""
        mount = mount_of(self.model.blocks, self.values, self.model.perturb(self.values))
        if mount is not None:
            cameras: Array = self.flanges @ mount[0]
            return cameras
        if "hand_eye.x" not in self.values:
            return None
        placed = motion(self.values, "hand_eye")
        return self.flanges @ placed[0] if self.rides else np.broadcast_to(placed, self.flanges.shape)

    @property
    def flange(self) -> Array:
        """T_base_flange, (n, 4, 4)."""
        return self.flanges[self.frames]

    @property
    def camera(self) -> Array | None:
        """T_base_camera, (n, 4, 4)."""
        return None if self.cameras is None else self.cameras[self.frames]

    @cached_property
    def joints(self) -> Array:
        """Positions of the joints, base first, (n, k, 3); none where flange poses were measured."""
        dataset = self.model.dataset
        if dataset.robot is None or dataset.poses.q is None:
            return np.empty((len(self.frames), 0, 3))
        positions: Array = dataset.robot.joint_frames(dataset.poses.q[None, self.frames])[0, :, :, :3, 3]
        return positions

    @cached_property
    def tip(self) -> Array:
        """The camera, or the middle of the points on the flange, (n, 3)."""
        if self.camera is not None:
            return self.camera[:, :3, 3]
        return np.stack([self._tool(int(pose)) for pose in self.frames])

    @cached_property
    def line(self) -> Array:
        """Base, joints and flange, (n, 2 + joints, 3)."""
        count = len(self.frames)
        return np.concatenate([np.zeros((count, 1, 3)), self.joints, self.flange[:, None, :3, 3]], axis=1)

    @cached_property
    def light(self) -> Array:
        """The first scanner's projector and points where its stripe falls, (n, 1 + k, 3); empty without a laser."""
        scanners = [block for block in self.model.blocks if block.sensor.has_laser_plane()]
        if not scanners:
            return np.empty((len(self.frames), 0, 3))
        light = np.full((len(self.frames), 1 + LIGHT_POINTS, 3), np.nan)
        for block in scanners:
            if block.name == scanners[0].name:
                self._add_light(light, block)
        return light

    def _add_light(self, light: Array, block: Block) -> None:
        """Where the light of one session falls."""
        perturb = self.model.perturb(self.values)
        at = values, _, effects = block.at(self.values, self.model.flange(self.values, perturb), perturb)
        known, mount = block.sensor.known(*at), block.sensor.in_cell(values, effects).mount
        if known is None or mount is None:
            return
        seen = known - block.sensor.residuals(*at)
        cameras = (self.flanges @ mount[0])[self.frames]
        baseline = np.array([[float(values["b"][0]), 0.0, 0.0]])
        of_pose = block.sensor.dataset.points.pose
        for i, pose in enumerate(self.frames):
            stripe = seen[0, of_pose == pose]
            stripe = stripe[np.isfinite(stripe).all(axis=1)]
            if len(stripe) or np.isnan(light[i, 0]).any():
                light[i, 0] = apply(cameras[i], baseline)[0]
            if len(stripe):
                along = np.linalg.svd(stripe - stripe.mean(axis=0), full_matrices=False)[2][0]
                order = np.argsort(stripe @ along)
                light[i, 1:] = stripe[order[np.linspace(0, len(order) - 1, LIGHT_POINTS).round().astype(int)]]

    @cached_property
    def known(self) -> Array:
        """Known or measured points of all rows, (m, 3); empty where rows are no points."""
        known = known_points(self.model, self.x)
        return np.empty((0, 3)) if known is None else self._in_base(known)

    def across_view(self, errors_m: Array) -> Bools:
        """Rows that say where a point is across the view alone, along image u and v, as a camera's do, (m,)."""
        of = self.model.dataset.sensor_of_row
        return ~np.isin(of, of[(errors_m[:, 2:] != 0.0).any(axis=1)])

    def shifts(self, errors_m: Array) -> Array | None:
        """Where the model puts points less where they are, (m, 3); from errors in the sensor's own frame."""
        known, across = known_points(self.model, self.x), self.across_view(errors_m)
        if known is None or not len(self.known) or (across.any() and self.cameras is None):
            return None
        moved = np.zeros(self.known.shape) if across.all() else self._in_base(known - errors_m) - self.known
        if self.cameras is not None and across.any():
            R = self.cameras[self.model.dataset.points.pose[across], :3, :3]
            u, v = -errors_m[across, :2].T
            moved[across] = np.einsum(
                "mij,mj->mi", R, np.stack([*((v, -u) if self._is_turned else (u, v)), 0 * u], axis=1)
            )
        return moved

    def misses(self, errors_m: Array) -> Array | None:
        """From each row's pixel to where the model predicts it, (m, 2) [px]; without the slope of the distortion."""
        view = camera_of(self.model.blocks, self.values, self.model.perturb(self.values))
        shifts, across = self.shifts(errors_m), self.across_view(errors_m)
        if view is None or shifts is None or self.cameras is None:
            return None
        T_camera_base = inverse(self.cameras)[self.model.dataset.points.pose]
        known, seen = (apply(T_camera_base, points) for points in (self.known, self.known + shifts))
        slopes: Array = known[:, :2] / known[:, 2:] - seen[:, :2] / seen[:, 2:]
        if self._is_turned:
            slopes = np.stack([-slopes[:, 1], slopes[:, 0]], axis=1)
        slopes[across] = -errors_m[across, :2] / known[across, 2:]
        return slopes @ view.K[:2, :2].T

    @property
    def _is_turned(self) -> bool:
        """Does the camera's frame have x along image v, as that of a scanner whose stripe moves along u?"""
        return self.model.blocks.has_laser_plane and self.model.dataset.stripe_axis == "u"

    def at(self, site: str) -> Array | None:
        """Where a site is in each pose, (n, 3); None where it is nowhere in space."""
        joints = moving_joints(self.model.dataset.robot)
        if site in joints and self.joints.shape[1]:
            return self.joints[:, joints.index(site)]
        hand = "tool" if self.camera is None else "hand_eye"
        of = {"base": self.line[:, 0], hand: (self.line[:, -1] + self.tip) / 2 if self.rides else self.tip}
        of |= {} if self.camera is None else {"camera": self.tip}
        of |= {"laser": self.light[:, 0]} if self.light.shape[1] else {}
        if len(self.known):
            of["target"] = np.broadcast_to(self.known.mean(axis=0), (len(self.frames), 3))
        return of.get(kind_of_site(site))

    def _tool(self, pose: int) -> Array:
        own = self._values_at(pose)
        names = dict.fromkeys(name.rpartition(".")[0] for name in own if name.startswith("tool."))
        tools = [vector(own, name)[0] for name in names] or [np.zeros(3)]
        middle: Array = apply(self.flanges[pose], np.mean(tools, axis=0)[None])[0]
        return middle

    def _values_at(self, pose: int) -> Values:
        """Values by the names that they have without sessions, as in the session of a pose."""
        dataset = self.model.dataset
        sessions, of_pose = dataset.sessions, dataset.poses.session
        return self.values if sessions is None or of_pose is None else sessions.values_in(self.values, of_pose[pose])

    def _in_base(self, points: Array) -> Array:
        """Points (m, 3) of rows in the base frame, where a tracker saw them in its own."""
        dataset, placed = self.model.dataset, points.copy()
        session = dataset.session_of_pose[dataset.points.pose]
        for rows in (session == number for number in np.unique(session)):
            own = self._values_at(int(dataset.points.pose[rows][0]))
            if "base.x" in own:
                placed[rows] = apply(inverse(motion(own, "base")[0]), points[rows])
        return placed


def cell_scene(
    model: Model,
    x: Array,
    errors_m: Mapping[str, Array],
    *,
    title: str,
    marked: Mapping[str, str] | None = None,
    remark: str = "",
) -> Scene:
    """The cell, to be turned and stepped through.

    Args:
        model: Fitted.
        x: Its parameters.
        errors_m: Errors of all rows by the name of their series, the last as the model leaves them [m].
        title: A few words.
        marked: Sites that are suspected, each with what its label says besides.
        remark: What else the caption says.
    """
    dataset, last = model.dataset, list(errors_m.values())[-1]
    of_pose = dataset.points.pose
    frames = _frames(of_pose, last)
    cell = CellPoses(model, x, frames)
    shown = some_rows(lengths_mm(last), MOST_POINTS)
    names = _names(model, shown, last)
    shifts = {name: moved[shown] for name, errors in errors_m.items() if (moved := cell.shifts(errors)) is not None}
    number = {int(pose): i for i, pose in enumerate(frames)}
    of_frame = [number.get(int(pose), -1) for pose in of_pose[shown]]
    shapes = _arm(cell, marked or {})
    if len(cell.known):
        shapes.append(dots(cell.known[shown], MUTED, names, of_frame, size=3.0))
    colours = COLOURS[:1] if len(shifts) == 1 else COLOURS[::-1]
    shapes += [
        arrows(cell.known[shown], moved, colour, names, of_frame, series=series)
        for (series, moved), colour in zip(shifts.items(), colours, strict=False)
    ]
    factor = 0.0
    if shifts:
        largest = np.percentile([np.linalg.norm(moved, axis=1) for moved in shifts.values()], 95)
        factor = magnification(float(largest), float(np.ptp(cell.known, axis=0).max()))
    taken = [dataset.poses.names[i] for i in frames]
    misses = cell.misses(last)
    images = photos(dataset, [int(i) for i in frames], last, misses)
    said = "Lines lead from known points to where the model puts them, magnified as the slider says." if shifts else ""
    photo = " Beside it the image of the pose: rings are points extracted from it" if images else ""
    photo += ", lines lead to where the model predicts them." if images and misses is not None else "." * bool(images)
    longest = 0.0 if misses is None else float(np.nanpercentile(np.linalg.norm(misses, axis=1), 95))
    return Scene(
        title,
        f"{said}{photo}{remark}".strip(),
        f"The cell in {len(frames)} poses, with {len(shown)} points and their errors.",
        shapes,
        taken,
        start=int(np.argmin(np.abs(frames - _typical(model)))),
        magnification=factor,
        in_photos=magnification(longest, (dataset.image_px or (0, 0))[0]),
        photos=images,
    )


def _arm(cell: CellPoses, marked: Mapping[str, str]) -> list[Shape]:
    line, tip, camera = cell.line, cell.tip, cell.camera
    extent = line if cell.joints.shape[1] else np.concatenate([tip, cell.known])[None]
    reach = float(np.ptp(extent.reshape(-1, 3), axis=0).max()) or 0.3
    ring = 0.05 * reach * np.array([(np.cos(a), np.sin(a), 0.0) for a in np.linspace(0, 2 * np.pi, 24)])
    shapes: list[Shape] = []
    if cell.joints.shape[1]:
        shapes += [
            path(ring, MUTED, width=2, closed=True, opacity=0.5),
            path(line, BODY, width=6, radius=link_radius(cell.model.dataset.arm[0])),
            path(line, MUTED, width=2),
        ]
    shapes += _axes(AXIS * reach)
    if camera is None or cell.rides:
        shapes.append(path(np.stack([line[:, -1], tip], axis=1), INK, width=3))
    if camera is not None:
        shapes += _camera(camera, SENSOR * reach, cell.model.dataset.image_px or (4, 3))
    if cell.light.shape[1]:
        colour = HELD_OUT if "laser" in marked else "#d62828"
        shapes += [path(cell.light, colour, width=1, closed=True, opacity=0.18),
                   path(cell.light[:, 1:], colour, width=2)]  # fmt: skip
    joints = [name for name in moving_joints(cell.model.dataset.robot) if name not in marked and cell.joints.shape[1]]
    places = {name: at for name in (*joints, *marked) if (at := cell.at(name)) is not None}
    for names, colour, size, bold in ((joints, MUTED, 3.5, False), (list(marked), HELD_OUT, 7.0, True)):
        here = [name for name in names if name in places]
        if here:
            said = [f"{place(name)} {marked.get(name, '')}".strip() for name in here]
            where = np.stack([places[name] for name in here], axis=1)
            shapes.append(labels(where, said, colour, size=size, bold=bold))
    return shapes


def _axes(length: float) -> list[Shape]:
    """The base frame."""
    ends = length * np.eye(3)
    lines = [path(np.stack([np.zeros(3), end]), colour, width=2) for end, colour in zip(ends, AXES, strict=True)]
    return [*lines, *(labels(end[None], [axis], colour, size=0.0, bold=False)
                      for end, axis, colour in zip(ends, "xyz", AXES, strict=True))]  # fmt: skip


def _camera(T: Array, size: float, image_px: tuple[int, int]) -> list[Shape]:
    """A pyramid that opens to where the camera looks."""
    half = 0.35 * size * np.array(image_px) / max(image_px)
    corners = np.array([(u * half[0], v * half[1], size) for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    ends = np.einsum("nij,kj->nki", T[:, :3, :3], corners) + T[:, None, :3, 3]
    eye = T[:, None, :3, 3]
    return [path(np.concatenate([eye, ends[:, [i, (i + 1) % 4]], eye], axis=1), INK, width=1) for i in range(4)]


def _frames(of_pose: Ints, errors: Array) -> Ints:
    """Poses with points, at most so many as a page carries: evenly taken, the worst among them."""
    seen = np.unique(of_pose)
    if len(seen) <= MOST_FRAMES:
        return seen
    return seen[some_rows(np.array([rms(errors[of_pose == i]) for i in seen]), MOST_FRAMES)]


def _typical(model: Model) -> int:
    """The pose with points whose joints, or flange, are nearest to the median."""
    dataset = model.dataset
    seen = np.unique(dataset.points.pose)
    positions = dataset.poses.q if dataset.poses.q is not None else dataset.flange()[:, :3, 3]
    away = np.linalg.norm(positions[seen] - np.median(positions[seen], axis=0), axis=1)
    return int(seen[np.argmin(away)])


def _names(model: Model, rows: Ints, errors: Array) -> Sequence[str]:
    lengths = lengths_mm(errors)
    return [
        f"pose {pose}, point {point}\nerror {millimetres(lengths[row] / 1e3)}"
        for row, pose, point in zip(rows, *point_names(model.dataset, rows), strict=True)
    ]
