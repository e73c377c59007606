"""Validation: prediction of other data of the same arm with the results of a diagnosis."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut, is_lower
from robolaser.diagnosis.result import Diagnosis, Validation
from robolaser.diagnosis.summary_text import transfer_sentences
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.noise_estimate import NoiseEstimate, weights_of_sizes
from robolaser.estimation.outliers import outliers_of, robust_fit
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import ENOUGH, SHARE, solve
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.run import Course, RunSummary, continued
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import NoiseModel
from robolaser.parameters import Parameter, Parameters

T = TypeVar("T")


def validated(diagnosis: Diagnosis, others: Sequence[Dataset], seed: int) -> Diagnosis:
    """The diagnosis with its errors on other data of the same arm and kind of sensor, see `check_same_arm`."""
    validation = tuple(_validation(diagnosis, other, seed) for other in others)
    carries = transfer_sentences(validation, has_effects=bool(diagnosis.model.effects))
    return replace(diagnosis, validation=validation, sentence=diagnosis.sentence + carries)


def _validation(diagnosis: Diagnosis, other: Dataset, seed: int) -> Validation:
    names = diagnosis.model.blocks.free + diagnosis.model.blocks.derived
    anew = _setup_parameters(diagnosis.model.blocks) | _setup_parameters(Blocks(other))
    calibrated = _without(dict(zip(names, diagnosis.calibrated_x.tolist(), strict=True)), anew)
    found = dict(zip(diagnosis.model.parameters.names, diagnosis.x.tolist(), strict=True))
    held = _without(found, anew)
    given = {**_without(diagnosis.dataset.parameters, anew), **other.parameters}
    nominal = calibrated | {name: given[name].nominal for name in calibrated if name in given}
    other = replace(other, parameters=given, radius_m=other.radius_m if diagnosis.dataset.radius_m else {})
    found_in = RunSummary.of(diagnosis.dataset)
    effects, numbers, remarks = _carried(diagnosis, found_in, other, found)

    def later(data: Dataset) -> Course | None:
        return continued(found_in, data).course

    data = AveragedData.of(other).subsampled(seed)
    near = Transfer.of(data, later, effects, held | numbers)
    gross = outliers_of(near.problem, robust_fit(near.problem, near.fit().x))
    if gross.any():
        remarks.append(
            f"{gross.sum()} of {len(gross)} rows of {other.name}, repeats averaged, are gross errors and are excluded"
        )
        marked = np.append(gross, False)[data.group] | (data.group < 0)
        data = AveragedData.of(other, marked)
    after = Transfer.of(data, later, effects, held | numbers)
    scatter = {name: source.value for name, source in diagnosis.noise.items() if source.of_poses}
    floor = after.fit().size_of(
        after.noise.at({name: scatter.get(name, size) for name, size in after.noise.sigmas.items()})
    )
    errors = after.held_out(seed)
    before = errors if not effects and calibrated == held else Transfer.of(data, later, (), calibrated).held_out(seed)
    sim = before if nominal == calibrated else Transfer.of(data, later, (), nominal).held_out(seed)
    return Validation(
        dataset=other.name,
        nominal_m=None if diagnosis.gap.nominal_m is None else rms(sim),
        calibrated_m=rms(before),
        after_m=rms(errors),
        noise_floor_m=floor,
        is_better=is_lower(before, errors, data.dataset.points.pose),
        rows=len(errors),
        remarks=tuple(remarks),
    )


def _setup_parameters(blocks: Blocks) -> set[str]:
    """Parameters to be refitted; those of sessions also by their name without the session."""
    return {name for own in blocks.setup_parameters for name in (own, own.partition("@")[0])}


def _without(values: Mapping[str, T], names: Collection[str]) -> dict[str, T]:
    return {name: value for name, value in values.items() if name not in names}


def _carried(
    diagnosis: Diagnosis, found_in: RunSummary, other: Dataset, found: Mapping[str, float]
) -> tuple[tuple[CandidateEffect, ...], dict[str, float], list[str]]:
    """Effects in the other run, their parameters by name, and remarks on those that are uncertain there."""
    run = continued(found_in, other)
    effects: list[CandidateEffect] = []
    numbers: dict[str, float] = {}
    remarks: list[str] = []
    values = {name: np.array([value]) for name, value in found.items()}
    for one in diagnosis.model.effects:
        carried = one.at(values).carried_to(run, found_in)
        if carried.doubt:
            left_out = " is left out" if carried.effect is None else ""
            remarks.append(f"{one}{left_out}: {carried.doubt}")
        if carried.effect is not None:
            effects.append(one)
            numbers |= {one.key(name): float(getattr(carried.effect, name)[0]) for name in one.effect.units()}
    return tuple(effects), numbers, remarks


@final
@dataclass(frozen=True, eq=False)
class Transfer:
    """A model of other data with all parameters held except placements and mounts."""

    problem: Problem  # the problem; both bounds of a held parameter are its value
    noise: NoiseModel  # the noise of its rows
    x: Array  # start values, (d,)

    @classmethod
    def of(
        cls,
        data: AveragedData,
        course: Callable[[Dataset], Course | None],
        effects: tuple[CandidateEffect, ...],
        held: Mapping[str, float],
        sizes: Mapping[str, float] | None = None,
    ) -> "Transfer":
        """The model of averaged data with some parameters held.

        Args:
            data: The averaged rows.
            course: Gives the course of the run at the poses of a data set.
            effects: Effects in the model.
            held: Values of held parameters by name.
            sizes: Sizes of the noise sources by name; without them, they are estimated from the rows.
        """
        whole = Model(data.raw, effects, course(data.raw))
        nominal = {item.name: item.nominal for item in whole.parameters.items}
        start = nominal | dict(held)
        if effects or start != nominal:  # else parameters in closed form are known already
            completed = whole.completed({name: np.array([value]) for name, value in start.items()}, known=held)
            start |= {name: float(value[0]) for name, value in completed.items() if name not in held}
        model = Model(data.dataset, effects, course(data.dataset)).sharing(whole.sensor_parameters)
        parameters = Parameters(tuple(_item(item, start[item.name], held) for item in model.parameters.items))
        x = parameters.nominal
        noise = (
            NoiseEstimate.of(data, model, x).for_weights() if sizes is None else weights_of_sizes(data, model, x, sizes)
        )
        return cls(Problem.of(model, noise, parameters=parameters), noise, x)

    def fit(self) -> Fit:
        """Fit the parameters that are not held."""
        return Fit(self.problem, solve(self.problem, self.x[None], tol=SHARE, enough=ENOUGH).x[0])

    def held_out(self, seed: int) -> Array:
        """Errors of rows on held-out poses, (m, j) [m]."""
        fit = self.fit()
        return HeldOut(fit, seed).of(fit).in_metres


def _item(item: Parameter, value: float, held: Mapping[str, float]) -> Parameter:
    """A held parameter with both bounds at its value, or a free one around its start value."""
    if item.name in held:
        return replace(item, nominal=value, lower=value, upper=value)
    if item.given:
        return replace(item, nominal=float(np.clip(value, item.lower, item.upper)))
    span = (item.upper - item.lower) / 2
    return replace(item, nominal=value, lower=value - span, upper=value + span)
