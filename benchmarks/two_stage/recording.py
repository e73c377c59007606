"""A recording as both ways see it: the same points, and the board's corners for the way that needs them."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import cv2
import numpy as np
from peer import View

from robolaser.data.dataset import Dataset, Points
from robolaser.data.image_list import PoseImages
from robolaser.data.loading import load
from robolaser.vision.board import find_board
from robolaser.vision.board_orientation import orient_by_robot
from robolaser.vision.extract import extract_points
from robolaser.vision.lens import find_lens
from robolaser.vision.stripe_trace import StripeSearch


@final
@dataclass(frozen=True)
class Recording:
    """Points of a stripe and corners of a board, one view a pose."""

    dataset: Dataset
    views: tuple[View, ...]


def measure(folder: Path) -> Recording:
    """Extract points and corners; points.csv, where there is one, is left aside."""
    dataset = load(folder)
    board, image_px, T = dataset.board, dataset.image_px, dataset.poses.T_base_flange
    if board is None or image_px is None or T is None or dataset.poses.image is None:
        raise SystemExit(f"{folder}: not a recording of a board with flange poses.")
    images = [(name, folder / file) for name, file in zip(dataset.poses.names, dataset.poses.image, strict=True)]
    shots = [PoseImages(row, name, (file,)) for row, (name, file) in enumerate(images)]
    search = StripeSearch.of(dataset, shots, channel="grey")
    found = extract_points(shots, search, board, R_base_flange=T[:, :3, :3])
    number = {name: i for i, name in enumerate(dataset.poses.names)}
    pose = np.array([number[name] for name in found.pose], dtype=np.int64)
    points = Points(pose, found.point, pixel=found.pixel, xyz=found.place)

    seen = [
        find_board(cv2.imread(str(f), cv2.IMREAD_GRAYSCALE), columns=board.columns, rows=board.rows) for _, f in images
    ]
    missing = [name for (name, _), one in zip(images, seen, strict=True) if one is None]
    if missing:
        raise SystemExit(f"{folder}: no board in {', '.join(missing)}; the two-stage way needs one in every image.")
    orientations = [one.orientations for one in seen if one is not None]
    lens = find_lens([ways[0] for ways in orientations], board.square_m, *image_px)
    grids = orient_by_robot(orientations, T[:, :3, :3], lens)
    v, u = np.indices((board.rows, board.columns))
    lattice = board.square_m * np.stack([u, v, np.zeros_like(u)], axis=-1).reshape(-1, 3)
    views = []
    for grid in grids:
        there = np.isfinite(grid).all(axis=-1).ravel()
        views.append(View(lattice[there], grid.reshape(-1, 2)[there]))
    return Recording(replace(dataset, points=points, warnings=()), tuple(views))
