"""The problem and the populations for tests of operators, and an algorithm with a generation count."""

from types import SimpleNamespace

from pymoo.core.termination import NoTermination

from robolaser.operators.testing import Bowl, evaluated_population

LOWER, UPPER = Bowl().xl, Bowl().xu
population = evaluated_population


def running(n_iter, termination=None):
    """The attributes of an algorithm that an operator may read."""
    return SimpleNamespace(n_iter=n_iter, termination=NoTermination() if termination is None else termination)
