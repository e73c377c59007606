"""The record of a contest: every run on disk as soon as it is done, so that it can be stopped and gone on with.

A file of JSON lines. The first says on what terms; then each session says where it runs, and each run what came of it
and how long the session had lasted by then. A last line that a power cut left unfinished is dropped.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.benchmark.convergence import Course
from robolaser.benchmark.plan import Contest, Key, key
from robolaser.benchmark.result import Effort
from robolaser.benchmark.single_run import FAILED, Run
from robolaser.errors import ComparisonForeign, RecordUnreadable, unreadable, unwritable

FORMAT = "robolaser-runs/1"
PACKAGES = ("robolaser", "numpy", "numba", "scipy", "pymoo", "cma")
"""Another version of one of these may search otherwise: its runs do not compare."""


@final
@dataclass
class _Session:
    """One stretch of work on a contest."""

    engine: str
    workers: int
    lasted_s: float = 0.0
    busy_s: float = 0.0


@final
class Record:
    """Runs of a contest in a file.

    Raises:
        RecordUnreadable: The file is no record.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._runs: dict[Key, Run] = {}
        self._sessions: list[_Session] = []
        self._terms: dict[str, Any] = {}
        self._size = 0
        if path.exists():
            self._read()

    @property
    def runs(self) -> tuple[Run, ...]:
        """Every run in it; of one that was made again, the last."""
        return tuple(self._runs.values())

    @property
    def made(self) -> tuple[Run, ...]:
        """Runs that need not be made again: those that did not fail."""
        return tuple(run for run in self._runs.values() if run.state != FAILED)

    @property
    def effort(self) -> Effort:
        """What all sessions took."""
        last = self._sessions[-1] if self._sessions else _Session("", 0)
        return Effort(
            last.engine,
            last.workers,
            seconds=sum(one.lasted_s for one in self._sessions),
            capacity_s=sum(one.lasted_s * one.workers for one in self._sessions),
            busy_s=sum(one.busy_s for one in self._sessions),
        )

    def begin(self, contest: Contest, *, engine: str, workers: int) -> None:
        """Open a session.

        Args:
            contest: What the runs are about.
            engine: Where they are made.
            workers: How many at a time.

        Raises:
            ComparisonForeign: The runs in the file were made on other terms.
            OutputError: The disk or the rights say no.
        """
        self._check(contest)
        self._terms = {
            "format": FORMAT,
            "budget": contest.budget,
            "time_limit_s": contest.time_limit_s,
            "problems": self._terms.get("problems", {}) | dict(contest.fingerprints),
            "versions": _versions(),
        }
        self._sessions.append(_Session(engine, workers))
        self._append({"terms": self._terms})
        self._append({"session": {"engine": engine, "workers": workers}})

    def add(self, run: Run, *, after_s: float) -> None:
        """Take in a run that was done so many seconds after the session began.

        Raises:
            OutputError: The disk or the rights say no.
        """
        self._append({"run": _as_json(run), "after_s": round(after_s, 3)})
        self._take(run, after_s)

    def _take(self, run: Run, after_s: float) -> None:
        self._runs[key(run)] = run
        self._sessions[-1].lasted_s = after_s
        self._sessions[-1].busy_s += run.seconds

    def _check(self, contest: Contest) -> None:
        """Refuse runs that do not compare with those to come."""
        known = self._terms.get("problems", {})
        for name, fingerprint in contest.fingerprints.items():
            if known.get(name, fingerprint) != fingerprint:
                raise ComparisonForeign(self._path, f"the problem {name}", "another one", "this one")
        for package, here in _versions().items():
            if self._terms.get("versions", {}).get(package, here) != here:
                raise ComparisonForeign(self._path, package, self._terms["versions"][package], here)
        for what in ("budget", "time_limit_s"):
            here = getattr(contest, what)
            if self._terms.get(what, here) != here:
                raise ComparisonForeign(self._path, what, self._terms[what], here)

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
                self._understand(json.loads(line))
            except (ValueError, KeyError, TypeError) as error:
                raise RecordUnreadable(self._path, number, f"{type(error).__name__}: {error}") from None
            self._size += len(line) + 1
        if data and not self._terms:
            raise RecordUnreadable(self._path, 1, "it does not begin with the terms of a comparison")

    def _understand(self, line: dict[str, Any]) -> None:
        if "terms" in line:
            if line["terms"]["format"] != FORMAT:
                raise ValueError(f"format {line['terms']['format']}")
            self._terms = line["terms"]
        elif "session" in line:
            self._sessions.append(_Session(**line["session"]))
        elif not (self._terms and self._sessions):
            raise ValueError("a run before the terms and the session that it belongs to")
        else:
            self._take(_from_json(line["run"]), float(line["after_s"]))


def _versions() -> dict[str, str]:
    """Of what makes the runs."""
    return {package: version(package) for package in PACKAGES}


def _as_json(run: Run) -> dict[str, Any]:
    course = run.course
    return {
        **{name: value for name, value in vars(run).items() if name != "course"},
        "course": [course.evaluations.tolist(), course.seconds.round(6).tolist(), course.costs.tolist()],
    }


def _from_json(run: dict[str, Any]) -> Run:
    evaluations, seconds, costs = run.pop("course")
    return Run(**run, course=Course(np.array(evaluations, np.int64), np.array(seconds, float), np.array(costs, float)))
