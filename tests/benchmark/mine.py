"""A user's problems and solvers, good and faulty, as in a current directory."""

import contextlib
import os
import time

import numpy as np
from pymoo.core.problem import ElementwiseProblem, Problem

HERE = np.random.default_rng().uniform(-3, 3, 3)


def halving(evaluator, seed):
    """Random steps from the best point, halved after each failure."""
    problem, rng = evaluator.problem, np.random.default_rng(seed)
    x, step, best = problem.sample_uniform(rng)[0], 0.5, np.inf
    while True:
        tries = x + step * (problem.upper - problem.lower) * rng.normal(size=(20, len(x)))
        tries = np.clip(tries, problem.lower, problem.upper)
        costs = evaluator.cost(tries)
        if costs.min() < best:
            x, best = tries[costs.argmin()], costs.min()
        else:
            step = max(step / 2, 1e-12)


def raising(evaluator, seed):
    """Evaluates some candidates and raises an error."""
    evaluator.cost(evaluator.problem.sample_uniform(np.random.default_rng(seed), 10))
    raise RuntimeError("out of ideas")


def not_a_number(evaluator, seed):
    """Evaluates a candidate of NaN."""
    evaluator.cost(np.full((1, evaluator.problem.dimension), np.nan))


def dying(evaluator, seed):
    """Evaluates a candidate and ends its process."""
    evaluator.cost(np.ones((1, evaluator.problem.dimension)))
    os._exit(3)


def hanging(evaluator, seed):
    """Evaluates a candidate and never returns."""
    evaluator.cost(np.ones((1, evaluator.problem.dimension)))
    time.sleep(1000)


def liar(evaluator, seed):
    """Repeatedly tries to reset its count of evaluations."""
    for _ in range(100):
        evaluator.cost(evaluator.problem.sample_uniform(np.random.default_rng(seed), 3))
        for name in ("evaluations", "budget"):
            with contextlib.suppress(AttributeError):
                setattr(evaluator, name, 1000 * (name == "budget"))


def deaf(evaluator, seed):
    """Catches the end of its budget and returns."""
    try:
        while True:
            evaluator.cost(evaluator.problem.sample_uniform(np.random.default_rng(seed), 3))
    except BaseException:
        return


def deaf_and_astray(evaluator, seed):
    """Catches the end of its budget and raises an error."""
    deaf(evaluator, seed)
    raise RuntimeError("out of ideas")


def deaf_for_ever(evaluator, seed):
    """Catches the end of its budget each time, and never returns."""
    while True:
        deaf(evaluator, seed)


class Sphere(Problem):
    """Squared distance to a point, plus a constant."""

    def __init__(self, offset=0.0, n_var=3, lowest=None):
        super().__init__(n_var=n_var, n_obj=1, xl=-5.0, xu=5.0)
        self.offset = offset
        if lowest is not None:
            self.lowest = lowest

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = ((x - 1.0) ** 2).sum(axis=1) + self.offset


SPHERE = Sphere()


class Sampled(Sphere):
    """Its setting has the name of an operator."""

    def __init__(self, sampling=1):
        super().__init__(n_var=sampling)


class Slow(ElementwiseProblem):
    """Slow, and counts its evaluations in a file."""

    def __init__(self, seconds=0.1, count=""):
        super().__init__(n_var=3, n_obj=1, xl=-5.0, xu=5.0)
        self.seconds, self.count = seconds, count

    def _evaluate(self, x, out, *args, **kwargs):
        time.sleep(self.seconds)
        if self.count:
            with open(self.count, "a") as file:
                file.write(".")
        out["F"] = float((x**2).sum())


class Stuck(ElementwiseProblem):
    """Evaluates ten candidates, and hangs at the next."""

    def __init__(self, n_obj=1):
        super().__init__(n_var=3, n_obj=n_obj, xl=-5.0, xu=5.0)
        self.left = 10

    def _evaluate(self, x, out, *args, **kwargs):
        self.left -= 1
        if self.left < 0:
            time.sleep(1000)
        out["F"] = [float(((x - i) ** 2).sum()) for i in range(self.n_obj)]


class Noisy(Problem):
    """A sphere with noise that lowers its cost, drawn from its own generator."""

    def __init__(self, knows=True):
        super().__init__(n_var=3, n_obj=1, xl=-5.0, xu=5.0)
        self.rng = np.random.default_rng(1)
        if knows:
            self.exact = self.without_noise

    def without_noise(self, x):
        return (x**2).sum(axis=1)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = self.without_noise(x) - 100.0 * self.rng.exponential(size=len(x))


class Flaky(ElementwiseProblem):
    """Raises an error for some candidates."""

    def __init__(self):
        super().__init__(n_var=2, n_obj=1, xl=-5.0, xu=5.0)

    def _evaluate(self, x, out, *args, **kwargs):
        if 4.0 < x[0] < 4.5:
            raise RuntimeError("diverged")
        out["F"] = float((x**2).sum())


class Whole(Problem):
    """Squared distance to 7.5, in whole numbers."""

    def __init__(self):
        super().__init__(n_var=3, n_obj=1, xl=0, xu=10, vtype=int)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = ((x - 7.5) ** 2).sum(axis=1)


class Elsewhere(Problem):
    """A different problem in each process."""

    def __init__(self):
        super().__init__(n_var=3, n_obj=1, xl=-5.0, xu=5.0)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = ((x - HERE) ** 2).sum(axis=1)


class Constrained(Problem):
    """A linear cost on a disc, with one equality constraint as well."""

    def __init__(self):
        super().__init__(n_var=2, n_obj=1, n_ieq_constr=1, n_eq_constr=1, xl=-2.0, xu=2.0)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"], out["G"], out["H"] = x.sum(axis=1), (x**2).sum(axis=1) - 1, 0.0 * x[:, :1]
