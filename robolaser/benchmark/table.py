"""The table of a benchmark: a run is a row, and is on disk as soon as it is done.

A SQLite database in WAL mode: several processes may add runs to it at the same time, and whoever is killed loses no run
that was added. A row of `runs` is a run, a row of `trajectory` an improvement of it, a row of `bests` its best
candidates, with several objectives those that nothing dominates (JSON); `problems`, `solvers`, `refused`, `sessions`
and `conditions` say what was run and where.
"""

import json
import sqlite3
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.evaluator import ConvergenceTrace
from robolaser.benchmark.plan import RunPlan, best_known, fingerprint
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult, Effort
from robolaser.benchmark.single_run import DONE, BenchmarkRun, Key
from robolaser.errors import BenchmarkError, OutputError, unwritable

NAME = "runs.sqlite"
"""Of the file in a result's folder."""
FILES = (NAME, f"{NAME}-wal", f"{NAME}-shm")
"""All files that SQLite keeps while runs are made."""
APPLICATION, FORMAT = 0x726C6273, 2
"""What SQLite's header says of such a file: whose it is, and in which format."""
WAIT_S = 60.0
"""Time that one writer waits for another."""
LOWER = 1e-9
"""A solver has improved the best known cost only if it is lower by more than this share."""

SCHEMA = f"""
create table conditions (name text primary key, value text not null) without rowid;
create table problems (name text unique not null, title text, family text, dimension integer, unit text, scale real,
                       best real, found_by text, fingerprint text);
create table solvers (name text unique not null, title text);
create table refused (problem text, algorithm text, reason text, unique (problem, algorithm));
create table sessions (id integer primary key, engine text, workers integer, lasted_s real, busy_s real);
create table runs (id integer primary key, problem text, algorithm text, seed integer, state text, reason text,
                   evaluations integer, seconds real, processor_s real, best real, violation real,
                   unique (problem, algorithm, seed));
create table bests (run integer primary key, x text, objectives text);
create table trajectory (run integer, evaluations integer, seconds real, cost real,
                         primary key (run, evaluations)) without rowid;
pragma application_id = {APPLICATION};
pragma user_version = {FORMAT};
"""


@final
class RunTable:
    """The runs of a benchmark, with all that is needed to rank them.

    Args:
        path: The file, created where it is not there; None: in memory.
        readonly: Only read it.

    Raises:
        BenchmarkError: The file is not such a table, is damaged, or is of a later format.
        OutputError: The file cannot be written.
    """

    def __init__(self, path: Path | None = None, *, readonly: bool = False) -> None:
        self._path, self._session = path, 0
        self.failed: dict[Key, float] = {}  # how long runs took that were added and failed [s]
        where = ":memory:" if path is None else f"{path.resolve().as_uri()}?mode={'ro' if readonly else 'rwc'}"
        with self._explained():
            self._db = sqlite3.connect(where, timeout=WAIT_S, isolation_level=None, uri=path is not None)
        try:
            if not readonly and self._is_empty():
                with self._written():
                    for statement in SCHEMA.split(";") if self._is_empty() else ():  # unless another writer was faster
                        self._db.execute(statement)
            found = [self._rows(f"pragma {name}")[0][0] for name in ("application_id", "user_version")]
            if found != [APPLICATION, FORMAT]:
                raise self._unreadable(
                    f"format {found[1]}, expected {FORMAT}" if found[0] == APPLICATION else "another program's"
                )
        except BaseException:
            self._db.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, which is then all that there is: SQLite's others are gone, unless somebody else writes."""
        with suppress(sqlite3.Error):
            self._db.execute("pragma busy_timeout = 0")
            self._db.execute("pragma journal_mode = delete")
        self._db.close()

    def begin(self, plan: RunPlan, *, engine: str, workers: int) -> None:
        """Open a session, in which runs of a plan are made so many at a time.

        Raises:
            BenchmarkError: The runs in the table were made under other conditions.
            OutputError: The file cannot be written.
        """
        conditions: dict[str, Any] = {
            "budget": plan.budget,
            "time_limit_s": plan.time_limit_s,
            **{f"version of {package}": _version(package) for package in plan.packages},
        }
        with suppress(OutputError):  # while another writer begins; it is safe without, only slower
            self._rows("pragma journal_mode = wal")
        self._rows("pragma synchronous = normal")
        prints = {problem.name: fingerprint(problem) for problem in plan.problems}
        known = dict(self._rows("select name, fingerprint from problems"))
        best = {problem.name: best_known(problem) for problem in plan.problems if problem.name not in known}
        with self._written():
            there = self._conditions()
            for name, value in conditions.items():
                if there.get(name, value) != value:
                    raise self._incomparable(name, there[name], value)
            for name, print_ in prints.items():
                if known.get(name, print_) != print_:
                    raise self._incomparable(f"the problem {name}", "another one", "this one")
            conditions["dropped"] = plan.dropped
            conditions["seeds"] = sorted({*there.get("seeds", ()), *plan.seeds})
            self._insert("conditions", ((name, json.dumps(value)) for name, value in conditions.items()), "replace")
            self._insert(
                "problems",
                (
                    (p.name, p.title, p.family, p.dimension, p.unit, p.scale, *best[p.name], prints[p.name])
                    for p in plan.problems
                    if p.name in best
                ),
            )
            self._insert("solvers", ((solver.name, solver.title) for solver in plan.solvers))
            self._insert("refused", ((*pair, reason) for pair, reason in plan.refused.items()), "replace")
            self._session = self._insert("sessions", [(None, engine, workers, 0.0, 0.0)])

    def add(self, run: BenchmarkRun, *, after_s: float) -> None:
        """Add a run that was done so many seconds after the session began; it replaces one of the same key."""
        if run.state != DONE:
            self.failed[run.key] = run.seconds
        trace, best = run.trace, run.trace.final if len(run.trace.costs) else None
        with self._written():
            for table in ("trajectory", "bests"):
                which = "(select id from runs where (problem, algorithm, seed) = (?, ?, ?))"
                self._db.execute(f"delete from {table} where run = {which}", run.key)
            told = (run.state, run.reason, run.evaluations, run.seconds, run.processor_s, best, run.violation)
            at = self._insert("runs", [(None, *run.key, *told)], "replace")
            rows = zip(trace.evaluations.tolist(), trace.seconds.tolist(), trace.costs.tolist(), strict=True)
            self._insert("trajectory", ((at, *row) for row in rows))
            self._insert("bests", [(at, _json(run.x), _json(run.front))])
            self._db.execute(
                "update sessions set lasted_s = max(lasted_s, ?), busy_s = busy_s + ? where id = ?",
                (after_s, run.seconds, self._session),
            )

    @property
    def begun(self) -> bool:
        """Whether a session is open."""
        return bool(self._session)

    def __len__(self) -> int:
        """Number of runs."""
        return int(self._rows("select count(*) from runs")[0][0])

    def made(self) -> Mapping[Key, float]:
        """How long each run took that did not fail and need not be made again [s]."""
        rows = self._rows("select problem, algorithm, seed, seconds from runs where state = ?", (DONE,))
        return {(problem, algorithm, seed): seconds for problem, algorithm, seed, seconds in rows}

    def result(self, plan: RunPlan | None = None) -> BenchmarkResult:
        """The result so far, of a plan or of all that is there."""
        conditions = self._conditions()
        problems = [ProblemSummary(*row[:-1]) for row in self._rows("select * from problems order by rowid")]
        solvers = dict(self._rows("select * from solvers order by rowid"))
        seeds = tuple(conditions.get("seeds", ()))
        if plan is not None:
            of_name = {problem.name: problem for problem in problems}
            problems = [of_name[spec.name] for spec in plan.specs if spec.name in of_name]
            solvers = {solver.name: solver.title for solver in plan.solvers}
            seeds = plan.seeds
        names = {problem.name for problem in problems}
        runs = tuple(self._runs(names, solvers, seeds))
        engine, workers = (self._rows("select engine, workers from sessions order by id desc limit 1") or [("", 0)])[0]
        effort = "select total(lasted_s), total(lasted_s * workers), total(busy_s) from sessions"
        return BenchmarkResult(
            problems=tuple(_measured(problem, runs) for problem in problems),
            solvers=solvers,
            refused={
                (problem, algorithm): reason
                for problem, algorithm, reason in self._rows("select * from refused order by rowid")
                if problem in names and algorithm in solvers
            },
            seeds=seeds,
            budget=conditions.get("budget", 0),
            time_limit_s=conditions.get("time_limit_s", 0.0),
            runs=runs,
            dropped=conditions.get("dropped", {}) if plan is None else plan.dropped,
            effort=Effort(engine, workers, *self._rows(effort)[0]),
        )

    def _runs(
        self, problems: Collection[str], solvers: Collection[str], seeds: Collection[int]
    ) -> Iterator[BenchmarkRun]:
        rows = self._rows("select * from runs order by id")
        improvements = np.array(
            self._rows("select run, evaluations, seconds, cost from trajectory order by run, evaluations"), float
        ).reshape(-1, 4)
        bests = {at: (_array(x), _array(front)) for at, x, front in self._rows("select * from bests")}
        for at, problem, algorithm, seed, state, reason, evaluations, seconds, processor_s, _, violation in rows:
            if problem in problems and algorithm in solvers and seed in seeds:
                of_run = improvements[slice(*np.searchsorted(improvements[:, 0], [at, at + 1]))]
                trace = ConvergenceTrace(of_run[:, 1].astype(np.int64), of_run[:, 2], of_run[:, 3])
                told = (state, reason, evaluations, seconds, processor_s)
                x, front = bests[at]
                yield BenchmarkRun(problem, algorithm, seed, *told, trace, violation, front, x)

    def _is_empty(self) -> bool:
        return not self._rows("select count(*) from sqlite_master")[0][0]

    def _conditions(self) -> dict[str, Any]:
        return {name: json.loads(value) for name, value in self._rows("select * from conditions")}

    def _rows(self, query: str, values: tuple[object, ...] = ()) -> list[Any]:
        with self._explained():
            return self._db.execute(query, values).fetchall()

    def _insert(self, table: str, rows: Any, otherwise: str = "ignore") -> int:
        """Add rows, and return the number of the last."""
        at = 0
        for row in rows:
            places = ", ".join("?" * len(row))
            at = self._db.execute(f"insert or {otherwise} into {table} values ({places})", row).lastrowid or 0
        return at

    @contextmanager
    def _written(self) -> Iterator[None]:
        """All of it or nothing, while no other process writes."""
        with self._explained():
            self._db.execute("begin immediate")
            try:
                yield
            except BaseException:
                self._db.execute("rollback")
                raise
            self._db.execute("commit")

    @contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.OperationalError as error:
            raise unwritable(self._path or Path(":memory:"), str(error)) from None
        except sqlite3.DatabaseError as error:
            raise self._unreadable(str(error)) from None

    def _unreadable(self, reason: str) -> BenchmarkError:
        return BenchmarkError(
            f"{self._path} is not a table of benchmark runs that can be read ({reason})."
            " Use another folder, or start over with --force."
        )

    def _incomparable(self, what: str, there: object, here: object) -> BenchmarkError:
        return BenchmarkError(
            f"{self._path} holds runs under other conditions: {what} is {there} there, here it is {here}, and such runs"
            " are not comparable. Continue under the same conditions, use another folder, or start over with --force."
        )


def load(path: str | Path) -> BenchmarkResult:
    """Read the runs of a comparison, finished or not, from its folder or the file `runs.sqlite` in it.

    `load(path).to_frame()` has a row for each run.

    Raises:
        BenchmarkError: There is no such table.

    Examples:
        >>> from robolaser.benchmark import load
        >>> from robolaser.cli import main
        >>> typed = "compare pymoo:sphere-2 --algorithms de --seeds 1 --budget 100 --output race --quiet"
        >>> main(typed.split())
        0
        >>> load("race").to_frame()["state"].tolist()
        ['done']
    """
    file = Path(path) / NAME if Path(path).is_dir() else Path(path)
    if not file.is_file():
        raise BenchmarkError(f"No runs in {path}: expected the folder of a comparison, or the file {NAME} in it.")
    with RunTable(file, readonly=True) as table:
        return table.result()


def starting_points(path: str | Path) -> Mapping[str, Array]:
    """What the runs of an earlier comparison left to begin with: their best candidates, (k, d), by problem.

    The lowest cost comes first; of several objectives there are those that nothing of the same run dominates.
    """
    found: dict[str, list[Array]] = {}
    for run in sorted(load(path).runs, key=lambda run: run.trace.final):
        if run.x is not None and len(run.x):
            found.setdefault(run.problem, []).append(run.x)
    return {name: np.concatenate(x) for name, x in found.items()}


def _json(array: Array | None) -> str | None:
    return None if array is None else json.dumps(array.tolist())


def _array(text: str | None) -> Array | None:
    return None if text is None else np.array(json.loads(text), float)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _measured(problem: ProblemSummary, runs: Collection[BenchmarkRun]) -> ProblemSummary:
    """With the lowest cost that anybody found, and targets in units of it unless it is close to zero."""
    best, found_by = problem.best, problem.found_by
    for run in runs:
        lower = best - LOWER * abs(best) if np.isfinite(best) else best
        if run.problem == problem.name and run.trace.final < lower:
            best, found_by = run.trace.final, run.algorithm
    scale = max(abs(best), problem.scale) if np.isfinite(best) else problem.scale
    return replace(problem, scale=scale, best=best, found_by=found_by)
