"""Detectability of a fault in a cell's data, the size of random faults, and effects that are their aliases."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.estimation.linearization import Linearization
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.trials.building import World
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, OUTLIERS

DETECTABLE = 80.0  # squared whitened misfit: some six standard deviations, after a search over places
AS_WELL = 14.0  # misfit that a rival may leave: less than a few parameters in any criterion
WORTH_A_FIT = 40.0  # multiple of that which one linear step may leave for a fit
TOL = 1e-5
AT_LEAST = 2  # parameters that a rival may always have
UNDETECTABLE = 0.08  # share of the effects that may be undetectable
TRIES = 6
OVERSIZED = 1.5e5  # the squared misfit above which an effect is made smaller: it is obvious
CLEARLY = 2.0  # largest multiple of detectable to which a faint effect is enlarged


@final
@dataclass(frozen=True)
class Detectability:
    """One fault's noise-free data, and the fit of the ordinary parameters to it."""

    dataset: Dataset  # one row a point, without noise
    truth: Mapping[str, float]  # the ordinary parameters; derived ones may be missing
    sigmas: Mapping[str, float]  # standard deviations of a row's noise by source, repeats averaged; left out: zero

    @classmethod
    def of(cls, world: World, *faults: FaultModel) -> "Detectability":
        """Detectability of faults under the noise of their world."""
        return cls(world.exact(faults), world.cell.truth, world.sigmas(of_row=True))

    @cached_property
    def _start(self) -> Array:
        model = Model(self.dataset)
        pairs = zip(model.parameters.names, model.parameters.nominal, strict=True)
        return model.fix_gauge(np.array([self.truth.get(name, nominal) for name, nominal in pairs]))

    @cached_property
    def noise(self) -> NoiseModel:
        """Noise of the rows."""
        sources = error_sources(Model(self.dataset), self._start)
        return NoiseModel(sources, {source.name: self.sigmas.get(source.name, 0.0) for source in sources})

    def _fitted(self, starts: Array, *effects: CandidateEffect) -> Linearization:
        """The best fit from several starts, (c, d)."""
        problem = Problem.of(Model(self.dataset, effects), self.noise)
        end = solve(problem, starts, tol=TOL)
        return Linearization(problem, end.x[end.cost.argmin()])

    @cached_property
    def _fit(self) -> Linearization:
        return self._fitted(self._start[None])

    @property
    def misfit(self) -> float:
        """Squared whitened misfit after the fit of the ordinary parameters."""
        return self._fit.cost

    def left_by(self, effect: CandidateEffect) -> float:
        """The misfit after one effect of the library is fitted together with the ordinary parameters."""
        fit, start = self._fit, effect.parameters.nominal.copy()
        columns = fit.project(fit.columns(effect)[0])
        step, *_ = np.linalg.lstsq(columns, -fit.r, rcond=1e-10)
        promised = float(np.square(fit.r + columns @ step).sum())
        if promised > max(WORTH_A_FIT * AS_WELL, 0.3 * fit.cost):
            return promised
        start[: len(step)] = step
        return min(fit.cost, self._fitted(np.concatenate([fit.x, start])[None], effect).cost)

    def nearest(self, effect: CandidateEffect, known: Mapping[str, float]) -> dict[str, float]:
        """The parameters of a library effect that are closest to the fault, by name.

        A fault of the library's form has its own; for another form these are the limit of an estimate as the noise
        vanishes (White 1982, Maximum likelihood estimation of misspecified models). The search starts from the fault's
        known equivalent parameters.
        """
        names = [*effect.effect.units()]
        inner = [each.name for each in effect.effect.nonlinear_parameters()]
        grid = effect.effect.grid(self.dataset, effect.where)
        tried = [
            {**dict(zip(inner, row, strict=True)), **known} for row in grid[: 1 if known.keys() >= {*inner} else None]
        ]
        starts = np.array([[*self._start, *(one.get(name, 0.0) for name in names)] for one in tried])
        best = self._fitted(starts, effect).x[-len(names) :]
        return dict(zip(names, best.tolist(), strict=True))

    def rivals(self, effect: str, where: str) -> list[list[str]]:
        """Library effects with no more parameters than the true one that explain the data as well."""
        sizes = {kind.name: len(kind.amplitudes()) for kind in EFFECTS}
        most = max(AT_LEAST, sizes.get(effect, 0))
        return [
            [kind.name, location]
            for kind in EFFECTS
            if sizes[kind.name] <= most
            for location in kind.locations(self.dataset)
            if (kind.name, location) != (effect, where) and self.left_by(CandidateEffect(kind, location)) <= AS_WELL
        ]


def sized_fault(
    world: World, name: str, places: tuple[str, ...], rng: np.random.Generator, *, least_misfit: float = DETECTABLE
) -> tuple[FaultModel, Detectability]:
    """A random fault with a name of `FAULT_MODELS`, at one of some locations, nearly always detectable.

    It should leave at least the stated squared whitened misfit.
    """
    model = FAULT_MODELS[name]
    least, most = model.sizes
    faint = least_misfit <= DETECTABLE and rng.random() < UNDETECTABLE
    for _ in range(TRIES):
        size = float(np.exp(rng.uniform(np.log(least), np.log(most))))
        fault = model.sample(str(rng.choice(places)), size, world.cell.run, rng)
        seen = _seen(world, fault, rng)
        if name == OUTLIERS or (faint and seen.misfit < DETECTABLE) or least_misfit < seen.misfit < OVERSIZED:
            break
        small = seen.misfit < least_misfit
        goal = least_misfit * rng.uniform(1.1, CLEARLY) if small else OVERSIZED * rng.uniform(0.1, 1.0)
        fitting = abs(fault.size) * np.sqrt(goal / max(seen.misfit, 1e-3))
        fault = replace(fault, size=float(np.copysign(min(most, fitting), fault.size)))
        seen = _seen(world, fault, rng)
        if seen.misfit > least_misfit:
            break
    return fault, seen


def noise_floor_m(world: World) -> float:
    """RMS 3-D error by all noise, repeats averaged."""
    noise = Detectability(world.exact(()), world.cell.truth, world.sigmas(of_row=False)).noise
    return float(np.sqrt(np.trace(noise.covariances, axis1=1, axis2=2).mean()))


def _seen(world: World, fault: FaultModel, rng: np.random.Generator) -> Detectability:
    seen = Detectability.of(world, fault)
    if fault.effect != OUTLIERS:
        return seen
    points = seen.dataset.points
    pixel = fault.shots(points["pixel"], np.arange(len(points)), rng)
    return replace(seen, dataset=replace(seen.dataset, points=replace(points, pixel=pixel)))
