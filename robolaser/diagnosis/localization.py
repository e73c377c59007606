"""The share of a gap that lies at each site: random functions there, their size by maximum likelihood."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.candidate_sites import Site, sites
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.thresholds import LIKELIHOOD_RATIO_OF_SITE

SIZES = np.exp(np.linspace(np.log(1e-2), np.log(1e4), 60))
"""Standard deviations tried for a function, relative to one that just shows among the noise."""
MAX_SITES = 4
"""Sites that a gap is divided among."""


@final
@dataclass(frozen=True)
class Localization:
    """A site where the gap, or a part of it, lies.

    Attributes:
        site: A joint's name, or another of `Site.site`.
        coordinate: In which coordinate.
        share: Of the squared whitened gap beyond noise, what a function there explains beyond the price of its freedom.
        likelihood_ratio: Twice its logarithm, against no function there.
        p_value: Of that, corrected for all sites and coordinates that were tried.
    """

    site: str
    coordinate: str
    share: float
    likelihood_ratio: float
    p_value: float


def likelihood_ratio(B: Array, residuals: Array, most: float) -> tuple[float, float]:
    """Twice the logarithm of the largest likelihood ratio of a random function, and the size that has it.

    Args:
        B: Derivatives of the whitened residuals by the function's basis, (k, p).
        residuals: Whitened, (k,).
        most: Largest plausible size.
    """
    eigenvalues, V = np.linalg.eigh(B.T @ B)
    eigenvalues = np.maximum(eigenvalues, 0.0)
    z2 = (V.T @ (B.T @ residuals)) ** 2
    scale = 1.0 / np.sqrt(max(float(eigenvalues.mean()), 1e-300))
    sizes = np.minimum(scale * SIZES, most)
    t = sizes[:, None] ** 2
    value = (z2 * t / (1.0 + eigenvalues * t) - np.log1p(eigenvalues * t)).sum(axis=1)
    best = int(np.argmax(value))
    return max(0.0, float(value[best])), float(sizes[best])


def p_value(ratio: float, tried: int) -> float:
    """Of a likelihood ratio of a variance that cannot be negative, the largest of so many (Self and Liang 1987)."""
    return float(min(1.0, tried * 0.5 * math.erfc(math.sqrt(0.5 * max(ratio, 0.0)))))


def localize(fit: Fit) -> list[Localization]:
    """Divide what a model leaves among the sites, one at a time, the likeliest first.

    A smooth random function of one coordinate at one site is added to the noise, its size by maximum likelihood; then
    the next, given the first. So rich functions pay for their freedom, and of two sites that could both explain the
    residuals only one is named.
    """
    chosen, tried = _chosen(fit, sites(fit))
    excess = fit.chi2 - fit.freedoms
    whole = max(excess, sum(ratio for _, ratio in chosen))
    found = [
        Localization(site.site, site.coordinate, ratio / whole, ratio, p_value(ratio, tried)) for site, ratio in chosen
    ]
    return sorted(found, key=lambda place: -place.share)


def unmodelled_chi2(fit: Fit) -> float:
    """Chi-squared that functions of unknown form at any site explain of what is left, beyond what chance gives."""
    places = [site for site in sites(fit) if site.unknown]
    return sum(ratio - LIKELIHOOD_RATIO_OF_SITE for _, ratio in _chosen(fit, places)[0])


def _chosen(fit: Fit, places: Iterable[Site]) -> tuple[list[tuple[Site, float]], int]:
    """The sites that the residuals speak for, each with its likelihood ratio; and how many were tried."""
    tried = list(places)
    chosen: list[tuple[Site, float]] = []
    residuals, B = fit.at.r, [fit.at.project(site.columns) for site in tried]
    for _ in range(MAX_SITES):
        ratios = [likelihood_ratio(b, residuals, site.most) for site, b in zip(tried, B, strict=True)]
        best = int(np.argmax([ratio for ratio, _ in ratios]))
        ratio, size = ratios[best]
        if ratio < LIKELIHOOD_RATIO_OF_SITE:
            break
        chosen.append((tried[best], ratio))
        U, s, _ = np.linalg.svd(size * B[best], full_matrices=False)
        shrink = U * (1.0 - 1.0 / np.sqrt(1.0 + s**2))
        residuals = residuals - shrink @ (U.T @ residuals)
        B = [b - shrink @ (U.T @ b) for b in B]
    return chosen, len(tried)
