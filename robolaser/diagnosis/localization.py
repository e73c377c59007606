"""The share of a gap at each site, by random functions there, with sizes of maximum likelihood."""

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.candidate_sites import Site, sites
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.profile_likelihood import SIZES
from robolaser.diagnosis.random_functions import RandomFunctions
from robolaser.diagnosis.thresholds import CHI2_PER_EFFECT, SEARCH_LIMIT
from robolaser.estimation.nonlinear_parameters import NEGLIGIBLE


@final
@dataclass(frozen=True)
class Localization:
    """A site of the gap, or of a part of it."""

    site: str  # a joint's name, or another of `Site.site`
    coordinate: str  # the coordinate that the error depends on
    share: float  # of the squared whitened gap above noise, explained there beyond the cost of a function's freedom
    likelihood_ratio: float  # twice its logarithm, against no function there
    p_value: float  # of such a ratio by noise alone, corrected for all candidates at all sites, see `corrected`
    unknown: bool = True  # whether the function may have a form outside the library of effects

    def beside(self, other: "Localization") -> "Localization":
        """The sum of two locations."""
        return replace(
            self,
            share=min(1.0, self.share + other.share),
            likelihood_ratio=self.likelihood_ratio + other.likelihood_ratio,
            p_value=min(self.p_value, other.p_value),
            unknown=self.unknown or other.unknown,
        )


def likelihood_ratio(normal: Array, gradient: Array, most: float = np.inf) -> tuple[float, float]:
    """Twice the logarithm of the largest likelihood ratio of a random function, and the size that maximizes it.

    Args:
        normal: JᵀJ of the derivatives J of the whitened residuals by the function's basis, (p, p).
        gradient: Jᵀr, their products with the residuals, (p,).
        most: Largest plausible size.
    """
    ratios, sizes = _likelihood_ratios(normal[None], gradient[None], np.array([most]), np.zeros(1))
    return float(ratios[0]), float(sizes[0])


def function_ratio(functions: RandomFunctions, site: Site) -> float:
    """Twice the logarithm of the likelihood ratio of a random function at a site."""
    return likelihood_ratio(functions.normal_equations(site), functions.gradient(site))[0] - site.price


def chance_ratio(gradient: Array, own: Array, shared: Array) -> float:
    """Twice the logarithm of the likelihood ratio of chance: independent motions of n groups, all of one size.

    The matrix inversion lemma avoids a cost of n³.

    Args:
        gradient: Products of the motions' columns with the residuals, (n,).
        own: Diagonal part of their products with each other, diag(own) - shared sharedᵀ, (n,).
        shared: Low-rank part of these products, (n, d).
    """
    mean = float(np.mean(own - np.square(shared).sum(axis=1)))
    if mean <= 0.0:
        return 0.0
    t = np.square(SIZES) / mean
    within = 1.0 + t[:, None] * own
    along = (gradient / within) @ shared
    left = np.eye(shared.shape[1]) - (shared.T * (t[:, None] / within)[:, None]) @ shared
    explained = t * (
        (gradient / within) @ gradient + t * (along * np.linalg.solve(left, along[..., None])[..., 0]).sum(axis=1)
    )
    return max(0.0, float((explained - np.log(within).sum(axis=1) - np.linalg.slogdet(left)[1]).max()))


def _likelihood_ratios(normal: Array, gradient: Array, most: Array, least: Array) -> tuple[Array, Array]:
    """Likelihood ratios of several functions and their sizes, see `likelihood_ratio`, (n,) each.

    Args:
        normal: Products of their derivatives with each other, (n, p, p).
        gradient: Products of these with the residuals, (n, p).
        most: Largest plausible sizes, (n,).
        least: Squared lengths up to which a direction counts as imitated and its remainder as rounding, (n,).
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
    """The p value of the best of several candidates, corrected for their number (Bonferroni 1936).

    It is at least the smallest positive number.
    """
    return min(1.0, tried * max(chance, sys.float_info.min))


def p_value(ratio: float, tried: int) -> float:
    """The p value of the largest of several likelihood ratios of a nonnegative variance (Self and Liang 1987)."""
    return corrected(0.5 * math.erfc(math.sqrt(0.5 * max(ratio, 0.0))), tried)


def localize(fit: Fit) -> list[Localization]:
    """Assign a model's remaining error to sites, one at a time, the likeliest first.

    A smooth random function of one coordinate at one site is added to the noise, with the size of maximum likelihood;
    then the next, given the first. This penalises the freedom of rich functions, and only one of two sites that explain
    the same residuals is reported. The scatter of whole poses is that without such functions, so that error explained
    by chance has no site.
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
    """Locations with the shares of equal sites and coordinates added."""
    whole: dict[tuple[str, str], Localization] = {}
    for one in located:
        before = whole.get(key := (one.site, one.coordinate))
        whole[key] = one if before is None else before.beside(one)
    return sorted(whole.values(), key=lambda one: -one.share)


def unmodelled_chi2(fit: Fit, where: str = "") -> float:
    """Chi-squared of the remaining error that functions of unknown form explain, beyond chance, at a site or any."""
    unknown = [site for site in sites(fit) if site.unknown and where in ("", site.site)]
    return sum(one.ratio - CHI2_PER_EFFECT for one in _select_sites(fit, unknown)[0])


def smooth_remainder(fit: Fit) -> Array:
    """Orthonormal directions of the whitened residuals in which smooth functions at sites exceed the noise, (K, n)."""
    fit = fit.with_likeliest_scatter
    selected, _ = _select_sites(fit, sites(fit))
    columns = [one.size * one.site.columns for one in selected]
    U, s, _ = np.linalg.svd(np.hstack([np.zeros((len(fit.at.white), 1)), *columns]), full_matrices=False)
    return np.asarray(U[:, s > 1.0])


@final
@dataclass(frozen=True)
class _SelectedSite:
    """A site with evidence in the residuals: twice the logarithm of the likelihood ratio, and the function's size."""

    site: Site
    ratio: float
    size: float


def _select_sites(fit: Fit, candidates: Iterable[Site]) -> tuple[list[_SelectedSite], int]:
    """Select the sites with evidence in the residuals; also return the number of candidates."""
    tried, functions = list(candidates), RandomFunctions(fit)
    normals = [functions.normal_equations(site) for site in tried]
    least = np.array([NEGLIGIBLE * functions.largest_square(site) for site in tried])
    prices = np.array([site.price for site in tried])
    most, sizes = np.array([site.most for site in tried]), np.array([len(normal) for normal in normals])
    selected: list[_SelectedSite] = []
    for _ in range(SEARCH_LIMIT):
        gradients = [functions.gradient(site) for site in tried]
        ratios, size = np.zeros(len(tried)), np.zeros(len(tried))
        for p in np.unique(sizes):
            same_size = np.flatnonzero(sizes == p)
            both = np.stack([normals[i] for i in same_size]), np.stack([gradients[i] for i in same_size])
            ratios[same_size], size[same_size] = _likelihood_ratios(*both, most[same_size], least[same_size])
        ratios -= prices
        best = int(np.argmax(ratios))
        if ratios[best] < CHI2_PER_EFFECT:
            break
        selected.append(_SelectedSite(tried[best], float(ratios[best]), float(size[best])))
        if len(selected) < SEARCH_LIMIT:
            functions.believe(tried[best], float(size[best]))
            normals = [normal - functions.newly_imitated(site) for normal, site in zip(normals, tried, strict=True)]
    return selected, len(tried)
