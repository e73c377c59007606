"""The problem and the populations that operators are tried on, and an algorithm that knows its time."""

from types import SimpleNamespace

from pymoo.core.termination import NoTermination

from robolaser.operators.testing import Bowl, evaluated_population

LOWER, UPPER = Bowl().xl, Bowl().xu
population = evaluated_population


def running(n_iter, termination=None):
    """As much of an algorithm as an operator may look at."""
    return SimpleNamespace(n_iter=n_iter, termination=NoTermination() if termination is None else termination)
