"""A solver that an installed package announces fits like ours, and a broken one is named with its package."""

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from functions import FunctionProblem
from scipy.optimize import check_grad

from robolaser.cli import main
from robolaser.data.dataset import Noise
from robolaser.errors import EstimationError, PluginError, UsageError
from robolaser.estimation.flat_problem import FlatProblem
from robolaser.estimation.least_squares_solver import (
    DEFAULT,
    LeastSquaresSolver,
    minimized,
    solver_named,
    solvers,
)
from robolaser.estimation.problem import Problem
from robolaser.estimation.robust_loss import Loss
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

WORKING = """
from scipy.optimize import least_squares

from robolaser.estimation.flat_problem import FlatProblem
from robolaser.estimation.least_squares_solver import LeastSquaresSolver

CALLS = []

class TrustRegion(LeastSquaresSolver):
    name = "scipy-trf"
    title = "SciPy's trust region reflective"

    def minimize(self, problem, start, *, tol):
        CALLS.append(start)
        flat = FlatProblem(problem)
        end = least_squares(
            flat.residuals, start[flat.free], flat.jacobian, bounds=(flat.lower, flat.upper), x_scale=flat.scale,
            ftol=tol, xtol=1e-15, gtol=None, max_nfev=1000,
        )
        return flat.completed(end.x), end.nfev * (1 + len(end.x))
"""

Install = Callable[[str], None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Put a package that announces a solver where Python finds it."""

    def put(code: str) -> None:
        (tmp_path / "trusting.py").write_text(code, "utf-8")
        info = tmp_path / "trusting-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: trusting\nVersion: 1.0\n", "utf-8")
        (info / "entry_points.txt").write_text("[robolaser.solvers]\nany = trusting:TrustRegion\n", "utf-8")
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.delitem(sys.modules, "trusting", raising=False)

    solvers.cache_clear()
    yield put
    solvers.cache_clear()


@pytest.fixture(scope="module")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("solvers") / "tracked"
    noise = ["--point-m", "2e-5", "--joint-rad", "1e-4", "--effect", "outliers=0.05"]
    cell = ["--robot", "scorbot_er7", "--sensor", "point", "--poses", "25"]
    assert main(["simulate", *cell, *noise, "--output", str(folder)]) == 0
    return folder


def test_from_the_nominal_cell_it_reaches_the_same_cost_as_ours(install: Install) -> None:
    install(WORKING)
    noise = Noise(pixel_px=0.2)
    made = simulate(find_robot("scorbot_er7"), poses=12, points=8, noise=noise, seed=5)
    problem = Problem.of(Model(made.dataset))
    start = problem.parameters.nominal
    ours, _ = minimized(DEFAULT, problem, start, tol=1e-13)
    theirs, _ = minimized(solver_named("scipy-trf"), problem, start, tol=1e-13)
    cost, lowest = problem.costs(np.stack([theirs, ours]))
    assert problem.costs(start[None])[0] > 10 * lowest
    assert cost == pytest.approx(lowest, rel=1e-9)


@pytest.mark.parametrize("fit", [[], ["--weights", "noise"], ["--loss", "huber"], ["--loss", "cauchy"]])
def test_calibrate_takes_it_by_name_and_finds_the_same(
    fit: list[str], install: Install, tracked: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install(WORKING)
    found = []
    for solver in ("levenberg-marquardt", "scipy-trf"):
        words = ["calibrate", str(tracked), "--output", str(tmp_path / solver), "--solver", solver, *fit, "--json"]
        assert main(words) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert sys.modules["trusting"].CALLS
    ours, theirs = found
    assert theirs["objective_m2"] == pytest.approx(ours["objective_m2"], rel=1e-7)
    for name, value in ours["parameters"].items():
        assert theirs["parameters"][name]["value"] == pytest.approx(value["value"], abs=0.001 * value["std"]), name


def test_it_is_listed_beside_ours(install: Install, capsys: pytest.CaptureFixture[str]) -> None:
    install(WORKING)
    assert main(["list", "solvers", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["solvers"]
    assert [entry["solver"] for entry in listed] == ["levenberg-marquardt", "scipy-trf"]


def test_an_incomplete_solver_is_named_with_its_package(install: Install) -> None:
    install(WORKING.replace("def minimize", "def minimise"))
    with pytest.raises(PluginError, match=r"trusting announces trusting:TrustRegion .* does not define minimize"):
        solvers()


def test_a_name_of_ours_is_taken(install: Install) -> None:
    install(WORKING.replace("scipy-trf", "levenberg-marquardt"))
    with pytest.raises(PluginError, match=r"the solver 'levenberg-marquardt', but robolaser has one of that name"):
        solvers()


def test_an_unknown_solver_is_wrong_usage_that_names_the_likeliest(install: Install) -> None:
    install(WORKING)
    with pytest.raises(UsageError, match=r"No solver 'scipy-tfr'\. Did you mean 'scipy-trf'\?"):
        solver_named("scipy-tfr")


@pytest.mark.parametrize(
    ("end", "reason"),
    [
        (np.array([2.0, 0.0]), "1 of 2 parameters outside their bounds"),
        (np.array([np.nan, 0.0]), "1 of 2 parameters outside their bounds or not finite"),
        (np.zeros(3), r"shape \(3,\), expected \(2,\)"),
    ],
)
def test_an_end_that_is_no_answer_is_an_error_that_names_the_solver(end: np.ndarray, reason: str) -> None:
    class Astray(LeastSquaresSolver):
        name = "astray"
        title = "goes anywhere"

        def minimize(self, problem, start, *, tol):
            return end, 1

    problem = FunctionProblem(lambda x: x, np.zeros(2), np.full(2, -1.0), np.full(2, 1.0))
    with pytest.raises(EstimationError, match=f"The solver astray .*{reason}"):
        minimized(Astray(), problem, np.zeros(2), tol=1e-9)


@pytest.mark.parametrize("loss", ["square", "huber", "cauchy"])
def test_a_flat_problem_has_the_cost_and_the_derivatives_of_the_whole(loss: str) -> None:
    whole = Problem.of(Model(simulate(find_robot("scorbot_er7"), poses=4, points=4, seed=3).dataset))
    x = whole.parameters.nominal
    scale = 0.5 * float(np.median(np.abs(whole.residuals(x[None]))))
    whole = whole.with_noise(None, Loss(loss, 1.0 if loss == "square" else scale))
    flat = FlatProblem(whole)
    r, J = flat.residuals(x[flat.free]), flat.jacobian(x[flat.free])
    assert r @ r == pytest.approx(whole.costs(x[None])[0], rel=1e-12)
    assert J.shape == (len(r), np.count_nonzero(~whole.fixed))
    slope = check_grad(
        lambda y: 1e6 * np.square(flat.residuals(y * flat.scale)).sum(),
        lambda y: 2e6 * flat.scale * (flat.jacobian(y * flat.scale).T @ flat.residuals(y * flat.scale)),
        x[flat.free] / flat.scale,
        epsilon=1e-7,
    )
    assert slope < 1e-4 * np.linalg.norm(2e6 * flat.scale * (J.T @ r))
