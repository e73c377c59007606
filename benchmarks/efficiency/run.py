"""Efficiency of the noise-weighted calibration: the variance of its predictions relative to the Cramér-Rao bound.

The same poses are measured repeatedly with new noise of known size on pixels and target points. Each repeat is
calibrated from the nominal values, and predicts the points of other poses. No unbiased estimate has a smaller
variance than tr G (Jᵀ Σ⁻¹ J)⁻¹ Gᵀ: J and G are the derivatives of fitted and predicted points at the truth, f fixed,
and Σ is the covariance of a row from both kinds of noise. (With the true pixels as further unknowns, that is the
Schur complement of the whole Fisher information.)

The mean over few repeats is uncertain. The linear estimate at the truth for the same noise is therefore a control
variate: its mean is the bound, and it is correlated with the repeat.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.calibrate import Plan, calibrate
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.model.forward_model import Model, jacobian_matrix
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

WORLDS = {"pixels and target alike": (0.1, 3e-5), "mostly pixels": (0.1, 5e-6), "mostly target": (0.02, 1e-4)}
"""Standard deviation of a pixel [px] and of a target point [m]."""
POSES, POINTS, UNSEEN = 60, 12, 20
BUILT = 4  # seed of a scanner that these poses determine well
OPENED = 3.0  # distance from nominal values to bounds, in widths of the bounds: none is active
POSITIVE = ("s_u", "s_v")
CLEAR = 4.0  # least distance of the truth from every bound, in standard deviations
PROCESSES = 2
PIXEL_STEP_PX = 0.1


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--repeats", type=int, default=40)
    repeats = options.parse_args().repeats
    print("| case | noise | bound on the RMS [mm] | `noise`: times the bound | `plain`: times the bound |")
    print("|---|---|---|---|---|")
    with ProcessPoolExecutor(PROCESSES) as pool:
        for name, (pixel_px, target_m) in WORLDS.items():
            cells = []
            for weights in ("noise", "plain"):
                work = [(name, weights, seed) for seed in range(repeats)]
                squares = np.array(list(pool.map(square_errors, work, chunksize=5)))
                cells.append(against(squares, bound(name).square))
            rms = 1e3 * np.sqrt(bound(name).square / (UNSEEN * POINTS))
            print(
                f"| {name} | {pixel_px:g} px, {1e3 * target_m:g} mm | {rms:.4f} | {cells[0]} | {cells[1]} |", flush=True
            )


@cache
def world(name: str) -> tuple[Dataset, Dataset, dict[str, float]]:
    """The fitted and the predicted data set, both without noise, and the truth."""
    pixel_px, target_m = WORLDS[name]
    stated = Noise(pixel_px=pixel_px, target_m=target_m)
    made = simulate(
        find_robot("scorbot_er7"), poses=POSES + UNSEEN, points=POINTS, options=CellOptions(stated=stated), seed=BUILT
    )
    opened = {}
    for key, item in made.dataset.parameters.items():
        room = OPENED * (item.upper - item.lower)
        lower = item.nominal / OPENED if key in POSITIVE else item.nominal - room
        opened[key] = replace(item, lower=lower, upper=item.nominal + room)
    dataset = replace(made.dataset, parameters=opened)
    fitted = np.arange(POSES + UNSEEN) % 4 != 0
    return dataset.of_poses(fitted), dataset.of_poses(~fitted), dict(made.truth)


@final
@dataclass(frozen=True)
class Bound:
    """The Cramér-Rao bound of the predictions.

    Attributes:
        square: Least expected sum over points of squared distances, tr G C Gᵀ [m²].
        answer: Errors of predictions by the linear estimate at the truth per error of a row, (3p, 3m).
        pixel_effect: Derivative of a row by its pixel, (m, 3, 2) [m/px].
    """

    square: float
    answer: Array
    pixel_effect: Array


@cache
def bound(name: str) -> Bound:
    """The bound of one world."""
    fitted, unseen, truth = world(name)
    model = Model(fitted)
    x = model.fix_gauge(np.array([truth[key] for key in model.parameters.names]))
    free = ~np.isin(model.parameters.names, model.blocks.fixed)
    J, G = (jacobian_matrix(each, x)[:, free] for each in (model, Model(unseen)))
    pixel_px, target_m = WORLDS[name]
    of_pixel = pixel_effect(model, x)
    row = pixel_px**2 * of_pixel @ np.swapaxes(of_pixel, 1, 2) + target_m**2 * np.eye(3)
    weighed = np.linalg.solve(row, J.reshape(len(row), 3, -1)).reshape(J.shape).T
    cov = np.linalg.inv(weighed @ J)
    room = np.minimum(x - model.parameters.lower, model.parameters.upper - x)[free] / np.sqrt(np.diag(cov))
    assert (room > CLEAR).all(), "a bound may be active"
    return Bound(float(np.trace(G @ cov @ G.T)), G @ cov @ weighed, of_pixel)


def pixel_effect(model: Model, x: Array) -> Array:
    """Derivative of each row by its pixel, by central differences, (m, 3, 2) [m/px]."""
    points = model.dataset.points
    assert points.pixel is not None

    def residuals(shift: Array) -> Array:
        moved = replace(points, pixel=points.pixel + shift)
        e: Array = Model(replace(model.dataset, points=moved)).residuals(x[None])[0]
        return e

    steps = PIXEL_STEP_PX * np.eye(2)
    return np.stack([(residuals(step) - residuals(-step)) / (2 * PIXEL_STEP_PX) for step in steps], axis=-1)


def square_errors(work: tuple[str, str, int]) -> tuple[float, float]:
    """Sum of squared distances of the points predicted by one repeat, and by the linear estimate [m²]."""
    name, weights, seed = work
    fitted, unseen, _ = world(name)
    pixel_px, target_m = WORLDS[name]
    rng = np.random.default_rng(seed)
    points = fitted.points
    assert points.pixel is not None
    assert points.xyz is not None
    of_pixel = pixel_px * rng.standard_normal(points.pixel.shape)
    of_target = target_m * rng.standard_normal(points.xyz.shape)
    shaken = replace(points, pixel=points.pixel + of_pixel, xyz=points.xyz + of_target)
    found = calibrate(replace(fitted, points=shaken), Plan(algorithm="gauss-newton", weights=weights))
    assert not found.on_bound.any(), "a bound is active"
    errors = of_target + (bound(name).pixel_effect @ of_pixel[..., None])[..., 0]
    linear = bound(name).answer @ errors.reshape(-1)
    return float(Model(unseen).cost(found.x[None])[0]), float(linear @ linear)


def against(squares: Array, least: float) -> str:
    """RMS error relative to the bound, with one standard error."""
    made, linear = squares.T
    swing = np.cov(made, linear)
    together = swing[0, 1] / swing[1, 1]
    mean = made.mean() - together * (linear.mean() - least)
    error = np.sqrt((swing[0, 0] - together * swing[0, 1]) / len(made))
    ratio = np.sqrt(mean / least)
    return f"{ratio:.4f} ± {ratio * error / (2 * mean):.1g}"


if __name__ == "__main__":
    main()
