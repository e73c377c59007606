"""The share of a gap at each site: random functions there, their size by maximum likelihood."""

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.candidate_sites import Site, sites
from robolaser.diagnosis.fit import NEGLIGIBLE, Fit
from robolaser.diagnosis.random_functions import RandomFunctions
from robolaser.diagnosis.thresholds import CHI2_PER_EFFECT, MOST_CAUSES

SIZES = np.exp(np.linspace(np.log(1e-2), np.log(1e4), 60))
"""Standard deviations tried for a function, relative to one that just shows among the noise."""


@final
@dataclass(frozen=True)
class Localization:
    """A site where the gap, or a part of it, is.

    Attributes:
        site: A joint's name, or another of `Site.site`.
        coordinate: In which coordinate.
        share: Of the squared whitened gap beyond noise, what a function there explains beyond the price of its freedom.
        likelihood_ratio: Twice its logarithm, against no function there.
        p_value: Of the best of what was tried at all sites, if there were only noise, see `corrected`.
        unknown: Whether the function may be of a form that the library of effects does not have.
    """

    site: str
    coordinate: str
    share: float
    likelihood_ratio: float
    p_value: float
    unknown: bool = True

    def beside(self, other: "Localization") -> "Localization":
        """Both as one."""
        return replace(
            self,
            share=min(1.0, self.share + other.share),
            likelihood_ratio=self.likelihood_ratio + other.likelihood_ratio,
            p_value=min(self.p_value, other.p_value),
            unknown=self.unknown or other.unknown,
        )


def likelihood_ratio(normal: Array, gradient: Array, most: float = np.inf) -> tuple[float, float]:
    """Twice the logarithm of the largest likelihood ratio of a random function, and the size that has it.

    Args:
        normal: Products of the derivatives of the whitened residuals by the function's basis with each other, (p, p).
        gradient: Their products with the residuals, (p,).
        most: Largest plausible size.
    """
    ratios, sizes = _likelihood_ratios(normal[None], gradient[None], np.array([most]), np.zeros(1))
    return float(ratios[0]), float(sizes[0])


def chance_ratio(gradient: Array, own: Array, shared: Array) -> float:
    """The same ratio of chance: independent motions, one for each of n groups, all of one size.

    By the matrix inversion lemma: what grows with the cube of n is left out.

    Args:
        gradient: Products of what the motions do with the residuals, (n,).
        own: Their products with each other are diag(own) - shared sharedᵀ, (n,).
        shared: See there, (n, d).
    """
    mean = float(np.mean(own - np.square(shared).sum(axis=1)))
    if mean <= 0.0:
        return 0.0
    best = 0.0
    for t in np.square(SIZES) / mean:
        within = 1.0 + t * own
        left, V = np.linalg.eigh(np.eye(shared.shape[1]) - shared.T @ (shared * (t / within)[:, None]))
        left = np.maximum(left, np.finfo(float).tiny)
        along = V.T @ (shared.T @ (gradient / within))
        explained = t * (gradient @ (gradient / within) + t * (np.square(along) / left).sum())
        best = max(best, float(explained - np.log(within).sum() - np.log(left).sum()))
    return best


def _likelihood_ratios(normal: Array, gradient: Array, most: Array, least: Array) -> tuple[Array, Array]:
    """The same of several functions, (n,) each.

    Args:
        normal: Products of their derivatives with each other, (n, p, p).
        gradient: With the residuals, (n, p).
        most: Largest plausible sizes, (n,).
        least: Squared lengths up to which a direction is imitated: what is left of it is rounding, (n,).
    """
    eigenvalues, V = np.linalg.eigh(normal)
    seen = eigenvalues > least[:, None]
    eigenvalues = np.where(seen, eigenvalues, 0.0)[:, None]
    z2 = np.where(seen, (np.swapaxes(V, 1, 2) @ gradient[..., None])[..., 0], 0.0)[:, None] ** 2
    mean = eigenvalues.mean(axis=2)
    scale = 1.0 / np.sqrt(np.where(mean > 0.0, mean, 1.0))
    sizes = np.minimum(scale * SIZES, most[:, None])
    t = sizes[..., None] ** 2
    value = (z2 * t / (1.0 + eigenvalues * t) - np.log1p(eigenvalues * t)).sum(axis=2)
    best = value.argmax(axis=1)[:, None]
    ratios = np.take_along_axis(value, best, axis=1)[:, 0]
    return np.maximum(0.0, ratios), np.take_along_axis(sizes, best, axis=1)[:, 0]


def corrected(chance: float, tried: int) -> float:
    """The p value of the best of so many candidates by the p value of that one (Bonferroni 1936).

    It is positive: a chance that is below the least positive number is that number.
    """
    return min(1.0, tried * max(chance, sys.float_info.min))


def p_value(ratio: float, tried: int) -> float:
    """Of a likelihood ratio of a variance that cannot be negative, the largest of so many (Self and Liang 1987)."""
    return corrected(0.5 * math.erfc(math.sqrt(0.5 * max(ratio, 0.0))), tried)


def localize(fit: Fit) -> list[Localization]:
    """Divide what a model leaves among the sites, one at a time, the likeliest first.

    A smooth random function of one coordinate at one site is added to the noise, its size by maximum likelihood; then
    the next, given the first. So rich functions pay for their freedom, and of two sites that could both explain the
    residuals only one is named. Whole poses scatter as much as they would if there were no such function: what chance
    explains is no site.
    """
    fit = fit.with_likeliest_scatter
    selected, tried = _select_sites(fit, sites(fit))
    excess = fit.chi2 - fit.freedoms
    whole = max(excess, sum(one.ratio for one in selected))
    found = [
        Localization(site.site, site.coordinate, one.ratio / whole, one.ratio, p_value(one.ratio, tried), site.unknown)
        for one in selected
        for site in [one.site]
    ]
    return sorted(found, key=lambda one: -one.share)


def merged(located: Iterable[Localization]) -> list[Localization]:
    """Each site and coordinate once, with its whole share."""
    whole: dict[tuple[str, str], Localization] = {}
    for one in located:
        before = whole.get(key := (one.site, one.coordinate))
        whole[key] = one if before is None else before.beside(one)
    return sorted(whole.values(), key=lambda one: -one.share)


def unmodelled_chi2(fit: Fit, where: str = "") -> float:
    """Chi-squared that functions of unknown form explain of what is left, beyond what chance gives.

    Args:
        fit: The model.
        where: The site that they are at; any by default.
    """
    unknown = [site for site in sites(fit) if site.unknown and where in ("", site.site)]
    return sum(one.ratio - CHI2_PER_EFFECT for one in _select_sites(fit, unknown)[0])


def smooth_remainder(fit: Fit) -> Array:
    """Orthonormal directions of the whitened residuals in which those functions exceed the noise, (K, n)."""
    fit = fit.with_likeliest_scatter
    selected, _ = _select_sites(fit, sites(fit))
    columns = [one.size * one.site.columns for one in selected]
    U, s, _ = np.linalg.svd(np.hstack([np.zeros((len(fit.at.white), 1)), *columns]), full_matrices=False)
    return np.asarray(U[:, s > 1.0])


@final
@dataclass(frozen=True)
class _SelectedSite:
    """A site that the residuals speak for, by twice the logarithm of a likelihood ratio, and the size that has it."""

    site: Site
    ratio: float
    size: float


def _select_sites(fit: Fit, candidates: Iterable[Site]) -> tuple[list[_SelectedSite], int]:
    """The sites that the residuals speak for; and how many were tried."""
    tried, functions = list(candidates), RandomFunctions(fit)
    normals = [functions.normal_equations(site) for site in tried]
    least = np.array([NEGLIGIBLE * functions.largest_square(site) for site in tried])
    most, sizes = np.array([site.most for site in tried]), np.array([len(normal) for normal in normals])
    selected: list[_SelectedSite] = []
    for _ in range(MOST_CAUSES):
        gradients = [functions.gradient(site) for site in tried]
        ratios, size = np.zeros(len(tried)), np.zeros(len(tried))
        for p in np.unique(sizes):
            alike = np.flatnonzero(sizes == p)
            both = np.stack([normals[i] for i in alike]), np.stack([gradients[i] for i in alike])
            ratios[alike], size[alike] = _likelihood_ratios(*both, most[alike], least[alike])
        best = int(np.argmax(ratios))
        if ratios[best] < CHI2_PER_EFFECT:
            break
        selected.append(_SelectedSite(tried[best], float(ratios[best]), float(size[best])))
        if len(selected) < MOST_CAUSES:
            functions.believe(tried[best], float(size[best]))
            normals = [normal - functions.newly_imitated(site) for normal, site in zip(normals, tried, strict=True)]
    return selected, len(tried)
