"""Small diagnoses of every kind of sensor and verdict, composed by hand."""

from dataclasses import replace

import numpy as np
from calibrated import arm, point, socket, stripe

from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.further_poses import Weighed
from robolaser.diagnosis.gross_errors import gross_sentence
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.result import (
    Alternative,
    DetectionLimit,
    Diagnosis,
    Estimate,
    Finding,
    Gap,
    NoiseSource,
    Repeatability,
)
from robolaser.diagnosis.summary_text import sentence
from robolaser.estimation.problem import Problem
from robolaser.model.effects import EFFECTS, candidate_effects
from robolaser.model.effects.effect import CandidateEffect

GEOMETRIC = ("joint_offset:perturb", "link_geometry:lift")
BY_NAME = {kind.name: kind for kind in EFFECTS}


def candidate_effect(text):
    name, _, where = text.partition(":")
    return CandidateEffect(BY_NAME[name], where)


def of(calibration, verdict="explained", *, rivals=(), gross=()):
    """A diagnosis with the model of a calibration as its final model."""
    model, x = calibration.model, calibration.x
    fit = Fit(Problem.of(model), x)
    names = model.parameters.names
    after = calibration.residuals
    before = after + (5e-4 * np.random.default_rng(8).normal(size=after.shape) if model.effects else 0.0)
    gap_m = np.geomspace(8e-4, 1.2e-4, len(model.effects) + 1) if verdict != "no_gap" else np.array([1.12e-4])
    findings = []
    for k, one in enumerate(model.effects):
        numbers = {}
        for item in one.parameters.items:
            i = names.index(item.name)
            std = float(calibration.std[i])
            number = Estimate(float(x[i]), std if np.isfinite(std) else None, item.unit)
            numbers[item.name.rpartition(".")[2]] = number
        findings.append(
            Finding(
                one,
                0.97,
                numbers,
                gap_m[k],
                gap_m[k + 1],
                gap_m[0],
                tuple(Alternative(candidate_effect(text), numbers, 1.01 * gap_m[k + 1]) for text in rivals),
            )
        )
    joints = model.dataset.robot.joints if model.dataset.robot else ()
    site = model.effects[0].where if model.effects else "base"
    locations = (
        ()
        if verdict == "no_gap"
        else (
            Localization(site, f"angle of {site}", 0.91, 80.0, 1e-12),
            Localization("image", "time", 0.06, 20.0, 1e-3),
        )
    )
    gap = Gap(0.012, gap_m[0], gap_m[-1], 1.1e-4, (0.9 * gap_m[-1], 1.1 * gap_m[-1]))
    gross = np.array(gross, dtype=np.int64)
    free = (candidate_effect("backlash:turn"), candidate_effect("joint_offset:turn")) if joints else ()
    noise = {name: NoiseSource(size, "m", "estimated", name == "joint") for name, size in calibration.noise.items()}
    return Diagnosis(
        dataset=model.dataset,
        verdict=verdict,
        sentence=sentence(
            verdict, findings, (), locations, gap, Repeatability({}, 0.0), gross_sentence(model.dataset, gross)
        ),
        gap=gap,
        where=locations,
        findings=tuple(findings),
        kinds=(),
        classes=(),
        outliers=gross,
        not_testable={"latency": "no joint velocities in the data"},
        next_poses=tuple(dict.fromkeys(joints, 0.1 * (k + 1)) for k in range(2 if joints else 0)),
        limits=tuple(
            DetectionLimit(one, one.effect.amplitudes()[0][0], size, "rad")
            for one, size in zip(free, (1e-4, None), strict=False)
        ),
        model=model,
        x=x,
        std=calibration.std,
        calibrated_x=x[: len(model.parameters) - len(model.effect_parameters)],
        unseen=None,
        before_m=before,
        after_m=after,
        noise=noise,
        repeatability=Repeatability({name: one for name, one in noise.items() if one.of_poses}, 5e-5),
        noise_remarks=("All rows of an image move together.",),
        seconds=2.5,
        weighed=Weighed(fit, fit, (), model.dataset),
    )


def with_effects(calibration, wanted, seed=9):
    """The same data, simulated again with effects."""
    rng = np.random.default_rng(seed)
    model = replace(calibration.model, effects=candidate_effects(wanted, calibration.model.dataset))
    sizes = rng.uniform(0.02, 0.1, len(model.effect_parameters)) * model.effect_parameters.upper
    x = np.concatenate([calibration.x, sizes])
    std = np.concatenate([calibration.std, 0.02 * np.abs(sizes)])
    residuals = rng.normal(scale=1e-4, size=calibration.residuals.shape)
    bounds = np.zeros(len(x), dtype=bool)
    return replace(calibration, model=model, x=x, std=std, residuals=residuals, held_out=None, on_bound=bounds)


def explained():
    return of(stripe(robot=arm(), effects=(*GEOMETRIC, "laser_roll")), rivals=("encoder_scale:perturb",), gross=(3, 7))


def no_gap():
    return of(stripe(robot=arm()), "no_gap", gross=(5,))


def unexplained():
    return of(with_effects(point(), ("joint_offset:perturb",)), "unexplained")


def nothing_known():
    return of(with_effects(socket(), ()), "unexplained")


def without_robot():
    return of(stripe(effects=("laser_roll", "radial_distortion")), "explained")


MADE = {
    "explained": explained, "no_gap": no_gap, "unexplained": unexplained, "nothing_known": nothing_known,
    "without_robot": without_robot,
}  # fmt: skip
"""Diagnoses to report on."""
