"""Recordings and calibrations of synthetic cells, on disk."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from calibrated import finished

from robolaser.calibration.result import as_json
from robolaser.data.dataset import Points
from robolaser.data.loading import load
from robolaser.data.stated_noise import Noise
from robolaser.data.stripe_file import FILE, STRIPE, write_stripes
from robolaser.data.writing import save
from robolaser.export.urdf import robot_urdf
from robolaser.geometry.camera import laser_plane
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

ROBOT = "scorbot_er7"


def dataset(*, poses=20, points=8, seed=1, robot=ROBOT):
    """A calibration's data set with nominal values and little noise, of an arm with a known path."""
    made = simulate(find_robot(robot), poses=poses, points=points, noise=Noise(pixel_px=0.1), seed=seed).dataset
    where = made.poses
    if where.time_s is None:
        where = replace(where, time_s=np.arange(len(where), dtype=float))
    return replace(made, poses=where)


def calibrated(data, effects=(), numbers=None):
    """A calibration of a data set: nominal values except those in `numbers`."""
    model = Model(data, candidate_effects(effects, data))
    names, x = model.parameters.names, model.parameters.nominal.copy()
    for name, value in (numbers or {}).items():
        x[names.index(name)] = value
    made = finished(model, x)
    return replace(made, std=np.full(len(x), np.nan), held_out=None, noise={"pixel": 0.1, "joint": 1e-5}, history=None)


def written(calibration, folder: Path) -> Path:
    """Write calibration.json and the files beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "calibration.json").write_text(json.dumps(as_json(calibration)), encoding="utf-8")
    if calibration.model.dataset.robot is not None:
        (folder / "robot.urdf").write_text(robot_urdf(calibration), encoding="utf-8")
    return folder


def recorded(data, folder: Path, stripes=None):
    """A recording on disk, with points or with stripes."""
    if stripes is None:
        save(data, folder)
    else:
        save(replace(data, points=Points(np.empty(0, np.int64), ())), folder)
        write_stripes(folder / FILE, [stripes])
    return load(folder)


def line_centres(data, *, per_pose, seed=3, std=0.1):
    """Line centres all over the image, the same number in each pose."""
    rng = np.random.default_rng(seed)
    n = len(data.poses) * per_pose
    stripes = np.empty(n, STRIPE)
    stripes["pose"] = np.arange(len(data.poses)).repeat(per_pose)
    width, height = data.image_px
    stripes["u"], stripes["v"] = rng.uniform(0, width - 1, n), rng.uniform(0, height - 1, n)
    stripes["std"], stripes["intensity"] = std, rng.uniform(20, 250, n)
    return stripes


def laser_planes(scanner):
    """The laser plane in the camera frame at each pose of a scan, (n, 4): n · P = d."""
    plane = scanner.perturb(scanner.at_poses)(Stage.LASER_PLANE, laser_plane(scanner.values))[0]
    return np.broadcast_to(plane, (len(scanner.dataset.poses), 4))
