"""The corrected model: a diagnosis's result as a calibration for prediction and scanning in other programs."""

from typing import Any

import numpy as np

from robolaser.arrays import Bools
from robolaser.calibration.calibrate import bound_warnings
from robolaser.calibration.exchanged_poses import with_rows_at
from robolaser.calibration.result import Calibration, as_json
from robolaser.diagnosis.gross_errors import counted
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.summary_text import exchanged_sentence
from robolaser.estimation.fisher_information import Information
from robolaser.estimation.identifiability import unidentifiable
from robolaser.estimation.noise_estimate import noise_of
from robolaser.model.forward_model import Model, jacobian


def corrected(diagnosis: Diagnosis, seed: int) -> Calibration:
    """The final model with all effects found.

    Its residuals are of every row of points.csv, gross errors included; its error on new poses is the remaining gap,
    without them.
    """
    x, parameters = diagnosis.x, diagnosis.model.parameters
    noise = noise_of(diagnosis.model, x)
    known = Information.of(jacobian(diagnosis.model, x[None])[0], noise, weights=noise)
    known += Information.of_known_distances(diagnosis.model, x)
    on_bound = given_on_bound(diagnosis)
    warnings = bound_warnings(diagnosis.model, on_bound)
    if len(diagnosis.outliers):
        warnings.append(
            f"{counted(diagnosis.dataset, diagnosis.outliers)}: objective_m2, rms_m and max_m include all rows, but the"
            " parameters are those of the others. See gross_errors in diagnosis.json."
        )
    if diagnosis.belongs:
        warnings.append(exchanged_sentence(diagnosis.belongs, diagnosis.dataset.poses.names).strip())
    model = Model(with_rows_at(diagnosis.dataset, diagnosis.belongs), diagnosis.model.effects)
    stated = np.array([item.fixed for item in parameters.items])
    return Calibration(
        model=model,
        algorithm="diagnosis",
        weights="noise",
        seed=seed,
        x=x,
        std=diagnosis.std,
        on_bound=on_bound,
        unidentifiable=tuple(unidentifiable(known, parameters.names, parameters.width, stated=stated)),
        residuals=model.residuals_at(parameters.values(x[None]))[0],
        held_out=diagnosis.after_m,
        unseen=diagnosis.unseen,
        fitted=diagnosis.model,
        noise={name: source.value for name, source in diagnosis.noise.items()},
        history=None,
        evaluations=0,
        seconds=diagnosis.seconds,
        warnings=(*diagnosis.dataset.warnings, *warnings),
    )


def given_on_bound(diagnosis: Diagnosis) -> Bools:
    """Mask of the parameters on a bound that the data set gives, (d,)."""
    x, parameters = diagnosis.x, diagnosis.model.parameters
    fixed = np.isin(parameters.names, diagnosis.model.blocks.held)
    of_effects = np.isin(parameters.names, diagnosis.model.effect_parameters.names)
    given = ~of_effects & [item.given for item in parameters.items]
    return np.asarray(given & ~fixed & ((x <= parameters.lower) | (x >= parameters.upper)))


def corrected_json(calibration: Calibration) -> dict[str, Any]:
    """Contents of calibration.json for a corrected model, which has no count of evaluations."""
    return as_json(calibration) | {"evaluations": None}
