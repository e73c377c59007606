"""The individuals of a generation as arrays, which become pymoo's only where somebody asks for them."""

import math
from collections.abc import Iterable
from copy import copy
from typing import Any, Self, final

import numpy as np
from pymoo.core.individual import Individual
from pymoo.core.population import Population

from robolaser.algorithms.violation import violation_of
from robolaser.arrays import Array, Ints

_CONSTRAINTS = ("G", "H")
_DERIVED = ("born", "feas")
"""Columns that pymoo's individuals work out by themselves, or call otherwise."""


@final
class Members:
    """Individuals side by side, one row each.

    An individual that was handed out is the truth about itself from then on: what its new owner changes in it holds.

    Attributes:
        X: Variables, (n, d).
        F: Costs, (n,).
        violation: By how much constraints are violated, (n,); None without constraints.
        columns: Variables X (n, d), costs F (n, 1), generations of birth born (n,) and what else the problem said of
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
        self._home: tuple[Members, int, Ints] | None = None

    @classmethod
    def evaluated_as(cls, X: Array, out: dict[str, Any], born: Ints) -> Self:
        """Put together candidates (n, d), what the problem said of them, and their generations of birth (n,).

        A cost that is not a number becomes infinite.
        """
        columns = {"X": X, **{name: value for name, value in out.items() if value.size or name not in _CONSTRAINTS}}
        if any(column.shape[:1] != (len(X),) for column in columns.values()):
            Population.new(X=X).set(**out)  # says what is wrong
        columns["born"] = born
        if np.isnan(columns["F"]).any():
            columns["F"] = np.where(np.isnan(columns["F"]), np.inf, columns["F"])
        if not columns.keys().isdisjoint(("CV", *_CONSTRAINTS)):
            columns["CV"], columns["feas"] = violation_of(columns)
        return cls(columns, frozenset(out))

    @classmethod
    def of(cls, individuals: Iterable[Individual]) -> Self:
        """Read pymoo's individuals."""
        made = list(individuals)
        names = ("X", "F", "G", "H", "CV", "feas", "n_iter")
        columns = dict(zip(names, Population(made).get(*names), strict=True))
        columns["born"] = np.array([generation or 0 for generation in columns.pop("n_iter")], np.int64)
        for name in ("X", "F"):
            columns[name] = np.asarray(columns[name], np.float64)
        columns = {name: column for name, column in columns.items() if column.size}
        if columns.keys().isdisjoint(("G", "H")) and not columns["CV"].any():
            del columns["CV"], columns["feas"]
        members = cls(columns)
        members.made = dict(enumerate(made))
        return members

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

    def now(self) -> "Members":
        """They as they are: those that were handed out may have been changed since."""
        if not self.made:
            return self
        told = Members.of(self.made.values())
        if not told.columns.keys() <= self.columns.keys():
            return Members.of(map(self.individual, range(len(self))))
        rows = np.fromiter(self.made, np.int64)
        columns = {name: column.copy() for name, column in self.columns.items()}
        for name, column in told.columns.items():
            columns[name][rows] = column
        members = Members(columns, self.evaluated)
        members.made = self.made
        return members

    def followed_by(self, offspring: "Members", kept: Ints) -> "Members":
        """Those of both, one after the other, who live on: first some of these, then some offspring, in their order.

        Args:
            offspring: Of the same problem.
            kept: Rows of both, joined.
        """
        n_own = int(np.count_nonzero(kept < len(self)))
        own, young = kept[:n_own], kept[n_own:] - len(self)
        if self.columns.keys() != offspring.columns.keys():
            return Members.of([*map(self.individual, own), *map(offspring.individual, young)])
        columns = {
            name: np.concatenate((column.take(own, 0), offspring.columns[name].take(young, 0)))
            for name, column in self.columns.items()
        }
        members = Members(columns, offspring.evaluated)
        if self.made:
            members.made = {to: self.made[row] for to, row in enumerate(own.tolist()) if row in self.made}
        offspring._home = members, n_own, young
        return members

    def individual(self, row: int) -> Individual:
        """One of them as pymoo's, always the same."""
        if self._home is not None:
            pop, first, rows = self._home
            at = int(np.searchsorted(rows, row))
            if at < len(rows) and rows[at] == row:
                return pop.individual(first + at)
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
