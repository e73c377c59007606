"""The individuals of a generation as arrays; pymoo's individuals are made only on demand."""

import math
from collections.abc import Iterable
from copy import copy
from typing import Any, Self, final

import numpy as np
from pymoo.core.individual import Individual, constr_to_cv
from pymoo.core.population import Population

from robolaser.arrays import Array, Bools, Ints

_CONSTRAINTS = ("G", "H")
_DERIVED = ("born", "feas")  # columns that pymoo's individuals work out by themselves, or call otherwise


@final
class PopulationArrays:
    """Individuals side by side, one row each.

    An individual that was handed out replaces its row from then on: changes made to it count.

    Attributes:
        X: Variables, (n, d).
        F: Costs, (n,).
        violation: By how much constraints are violated, (n,); None without constraints.
        columns: Variables X (n, d), costs F (n, 1), generations of birth born (n,) and what else the problem values of
            them, (n, ...) each, by pymoo's names. Where there are constraints CV (n, 1) is by how much they are
            violated and feas (n,) whether that is tolerated.
        evaluated: What pymoo's evaluator notes as evaluated.
        made: Individuals that were handed out, by row.
    """

    __slots__ = ("F", "X", "_home", "columns", "evaluated", "made", "violation")

    def __init__(self, columns: dict[str, Any], evaluated: frozenset[str] = frozenset()) -> None:
        self.columns, self.evaluated = columns, evaluated
        self.X: Array = columns["X"]
        self.F: Array = columns["F"][:, 0]
        self.violation: Array | None = columns["CV"][:, 0] if "CV" in columns else None
        self.made: dict[int, Individual] = {}
        self._home: tuple[PopulationArrays, Ints] | None = None

    @classmethod
    def evaluated_as(cls, X: Array, out: dict[str, Any], born: Ints, evaluated: frozenset[str]) -> Self:
        """Put together what is known of candidates; a cost that is not a number becomes infinite.

        Args:
            X: Candidates, (n, d).
            out: What the problem values of them, (n, ...) each, by pymoo's names.
            born: Their generations of birth, (n,).
            evaluated: What pymoo's evaluator notes as evaluated, besides what is in `out`.
        """
        columns: dict[str, Any] = {"X": X, "born": born}
        for name, value in out.items():
            if value.shape[:1] != (len(X),):
                Population.new(X=X).set(name, value)  # says what is wrong
            if value.size or name not in _CONSTRAINTS:
                columns[name] = value
        F = columns["F"]
        if math.isnan(F.min()):
            columns["F"] = np.where(np.isnan(F), np.inf, F)
        if not columns.keys().isdisjoint(("CV", *_CONSTRAINTS)):
            columns["CV"], columns["feas"] = _violation_of(columns)
        return cls(columns, evaluated.union(out))

    @classmethod
    def of(cls, individuals: Iterable[Individual]) -> Self:
        """Read pymoo's individuals."""
        made = list(individuals)
        columns = {
            "X": np.array([one.X for one in made], np.float64),
            "F": np.array([one.F for one in made], np.float64),
            "G": np.array([one.G for one in made]),
            "H": np.array([one.H for one in made]),
            "CV": np.array([one.CV for one in made]),
            "feas": np.array([one.feas for one in made]),
            "born": np.array([one.data.get("n_iter") or 0 for one in made], np.int64),
        }
        columns = {name: column for name, column in columns.items() if column.size}
        if columns.keys().isdisjoint(_CONSTRAINTS) and not columns["CV"].any():
            del columns["CV"], columns["feas"]
        arrays = cls(columns)
        arrays.made = dict(enumerate(made))
        return arrays

    def __len__(self) -> int:
        return len(self.columns["X"])

    def best(self) -> int:
        """Row of pymoo's optimum: the best that is feasible, else the one that violates least."""
        if self.violation is None:
            return int(self.F.argmin())
        rows = np.flatnonzero(self.columns["feas"])
        return int(rows[self.F[rows].argmin()] if len(rows) else self.violation.argmin())

    def best_cost(self) -> float:
        """Cost of pymoo's optimum; infinite if it is not feasible or no number."""
        row = self.best()
        cost = float(self.F[row])
        tolerated = self.violation is None or self.columns["feas"][row]
        return cost if tolerated and not math.isnan(cost) else math.inf

    def now(self) -> "PopulationArrays":
        """They as they are: those that were handed out may have been changed since."""
        if not self.made:
            return self
        current = PopulationArrays.of(self.made.values())
        if not current.columns.keys() <= self.columns.keys():
            return PopulationArrays.of(map(self.individual, range(len(self))))
        rows = np.fromiter(self.made, np.int64)
        columns = {name: column.copy() for name, column in self.columns.items()}
        for name, column in current.columns.items():
            columns[name][rows] = column
        arrays = PopulationArrays(columns, self.evaluated)
        arrays.made = self.made
        return arrays

    def followed_by(self, offspring: "PopulationArrays", kept: Ints) -> "PopulationArrays":
        """Those of both who live on.

        Args:
            offspring: Of the same problem, made since.
            kept: Rows of both, one after the other; these come first.
        """
        if self.columns.keys() != offspring.columns.keys():
            both = [one.individual(row) for one in (self, offspring) for row in range(len(one))]
            return PopulationArrays.of([both[row] for row in kept])
        current, n = offspring.columns, len(self)
        old, young = kept[kept < n], kept[kept >= n] - n
        columns = {name: _joined(column, old, current[name], young) for name, column in self.columns.items()}
        arrays = PopulationArrays(columns, offspring.evaluated)
        if self.made:
            arrays.made = {to: self.made[row] for to, row in enumerate(kept.tolist()) if row in self.made}
        offspring._home = arrays, kept - n
        return arrays

    def individual(self, row: int) -> Individual:
        """One of them as pymoo's, always the same."""
        if self._home is not None:
            generation, rows = self._home
            for at in np.flatnonzero(rows == row):
                return generation.individual(int(at))
        if row not in self.made:
            self.made[row] = self._new(row)
        return self.made[row]

    def population(self) -> Population:
        """All of them as pymoo's."""
        return Population([self.individual(row) for row in range(len(self))])

    def _new(self, row: int) -> Individual:
        one = Individual(n_gen=int(self.columns["born"][row]), n_iter=int(self.columns["born"][row]))
        for name, column in self.columns.items():
            if name not in _DERIVED:
                one.set(name, copy(column[row]))
        one.evaluated.update(self.evaluated)
        return one


def _joined(one: Array, rows: Ints, other: Array, others: Ints) -> Array:
    """Rows of one array and then of another, in one pass."""
    n = len(rows)
    both = np.empty((n + len(others), *one.shape[1:]), np.result_type(one, other))
    one.astype(both.dtype, copy=False).take(rows, 0, both[:n], "clip")
    other.astype(both.dtype, copy=False).take(others, 0, both[n:], "clip")
    return both


def _violation_of(values: dict[str, Any]) -> tuple[Array, Bools]:
    """Violation, (n, 1), and whether pymoo tolerates it, (n,).

    Args:
        values: Values of n candidates: of G (n, g), which is to be at most 0, H (n, h), which is to be 0,
            and CV (n, 1), the violation itself, those that there are.
    """
    config = Individual.default_config()
    if "CV" in values:
        violation = np.asarray(values["CV"], np.float64)[:, 0]
    else:
        G = _each(values["G"], config["cv_ieq"]) if "G" in values else 0.0
        H = _each(np.abs(values["H"]), config["cv_eq"]) if "H" in values else 0.0
        violation = np.asarray(G + H, np.float64)
    return violation[:, None], violation <= config.get("cv_eps", 0.0)


def _each(excess: Array, rule: dict[str, Any]) -> Array:
    if rule["func"] is np.sum:
        return np.asarray(constr_to_cv(excess, **{**rule, "func": lambda rows: rows.sum(axis=1)}))
    return np.array([constr_to_cv(row, **rule) for row in excess])
