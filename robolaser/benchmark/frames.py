"""Runs as tables for pandas, CSV and Parquet."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result_arrays import TOLERANCES, targets
from robolaser.benchmark.single_run import BenchmarkRun

if TYPE_CHECKING:
    import pandas as pd

RUN = ("problem", "algorithm", "seed", "state", "reason", "evaluations", "seconds", "processor_s", "violation")
"""What a row of the first table takes from its run as it is."""


def runs_frame(runs: Sequence[BenchmarkRun], problems: Mapping[str, ProblemSummary]) -> "pd.DataFrame":
    """A row for each run."""
    import pandas as pd  # noqa: PLC0415 - a third of a second

    frame = pd.DataFrame({name: [getattr(run, name) for run in runs] for name in RUN})
    best = np.array([run.trace.final for run in runs])
    frame.insert(8, "best", best)
    for at, name in ((1, "family"), (2, "dimension")):
        frame.insert(at, name, [getattr(problems[run.problem], name) for run in runs])
    lowest, scale = (np.array([getattr(problems[run.problem], name) for run in runs]) for name in ("best", "scale"))
    return frame.assign(lowest=lowest, scale=scale, excess=_excess(best, lowest, scale))


def trajectory_frame(runs: Sequence[BenchmarkRun], problems: Mapping[str, ProblemSummary]) -> "pd.DataFrame":
    """A row for each improvement of a run."""
    frame = _repeated(runs, [len(run.trace.costs) for run in runs], ("problem", "algorithm", "seed"))
    for name, column in (("evaluations", "evaluations"), ("seconds", "seconds"), ("costs", "cost")):
        frame[column] = np.concatenate([getattr(run.trace, name) for run in runs] or [np.empty(0)])
    lowest, scale = (np.array([getattr(problems[name], of) for name in frame.problem]) for of in ("best", "scale"))
    return frame.assign(excess=_excess(frame.cost.to_numpy(), lowest, scale))


def targets_frame(runs: Sequence[BenchmarkRun], problems: Mapping[str, ProblemSummary]) -> "pd.DataFrame":
    """A row for each run and target; what was not reached is missing."""
    frame = _repeated(runs, len(TOLERANCES), ("problem", "algorithm", "seed", "state", "reason"))
    costs = {name: targets(problem.best, problem.scale) for name, problem in problems.items()}
    hits = [run.trace.first_hits(costs[run.problem]) for run in runs]
    evaluations, seconds = (np.array([hit[i] for hit in hits]).ravel() for i in (0, 1))
    reached = np.isfinite(evaluations)
    frame["tolerance"] = np.tile([float(f"{tolerance:.6g}") for tolerance in TOLERANCES], len(runs))
    frame["target"] = np.concatenate([costs[run.problem] for run in runs] or [np.empty(0)])
    frame["reached"] = np.where(reached, "yes", "no")
    frame["evaluations"] = np.where(reached, evaluations, np.nan)
    frame["evaluations"] = frame["evaluations"].astype("Int64")
    frame["seconds"] = np.where(reached, seconds, np.nan).round(6)
    of_runs: dict[str, Any] = {
        "evaluations": [run.evaluations for run in runs],
        "seconds": np.array([run.seconds for run in runs]).round(6),
        "processor_s": np.array([run.processor_s for run in runs]).round(6),
        "best": [run.trace.final if len(run.trace.costs) else np.nan for run in runs],
        "violation": [run.violation for run in runs],
    }
    return frame.assign(**{f"run_{name}": np.repeat(column, len(TOLERANCES)) for name, column in of_runs.items()})


FRAMES = {"runs": runs_frame, "trajectory": trajectory_frame, "targets": targets_frame}
"""The tables by name."""


def _repeated(runs: Sequence[BenchmarkRun], times: int | Sequence[int], names: Sequence[str]) -> "pd.DataFrame":
    import pandas as pd  # noqa: PLC0415 - a third of a second

    columns: dict[str, Any] = {name: [getattr(run, name) for run in runs] for name in names}
    frame = pd.DataFrame(columns)
    return frame.loc[frame.index.repeat(times)].reset_index(drop=True)


def _excess(cost: np.ndarray, lowest: np.ndarray, scale: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        excess: np.ndarray = (cost - lowest) / scale
    return np.where(np.isnan(excess), np.inf, excess)
