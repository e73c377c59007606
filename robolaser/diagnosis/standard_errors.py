"""Standard errors that are valid for an incomplete model.

Noise alone gives their lower limit. Whole poses may scatter otherwise than in the noise model, and effects too small to
be found bias those that were.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.special import stdtrit

from robolaser.arrays import Array, Ints
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.profile_likelihood import SIZES
from robolaser.diagnosis.score_tests import ScoreTest
from robolaser.diagnosis.thresholds import SEEN, SIGMA_OF_95_PERCENT
from robolaser.estimation.certainty import EVEN
from robolaser.estimation.nonlinear_parameters import NEGLIGIBLE


def standard_errors(
    fit: Fit, tests: Sequence[ScoreTest] = (), evidence: Sequence[EffectEvidence] = (), whole: Fit | None = None
) -> Array:
    """One standard deviation of each parameter, (d,): the larger of noise and scatter of poses, plus other effects.

    Alternatives to each effect found, and its absence, count with their weights (model averaging: Hoeting, Madigan,
    Raftery, Volinsky 1999).

    Known distances and priors count as stated. With few poses the scatter itself is uncertain: Student's t, with one
    degree of freedom less than poses, widens all so that 1.96 of them are a 95 % interval.

    Args:
        fit: The model.
        tests: Score tests of effects outside it.
        evidence: Evidence for effects in it.
        whole: The same model fitted to more poses, for noise and scatter.
    """
    whole = whole or fit
    variances = _by_noise_and_poses(whole)
    if tests:
        white, left = np.hstack([test.white for test in tests]), np.hstack([test.columns for test in tests])
        other = (left**2).sum(axis=0) > NEGLIGIBLE * (white**2).sum(axis=0)
        pull = _influence(fit)[:, : len(white)] @ white[:, other]
        variances = variances + considered_variances(pull, left[:, other], fit.at.r)
    variances = variances + between_models(fit, evidence) + _of_moments(whole)
    widened = stdtrit(max(1, len(whole.poses) - 1), 0.975) / SIGMA_OF_95_PERCENT
    return np.asarray(widened * np.sqrt(variances))


def _of_moments(fit: Fit) -> Array:
    """Variances of moments at which effects begin, uniform between two poses, where no row depends on them, (d,)."""
    variances = np.zeros(len(fit.x))
    for one in fit.effects:
        if one.effect.begins:
            progress = np.unique(fit.model.run.progress_of_all[fit.poses])
            (moment,) = (one.key(each.name) for each in one.effect.nonlinear_parameters())
            i = fit.problem.parameters.names.index(moment)
            after = int(np.clip(np.searchsorted(progress, fit.x[i]), 1, len(progress) - 1))
            variances[i] = (progress[after] - progress[after - 1]) ** 2 / 12.0
    return variances


def _by_noise_and_poses(fit: Fit) -> Array:
    """The larger of the variances by noise and by the scatter of whole poses, (d,)."""
    at, K, influence = fit.at, len(fit.at.white), _influence(fit)
    by_poses = clustered_variances(influence[:, :K], at.Q[:K], at.white, fit.pose_of_number)
    by_poses += np.square(influence[:, K:]).sum(axis=1)
    return np.maximum(np.diag(at.covariance), by_poses)


def _influence(fit: Fit) -> Array:
    """Derivatives of the parameters by each whitened number, (d, K + e)."""
    return np.asarray((fit.at.covariance / fit.problem.scale) @ fit.at.J.T)


def between_models(fit: Fit, evidence: Sequence[EffectEvidence]) -> Array:
    """Variances between the fit and those with alternatives to its effects, or without them, by their weights, (d,)."""
    moved = np.zeros(len(fit.x))
    for one in evidence:
        for candidate, other in ((None, one.without), *one.alternatives):
            values = other.values
            there = np.array([values.get(name, x) for name, x in fit.values.items()])
            moved += one.weights[candidate] * np.square(there - fit.x)
    return moved


def clustered_variances(influence: Array, Q: Array, residuals: Array, cluster: Ints) -> Array:
    """Variances of linear estimates by the scatter of independent clusters, with any correlation within each, (d,).

    The sandwich estimator, residuals corrected for the leverage of their own cluster (Bell, McCaffrey 2002; Cameron,
    Miller 2015, A practitioner's guide to cluster-robust inference).

    Args:
        influence: Derivatives of the estimates by each row, (d, K).
        Q: Orthonormal basis of the parameters' columns, (K, n).
        residuals: Residuals of the fit, (K,).
        cluster: The cluster of each row, (K,).
    """
    variances = np.zeros(len(influence))
    for own in _alike_clusters(cluster):
        r = residuals[own][..., None]
        U, s, _ = np.linalg.svd(Q[own], full_matrices=False)
        raised = 1.0 / np.sqrt(1.0 - np.minimum(s**2, 1.0 - SEEN)) - 1.0
        freed = r + U @ (raised[..., None] * (np.swapaxes(U, 1, 2) @ r))
        variances += np.square(np.einsum("dpk,pk->dp", influence[:, own], freed[..., 0])).sum(axis=1)
    return variances


def _alike_clusters(cluster: Ints) -> Iterator[Ints]:
    """Rows of clusters (p, k), those with the same number of rows k together."""
    order = np.argsort(cluster, kind="stable")
    _, starts, counts = np.unique(cluster[order], return_index=True, return_counts=True)
    for k in np.unique(counts):
        yield order[starts[counts == k][:, None] + np.arange(k)]


def considered_variances(pull: Array, columns: Array, residuals: Array) -> Array:
    """Variances that effects too small to be found add to linear estimates without them, (d,).

    Their amplitudes are random, each with its usual size times a common factor up to 1, averaged over its posterior
    (Schmidt's considered parameters, 1966, their size by marginal likelihood, MacKay 1992). Both the posterior variance
    and the posterior mean of the amplitudes shift the estimates.

    Args:
        pull: Shift of the estimates by each amplitude at its usual size, (d, q).
        columns: The amplitudes' columns, without the part that the parameters imitate, (K, q).
        residuals: Residuals of the fit, of unit variance, (K,).
    """
    eigenvalues, V = np.linalg.eigh(columns.T @ columns)
    eigenvalues = np.maximum(eigenvalues, 0.0)
    along, pull = V.T @ (columns.T @ residuals), pull @ V
    sizes = np.append(0.0, SIZES[SIZES <= 1.0])
    t = sizes[:, None] ** 2
    shrunk = t / (1.0 + t * eigenvalues)
    log_ratios = 0.5 * (along**2 * shrunk - np.log1p(t * eigenvalues)).sum(axis=1)
    prior = np.where(sizes > 0.0, (1.0 - EVEN) / (len(sizes) - 1), EVEN)
    weights = prior * np.exp(log_ratios - log_ratios.max())
    added = [pull**2 @ s + (pull @ (s * along)) ** 2 for s in shrunk]
    return np.asarray(weights @ np.array(added) / weights.sum())
