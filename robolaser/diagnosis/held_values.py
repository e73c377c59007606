"""Values that a data set holds: fixed or narrowly bounded parameters, radii of balls, a contradicted distance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.contradicted_distance import ContradictedDistance
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.penalties import complexity_penalty
from robolaser.diagnosis.result import Diagnosis, Estimate
from robolaser.diagnosis.thresholds import SIGMA_OF_95_PERCENT
from robolaser.estimation.linearization import TOUCH
from robolaser.estimation.noise_estimate import NOISE_CONTRADICTED_SIGMA
from robolaser.model.blocks.block import LASER, THINGS
from robolaser.parameters import Parameter

PARTS: Final[Mapping[str, str]] = {
    **dict.fromkeys(LASER, "laser"),
    **dict.fromkeys(("w", "phi", "psi", "t_x", "t_y", "t_z", "hand_eye"), "hand_eye"),
    **dict.fromkeys(("target", "socket", "ball"), "target"),
    "base": "base",
    "tool": "tool",
}
"""The sensor's part of a parameter, by the first part of its name; all others are the camera's."""
MOST_WRONG: Final = 4.0  # ratio, either way, of a right value to one that is held wrongly
FAR_OFF: Final[Mapping[str, float]] = {"m": 0.1, "rad": 0.2}  # likewise the difference of places and turns, by the unit


@final
@dataclass(frozen=True, eq=False)
class Held:
    """Values of one part of a sensor that one table of dataset.toml holds."""

    where: str  # the sensor's part
    table: str  # of dataset.toml
    values: Mapping[str, float]  # by name
    freed: tuple[Dataset, ...]  # data sets in which they are free: the first that can be calibrated is to be used
    off: ContradictedDistance | None = None  # the distance, if they are one

    @property
    def cause(self) -> str:
        """The class of causes of the part."""
        return {"hand_eye": "mount", "tool": "mount"}.get(self.where, self.where.rpartition(".")[2])

    @property
    def log_odds(self) -> float:
        """Logarithm of the odds that they are wrong by what belongs to no pose: the residual of a distance."""
        if self.off is None:
            return 0.0
        return 0.5 * ((self.off.excess_m / self.off.known.sigma_m) ** 2 - complexity_penalty(1, 1))

    def moved(self, free: Diagnosis) -> dict[str, Estimate]:
        """The values that certainly differ in the diagnosis in which they are free, as they are there; may be empty.

        Values that are only determined together differ if any combination of them does.
        """
        if self.off:
            would_be, correlation = {self.off.key: _length(self.off, free.weighed.final)}, np.eye(1)
        else:
            would_be = {name: _estimate(free, name) for name in self.values}
            correlation = _correlation(free, list(self.values))
        sigmas = np.array([(one.value - self.values[name]) / (one.std or np.inf) for name, one in would_be.items()])
        if sigmas @ np.linalg.pinv(correlation, hermitian=True) @ sigmas <= NOISE_CONTRADICTED_SIGMA**2 * len(sigmas):
            return {}
        least = min(SIGMA_OF_95_PERCENT, np.abs(sigmas).max())
        return {name: one for (name, one), by in zip(would_be.items(), sigmas, strict=True) if abs(by) >= least}


def held_values(found: Diagnosis) -> list[Held]:
    """The values that a diagnosed data set holds, those of a part together."""
    dataset, blocks, groups = found.dataset, found.model.blocks, list[Held]()
    without_effects = dict(zip(found.model.parameters.names, found.calibrated_x.tolist(), strict=False))
    parts: dict[str, dict[str, float]] = {}
    for name, item in blocks.given.items():
        if not item.given:  # it follows in closed form, and no file holds it
            continue
        near = TOUCH * (item.upper - item.lower)
        if name not in blocks.fixed and not item.lower + near < without_effects[name] < item.upper - near:
            parts.setdefault(_part(name, dataset), {})[name] = item.nominal
    groups += [Held(part, "[parameters]", values, _freed(dataset, values)) for part, values in parts.items()]
    if dataset.radius_m:
        groups.append(Held("target", "[target], radius_m", _radii(found), (replace(dataset, radius_m={}),)))
    final = found.weighed.final
    if off := ContradictedDistance.of(final.model, final.x):
        values, freed = {off.key: off.stated_m}, (off.removed_from(dataset),)
        groups.append(Held(_part(off.key, dataset), "[target], distances_m", values, freed, off))
    return groups


def _freed(dataset: Dataset, values: Mapping[str, float]) -> tuple[Dataset, ...]:
    """The data set without some parameters, for those with a closed form, and with wide bounds of them."""
    plain = {name.partition("@")[0] for name in values}
    without = {name: item for name, item in dataset.parameters.items() if name not in plain}
    positive = dataset.format.positive
    wide = {name: _widened(item, positive) if name in plain else item for name, item in dataset.parameters.items()}
    return replace(dataset, parameters=without), replace(dataset, parameters=wide)


def _widened(item: Parameter, positive: tuple[str, ...]) -> Parameter:
    """A parameter with bounds that no longer hold it."""
    bounds = item.nominal / MOST_WRONG, item.nominal * MOST_WRONG
    room = 0.0 if item.name in positive else item.upper - item.lower + FAR_OFF.get(item.unit, 0.0)
    return replace(item, lower=min(*bounds, item.lower - room), upper=max(*bounds, item.upper + room))


def _radii(found: Diagnosis) -> dict[str, float]:
    """The stated radii of balls, by the names of the parameters if they were not stated."""
    names = (name.partition("@") for name in found.model.blocks.derived if name.startswith("ball."))
    balls = [(plain[:-1], session) for plain, *session in names if plain.endswith(".x")]
    return {f"{ball}radius{''.join(session)}": found.dataset.radius_m[ball[5:-1]] for ball, session in balls}


def _part(name: str, dataset: Dataset) -> str:
    owner, _, own = name.partition(".")
    if owner not in {*PARTS, *THINGS} and own:
        part = PARTS.get(own.partition(".")[0], "camera")
        return f"{owner}.{part}" if part in ("camera", "laser", "target") else part
    return PARTS.get(owner, "camera")


def _length(off: ContradictedDistance, free: Fit) -> Estimate:
    """A distance by a fit in which it is not known."""
    slopes = off.known.jacobian(free.model.at(free.x)[0], free.problem.parameters.names)[0, off.number]
    return Estimate(off.in_model(free.model, free.x), float(np.sqrt(slopes @ free.at.covariance @ slopes)), "m")


def _correlation(found: Diagnosis, names: Sequence[str]) -> Array:
    """Correlation of parameters of the final model, (n, n); those without an error are independent."""
    fit = found.weighed.final
    own = [fit.problem.parameters.names.index(name) for name in names]
    covariance = fit.at.covariance[np.ix_(own, own)]
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    unit = covariance / np.maximum(np.outer(std, std), np.finfo(float).tiny)
    return np.where(np.eye(len(names)) > 0, 1.0, unit)


def _estimate(found: Diagnosis, name: str) -> Estimate:
    i = found.model.parameters.names.index(name)
    std = float(found.std[i])
    return Estimate(float(found.x[i]), std if np.isfinite(std) else None, found.model.parameters.items[i].unit)
