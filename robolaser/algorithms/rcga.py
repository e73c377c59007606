"""The real-coded genetic algorithm of Lee et al. 2004, figure 4."""

import math
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.core.duplicate import NoDuplicateElimination
from pymoo.core.evaluator import Evaluator
from pymoo.core.individual import Individual
from pymoo.core.mating import Mating
from pymoo.core.population import Population
from pymoo.core.repair import NoRepair
from pymoo.core.variable import get
from pymoo.operators.sampling.rnd import FloatRandomSampling
from pymoo.util.display.single import SingleObjectiveOutput

from robolaser.algorithms.stopping import Stalled, several_objectives
from robolaser.algorithms.user_code import keywords
from robolaser.arrays import Array, Ints
from robolaser.errors import AlgorithmError
from robolaser.operators import ArithmeticCrossover, ElitistReplacement, NonUniformMutation, RouletteSelection
from robolaser.operators.arithmetic_crossover import arithmetic
from robolaser.operators.bounds import check_share, finite_bounds
from robolaser.operators.elitist_replacement import survivors
from robolaser.operators.non_uniform_mutation import non_uniform, step_size
from robolaser.operators.roulette_selection import inverse_cost, roulette_wheel

ELITES = 0.1
"""Share of elites in the population. The paper does not state it; from 1 to 20 of 100 it makes little difference, on
Ackley's function 6 to 20 end three times closer than 1 or 2."""

EVALUATED = ["F", "G", "H"]  # the values that pymoo's evaluator requests of a problem by default

_BELONGS_TO = {"prob_crossover": "crossover", "prob_var": "mutation", "b": "mutation", "n_elites": "survival"}
"""The operator that takes each setting."""


@final
@dataclass(frozen=True, eq=False)
class Generation:
    """Individuals as arrays, until pymoo's are requested."""

    X: Array  # variables, (n, d)
    F: Array  # costs, (n,)
    born: Ints  # generations of birth, (n,)

    def individual(self, row: int) -> Individual:
        """One of them as pymoo's."""
        born = int(self.born[row])
        one = Individual(n_gen=born, n_iter=born)
        one.X, one.F = self.X[row].copy(), self.F[[row]]
        one.evaluated.update(EVALUATED)
        return one


@final
class RCGA(GeneticAlgorithm):
    """Elites, roulette, arithmetic crossover and non-uniform mutation, with the settings of the paper.

    It stops after 10 000 generations without a better cost, unless it is given another termination, such as
    `Stalled(500)` or `("fmin", 1e-6)`. The last generation T of the mutation is the termination's, see
    `NonUniformMutation`. A cost that is not a number counts as infinite.

    The seed determines a run. Draws, in this order, for N individuals, E elites, d variables and M = ⌈(N − E)/2⌉ pairs:
    first random((N, d)), the initial population; then in each generation random((M, 2)), the parents on the
    wheel; random(M), crossed where below `prob_crossover`; if any is, random((M, 1)), λ; random((2M, d)), moved
    where below `prob_var`, the first children of all pairs before the second ones; for the h genes that move,
    row by row, random(h), up where below 0.5, and random(h), r; random(2M), which pymoo's mutation draws without
    effect. The last child is dropped where N − E is odd.

    Args:
        pop_size: Individuals N.
        n_elites: Best individuals E that pass to the next generation unchanged; a tenth of N by default.
        prob_crossover: Probability that a pair is crossed.
        prob_var: Mutation rate: probability that a gene is moved.
        b: Non-uniformity of the mutation.
        kwargs: More for pymoo's `GeneticAlgorithm`: `termination`, `sampling`, `repair`, `eliminate_duplicates` and
            others, and other operators as `selection`, `crossover`, `mutation` and `survival`, with their own settings.

    Raises:
        AlgorithmError: A setting makes no sense, or belongs to an operator that is replaced; in `setup`, if the problem
            has more than one objective, variables that are not real numbers or one without finite bounds.

    Examples:
        >>> from robolaser.algorithms import RCGA
        >>> result = minimize(sphere, RCGA(pop_size=40), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    archive: Any
    _pop: Any
    _off: Any
    _opt: Any
    _rows: Ints  # of `off`, where the individuals of `pop` are from; below 0: they are older

    def __init__(
        self,
        pop_size: int = 100,
        *,
        n_elites: int | None = None,
        prob_crossover: float = 0.85,
        prob_var: float = 0.1,
        b: float = 5.0,
        **kwargs: Any,
    ) -> None:
        given = {"prob_crossover": prob_crossover, "prob_var": prob_var, "b": b, "n_elites": n_elites}
        _settings_of_parts_in_use(given, kwargs)
        for name in sorted(kwargs.keys() - {*keywords(GeneticAlgorithm)[0]}):
            raise AlgorithmError(f"RCGA has no setting '{name}', and neither has pymoo's GeneticAlgorithm.")
        if pop_size < 1:
            raise AlgorithmError(f"RCGA: pop_size is {pop_size!r}, expected at least 1.")
        if "survival" in kwargs:
            n_elites = getattr(kwargs["survival"], "n_elites", 0)
        elif n_elites is None:
            n_elites = min(max(round(ELITES * pop_size), 1), pop_size - 1)
        if not 0 <= n_elites < pop_size:
            raise AlgorithmError(f"RCGA: n_elites is {n_elites!r}, expected 0 to {pop_size - 1}, below pop_size.")
        check_share("RCGA", "prob_crossover", prob_crossover)
        check_share("RCGA", "prob_var", prob_var)
        parts: dict[str, Any] = {
            "n_offsprings": pop_size - n_elites,
            "sampling": FloatRandomSampling(),
            "selection": RouletteSelection(),
            "crossover": ArithmeticCrossover(prob=prob_crossover),
            "mutation": NonUniformMutation(prob_var=prob_var, b=b),
            "survival": ElitistReplacement(n_elites),
            "eliminate_duplicates": False,
            "termination": Stalled(),
            "output": SingleObjectiveOutput(),
        }
        super().__init__(pop_size=pop_size, **parts | kwargs)

    def _setup(self, problem: Any, **kwargs: Any) -> None:
        if problem.n_obj != 1:
            raise several_objectives("RCGA", problem.n_obj)
        if getattr(problem, "vars", None) is not None:
            raise AlgorithmError(
                f"RCGA works on vectors of real numbers; {type(problem).__name__} declares its variables one by"
                " one with `vars`. State n_var, xl and xu instead, or use pymoo's MixedVariableGA."
            )
        if getattr(problem, "vtype", None) in (int, bool) and type(self.repair) is NoRepair:
            raise AlgorithmError(
                f"RCGA works on real numbers; the variables of {type(problem).__name__} are whole numbers. Pass"
                " RCGA(repair=RoundingRepair()), pymoo's, which rounds each candidate."
            )
        finite_bounds(problem, "RCGA")

    @property
    def pop(self) -> Any:
        """The generation, a pymoo Population."""
        self._make_individuals()
        return self._pop

    @pop.setter
    def pop(self, value: Any) -> None:
        self._pop = value

    @property
    def off(self) -> Any:
        """The offspring of this generation, a pymoo Population."""
        self._make_individuals()
        return self._off

    @off.setter
    def off(self, value: Any) -> None:
        self._off = value

    @property
    def opt(self) -> Any:
        """The best of the generation, a pymoo Population of one."""
        if self._opt is None and isinstance(self._pop, Generation):
            self._opt = Population.create(self._pop.individual(int(self._pop.F.argmin())))
        return self._opt

    @opt.setter
    def opt(self, value: Any) -> None:
        self._opt = value

    @property
    def arrays(self) -> tuple[Array, Array]:
        """The generation's variables and costs, (n, d) and (n,)."""
        if isinstance(self._pop, Generation):
            return self._pop.X, self._pop.F
        X, F = self._pop.get("X", "F")
        return np.asarray(X, np.float64), np.asarray(F[:, 0], np.float64)

    @arrays.setter
    def arrays(self, arrays: tuple[Array, Array]) -> None:
        self._pop = self._off = Generation(*arrays, np.full(len(arrays[0]), self.n_iter))
        self._rows = np.arange(len(arrays[0]))

    def _make_individuals(self) -> None:
        """From now on generations are pymoo's, since callers may keep and change their individuals."""
        if isinstance(self._pop, Generation):
            best, opt = int(self._pop.F.argmin()), self.opt[0]
            young = [self._off.individual(row) for row in range(len(self._off.F))]
            if self._rows[best] >= 0:
                young[self._rows[best]] = opt
            members = [young[row] if row >= 0 else self._pop.individual(i) for i, row in enumerate(self._rows)]
            members[best] = opt
            self._pop, self._off = Population(members), Population(young)

    def next(self) -> None:
        """Make the next generation, as arrays unless pymoo's individuals have been requested."""
        if not (isinstance(self._pop, Generation) and self._is_itself()):
            super().next()
            return
        X, old = self._bred(), self._pop
        values = self.problem.evaluate(X.copy(), return_values_of=EVALUATED, return_as_dictionary=True, algorithm=self)
        self.evaluator.n_eval += len(X)
        X, F = values.get("X", X), values["F"][:, 0]
        off = Generation(X, np.where(np.isnan(F), np.inf, F), np.full(len(X), self.n_iter))
        n = len(old.F)
        kept = survivors(old.F, off.F, self.survival.n_elites, min(self.pop_size, n + len(X)))
        X, F = np.concatenate((old.X, off.X)), np.concatenate((old.F, off.F))
        born = np.concatenate((old.born, off.born))
        self._pop, self._off, self._rows = Generation(X[kept], F[kept], born[kept]), off, kept - n
        self._post_advance()
        if self.termination.has_terminated():
            self.finalize()
        if self.archive is not None:
            self.archive = self.archive.add(self.off)

    def _set_optimum(self) -> None:
        if isinstance(self._pop, Generation):
            self._opt = None
        else:
            super()._set_optimum()

    def _is_itself(self) -> bool:
        mating, evaluator = self.mating, self.evaluator
        return (
            type(self) is RCGA
            and type(evaluator) is Evaluator
            and evaluator.callback is None
            and evaluator.evaluate_values_of == EVALUATED
            and type(mating) is Mating
            and type(mating.repair) is NoRepair
            and type(mating.eliminate_duplicates) is NoDuplicateElimination
            and _is_plainly(mating.selection, RouletteSelection)
            and _is_plainly(mating.crossover, ArithmeticCrossover)
            and _is_plainly(mating.mutation, NonUniformMutation)
            and type(self.survival) is ElitistReplacement
        )

    def _bred(self) -> Array:
        crossover, mutation, rng = self.mating.crossover, self.mating.mutation, self.random_state
        n, d = math.ceil(self.n_offsprings / 2), self.problem.n_var

        coins = rng.random(3 * n)
        crossed = coins[2 * n :] < get(crossover.prob)
        share = rng.random(n) if crossed.any() else np.zeros(n)
        moved = rng.random((2 * n, d)) < mutation.get_prob_var(self.problem)
        h = np.count_nonzero(moved)
        upward, r, draws = np.split(rng.random(2 * h + 2 * n), (h, 2 * h))
        steps = step_size(r, mutation.progress_of(self), get(mutation.b))

        Y = mates = self._pop.X.take(roulette_wheel(inverse_cost(self._pop.F), coins[: 2 * n].reshape(n, 2)).T, 0)
        if crossed.any():
            Y = arithmetic(mates, share[:, None])
            np.copyto(Y, mates, where=~crossed[:, None])
        Y = Y.reshape(2 * n, d)
        lower, upper = np.asarray(self.problem.xl, np.float64), np.asarray(self.problem.xu, np.float64)
        mutants = np.minimum(np.maximum(Y, lower), upper)
        at = moved.reshape(-1).nonzero()[0]
        genes, gene = mutants.reshape(-1), at % d
        genes[at] = non_uniform(genes[at], lower[gene], upper[gene], upward < 0.5, steps)
        if (prob := float(get(mutation.prob))) < 1.0:
            mutants = np.where(draws[:, None] <= prob, mutants, Y)
        return np.asarray(mutants[: self.n_offsprings])

    def _initialize_advance(self, infills: Any = None, **kwargs: Any) -> None:
        _never_nan(infills)
        super()._initialize_advance(infills=infills, **kwargs)
        more = self.problem.has_constraints() or any(one.data.keys() - {"n_gen", "n_iter"} for one in infills)
        if self._pop is infills and not more:
            self.arrays = self.arrays

    def _advance(self, infills: Any = None, **kwargs: Any) -> Any:
        _never_nan(infills)
        return super()._advance(infills=infills, **kwargs)


def _settings_of_parts_in_use(given: dict[str, Any], replaced: dict[str, Any]) -> None:
    """Refuse a setting of an operator that another one replaces."""
    for name, slot in _BELONGS_TO.items():
        if slot in replaced and given[name] != (RCGA.__init__.__kwdefaults__ or {})[name]:
            raise AlgorithmError(
                f"RCGA: {name} belongs to the paper's {slot}, which {type(replaced[slot]).__name__} replaces."
                f" State either {name} or {slot}."
            )


def _is_plainly(operator: Any, kind: Any) -> bool:
    return type(operator) is kind and operator.repair is None and operator.vtype is None


def _never_nan(pop: Any) -> None:
    """Make costs that are not numbers infinite: pymoo's optimum would be the first of them."""
    F = pop.get("F")
    if np.isnan(F).any():
        pop.set("F", np.where(np.isnan(F), np.inf, F))
