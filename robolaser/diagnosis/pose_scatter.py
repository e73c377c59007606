"""Scatter of whole poses by its location: noise within a limit, a gap beyond it."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.local_unknown import fine_chi2
from robolaser.diagnosis.localization import Localization, localize, p_value, unmodelled_chi2
from robolaser.diagnosis.penalties import posterior_weights
from robolaser.diagnosis.pose_noise import explained
from robolaser.diagnosis.sparse_shapes import sparse_shape_chi2
from robolaser.diagnosis.thresholds import CHI2_OF_UNMODELLED_CAUSE, CHI2_PER_EFFECT
from robolaser.estimation.noise_estimate import NoiseEstimate, noise_limits
from robolaser.estimation.solver import ENOUGH
from robolaser.model.blocks.errors import moved_with_pose
from robolaser.model.effects.joints import moving_joints
from robolaser.model.error_source import ErrorSource
from robolaser.model.noise.covariance import NoiseModel

NAME, CLASS = "pose_scatter", "repeatability"  # names of the effect and of its class of causes in results
JOINTS, FLANGE = "joints", "flange"  # locations: all joints equally, and the flange, for motion of unknown origin
ONE_JOINT = "joint "  # prefix of the name of a noise source for the readings of one joint
GRANTED: Final = 0.25  # share of the scatter that is tried as chance beside a shape
BY_CHANCE = "chance, from pose to pose"  # the coordinate of a gap by scatter of poses
NUMBERS: Final = {"m": "shift", "rad": "turn"}  # name of a standard deviation by its unit


@final
@dataclass(frozen=True)
class Spread:
    """The size of a scatter."""

    value: float  # standard deviation
    std: float  # its standard error
    unit: str  # unit of both
    limit: float  # the largest standard deviation that counts as noise


@final
@dataclass(frozen=True)
class PartScatter:
    """Scatter of whole poses at one location: noise within its limit, a gap beyond it."""

    where: str  # a joint, `joints` or `flange`
    probability: float  # probability of this location among all possible ones
    sizes: Mapping[str, Spread]  # `turn` [rad] or `shift` [m], of a joint reading or of the flange
    stated_m: float | None  # the repeatability that the data set states: then the limit
    likelihood_ratio: float  # twice its logarithm, against scatter within the limits
    p_value: float  # of that ratio, corrected for the locations that were tried
    size_m: float  # root-mean-square 3-D error of a row by all noise, this scatter included [m]
    noise: NoiseModel  # all noise, each source at most at its limit
    whole_noise: NoiseModel  # all noise, this scatter without a limit
    # share of the gap beside functions of unknown form, and probability of scatter: errors with steps and corners
    # leave scatter beside a smooth function
    share: float = 1.0

    @property
    def is_excess(self) -> bool:
        """Whether it exceeds the limit of noise."""
        return any(size.value > size.limit for size in self.sizes.values())

    @property
    def as_cause(self) -> float:
        """Probability of scatter at this location."""
        return self.share * self.probability

    def remainder(self, fit: Fit, left: Sequence[Localization]) -> list[Localization]:
        """The locations of a model's error beside this scatter, the largest share first, from those without it.

        At a joint that scatters, a function of unknown form may be a part of it.
        """
        if self.where in (JOINTS, FLANGE):
            return list(left)
        granted = localize(Fit.of(fit.problem.with_noise(self.whole_noise), fit.x))
        own = [one for one in left if one.site == self.where]
        return sorted([*own, *(one for one in granted if one.site != self.where)], key=lambda one: -one.share)

    def located(self, gap_m: float, floor_m: float) -> Localization:
        """The location of the gap by scatter, with its share of the squared gap above the noise floor."""
        whole = max(gap_m**2 - floor_m**2, 1e-300)
        share = float(np.clip((self.size_m**2 - floor_m**2) / whole, 0.0, 1.0))
        return Localization(self.where, BY_CHANCE, share, self.likelihood_ratio, self.p_value, unknown=False)


@final
@dataclass(frozen=True, eq=False)
class _Part:
    """A location that may scatter: its noise sources without a limit, and those that are added to the noise model."""

    where: str
    names: tuple[str, ...]
    further: tuple[ErrorSource, ...] = ()


def beside(where: Iterable[Localization], scattered: Localization) -> list[Localization]:
    """All locations of the gap, the largest share first; the others divide the share that scatter leaves."""
    rest = [replace(one, share=(1.0 - scattered.share) * one.share) for one in where]
    return sorted([scattered, *rest], key=lambda one: -one.share)


def pose_scatter(fit: Fit, found: NoiseEstimate) -> PartScatter | None:
    """Scatter of whole poses at the likeliest location, if it explains more than scatter within the limits; else None.

    By the noise estimated from the final model's residuals, without a limit for one location at a time. A repeatable
    error is no scatter.
    """
    base = found.limited
    of_poses = _limits_of_poses(found)
    if not any(name in of_poses for name in base.estimated):
        return None
    parts = list(_scattering_parts(fit, found))
    loose = [found.loosened(part.names, part.further) for part in parts]
    noises = [one.limited if _may_grow(part, found, one) else base for one, part in zip(loose, parts, strict=True)]
    costs = [one.likelihood.cost(noise) for one, noise in zip(loose, noises, strict=True)]
    twice = 2.0 * np.array([cost for cost, _ in costs])
    best = int(np.argmin(twice))
    ratio = 2.0 * found.likelihood.cost(base)[0] - float(twice[best])
    part, noise = parts[best], noises[best]
    if ratio < CHI2_PER_EFFECT or _has_shape(fit, loose[best], part):
        return None
    usual = noise_limits(part.further, fit.model.dataset, alone=False) if part.where == FLANGE else {}
    limits = {name: {**usual, **found.limits}.get(name, found.limits.get("joint", np.inf)) for name in part.names}
    units = {source.name: source.unit for source in noise.sources}
    sizes = {
        NUMBERS[units[name]]: Spread(
            float(noise.sigmas[name]),
            float(noise.sigmas[name] * costs[best][1].get(name, 0.0)),
            units[name],
            limits[name],
        )
        for name in part.names
    }
    return PartScatter(
        where=part.where,
        probability=float(posterior_weights(twice)[best]),
        sizes=sizes,
        stated_m=fit.model.dataset.noise.repeatability_m,
        likelihood_ratio=ratio,
        p_value=p_value(ratio, len(parts)),
        size_m=fit.size_of(noise),
        noise=noise.at({name: min(noise.sigmas[name], limit) for name, limit in limits.items()}),
        whole_noise=noise,
    )


def _limits_of_poses(found: NoiseEstimate) -> dict[str, float]:
    """Limits of lengths and angles, without those of pixels, which are not of poses."""
    units = {source.name: source.unit for source in found.likelihood.sources}
    return {name: limit for name, limit in found.limits.items() if units.get(name) in NUMBERS}


def _scattering_parts(fit: Fit, found: NoiseEstimate) -> Iterator[_Part]:
    sources = {source.name: source for source in found.likelihood.sources}
    if joint := sources.get("joint"):
        yield _Part(JOINTS, ("joint",))
        robot, _ = fit.model.dataset.arm
        for column, number in enumerate(robot.chain):
            name = robot.joints[number]
            one = replace(
                joint, name=f"{ONE_JOINT}{name}", effect=joint.effect[:, :, [column]], stated=None,
                unit="m" if robot.prismatic[number] else "rad",
            )  # fmt: skip
            yield _Part(name, (one.name,), (one,))
    elsewhere = tuple(name for name in _limits_of_poses(found) if name in sources and name != "joint")
    if elsewhere:
        yield _Part(FLANGE, elsewhere)
        return
    shifts, turns = moved_with_pose(fit.model.blocks, *fit.model.at(fit.x))
    of_pose = fit.model.dataset.points.pose
    further = (
        ErrorSource("flange", shifts, of_pose, level="pose"),
        ErrorSource("flange_turn", turns, of_pose, "rad", level="pose"),
    )
    yield _Part(FLANGE, tuple(one.name for one in further), further)


def _may_grow(part: _Part, found: NoiseEstimate, loose: NoiseEstimate) -> bool:
    """Whether a part may scatter more than in the likeliest noise within the limits, by a score test if it is new."""
    sigmas = found.limited.sigmas
    if part.further:
        return 2.0 * loose.likelihood.gain_of_growth(found.limited, part.names) > ENOUGH
    return any(name in found.known or sigmas[name] >= found.limits[name] for name in part.names)


def _has_shape(fit: Fit, found: NoiseEstimate, part: _Part) -> bool:
    """Whether the apparent scatter, or a part of it, depends on a coordinate.

    At a joint this is its own angle or torque, or time, also in steps, or smoothly another joint's angle or the
    posture; elsewhere any coordinate at any site. The shape then explains more, the less of the scatter is granted,
    beyond the likelihood lost by that; a shape beside the whole scatter is another cause.
    """
    alone = replace(found, likelihood=replace(found.likelihood, J=explained(fit, smooth=False)))
    noise = alone.limited
    least = alone.likelihood.cost(noise)[0]

    def gain(share: float) -> float:
        beside = noise.at({name: share * noise.sigmas[name] for name in part.names})
        lost = 2.0 * (alone.likelihood.cost(beside)[0] - least)
        return _shape_chi2(Fit.of(fit.problem.with_noise(beside), fit.x), part.where) - lost

    return gain(GRANTED) > max(gain(1.0), CHI2_OF_UNMODELLED_CAUSE)


def _shape_chi2(fit: Fit, where: str) -> float:
    """Chi-squared that shapes and functions explain beyond chance."""
    if where not in moving_joints(fit.model.dataset.robot):
        return unmodelled_chi2(fit)
    of_joint = max(sparse_shape_chi2(fit, where), fine_chi2(fit, where))
    return max(of_joint - CHI2_PER_EFFECT, unmodelled_chi2(fit, where))
