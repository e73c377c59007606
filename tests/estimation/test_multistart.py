"""The global optimum is found whatever the seed, and it is known when it may not have been."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import least_squares

from robolaser.arrays import Array
from robolaser.data.stated_noise import Noise
from robolaser.estimation.multistart import AGREEING, MOST_ROUNDS, multistart
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, Simulated, paper, simulate

WORLDS = {
    "the paper's": lambda: paper(find_robot("scorbot_er7"), seed=1),
    "ten points": lambda: simulate(find_robot("scorbot_er7"), poses=5, points=2, noise=Noise(target_m=3e-4), seed=1),
    "no noise": lambda: simulate(find_robot("ur5"), poses=8, points=5, noise=Noise(), seed=1),
    "unplaced": lambda: simulate(
        find_robot("ur3"), poses=12, points=6, noise=Noise(target_m=2e-4), options=CellOptions(placed=False), seed=1
    ),
}


@pytest.fixture(scope="module", params=list(WORLDS))
def made(request: pytest.FixtureRequest) -> Simulated:
    return WORLDS[request.param]()


@pytest.mark.parametrize("seed", range(5))
def test_every_seed_ends_where_the_truth_does_or_lower(made: Simulated, seed: int) -> None:
    model = Model(made.dataset)
    truth = model.fix_gauge(np.array([made.truth[name] for name in model.parameters.names]))
    known = solve(Problem.of(model), truth[None]).cost[0]
    found = multistart(model, seed=seed)
    assert found.cost <= known * (1 + 1e-6) + 1e-18
    assert found.agreeing >= AGREEING
    assert model.cost(found.x[None])[0] == pytest.approx(found.cost, rel=1e-9, abs=1e-25)


def test_a_descent_ends_where_scipys_does() -> None:
    model = Model(paper(find_robot("scorbot_er7"), seed=2).dataset)
    problem, start = Problem.of(model), model.parameters.nominal
    ours = solve(problem, start[None])
    free = ~problem.fixed

    def fun(z: np.ndarray) -> np.ndarray:
        x = start.copy()
        x[free] = problem.lower[free] + z * problem.scale[free]
        return model.residuals(x[None]).reshape(-1)

    z = (start - problem.lower)[free] / problem.scale[free]
    theirs = least_squares(fun, z, bounds=(0, 1), jac="3-point", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=3000)
    assert ours.cost[0] <= 2 * theirs.cost * (1 + 1e-8)
    assert model.cost(ours.x)[0] == pytest.approx(ours.cost[0], rel=1e-9)


def test_a_start_at_a_pole_spoils_no_other() -> None:
    model = Model(paper(find_robot("scorbot_er7"), seed=2).dataset)
    pole = model.parameters.nominal.copy()
    pole[7], pole[4] = 0.0, model.dataset.points.pixel[0, 1]
    assert not np.isfinite(model.cost(pole[None])[0])
    assert multistart(model, seed=1, starts=pole[None]).cost == pytest.approx(multistart(model, seed=1).cost, rel=1e-9)


def test_an_optimum_that_nothing_confirms_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """With one round and descents that stop early no two ends agree."""
    monkeypatch.setattr("robolaser.estimation.multistart.TOLERANCE", 0.5)
    monkeypatch.setattr("robolaser.estimation.multistart.MOST_ROUNDS", 1)
    assert MOST_ROUNDS > 1
    assert multistart(Model(paper(find_robot("scorbot_er7"), seed=1).dataset), seed=1).agreeing < AGREEING


@pytest.mark.parametrize("made", ["the paper's", "no noise"], indirect=True)
def test_whoever_watches_sees_the_best_fall_round_by_round(made: Simulated, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robolaser.estimation.multistart.AGREEING", 16)  # more than the first round has descents
    model, seen = Model(made.dataset), list[tuple[float, int, Array]]()
    found = multistart(model, seed=1, progress=lambda *so_far: seen.append(so_far))
    costs = [model.cost(x[None])[0] for *_, x in seen]
    screened, descended = costs[::2], costs[1::2]
    assert len(descended) >= 3
    assert all(
        later <= earlier + 1e-12 * screened[0] for earlier, later in pairwise(descended)
    )  # a cost of rounding alone
    assert all(end <= candidate for candidate, end in zip(screened, descended, strict=True))
    assert all(earlier[1] < later[1] for earlier, later in pairwise(seen))
    assert all(earlier[0] <= later[0] <= 1.0 for earlier, later in pairwise(seen))
    assert seen[-1][1] == found.evaluations
    assert np.array_equal(seen[-1][2], found.x)
    assert found.cost == multistart(model, seed=1).cost
