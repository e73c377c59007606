"""The judge of comparisons: which contestant is better, by how much, and how sure that is."""

from robolaser.benchmark.standings.judgement import judged, standings
from robolaser.benchmark.standings.table import (
    Estimate,
    Measure,
    OnProblem,
    Order,
    Pair,
    Place,
    Quality,
    Ranks,
    Reached,
    Result,
    Standings,
)

__all__ = [
    "Estimate",
    "Measure",
    "OnProblem",
    "Order",
    "Pair",
    "Place",
    "Quality",
    "Ranks",
    "Reached",
    "Result",
    "Standings",
    "judged",
    "standings",
]
