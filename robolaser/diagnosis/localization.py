"""The share of a gap that lies at each site: random functions there, their size chosen by what the residuals show."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.stats import chi2

from robolaser.arrays import Array
from robolaser.diagnosis.candidate_sites import Site, sites
from robolaser.diagnosis.penalized_fit import Fitted
from robolaser.diagnosis.verdict import SITE_SIGNIFICANT

SIZES = np.exp(np.linspace(np.log(1e-2), np.log(1e4), 60))
"""Standard deviations tried for a function, relative to one that just shows among the noise."""
MOST = 4
"""Sites at most that a gap is divided among."""


@final
@dataclass(frozen=True)
class Localization:
    """A place where the gap, or a part of it, lies.

    Attributes:
        site: The place.
        coordinate: In which coordinate.
        share: Of the squared whitened excess over noise, what a function there explains beyond its freedom's price.
        likelihood_ratio: Twice the logarithm, against no function there.
        p_value: Of that, with all sites and coordinates that were asked in mind.
    """

    site: str
    coordinate: str
    share: float
    likelihood_ratio: float
    p_value: float


def likelihood_ratio(B: Array, rest: Array, most: float) -> tuple[float, float]:
    """Largest likelihood ratio of a random function, and the size that has it.

    Args:
        B: What its shapes do to the residuals, (k, p).
        rest: The residuals, (k,).
        most: Largest plausible size.
    """
    eigenvalues, V = np.linalg.eigh(B.T @ B)
    eigenvalues = np.maximum(eigenvalues, 0.0)
    z2 = (V.T @ (B.T @ rest)) ** 2
    scale = 1.0 / np.sqrt(max(float(eigenvalues.mean()), 1e-300))
    sizes = np.minimum(scale * SIZES, most)
    t = sizes[:, None] ** 2
    value = (z2 * t / (1.0 + eigenvalues * t) - np.log1p(eigenvalues * t)).sum(axis=1)
    best = int(np.argmax(value))
    return max(0.0, float(value[best])), float(sizes[best])


def where(fitted: Fitted) -> list[Localization]:
    """Divide what a model leaves among the sites, one at a time, the likeliest first.

    A smooth random function of one coordinate at one site is added to the noise, its size by maximum likelihood; then
    the next, given the first. So rich functions pay for their freedom, and of two sites that could both explain the
    residuals only one is named. A likelihood in which functions are averaged over is the product of predictions of
    each pose from those before it: functions that do not predict have none.

    Args:
        fitted: The model.
    """
    chosen, asked = _chosen(fitted, sites(fitted))
    excess = fitted.misfit - (len(fitted.r) - len(fitted.x))
    whole = max(excess, sum(ratio for _, ratio in chosen))
    found = [
        Localization(site.site, site.coordinate, ratio / whole, ratio, float(min(1.0, 0.5 * asked * chi2.sf(ratio, 1))))
        for site, ratio in chosen
    ]
    return sorted(found, key=lambda lies: -lies.share)


def explained(fitted: Fitted) -> float:
    """What functions of any unknown form at any site would explain of what a model leaves, in squared whitened misfit.

    Twice the logarithm of their likelihood ratio, less what chance would give the best of them.
    """
    return sum(
        ratio - SITE_SIGNIFICANT for _, ratio in _chosen(fitted, [site for site in sites(fitted) if site.unknown])[0]
    )


def _chosen(fitted: Fitted, places: Iterable[Site]) -> tuple[list[tuple[Site, float]], int]:
    """The sites that the residuals speak for, each with its likelihood ratio; and how many were asked."""
    asked = list(places)
    chosen: list[tuple[Site, float]] = []
    white, B = fitted.rest, [fitted.projected(site.columns) for site in asked]
    for _ in range(MOST):
        ratios = [likelihood_ratio(b, white, site.most) for site, b in zip(asked, B, strict=True)]
        best = int(np.argmax([ratio for ratio, _ in ratios]))
        ratio, size = ratios[best]
        if ratio < SITE_SIGNIFICANT:
            break
        chosen.append((asked[best], ratio))
        U, s, _ = np.linalg.svd(size * B[best], full_matrices=False)
        shrink = U * (1.0 - 1.0 / np.sqrt(1.0 + s**2))
        white = white - shrink @ (U.T @ white)
        B = [b - shrink @ (U.T @ b) for b in B]
    return chosen, len(asked)
