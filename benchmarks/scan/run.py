"""How fast does a recording's stripes.npy become a PLY file on disk: against plain NumPy, and as it grows?

Every figure is the median of rounds in which both ways take turns; in brackets the lowest and the highest. Memory is
what a scan in a process of its own held at most at once, beyond what it held before, as tracemalloc counts it.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration, json_text
from robolaser.compiled import cores
from robolaser.data.dataset import Dataset, Noise, Points
from robolaser.data.loading import load
from robolaser.data.stripe_file import FILE, STRIPE, open_stripes, write_stripes
from robolaser.data.writing import save
from robolaser.export.urdf import robot_urdf
from robolaser.geometry.camera import intersect, laser_plane, metric, rays, undistort
from robolaser.geometry.rigid_motion import apply
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.scan import Scan, prepare, read_calibration
from robolaser.scan.ply import VERTEX, map_ply, positions_of, write_ply
from robolaser.simulation import simulate

MODELS = {
    "nominal": (),
    "laser_roll, backlash": ("laser_roll", "backlash:joint_2"),
    "laser_curvature, radial_distortion": ("laser_curvature", "radial_distortion"),
}
POSES = 200
CHUNK = 1 << 20  # middles that plain NumPy takes at a time


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rounds", type=int, default=5)
    options.add_argument("--millions", type=int, nargs="+", default=[4, 20])
    options.add_argument("--one", nargs=2, type=Path, help=argparse.SUPPRESS)
    told = options.parse_args()
    if told.one:
        print(memory(*told.one))
        return
    with tempfile.TemporaryDirectory() as folder:
        print("| model | million middles | cores | NumPy [million/s] | robolaser [million/s] | times | memory [MB] |")
        print("|---" * 7 + "|")
        for model, effects in MODELS.items():
            for millions in told.millions:
                compare(model, effects, millions, told.rounds, Path(folder))


def compare(model: str, effects: tuple[str, ...], millions: int, rounds: int, folder: Path) -> None:
    calibration, recording = made(effects, millions, folder)
    scan, out = prepare(read_calibration(calibration), load(recording)), folder / "cloud.ply"
    count = millions * 1_000_000
    for threads in (1, 2):
        os.environ["OMP_NUM_THREADS"] = str(threads)
        cores.cache_clear()
        seconds = []
        for _ in range(rounds + 1):  # the first compiles and fills the disk's cache
            began = time.perf_counter()
            write_ply(out, scan.cloud.pieces(), ())
            ours = time.perf_counter() - began
            kept = positions_of(map_ply(out)[:1000])
            began = time.perf_counter()
            if effects == ():
                plain(scan, recording / FILE, out)
                np.testing.assert_allclose(positions_of(map_ply(out)[:1000]), kept, atol=1e-6)
            seconds.append((ours, time.perf_counter() - began))
        ours_s, plain_s = np.array(seconds[1:]).T
        took = subprocess.run(
            [sys.executable, __file__, "--one", str(calibration), str(recording)],
            check=True,
            capture_output=True,
            text=True,
        ).stdout.strip()
        against = f"{count / np.median(plain_s) / 1e6:.1f} | " if effects == () else "| "
        ratio = spread(plain_s / ours_s) if effects == () else ""
        print(
            f"| {model} | {millions} | {threads} | {against}{spread(count / ours_s / 1e6)} | {ratio} | {took} |",
            flush=True,
        )


def made(effects: tuple[str, ...], millions: int, folder: Path) -> tuple[Path, Path]:
    """A calibration and a recording on disk."""
    dataset: Dataset = simulate(find_robot("scorbot_er7"), poses=POSES, points=4, noise=Noise(), seed=1).dataset
    model = Model(dataset, candidate_effects(effects, dataset))
    x, d = model.parameters.nominal, len(model.parameters)
    found = Calibration(
        model, "none", "plain", 1, x, np.full(d, np.nan), np.zeros(d, dtype=bool), (), model.residuals(x[None])[0],
        None, {"pixel": 0.1, "joint": 1e-5}, None, 1, 0.0, (),
    )  # fmt: skip
    calibration, recording = folder / "calibration", folder / f"{millions}"
    calibration.mkdir(exist_ok=True)
    (calibration / "calibration.json").write_text(json_text(found), encoding="utf-8")
    (calibration / "robot.urdf").write_text(robot_urdf(found), encoding="utf-8")
    if not (recording / FILE).exists():
        save(replace(dataset, points=Points(np.empty(0, np.int64), ())), recording)
        width, height = dataset.image_px or (640, 480)
        rng, of_pose = np.random.default_rng(0), millions * 1_000_000 // POSES
        write_stripes(recording / FILE, (stripe(rng, pose, of_pose, width, height) for pose in range(POSES)))
    return calibration, recording


def stripe(rng: np.random.Generator, pose: int, count: int, width: int, height: int) -> np.ndarray:
    """Middles all over the image of one pose."""
    out = np.empty(count, STRIPE)
    out["pose"], out["std"], out["intensity"] = pose, 0.1, 100.0
    out["u"], out["v"] = rng.uniform(0, width - 1, count), rng.uniform(0, height - 1, count)
    return out


def plain(scan: Scan, stripes_file: Path, out: Path) -> None:
    """The same in NumPy, written straight from the equations; its scatter by a difference."""
    scanner, stripes = scan.cloud.scanner, open_stripes(stripes_file)
    values, T = scanner.values, scanner.camera

    def seen(pixel: Array) -> Array:
        ray = rays(undistort(metric(pixel[None], values), values["k"]), values["f"], scanner.dataset.stripe_axis)
        return intersect(ray, laser_plane(values))[0]

    def pieces():  # type: ignore[no-untyped-def]
        for first in range(0, len(stripes), CHUNK):
            piece = stripes[first : first + CHUNK]
            pixel = np.stack([piece["u"], piece["v"]], axis=-1).astype(np.float64)
            points, beside = seen(pixel), seen(pixel + np.array([0.0, 0.25]))
            vertices = np.empty(len(piece), VERTEX)
            vertices["x"], vertices["y"], vertices["z"] = apply(T[piece["pose"]], points).T
            slope = np.linalg.norm(beside - points, axis=1) / 0.25
            vertices["std"] = np.hypot(piece["std"] * slope, scan.cloud.arm[piece["pose"]])
            vertices["pose"], vertices["intensity"] = piece["pose"], piece["intensity"]
            yield vertices[(points[:, 2] > 0) & (points[:, 2] < 10.0)]

    write_ply(out, pieces(), ())


def memory(calibration: Path, recording: Path) -> str:
    """Megabytes that a scan takes at most, beyond what stands before it."""
    scan = prepare(read_calibration(calibration), load(recording))
    next(scan.cloud.pieces())  # compiled and warm
    tracemalloc.start()
    write_ply(recording / "cloud.ply", scan.cloud.pieces(), ())
    return f"{tracemalloc.get_traced_memory()[1] / 1e6:.1f}"


def spread(values: Array) -> str:
    """Median, lowest and highest."""
    low, mid, high = (f"{value:.3g}" for value in np.quantile(values, (0, 0.5, 1)))
    return f"{mid} ({low} to {high})"


if __name__ == "__main__":
    main()
