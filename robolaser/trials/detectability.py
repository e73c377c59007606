"""How detectable a fault is in a cell's data, and which effects of the library are its aliases."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.estimation.fisher_information import lengths
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.derivatives import jacobian_matrix
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.noise import NoiseModel
from robolaser.model.noise.sources import error_sources

DETECTABLE = 80.0  # squared whitened misfit: some six standard deviations, after a search over places
AS_WELL = 14.0  # what a rival may leave: not worth a few parameters' difference in any criterion
WORTH_A_FIT = 40.0  # times what a rival may leave: what one linear step must promise
TOL = 1e-5
AT_LEAST = 2  # a rival may have so many parameters whatever the true effect has


@final
@dataclass(frozen=True)
class Detectability:
    """One fault's noise-free data, and the fit of the ordinary parameters to it."""

    dataset: Dataset  # one row a point, without noise
    truth: Mapping[str, float]  # the ordinary parameters; those that follow from the data may be left out
    # standard deviations of the sources of a row's noise, repeats averaged, by name; those left out are zero
    sigmas: Mapping[str, float]

    @cached_property
    def _model(self) -> Model:
        return Model(self.dataset)

    @cached_property
    def _start(self) -> Array:
        parameters = self._model.parameters
        pairs = zip(parameters.names, parameters.nominal, strict=True)
        return self._model.fix_gauge(np.array([self.truth.get(name, nominal) for name, nominal in pairs]))

    @cached_property
    def _noise(self) -> NoiseModel:
        sources = error_sources(self._model, self._start)
        return NoiseModel(sources, {source.name: self.sigmas.get(source.name, 0.0) for source in sources})

    @cached_property
    def _fit(self) -> tuple[Array, float]:
        end = solve(Problem.of(self._model, self._noise), self._start[None], tol=TOL)
        return end.x[0], float(end.cost[0])

    @property
    def misfit(self) -> float:
        """Squared whitened misfit that is left once the ordinary parameters are fitted."""
        return self._fit[1]

    @property
    def floor_m(self) -> float:
        """Root-mean-square 3-D error that the noise alone makes."""
        return float(np.sqrt(np.trace(self._noise.covariances, axis1=1, axis2=2).mean()))

    def left_by(self, candidate_effect: CandidateEffect) -> float:
        """What is left once one effect of the library is fitted together with the ordinary parameters."""
        x, cost = self._fit
        model = Model(self.dataset, (candidate_effect,))
        problem = Problem.of(model, self._noise)
        start = np.concatenate([x, candidate_effect.parameters.nominal])
        ordinary = len(x)
        J = self._whitened(jacobian_matrix(model, start))[:, ~problem.fixed]
        r = self._noise.whiten(self._model.residuals(x[None]))[0]
        step, *_ = np.linalg.lstsq(J / lengths(J), -r, rcond=1e-10)
        promised = float(np.square(r + J / lengths(J) @ step).sum())
        if promised > max(WORTH_A_FIT * AS_WELL, 0.3 * cost):
            return promised
        moved = start.copy()
        moved[~problem.fixed] += step / lengths(J)
        moved[:ordinary] = x
        return min(cost, float(solve(problem, moved[None], tol=TOL).cost[0]))

    def nearest(self, candidate_effect: CandidateEffect, known: Mapping[str, float]) -> dict[str, float]:
        """The parameters of an effect of the library that come closest to the fault, by their names there.

        A fault of the library's own form has its own; of another form these are what an estimate tends to as the noise
        vanishes (White 1982, Maximum likelihood estimation of misspecified models).

        Args:
            candidate_effect: The effect.
            known: Parameters that mean the same in the fault; from there they are looked for.
        """
        effect, names = candidate_effect.effect, [*candidate_effect.effect.units()]
        inner = [each.name for each in effect.nonlinear_parameters()]
        grid = effect.grid(self.dataset, candidate_effect.where)
        tried = [
            {**dict(zip(inner, row, strict=True)), **known} for row in grid[: 1 if known.keys() >= {*inner} else None]
        ]
        starts = np.array([[*self._start, *(one.get(name, 0.0) for name in names)] for one in tried])
        model = Model(self.dataset, (candidate_effect,))
        end = solve(Problem.of(model, self._noise), starts, tol=TOL)
        best = end.x[end.cost.argmin()][-len(names) :]
        return dict(zip(names, best.tolist(), strict=True))

    def rivals(self, effect: str, where: str) -> list[list[str]]:
        """What of the library, with no more parameters than the true effect, explains it as well."""
        sizes = {kind.name: len(kind.amplitudes()) for kind in EFFECTS}
        most = max(AT_LEAST, sizes.get(effect, 0))
        return [
            [kind.name, place]
            for kind in EFFECTS
            if sizes[kind.name] <= most
            for place in kind.locations(self.dataset)
            if (kind.name, place) != (effect, where) and self.left_by(CandidateEffect(kind, place)) <= AS_WELL
        ]

    def _whitened(self, J: Array) -> Array:
        return self._noise.whiten(np.ascontiguousarray(J.T)).T
