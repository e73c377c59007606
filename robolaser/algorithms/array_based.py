"""A pymoo algorithm that keeps its generations as arrays, and makes pymoo's populations only for who asks."""

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population

from robolaser.algorithms.population import PopulationArrays
from robolaser.arrays import Array, Ints


class ArrayBased(GeneticAlgorithm, ABC):
    """A genetic algorithm of pymoo's whose `next` goes from array to array where all its parts are known.

    `pop`, `off` and `opt` are pymoo's populations, made when somebody reads them and kept for that generation. Asking
    and telling, another evaluator and parts that are not its own take pymoo's way, with the same outcome.
    """

    problem: Any
    termination: Any
    archive: Any
    is_initialized: bool
    _pop: Any
    _off: Any
    _opt: Any

    @property
    def pop(self) -> Any:
        """The generation, a pymoo Population."""
        if isinstance(self._pop, PopulationArrays):
            self._pop = self._pop.population()
        return self._pop

    @pop.setter
    def pop(self, value: Any) -> None:
        self._pop = value

    @property
    def off(self) -> Any:
        """The offspring that this generation was made with, a pymoo Population."""
        if isinstance(self._off, PopulationArrays):
            self._off = self._off.population()
        return self._off

    @off.setter
    def off(self, value: Any) -> None:
        self._off = value

    @property
    def opt(self) -> Any:
        """The best of the generation, a pymoo Population of one."""
        if isinstance(self._opt, PopulationArrays):
            self._opt = Population.create(self._opt.individual(self._opt.best()))
        return self._opt

    @opt.setter
    def opt(self, value: Any) -> None:
        self._opt = value

    @property
    def arrays(self) -> PopulationArrays:
        """The generation as it is now, as arrays."""
        return self._pop.now() if isinstance(self._pop, PopulationArrays) else PopulationArrays.of(self._pop)

    @arrays.setter
    def arrays(self, arrays: PopulationArrays) -> None:
        self._pop = self._opt = arrays

    def best_cost(self) -> float:
        """Cost of the optimum; infinite if it is not feasible or no number."""
        best = self._opt if isinstance(self._opt, PopulationArrays) else PopulationArrays.of(self._opt)
        return best.best_cost()

    def next(self) -> None:
        """Make the next generation."""
        if not (self._is_itself() and self._evaluates_plainly()):
            super().next()
            return
        if self.is_initialized:
            parents = self.arrays
            off = self._evaluated(self._bred(parents))
            self._pop = parents.followed_by(off, self._kept(parents, off))
        else:
            self._initialize()
            self._pop = off = self._evaluated(self._sampled())
            self.is_initialized = True
        self._off = off
        self._post_advance()
        if self.termination.has_terminated():
            self.finalize()
        if self.archive is not None:
            self.archive = self.archive.add(self.off)

    def _evaluated(self, X: Array) -> PopulationArrays:
        names = self.evaluator.evaluate_values_of
        said = self.problem.evaluate(X.copy(), return_values_of=names, return_as_dictionary=True, algorithm=self)
        out = {name: np.array(value) for name, value in said.items()}  # the problem may keep and change its own
        self.evaluator.n_eval += len(X)
        return PopulationArrays.evaluated_as(X, out, np.full(len(X), self.n_iter), frozenset(names))

    def _set_optimum(self) -> None:
        if isinstance(self._pop, PopulationArrays):
            self._opt = self._pop
        else:
            super()._set_optimum()

    def _infill(self) -> Any:
        return Population.new(X=self._bred(self.arrays)) if self._is_itself() else super()._infill()

    def _evaluates_plainly(self) -> bool:
        evaluator = self.evaluator
        return (
            self.problem is not None
            and type(evaluator) is Evaluator
            and vars(evaluator).keys().isdisjoint(("eval", "_eval"))
            and evaluator.callback is None
            and "F" in evaluator.evaluate_values_of
        )

    @abstractmethod
    def _is_itself(self) -> bool:
        """Whether nobody has put another part in the place of one whose work is done here on arrays."""

    @abstractmethod
    def _sampled(self) -> Array:
        """First candidates, (n, d)."""

    @abstractmethod
    def _bred(self, parents: PopulationArrays) -> Array:
        """Children of a generation, (n, d)."""

    @abstractmethod
    def _kept(self, parents: PopulationArrays, offspring: PopulationArrays) -> Ints:
        """Who live on, (n,): rows of parents and offspring, one after the other."""
