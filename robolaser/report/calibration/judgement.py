"""What a calibration's errors mean beside its noise, and how it was found, in sentences."""

import numpy as np

from robolaser.report.digits import millimetres, times
from robolaser.report.error_analysis import ErrorAnalysis

WEIGHTING = {"plain": "plain: all points weighted alike", "noise": "points weighted by their noise"}
"""What a calibration's option `weights` does."""
NOISE_ALONE = 1.1  # excess over noise up to which all is well: stated noise is seldom known better
CHANCE = 2.0  # standard errors of the excess that are allowed for on top
UNMODELLED = 2.0  # excess over noise from which no doubt about the noise explains it
OVERFITTED = 1.5
"""Error on new poses over error on fitted ones from which the parameters are more than the poses can carry."""


def headline(analysis: ErrorAnalysis) -> str:
    """Error on new poses beside what noise alone would give."""
    calibration = analysis.calibration
    does = calibration.model.blocks.sensor.format.task
    noise = analysis.noise_m
    if calibration.held_out_rms_m is None:
        first = "The error on new poses is unknown: there are too few poses to hold any out"
    else:
        first = f"On held-out poses, {does} {millimetres(calibration.held_out_rms_m)} off"
    if noise is None:
        return f"{first}; these data do not show how much of that is noise."
    return f"{first}; measurement noise alone would give {millimetres(noise)}."


def judgement(analysis: ErrorAnalysis) -> str:
    """What the two figures together mean."""
    calibration, noise = analysis.calibration, analysis.noise_m
    error = calibration.held_out_rms_m
    said = []
    if calibration.setup_warning is not None:
        said.append(calibration.setup_warning)
    elif noise is None:
        said.append(
            "State the known noise under `[noise]` in `dataset.toml`: then this report separates it from the errors of"
            " the model."
        )
    elif error is None:
        said.append("Measure more poses: the training error says little.")
    else:
        said.append(_against_noise(*excess(analysis, noise), error / noise))
    if error is not None and error > OVERFITTED * calibration.rms_m:
        said.append(
            f"The error on new poses is {times(error / calibration.rms_m)} times the training error:"
            " the poses are too few or too similar for this many parameters."
        )
    return " ".join(said)


def excess(analysis: ErrorAnalysis, noise_m: float) -> tuple[float, float]:
    """How many times larger the residuals are than noise leaves them in a fit, and the standard error of that.

    Fitted parameters swallow a part of the noise, which the degrees of freedom make up for; the error on new poses
    would not do here, since few poses raise it without anything being unmodelled.
    """
    calibration = analysis.calibration
    numbers = int(calibration.model.blocks.row_numbers.sum())
    free = max(1, numbers - len(calibration.x) + len(calibration.model.blocks.held))
    ratio = calibration.rms_m / noise_m * float(np.sqrt(numbers / free))
    return ratio, ratio / float(np.sqrt(2 * free))


def _against_noise(over: float, chance: float, ratio: float) -> str:
    if over <= NOISE_ALONE + CHANCE * chance:
        return "The remaining error is noise: the model is complete for these data."
    if over < UNMODELLED:
        return (
            f"That is {times(ratio)} times the noise: a small effect is unmodelled, or the noise is larger than stated."
            " `robolaser diagnose` finds which."
        )
    return (
        f"That is {times(ratio)} times the noise: something is unmodelled, and no choice of these parameters"
        " removes it. `robolaser diagnose` finds where it is, and which effects explain it."
    )


def method(analysis: ErrorAnalysis) -> str:
    """How the parameters were found."""
    calibration = analysis.calibration
    return (
        f"{calibration.algorithm}, seed {calibration.seed}, {WEIGHTING[calibration.weights]}; "
        f"{calibration.evaluations:,} candidates in {calibration.seconds:.1f} s"
    )
