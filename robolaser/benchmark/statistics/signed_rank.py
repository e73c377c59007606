"""How probable it is that one algorithm is better than another on further problems, and that the two are alike.

The Bayesian signed-rank test: problems are weighed by a Dirichlet process, and a pair of problems speaks for whoever is
ahead on their average. Benavoli, Mangili, Corani, Zaffalon & Ruggeri 2014, "A Bayesian Wilcoxon signed-rank test based
on the Dirichlet process"; Benavoli, Corani, Demšar & Zaffalon 2017 on the region of practical equivalence (ROPE).
"""

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.result_arrays import HEADLINE, ResultArrays
from robolaser.benchmark.statistics.ranks import outcomes
from robolaser.benchmark.statistics.superiority import superiority

if TYPE_CHECKING:
    import pandas as pd

ROPE = 0.06
"""A12 within so much of a half is negligible: Vargha & Delaney 2000, table 1."""
PRIOR = 1.0
"""Weight of the prior, one further problem on which the two are alike."""
SAMPLES = 5000
"""Of the posterior: probabilities have a standard error of at most 0.007."""


def shares(differences: Array, rng: np.random.Generator, *, rope: float = ROPE, samples: int = SAMPLES) -> Array:
    """Shares of pairs of problems that speak for the one, for neither and for the other, in posterior samples, (b, 3).

    Differences (p,) of the two are above 0 where the first is better; averages of two within `rope` are none.
    """
    weights = rng.dirichlet([PRIOR, *np.ones(len(differences))], samples)
    values = np.append(0.0, differences)
    means = (values[:, None] + values) / 2
    regions = (means > rope, np.abs(means) <= rope, means < -rope)
    return np.stack([((weights @ region) * weights).sum(axis=1) for region in regions], axis=1)


def signed_rank(arrays: ResultArrays, *, seed: int = 1, rope: float = ROPE) -> "pd.DataFrame":
    """The test of each pair of algorithms by how often the runs of the one beat those of the other.

    A row for each pair: `algorithm`, `other`, `problems` on which both have runs, and the probabilities `better`,
    `alike` and `worse` that the largest share of pairs of problems speaks for it, for neither, or for the other.
    """
    import pandas as pd  # noqa: PLC0415 - a third of a second

    ahead = superiority(outcomes(arrays.evaluations[..., arrays.target(HEADLINE)], arrays.final)).value - 0.5
    rows = []
    for i, j in combinations(range(len(arrays.algorithms)), 2):
        differences = ahead[:, i, j][~np.isnan(ahead[:, i, j])]
        if len(differences):
            won = shares(differences, np.random.default_rng(seed), rope=rope).argmax(axis=1)
            probable = np.bincount(won, minlength=3) / len(won)
            rows.append((arrays.algorithms[i], arrays.algorithms[j], len(differences), *probable))
    return pd.DataFrame(rows, columns=["algorithm", "other", "problems", "better", "alike", "worse"])
