"""From images to points: pixels of the stripe with their positions on the board."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Image, Ints
from robolaser.data.board import Board
from robolaser.data.dataset import Points
from robolaser.data.image_list import PoseImages
from robolaser.vision.board import BoardCorners, find_board
from robolaser.vision.board_placement import FEWEST_LINES, crosses_squares, on_plane
from robolaser.vision.lens import BoardPlane, Intrinsics
from robolaser.vision.runs import LineCentres
from robolaser.vision.stripe_detection import find_line_centres
from robolaser.vision.stripe_trace import StripeSearch
from robolaser.vision.target import target_in
from robolaser.vision.target_corners import Frame

BRIGHTER = 1.2  # least grey of a stripe relative to light squares: it adds light to them
LIGHT_PERCENT = 80.0  # percentile of a board's pixels that is paper: marks and ink cover two thirds
MUCH = 0.05  # excluded share of a stripe that is reported: the image's rim and a shadow cause as much
SQUARES_BEYOND = 0.9  # squares beyond the inner corners that certainly belong to the board: it has a whole one there


@final
@dataclass(frozen=True)
class Extraction:
    """Pixels of the stripe with their positions on the board."""

    # pixels with the lens's distortion and positions in the board's frame; a point's name is its line of pixels,
    # `repeat` the number of the image at its pose, from 1
    points: Points
    frames: tuple[Frame, ...]  # the result for each pose, in order
    lens: Intrinsics  # whose distortion was removed before planes were fitted
    pixel_noise_px: float  # scatter of the stripe's centre about its smooth course [px]
    channel: str = "grey"  # name of the channel for the detection of the light

    def __len__(self) -> int:
        return len(self.points)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Warnings on the position of the stripe."""
        used = [frame for frame in self.frames if not frame.skipped]
        cut = [frame.left_out for frame in used if frame.left_out > MUCH]
        beside = sum(frame.beside for frame in used)
        doubts = []
        if cut:
            doubts.append(
                f"in {len(cut)} of {len(used)} images the stripe has a step beside the board's squares, as on a table"
                f" below a thick board: {np.mean(cut):.0%} of its length there, beyond the step, was excluded."
            )
        if beside:
            doubts.append(
                f"in {beside} of {len(used)} images the stripe crosses none of the board's squares; it is assumed"
                " to be in the board's plane, which is wrong if it is on a table below a thick board."
            )
        return tuple(doubts)


@final
@dataclass(frozen=True)
class Look:
    """Board and stripe in the images of a pose."""

    board: BoardCorners | None
    centres: tuple[LineCentres, ...]


def look(shots: PoseImages, search: StripeSearch, board: Board) -> Look:
    """Detect the board, without the laser where there is such an image, and candidates for the stripe."""
    without = None if shots.unlit is None else search.camera.grey(shots.unlit)
    seen = None if without is None else _board_in(without, board)
    found: list[LineCentres] = []
    for image, light in search.lights(shots):
        if seen is None and not found:
            seen = _board_in(image, board)
        centres = find_line_centres(light, search.axis)
        if seen is not None and without is None and search.channel == "grey":
            centres = centres.at(centres.peak > BRIGHTER * seen.white_level)
        found.append(centres)
    return Look(seen, tuple(found))


def _board_in(image: Image, board: Board) -> BoardCorners | None:
    if board.kind == "checkerboard":
        return find_board(image, columns=board.columns, rows=board.rows)
    ways = target_in(image, board)
    if not ways:
        return None
    (left, top), (right, bottom) = (end(ways[0], axis=(0, 1)).astype(int) for end in (np.nanmin, np.nanmax))
    return BoardCorners(ways, float(np.percentile(image[max(top, 0) : bottom, max(left, 0) : right], LIGHT_PERCENT)))


@final
@dataclass(frozen=True)
class OnBoard:
    """The stripe on the board's plane in one image."""

    repeat: int  # number of the image at its pose, from 1
    line: Ints  # lines of pixels of the points, (n,)
    pixel: Array  # (n, 2) [px]
    place: Array  # (n, 3) [m]
    off: Array  # distance of all its centres from a straight line, (k,) [px]
    crosses: bool  # whether it crosses the board's squares
    left_out: float  # share of its lines of pixels beyond a step beside the squares


def on_board(
    shots: tuple[LineCentres, ...], view: BoardPlane, lens: Intrinsics, board: Board, step: int
) -> list[OnBoard]:
    """The stripe in each image of a pose that shows enough of it on the board."""
    found = []
    size, surely_m = board.square_m * np.array([board.columns - 1, board.rows - 1]), SQUARES_BEYOND * board.square_m
    for number, centres in enumerate(shots, start=1):
        straight = lens.undistort(centres.pixel)
        place = view.intersect(straight)
        along, across = straight[:, ::-1].T if centres.axis == "v" else straight.T
        on_squares = np.all(np.abs(place - size / 2) <= size / 2 + surely_m, axis=-1)
        kept, off = on_plane(centres, along, across, _nearness(place, size), on_squares)
        if kept.sum() < FEWEST_LINES:
            continue
        lines = np.flatnonzero(kept)
        taken = lines[_every(centres.line[lines], step)]
        crosses = crosses_squares(centres, on_squares)
        beyond = _beyond(centres, kept) if crosses else 0.0
        xyz = np.pad(place[taken], ((0, 0), (0, 1)))
        found.append(OnBoard(number, centres.line[taken], centres.pixel[taken], xyz, off[kept], crosses, beyond))
    return found


def _every(line: Ints, step: int) -> Ints:
    """Lines of pixels (n) at multiples of `step` in the image, (k,); the central one where there is none."""
    chosen = np.flatnonzero(line % step == step // 2)
    return chosen if len(chosen) else np.arange(len(line))[len(line) // 2 :][:1]


def frame_of(pose: str, shots: tuple[LineCentres, ...], view: BoardPlane | None, found: Sequence[OnBoard]) -> Frame:
    """The result for the images of a pose."""
    if view is None:
        return Frame(pose, skipped="no board")
    if not found:
        skipped = "no stripe on the board" if any(map(len, shots)) else "no stripe"
        return Frame(pose, skipped=skipped, corner_rms_px=view.corner_rms_px)
    return Frame(
        pose,
        points=sum(len(one.line) for one in found),
        corner_rms_px=view.corner_rms_px,
        line_rms_px=float(np.sqrt(np.mean(np.concatenate([one.off for one in found]) ** 2))),
        beside=not all(one.crosses for one in found),
        left_out=float(np.mean([one.left_out for one in found])),
    )


def _beyond(centres: LineCentres, kept: Bools) -> float:
    """Share of the lines of pixels with a stripe's light before the first or after the last kept one."""
    lines = np.unique(centres.line[centres.is_symmetric])
    first, last = centres.line[kept].min(), centres.line[kept].max()
    return float(((lines < first) | (lines > last)).mean())


def _nearness(place: Array, size: Array) -> Array:
    """Weights (n,) of positions, (n, 2) [m], by their distance beyond the corners, in sizes of the board, (2,) [m]."""
    beyond = np.linalg.norm(np.maximum(np.abs(place - size / 2) - size / 2, 0.0), axis=-1) / size.max()
    return np.asarray(1.0 / (1.0 + beyond**2))
