"""Remarks on noise that differs from the stated one, is shared by an image, or grows with range."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.thresholds import MOST_OVER_STATED, ONE_MEASUREMENT
from robolaser.estimation.certainty import EVEN
from robolaser.estimation.noise_estimate import NOISE_CONTRADICTED_SIGMA, Excess, row_excess
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.repeats import PixelRepeats, pixel_repeats

KEYS: Final = {
    "pixel": "pixel_px",
    "target": "target_m",
    "point": "point_m",
    "angle": "angle_rad",
    "joint": "joint_rad",
}
"""The key of each source in `[noise]`."""
SHOWN: Final = {"repeats": "repeated shots", "estimated": "residuals"}  # the evidence for noise, by its origin


def noise_remarks(final: Fit, noise: NoiseModel, shots: Dataset, *, fits: bool) -> tuple[str, ...]:
    """Sentences on the noise of a diagnosis.

    Args:
        final: Its model.
        noise: The noise in the judgement of its residuals.
        shots: The data set with its repeats.
        fits: Whether the residuals are noise: an unexplained error may grow with any quantity.
    """
    remarks = []
    for sensor in shots.sensors:
        part = sensor.data
        repeats = pixel_repeats(part)
        remarks += [
            *_contradicted(noise, part, sensor.prefix, fits=fits),
            *_smaller(final, part, repeats),
            *_shared(part, repeats),
        ]
    return (*dict.fromkeys(remarks), *(_growing(final) if fits else ()))


def over_stated(noise: NoiseModel) -> float:
    """Largest ratio of estimated to stated row noise; 0 if none is stated."""
    ratios = (
        noise.sigmas[source.name] / source.stated
        for source in noise.sources
        if source.stated and source.level != "pose" and noise.origin.get(source.name) == "estimated"
    )
    return max(ratios, default=0.0)


def as_stated(noise: NoiseModel) -> NoiseModel:
    """The noise with row noise as stated."""
    return noise.at({one.name: one.stated for one in noise.sources if one.stated and one.level != "pose"})


def _contradicted(noise: NoiseModel, shots: Dataset, prefix: str, *, fits: bool) -> Iterator[str]:
    """Remarks on sources that exceed the stated value; it stays in use if the excess is no noise, see `over_stated`."""
    for key_name, key in KEYS.items():
        name = f"{prefix}{key_name}"
        stated, used = getattr(shots.noise, key), noise.sigmas.get(name)
        origin = noise.origin.get(name, "stated")
        if stated is not None and used is not None and origin != "stated" and used > stated:
            is_no_noise = not fits and origin == "estimated" and used >= MOST_OVER_STATED * stated
            which = "the stated value counts as noise" if is_no_noise else "the larger one is used"
            yield f"[noise] states {key} = {stated:.2g}, but {SHOWN[origin]} scatter by {used:.2g}: {which}."


def _smaller(final: Fit, shots: Dataset, repeats: PixelRepeats | None) -> Iterator[str]:
    stated = shots.noise.pixel_px
    if stated and repeats and Excess.of(repeats.freedoms * (repeats.sigma_px / stated) ** 2, repeats.freedoms).is_below:
        yield (
            f"[noise] states pixel_px = {stated:.2g}, but repeated shots scatter by only {repeats.sigma_px:.2g}: the"
            " stated value is used, and may hide effects."
        )
        return
    row_excesses = row_excess(final.noise, final.at.white, final.problem.numbers - len(final.x))
    if row_excesses.is_below and "stated" in final.noise.origin.values():
        yield (
            "The rows of a pose agree as if they were made from one measurement: they do not show its noise, and the"
            " value in [noise] is used."
            if row_excesses.ratio < ONE_MEASUREMENT
            else f"The rows of a pose scatter only {row_excesses.ratio:.2g} times as much as [noise] states: the stated"
            " value is used, and may hide effects."
        )


def _shared(shots: Dataset, repeats: PixelRepeats | None) -> Iterator[str]:
    if repeats is None:
        return
    for axis, size, sigma in zip("uv", repeats.shared_px, repeats.shared_z, strict=True):
        if sigma > NOISE_CONTRADICTED_SIGMA:
            yield (
                f"All rows of an image move together along {axis} by {size:.2g} px from shot to shot: more rows do not"
                " average that out, more shots do. It counts as scatter of whole poses."
            )


def _growing(final: Fit) -> Iterator[str]:
    """Test squared whitened residuals against the logarithm of the range by a score test (Cook, Weisberg 1983)."""
    model = final.model
    ranges = model.blocks.ranges(*model.at(final.x))
    if ranges is None or ranges.min() <= 0.0 or np.ptp(ranges) == 0.0:
        return
    squares = final.row_squares / model.blocks.row_numbers
    over = squares / squares.mean() - 1.0
    away = np.log(ranges) - np.log(ranges).mean()
    sigma = float(over @ away / np.sqrt((away @ away) * over.var()))
    exponent = 0.5 * float(over @ away / (away @ away))
    if sigma > NOISE_CONTRADICTED_SIGMA and exponent > EVEN:
        yield (
            f"The noise of a row grows with its distance from the sensor, about as its power {exponent:.1f}: near rows"
            " count too little, far rows too much."
        )
