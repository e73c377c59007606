"""Landscape statistics of an instance of the suite, within its bounds and at its optimum."""

import numpy as np
from scipy.spatial.distance import pdist
from scipy.stats import spearmanr

from robolaser.model.forward_model import jacobian_matrix
from robolaser.problems.calibration_suite import SuiteProblem

SAMPLES = 2000
BEST = 0.05  # share of the samples for the dispersion
GAUGE = 1e-13  # relative to the largest singular value: smaller ones move no point


def landscape(problem: SuiteProblem, seed: int = 1) -> dict[str, float]:
    """Statistics of J within the bounds, each variable in units of its range.

    `correlation` is Spearman's, of J and the distance to the optimum (Jones & Forrest 1995); `dispersion` the mean
    distance between the best samples relative to all (Lunacek & Whitley 2006); `condition` the condition number of the
    Gauss-Newton Hessian at the optimum in directions that move a point; `gauge` the number of the other directions;
    `poles` the share of samples with infinite J; `median` the median of the others relative to the lowest J.
    """
    u = np.random.default_rng(seed).random((SAMPLES, problem.dimension))
    width = problem.xu - problem.xl
    J = problem.evaluate(problem.xl + u * width)[:, 0]
    finite = np.isfinite(J)
    best = (problem.best_x - problem.xl) / width
    near = u[finite][np.argsort(J[finite])[: int(BEST * finite.sum())]]
    singular = np.linalg.svd(_slopes(problem, best), compute_uv=False)
    determined = singular[singular > GAUGE * singular[0]]
    return {
        "correlation": spearmanr(np.linalg.norm(u[finite] - best, axis=1), J[finite]).statistic,
        "dispersion": pdist(near).mean() / pdist(u[finite]).mean(),
        "condition": (determined[0] / determined[-1]) ** 2,
        "gauge": problem.dimension - len(determined),
        "poles": 1 - finite.mean(),
        "median": float(np.median(J[finite])) / problem.lowest,
    }


def _slopes(problem: SuiteProblem, u: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """Derivatives of the residuals, (K, dimension); by central differences for reduced instances."""
    width = problem.xu - problem.xl
    if not problem.instance.reduced:
        whole = jacobian_matrix(problem.model, problem.completed((problem.xl + u * width)[None])[0])
        return whole[:, problem.model.parameters.columns(problem.names)] * width
    steps = step * np.eye(len(u))
    sides = [problem.model.residuals(problem.completed(problem.xl + (u + s * steps) * width)) for s in (1, -1)]
    return ((sides[0] - sides[1]) / (2 * step)).reshape(len(u), -1).T
