"""The cell in space by a fitted model: arm, sensor, light, points and image of each pose, and suspected sites."""

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly
from robolaser.diagnosis.cause_words import place
from robolaser.errors import ImageError
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.sensor_sites import kind_of_site
from robolaser.model.forward_model import Model
from robolaser.report.cell_poses import CellPoses
from robolaser.report.chart import FITTED, HELD_OUT, INK, MUTED
from robolaser.report.digits import millimetres
from robolaser.report.error_analysis import lengths_mm, point_names, some_rows
from robolaser.report.scene import Scene, Shape, arrows, dots, labels, magnification, path, photo
from robolaser.robot.collision_bodies import link_radius

MOST_FRAMES: Final = 60
MOST_POINTS: Final = 500  # of the target, and errors of each kind, that a scene carries
COLOURS: Final = (FITTED, HELD_OUT)
BODY: Final = "var(--body)"
AXES: Final = ("#d6453d", "#3a9a4e", "#3d74c9")
AXIS: Final = 0.18  # length of the axes of the base frame as a share of the arm's
SENSOR: Final = 0.12  # length of the drawn sensor as a share of the arm's


def cell_scene(
    model: Model, x: Array, errors_m: Mapping[str, Array], *, title: str, marked: Mapping[str, str] | None = None
) -> Scene:
    """The cell by a fitted model, to be turned and stepped through.

    Errors of all rows are by the name of their series, the model's last [m]; suspected sites are marked by a text.
    """
    dataset, last = model.dataset, list(errors_m.values())[-1]
    of_pose = dataset.points.pose
    frames = _frames(of_pose, last)
    cell = CellPoses(model, x)
    shown = some_rows(lengths_mm(last), MOST_POINTS)
    names = _names(model, shown, last)
    shifts = {name: moved[shown] for name, errors in errors_m.items() if (moved := cell.shifts(errors)) is not None}
    number = {int(pose): i for i, pose in enumerate(frames)}
    of_frame = [number.get(int(pose), -1) for pose in of_pose[shown]]
    shapes = _arm(cell, frames, marked or {})
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
    note = "Lines lead from known to predicted points, magnified by the slider." if shifts else ""
    beside = " Beside it the image of the pose: rings are points extracted from it" if images else ""
    beside += ", lines lead to the predicted ones." if images and misses is not None else "." * bool(images)
    remark = " Highlighted: what is suspected, with its share of the error." if marked else ""
    longest = 0.0 if misses is None else float(np.nanpercentile(np.linalg.norm(misses, axis=1), 95))
    return Scene(
        title,
        f"{note}{beside}{remark}".strip(),
        f"The cell in {len(frames)} poses, with {len(shown)} points and their errors.",
        shapes,
        taken,
        magnification=factor,
        in_photos=magnification(longest, (dataset.image_px or (0, 0))[0]),
        photos=images,
    )


def _arm(cell: CellPoses, frames: Ints, marked: Mapping[str, str]) -> list[Shape]:
    line, tip, light = cell.line(frames), cell.tip[frames], cell.light(frames)
    has_joints = line.shape[1] > len(("base", "flange"))
    camera = None if cell.camera is None else cell.camera[frames]
    extent = line if has_joints else np.concatenate([tip, cell.known])[None]
    reach = float(np.ptp(extent.reshape(-1, 3), axis=0).max()) or 0.3
    ring = 0.05 * reach * np.array([(np.cos(a), np.sin(a), 0.0) for a in np.linspace(0, 2 * np.pi, 24)])
    shapes: list[Shape] = []
    if has_joints:
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
    if light.shape[1]:
        colour = HELD_OUT if "laser" in marked else "#d62828"
        shapes += [path(light, colour, width=1, closed=True, opacity=0.18)]
        shapes.append(path(light[:, 1:], colour, width=2))
    drawn = moving_joints(cell.model.dataset.robot) if has_joints else ()
    hand = (line[:, -1] + tip) / 2 if cell.rides else tip
    places = {joint: line[:, 1 + i] for i, joint in enumerate(drawn)}
    sites = {"base": line[:, 0], "tool" if camera is None else "hand_eye": hand}
    sites |= {} if camera is None else {"camera": tip}
    sites |= {"laser": light[:, 0]} if light.shape[1] else {}
    sites |= {"target": np.broadcast_to(cell.known.mean(axis=0), tip.shape)} if len(cell.known) else {}
    places |= {site: sites[kind] for site in marked if (kind := kind_of_site(site)) in sites}
    joints = [name for name in drawn if name not in marked]
    for names, colour, size, bold in ((joints, MUTED, 3.5, False), (list(marked), HELD_OUT, 7.0, True)):
        here = [name for name in names if name in places]
        if here:
            texts = [f"{place(name)} {marked.get(name, '')}".strip() for name in here]
            where = np.stack([places[name] for name in here], axis=1)
            shapes.append(labels(where, texts, colour, size=size, bold=bold))
    return shapes


def _axes(length: float) -> list[Shape]:
    """The base frame."""
    ends = length * np.eye(3)
    lines = [path(np.stack([np.zeros(3), end]), colour, width=2) for end, colour in zip(ends, AXES, strict=True)]
    return [*lines, *(labels(end[None], [axis], colour, size=0.0, bold=False)
                      for end, axis, colour in zip(ends, "xyz", AXES, strict=True))]  # fmt: skip


def _camera(T: Array, size: float, image_px: tuple[int, int]) -> list[Shape]:
    """A pyramid that opens along the camera's view."""
    half = 0.35 * size * np.array(image_px) / max(image_px)
    corners = np.array([(u * half[0], v * half[1], size) for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    ends = np.einsum("nij,kj->nki", T[:, :3, :3], corners) + T[:, None, :3, 3]
    eye = T[:, None, :3, 3]
    return [path(np.concatenate([eye, ends[:, [i, (i + 1) % 4]], eye], axis=1), INK, width=1) for i in range(4)]


def _frames(of_pose: Ints, errors: Array) -> Ints:
    """Poses with points, at most as many as a page holds: evenly taken, including the worst."""
    seen = np.unique(of_pose)
    if len(seen) <= MOST_FRAMES:
        return seen
    return seen[some_rows(np.array([rms(errors[of_pose == i]) for i in seen]), MOST_FRAMES)]


def _names(model: Model, rows: Ints, errors: Array) -> Sequence[str]:
    lengths = lengths_mm(errors)
    return [
        f"pose {pose}, point {point}\nerror {millimetres(lengths[row] / 1e3)}"
        for row, pose, point in zip(rows, *point_names(model.dataset, rows), strict=True)
    ]


MOST_PHOTOS: Final = 10
MOST_RINGS: Final = 80  # of an image
WIDTH_PX: Final = 560
QUALITY: Final = 55  # of JPEG: an image takes 10 to 40 kB


def photos(dataset: Dataset, frames: Sequence[int], errors_m: Array, misses: Array | None) -> Mapping[str, Shape]:
    """Images of some of these poses by their names, the worst first; none where none can be read.

    `misses` lead from each row's pixel to the predicted one, (m, 2) [px]; None where there is none.
    """
    images, pixel, of_pose = dataset.poses.image, dataset.points.pixel, dataset.points.pose
    if images is None or dataset.folder is None or pixel is None or dataset.image_px is None:
        return {}
    made: dict[str, Shape] = {}
    for pose in sorted(frames, key=lambda pose: -rms(errors_m[of_pose == pose])):
        source = (
            _small(dataset.folder / images[pose], dataset.image_px) if images[pose] and len(made) < MOST_PHOTOS else ""
        )
        if source:
            rows = np.flatnonzero(of_pose == pose)
            rows = rows[evenly(len(rows), MOST_RINGS)]
            lengths = lengths_mm(errors_m[rows])
            off = np.full((len(rows), 2), np.nan) if misses is None else misses[rows]
            names = [
                f"point {dataset.points.names[row]}\nerror {millimetres(length / 1e3)}"
                + (f"\n{px:.2g} px from where the model predicts it" if np.isfinite(px) else "")
                for row, length, px in zip(rows, lengths, np.linalg.norm(off, axis=1), strict=True)
            ]
            made[dataset.poses.names[pose]] = photo(source, dataset.image_px, pixel[rows], off, names)
    return made


def _small(path: Path, size_px: tuple[int, int]) -> str:
    """An image as a data URI; empty where it cannot be read, or has another size than was stated."""
    import cv2  # noqa: PLC0415 - slow to import

    from robolaser.vision.images import depth_of, eight_bits, read_image  # noqa: PLC0415

    try:
        image = read_image(path, size_px, cv2.IMREAD_GRAYSCALE)
    except ImageError:
        return ""
    scale = min(1.0, WIDTH_PX / max(size_px))
    width, height = (max(1, round(scale * side)) for side in size_px)
    small = cv2.resize(eight_bits(image, depth_of(image)), (width, height), interpolation=cv2.INTER_AREA)
    jpeg = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg.tobytes()).decode()}"
