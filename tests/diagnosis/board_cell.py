"""A SCORBOT's scanner on a board, and the start of its diagnosis."""

from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.preparation import Preparation
from robolaser.estimation.averaging import AveragedData
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5)


def cell(effects: dict[str, float] | None = None, seed: int = 2, poses: int = 40) -> Dataset:
    return simulate(
        find_robot("scorbot_er7"), poses=poses, points=8, noise=NOISE, effects=effects,
        options=CellOptions(repeats=2), seed=seed,
    ).dataset  # fmt: skip


def begun(dataset: Dataset) -> tuple[AveragedData, Fit]:
    preparation = Preparation.of(dataset, 1)
    data, fit = preparation.weighted.data, preparation.fit(())
    noise = fit.noise.at({source.name: 0.0 for source in fit.noise.sources_of_poses})
    return data, Fit.of(fit.problem.with_noise(noise), fit.x)  # an arm that repeats perfectly
