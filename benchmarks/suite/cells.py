"""The data sets of the suite: simulated once and kept, or some rows of measurements that others have published."""

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from robolaser.data.dataset import Dataset, Poses
from robolaser.data.loading import load
from robolaser.data.stated_noise import Noise
from robolaser.data.subsampling import evenly
from robolaser.data.writing import save
from robolaser.model.forward_model import Model
from robolaser.parameters import Parameter
from robolaser.simulation import CellOptions, paper, simulate

FOLDER = Path(__file__).parents[2] / "robolaser" / "problems" / "calibration_suite" / "data"
MEASURED = Path(os.environ.get("ROBOLASER_DATA", "data"))
CHOICE = 300  # poses, of which the degenerate cells take the few that are most alike


def without_arm(dataset: Dataset, name: str) -> Dataset:
    """The same with flange poses in the place of joint angles, so that nobody needs the arm's model."""
    names = tuple(str(i) for i in range(len(dataset.poses)))
    poses = Poses(names, T_base_flange=dataset.flange())
    return replace(dataset, name=name, robot=None, poses=poses, path_known=False)


def alike(robot: str, poses: int, points: int, unlike: Callable[[np.ndarray], np.ndarray]) -> Dataset:
    """A cell of many poses, less all but those whose flanges (n, 3, 3) are least unlike."""
    made = simulate(robot, poses=CHOICE, points=points, noise=Noise(target_m=1e-4), seed=1).dataset
    kept = np.isin(np.arange(CHOICE), np.argsort(unlike(made.flange()[:, :3, :3]))[:poses])
    return made.of_poses(kept)


def tilt(flanges: np.ndarray) -> np.ndarray:
    """Angle between the tool and the plumb line, (n, 3, 3) -> (n,) [rad]."""
    return np.arccos(np.clip(-flanges[:, 2, 2], -1, 1))


def turn(flanges: np.ndarray) -> np.ndarray:
    """Angle to a flange that has many near it, (n, 3, 3) -> (n,) [rad]."""
    between = np.arccos(np.clip((np.einsum("aij,bij->ab", flanges, flanges) - 1) / 2, -1, 1))
    return between[np.sort(between, axis=1)[:, 10].argmin()]


def thinned(name: str, poses: int, rows: int) -> Dataset:
    """Some poses of a published data set, and some rows of each; a scanner without its camera's board."""
    whole = load(MEASURED / name)
    dataset = replace(whole.parts[0], parameters=whole.parameters)
    kept = np.zeros(len(dataset.poses), dtype=bool)
    seen = np.unique(dataset.points.pose)
    kept[seen[evenly(len(seen), poses)]] = True
    dataset = dataset.of_poses(kept)
    places = [np.flatnonzero(dataset.points.pose == i) for i in range(len(dataset.poses))]
    chosen = np.concatenate([rows_of[evenly(len(rows_of), rows)] for rows_of in places])
    return replace(
        dataset,
        points=dataset.points.take(chosen),
        poses=replace(
            dataset.poses, image=None, time_s=None, temperature_c=None, qd=None, qd_from_path=False, extra={}
        ),
        distances_m=(),  # rows that count as their noise says would be no part of J
        board=None,
        path_known=False,
        time_is_order=False,
    )


def bounded(dataset: Dataset, seed: int = 1) -> Dataset:
    """The same with bounds for what has none, as wide as usual, the optimum anywhere within."""
    rng = np.random.default_rng(seed)
    found = {}
    for item in Model(dataset).sensor_parameters.items:
        found[item.name] = item if item.given else _around(item, rng)
    return replace(dataset, parameters=found)


def _around(item: Parameter, rng: np.random.Generator) -> Parameter:
    """Bounds as far apart as the parameter's own, about another middle; all turns lie within a full one."""
    width = item.upper - item.lower
    middle = item.nominal + rng.uniform(-0.35, 0.35) * width
    if item.unit == "rad":
        width, middle = 6.28, (middle + np.pi) % (2 * np.pi) - np.pi
    middle = round(float(middle), 3)
    lower, upper = (round(middle + side * width / 2, 3) for side in (-1, 1))
    return replace(item, nominal=middle, lower=lower, upper=upper, given=True)


SIMULATED: dict[str, Callable[[], Dataset]] = {
    "lee2004": lambda: paper("scorbot_er7", seed=1).dataset,
    "ten-points": lambda: simulate("scorbot_er7", poses=5, points=2, noise=Noise(target_m=3e-4), seed=1).dataset,
    "ur10-pixels": lambda: (
        simulate("ur10", poses=20, points=8, noise=Noise(target_m=3e-4, pixel_px=0.2), seed=1).dataset
    ),
    "level-views": lambda: alike("scorbot_er7", 8, 6, tilt),
    "like-views": lambda: alike("panda", 10, 6, turn),
    "unplaced": lambda: (
        simulate(
            "ur3", poses=20, points=6, noise=Noise(target_m=2e-4), options=CellOptions(placed=False), seed=1
        ).dataset
    ),
    "along-v": lambda: (
        simulate(
            "z1", poses=6, points=8, noise=Noise(target_m=3e-4), options=CellOptions(stripe_axis="v"), seed=1
        ).dataset
    ),
    "camera-in-hand": lambda: (
        simulate("ur5", kind="camera", poses=12, points=12, noise=Noise(pixel_px=0.2), seed=1).dataset
    ),
    "ball-profiles": lambda: (
        simulate("panda", kind="profile", poses=24, points=3, noise=Noise(point_m=5e-5), seed=1).dataset
    ),
}
REAL: dict[str, Callable[[], Dataset]] = {
    "etna-s2": lambda: thinned("etna-s2", 10, 16),
    "etna-s3": lambda: thinned("etna-s3", 18, 10),
    "ur3e-camera": lambda: thinned("ur3e-hand-eye-2", 14, 12),
    "ur5-tracker": lambda: thinned("ur5-tracker", 80, 1),
    "ur10-tracker": lambda: thinned("ur10-tracker-b", 50, 3),
    "panda-1-sockets": lambda: thinned("mukca-panda_1", 182, 1),
    "panda-3-sockets": lambda: thinned("mukca-panda_3", 390, 1),
    "dinova-sockets": lambda: thinned("mukca-dinova_1", 140, 1),
}


def main() -> None:
    """Write those that are named, or all that are not there."""
    wanted = sys.argv[1:] or [name for name in (*SIMULATED, *REAL) if not (FOLDER / name).exists()]
    for name in wanted:
        dataset = without_arm(SIMULATED[name](), name) if name in SIMULATED else replace(REAL[name](), name=name)
        save(bounded(dataset), FOLDER / name, overwrite=True)
        (FOLDER / name / ".robolaser.json").unlink(missing_ok=True)
        print(name, dataset.summary, flush=True)


if __name__ == "__main__":
    main()
