"""Rankings of solvers: which is better, by how much, and how certain that is."""

from robolaser.benchmark.standings.ranking import standings, standings_of
from robolaser.benchmark.standings.table import (
    FinalCosts,
    IntervalEstimate,
    Measure,
    OnProblem,
    Order,
    Pair,
    Ranks,
    Reached,
    Result,
    Standing,
    Standings,
)

__all__ = [
    "FinalCosts",
    "IntervalEstimate",
    "Measure",
    "OnProblem",
    "Order",
    "Pair",
    "Ranks",
    "Reached",
    "Result",
    "Standing",
    "Standings",
    "standings",
    "standings_of",
]
