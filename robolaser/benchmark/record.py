"""The record of a benchmark: every run is on disk as soon as it is done, so a stopped benchmark can be resumed.

A file of JSON lines. The first holds the conditions that all runs share; then come a line for each session, which says
where it runs, and a line for each run, with its result and how long the session had lasted by then. A last line that a
power cut left unfinished is dropped.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.benchmark.convergence import ConvergenceTrace
from robolaser.benchmark.plan import Key, RunPlan, key
from robolaser.benchmark.result import Effort
from robolaser.benchmark.single_run import FAILED, BenchmarkRun
from robolaser.errors import BenchmarkError, unreadable, unwritable

FORMAT = "robolaser-runs/1"
PACKAGES = ("robolaser", "numpy", "numba", "scipy", "pymoo", "cma")
"""Packages whose other versions may search differently: runs with them are not comparable."""


@final
@dataclass
class _WorkSession:
    """One stretch of work on a benchmark."""

    engine: str
    workers: int
    lasted_s: float = 0.0
    busy_s: float = 0.0


@final
class RunRecord:
    """Runs of a benchmark in a file.

    Raises:
        BenchmarkError: The file is not such a record, or is damaged.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._runs: dict[Key, BenchmarkRun] = {}
        self._sessions: list[_WorkSession] = []
        self._conditions: dict[str, Any] = {}
        self._size = 0
        if path.exists():
            self._read()

    @property
    def runs(self) -> tuple[BenchmarkRun, ...]:
        """Every run in it; if a run was made again, the last one."""
        return tuple(self._runs.values())

    @property
    def made(self) -> tuple[BenchmarkRun, ...]:
        """The runs that did not fail, and need not be made again."""
        return tuple(run for run in self._runs.values() if run.state != FAILED)

    @property
    def effort(self) -> Effort:
        """Time and workers of all sessions."""
        last = self._sessions[-1] if self._sessions else _WorkSession("", 0)
        return Effort(
            last.engine,
            last.workers,
            seconds=sum(session.lasted_s for session in self._sessions),
            capacity_s=sum(session.lasted_s * session.workers for session in self._sessions),
            busy_s=sum(session.busy_s for session in self._sessions),
        )

    def begin(self, plan: RunPlan, *, engine: str, workers: int) -> None:
        """Open a session.

        Args:
            plan: Which runs will be made.
            engine: Where they are made.
            workers: Runs at a time.

        Raises:
            BenchmarkError: The runs in the file were made under other conditions.
            OutputError: The file cannot be written.
        """
        self._check(plan)
        self._conditions = {
            "format": FORMAT,
            "budget": plan.budget,
            "time_limit_s": plan.time_limit_s,
            "problems": self._conditions.get("problems", {}) | dict(plan.fingerprints),
            "versions": _versions(),
        }
        self._sessions.append(_WorkSession(engine, workers))
        self._append({"conditions": self._conditions})
        self._append({"session": {"engine": engine, "workers": workers}})

    def add(self, run: BenchmarkRun, *, after_s: float) -> None:
        """Add a run that was done so many seconds after the session began.

        Raises:
            OutputError: The file cannot be written.
        """
        self._append({"run": _as_json(run), "after_s": round(after_s, 3)})
        self._take(run, after_s)

    def _take(self, run: BenchmarkRun, after_s: float) -> None:
        self._runs[key(run)] = run
        self._sessions[-1].lasted_s = after_s
        self._sessions[-1].busy_s += run.seconds

    def _check(self, plan: RunPlan) -> None:
        """Raise unless the runs in the file are comparable with those to come."""
        known = self._conditions.get("problems", {})
        for name, fingerprint in plan.fingerprints.items():
            if known.get(name, fingerprint) != fingerprint:
                raise self._incomparable(f"the problem {name}", "another one", "this one")
        for package, here in _versions().items():
            if self._conditions.get("versions", {}).get(package, here) != here:
                raise self._incomparable(package, self._conditions["versions"][package], here)
        for what in ("budget", "time_limit_s"):
            here = getattr(plan, what)
            if self._conditions.get(what, here) != here:
                raise self._incomparable(what, self._conditions[what], here)

    def _incomparable(self, what: str, there: object, here: object) -> BenchmarkError:
        return BenchmarkError(
            f"{self._path} holds runs under other conditions: {what} is {there} there, here it is {here}, and such runs"
            " are not comparable. Continue under the same conditions, use another folder, or start over with --force."
        )

    def _unreadable(self, line: int, reason: str) -> BenchmarkError:
        return BenchmarkError(
            f"{self._path}, line {line}, does not belong to a record of benchmark runs ({reason})."
            " Use another folder, start over with --force, or delete that line to continue without it."
        )

    def _append(self, line: Mapping[str, Any]) -> None:
        """Write a line after the last whole one."""
        data = (json.dumps(line, allow_nan=False, ensure_ascii=False) + "\n").encode()
        try:
            with self._path.open("r+b" if self._path.exists() else "wb") as file:
                file.truncate(self._size)
                file.seek(self._size)
                file.write(data)
        except OSError as error:
            raise unwritable(self._path, error.strerror or str(error)) from None
        self._size += len(data)

    def _read(self) -> None:
        try:
            data = self._path.read_bytes()
        except OSError as error:
            raise unreadable(self._path, error.strerror or str(error)) from None
        *lines, _ = data.split(b"\n")  # what comes after the last end of a line was cut off
        for number, line in enumerate(lines, start=1):
            try:
                self._parse(json.loads(line))
            except (ValueError, KeyError, TypeError) as error:
                raise self._unreadable(number, f"{type(error).__name__}: {error}") from None
            self._size += len(line) + 1
        if data and not self._conditions:
            raise self._unreadable(1, "it does not begin with the conditions of a benchmark")

    def _parse(self, line: dict[str, Any]) -> None:
        if "conditions" in line:
            if line["conditions"]["format"] != FORMAT:
                raise ValueError(f"format {line['conditions']['format']}")
            self._conditions = line["conditions"]
        elif "session" in line:
            self._sessions.append(_WorkSession(**line["session"]))
        elif not (self._conditions and self._sessions):
            raise ValueError("a run before the conditions and the session that it belongs to")
        else:
            self._take(_from_json(line["run"]), float(line["after_s"]))


def _versions() -> dict[str, str]:
    """Of the packages that make the runs."""
    return {package: version(package) for package in PACKAGES}


def _as_json(run: BenchmarkRun) -> dict[str, Any]:
    trace = run.trace
    return {
        **{name: value for name, value in vars(run).items() if name != "trace"},
        "trace": [trace.evaluations.tolist(), trace.seconds.round(6).tolist(), trace.costs.tolist()],
    }


def _from_json(run: dict[str, Any]) -> BenchmarkRun:
    evaluations, seconds, costs = run.pop("trace")
    return BenchmarkRun(
        **run, trace=ConvergenceTrace(np.array(evaluations, np.int64), np.array(seconds, float), np.array(costs, float))
    )
