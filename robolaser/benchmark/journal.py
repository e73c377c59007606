"""The runs of a comparison on disk, `runs.jsonl`: a line for the plan, and one for each run as it ends.

Lines are only appended, so a killed process loses no finished run. Journals of one comparison may be merged.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.benchmark.evaluator import ConvergenceTrace
from robolaser.benchmark.measures import measured
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.run import DONE, BenchmarkRun, RunKey
from robolaser.errors import BenchmarkError, unwritable

NAME = "runs.jsonl"
FORMAT = "robolaser-runs/1"


@final
class Journal:
    """The runs of a comparison, with all data for their ranking.

    The file is created with the first line, which replaces another journal unless that is resumed; without a path they
    are in memory.

    Raises:
        BenchmarkError: The file is not such a journal.
    """

    def __init__(self, path: Path | None = None, *, resume: bool = True) -> None:
        self._path, self._mode = path, "a" if resume else "w"
        self._lines: list[str] = []
        self._plans: list[dict[str, Any]] = []
        self._runs: dict[RunKey, BenchmarkRun] = {}
        self._sessions: list[float] = []
        if resume and path is not None and path.is_file():
            self._read(path)
            if (whole := "".join(self._lines)) != path.read_text(encoding="utf-8"):
                path.write_text(whole, encoding="utf-8")  # the process was killed within a line

    @classmethod
    def read(cls, files: Iterable[Path]) -> "Journal":
        """The journal of several files together, which are not changed."""
        journal = cls()
        for file in files:
            journal._read(file)
        return journal

    def __len__(self) -> int:
        """Number of runs."""
        return len(self._runs)

    def done(self) -> Mapping[RunKey, float]:
        """Times of the runs that did not fail and need not be repeated [s]."""
        return {key: run.seconds for key, run in self._runs.items() if run.state == DONE}

    def begin(self, plan: Mapping[str, Any]) -> None:
        """Add a plan: its `conditions`, `problems`, `solvers`, `refused`, `seeds`, `target`, `engine` and `workers`.

        Raises:
            BenchmarkError: The existing runs were made under other conditions.
        """
        entry = {"format": FORMAT, **plan}
        self._planned(entry, str(self._path))
        self._write(entry)

    def add(self, run: BenchmarkRun, *, after_s: float) -> None:
        """Add a run that ended so many seconds after the session began; it replaces one of the same key."""
        entry = asdict(replace(run, trace=None))  # type: ignore[arg-type]
        entry["trace"] = [column.tolist() for column in (run.trace.evaluations, run.trace.seconds, run.trace.costs)]
        self._ran(entry, after_s)
        self._write({"run": entry, "after_s": after_s})

    def result(self, of: Mapping[str, Any] | None = None) -> BenchmarkResult:
        """The result so far, of a plan or of all plans."""
        plans = self._plans if of is None else [dict(of)]
        problems: dict[str, ProblemSummary] = {}
        solvers: dict[str, str] = {}
        refused: dict[tuple[str, str], str] = {}
        know_budget, seeds = set(), set()
        for plan in plans:
            problems |= {one["name"]: ProblemSummary(**one) for one in plan["problems"]}
            solvers |= {name: title for name, title, _ in plan["solvers"]}
            know_budget |= {name for name, _, knows in plan["solvers"] if knows}
            refused |= {(problem, solver): reason for problem, solver, reason in plan["refused"]}
            seeds |= set(plan["seeds"])
        made = [run for (p, a, seed), run in self._runs.items() if p in problems and a in solvers and seed in seeds]
        made.sort(key=lambda run: (run.seed, list(solvers).index(run.algorithm)))  # not in the order of their ends
        ranked: list[BenchmarkRun] = []
        for name, problem in problems.items():
            problems[name], runs = measured(problem, [run for run in made if run.problem == name])
            ranked += runs
        last = plans[-1] if plans else {}
        conditions = last.get("conditions", {})
        return BenchmarkResult(
            problems=tuple(problems.values()),
            solvers=solvers,
            know_budget=frozenset(know_budget),
            refused=refused,
            seeds=tuple(sorted(seeds)),
            budget=str(conditions.get("budget", "")),
            target=last.get("target"),
            time_limit_s=float(conditions.get("time_limit_s", 0.0)),
            runs=tuple(ranked),
            made=tuple(made),
            engine=last.get("engine", ""),
            workers=last.get("workers", 0),
            seconds=sum(self._sessions),
            journal="".join(self._lines),
        )

    def _read(self, file: Path) -> None:
        try:
            for line in file.read_text(encoding="utf-8").split("\n")[:-1]:
                entry = json.loads(line)
                if "run" in entry:
                    self._ran(entry["run"], entry["after_s"])
                elif entry["format"] != FORMAT:
                    raise ValueError(f"format {entry['format']}, expected {FORMAT}")
                else:
                    self._planned(entry, str(file))
                self._lines.append(f"{line}\n")
        except (ValueError, LookupError, TypeError) as error:
            raise BenchmarkError(
                f"{file} cannot be read as the runs of a comparison ({type(error).__name__}: {error})."
                " Use another folder, or start over with --force."
            ) from None

    def _planned(self, plan: dict[str, Any], where: str) -> None:
        for name, value in plan["conditions"].items():
            there = next((one["conditions"][name] for one in self._plans if name in one["conditions"]), value)
            if there != value:
                raise _incomparable(where, name, there, value)
        known = {one["name"]: one["fingerprint"] for there in self._plans for one in there["problems"]}
        for one in plan["problems"]:
            if known.get(one["name"], one["fingerprint"]) != one["fingerprint"]:
                raise _incomparable(where, f"the problem {one['name']}", "another one", "this one")
        titles = {name: title for there in self._plans for name, title, _ in there["solvers"]}
        for name, title, _ in plan["solvers"]:
            if titles.get(name, title) != title:
                raise _incomparable(where, f"the algorithm {name}", f"'{titles[name]}'", f"'{title}'")
        self._plans.append(plan)
        self._sessions.append(0.0)

    def _ran(self, entry: dict[str, Any], after_s: float) -> None:
        run = BenchmarkRun(**{**entry, "trace": ConvergenceTrace.of(zip(*entry["trace"], strict=True))})
        self._runs.pop(run.key, None)
        self._runs[run.key] = run
        self._sessions[-1] = max(self._sessions[-1], after_s)

    def _write(self, entry: Mapping[str, Any]) -> None:
        line = json.dumps(entry, default=_plain) + "\n"
        self._lines.append(line)
        if self._path is not None:
            try:
                with self._path.open(self._mode, encoding="utf-8") as file:
                    file.write(line)
                self._mode = "a"
            except OSError as error:
                raise unwritable(self._path, str(error)) from None


def merge(paths: Sequence[str | Path]) -> BenchmarkResult:
    """Merge the runs of several folders, as of an array job; of runs with one seed the last counts.

    Raises:
        BenchmarkError: One of them has no runs, or they were made under other conditions.
    """
    files = [path / NAME if path.is_dir() else path for path in map(Path, paths)]
    for path, file in zip(paths, files, strict=True):
        if not file.is_file():
            raise BenchmarkError(f"No runs in {path}: expected the folder of a comparison, or the file {NAME} in it.")
    return Journal.read(files).result()


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)


def _incomparable(where: str, what: str, there: object, here: object) -> BenchmarkError:
    return BenchmarkError(
        f"{where} holds runs under other conditions: {what} is {there} there, here it is {here}, and such runs"
        " are not comparable. Continue under the same conditions, use another folder, or start over with --force."
    )
