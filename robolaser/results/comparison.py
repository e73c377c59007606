"""Comparisons of algorithms."""

import json
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from robolaser.benchmark.export import comparison_json, runs_csv
from robolaser.benchmark.journal import NAME as JOURNAL
from robolaser.benchmark.journal import merge
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings.ranking import standings
from robolaser.benchmark.standings.table import Standings
from robolaser.errors import UsageError
from robolaser.report.comparison import page as of_comparison
from robolaser.report.document import Document
from robolaser.report.page import render
from robolaser.results import PAGE, Files, Result

if TYPE_CHECKING:
    import pandas as pd


@final
class ComparisonResult(Result):
    """A comparison of algorithms, with the attributes of its `BenchmarkResult`.

    Attributes:
        benchmark: All runs.

    Examples:
        >>> robolaser.compare(["pymoo:sphere-2"], ["de"], seeds=1, budget=100).to_frame()["state"].tolist()
        ['done']
    """

    command = "compare"

    def __init__(self, benchmark: BenchmarkResult) -> None:
        self.benchmark = benchmark

    def __getattr__(self, name: str) -> Any:
        if name == "benchmark":  # of an object that is being unpickled
            raise AttributeError(name)
        return getattr(self.benchmark, name)

    def to_dict(self) -> dict[str, Any]:
        """The contents of comparison.json."""
        return dict(json.loads(comparison_json(self.benchmark, self.standings)))

    def to_frame(self, of: Any = "runs") -> "pd.DataFrame":
        """The runs, or runs and "targets", as `BenchmarkResult.to_frame` has them."""
        return self.benchmark.to_frame(of)

    def files(self, *, command: str = "") -> Files:
        """The runs, runs.csv, comparison.json and the report."""
        return {
            JOURNAL: self.benchmark.journal,
            "runs.csv": runs_csv(self.benchmark),
            PAGE: render(of_comparison.document(self.benchmark, self.standings), command),
            "comparison.json": comparison_json(self.benchmark, self.standings),
        }

    def _document(self, *, brief: bool) -> Document:
        return of_comparison.document(self.benchmark, self.standings, brief=brief)

    @cached_property
    def standings(self) -> tuple[Standings, ...]:
        """The ranking of algorithms on each family of problems."""
        return tuple(standings(self.benchmark, family) for family in self.benchmark.families)


def load_comparison(*folders: str | Path) -> ComparisonResult:
    """Load comparisons, finished or not, and merge their runs, such as those of an array job.

    Of several runs of a problem, algorithm and seed, the last counts.

    Args:
        folders: Folders of the comparisons.

    Raises:
        UsageError: No folder is given.
        BenchmarkError: One of them has no runs, or they were made under other conditions.

    Examples:
        >>> for seed in (1, 2):
        ...     task = {"seeds": 1, "first_seed": seed, "budget": 100, "output": f"node-{seed}"}
        ...     _ = robolaser.compare(["pymoo:sphere-2"], ["de"], **task)
        >>> len(robolaser.load_comparison("node-1", "node-2").runs)
        2
    """
    if not folders:
        raise UsageError("Name the folder of a comparison.")
    return ComparisonResult(merge(folders))
