"""Rankings of solvers: which is better, by how much, and how certain that is."""

from robolaser.benchmark.standings.ranking import standings
from robolaser.benchmark.standings.table import Standings

__all__ = ["Standings", "standings"]
