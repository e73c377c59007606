"""A run that is taken up again goes on as if it had never stopped."""

import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.ga import GA, FitnessSurvival
from pymoo.core.problem import Problem
from pymoo.core.termination import TerminateIfAny
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.operators.repair.rounding import RoundingRepair
from pymoo.operators.selection.rnd import RandomSelection
from pymoo.problems import get_problem
from pymoo.termination import get_termination

from robolaser.algorithms import RCGA, CostReached, Stalled
from robolaser.algorithms.checkpoint import load, save
from robolaser.errors import AlgorithmError, OutputError

PROBLEM = get_problem("rastrigin", n_var=3)


class Fenced(Problem):
    def __init__(self):
        super().__init__(n_var=2, n_obj=1, n_ieq_constr=1, xl=-1.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = (X**2).sum(axis=1, keepdims=True)
        out["G"] = 1.0 - X.sum(axis=1, keepdims=True)


def started(generations, problem=PROBLEM, termination=("n_gen", 40), **settings):
    algorithm = RCGA(pop_size=12, **settings).setup(problem, termination=termination, seed=2)
    for _ in range(generations):
        algorithm.next()
    return algorithm


def trail(algorithm):
    """All that is left of a run, generation by generation."""
    steps = []
    while algorithm.has_next():
        algorithm.next()
        pop = algorithm.pop
        steps.append((algorithm.n_iter, algorithm.evaluator.n_eval, *pop.get("X").ravel(), *pop.get("F").ravel()))
    return np.array(steps)


@pytest.mark.parametrize("generations", [1, 2, 17, 39])
def test_a_resumed_run_is_the_same_run(tmp_path, generations):
    algorithm = started(generations)
    save(algorithm, tmp_path / "run.npz")
    resumed = load(tmp_path / "run.npz", PROBLEM, termination=("n_gen", 40))
    assert resumed.opt[0].F[0] == algorithm.opt[0].F[0]
    expected = trail(algorithm)
    assert np.array_equal(trail(resumed), expected)
    assert len(expected) == 40 - generations


@pytest.mark.parametrize(
    "termination",
    [
        None,
        ("n_eval", 400),
        TerminateIfAny(Stalled(8), CostReached(1e-9), get_termination("n_gen", 60)),
        "soo",
    ],
    ids=["its own", "evaluations", "combined", "pymoo's"],
)
def test_what_a_termination_remembers_is_resumed(tmp_path, termination):
    def rules():
        return (
            termination
            if not isinstance(termination, TerminateIfAny)
            else TerminateIfAny(Stalled(8), CostReached(1e-9), get_termination("n_gen", 60))
        )

    settings = {"patience": 9, "cost": 1e-12}
    algorithm = RCGA(pop_size=12, **settings)
    algorithm.setup(PROBLEM, seed=2, **({} if termination is None else {"termination": rules()}))
    for _ in range(20):
        algorithm.next()
    save(algorithm, tmp_path / "run.npz")
    resumed = load(tmp_path / "run.npz", PROBLEM, termination=rules())
    assert np.array_equal(trail(resumed), trail(algorithm))


def test_a_time_budget_goes_on_where_it_was(tmp_path):
    algorithm = started(3, termination=("time", 100))
    algorithm.start_time -= 60.0
    algorithm.next()
    save(algorithm, tmp_path / "run.npz")
    resumed = load(tmp_path / "run.npz", PROBLEM, termination=("time", 100))
    resumed.next()
    assert 0.6 < resumed.termination.perc < 0.7


def test_constraints_and_infinite_costs_survive(tmp_path):
    algorithm = started(5, Fenced())
    algorithm.pop[3].F = np.array([np.inf])
    save(algorithm, tmp_path / "run.npz")
    resumed = load(tmp_path / "run.npz", Fenced(), termination=("n_gen", 40))
    assert np.array_equal(resumed.pop.get("CV"), algorithm.pop.get("CV"))
    assert np.array_equal(trail(resumed), trail(algorithm))


def test_a_checkpoint_from_a_callback_is_not_off_by_one(tmp_path):
    def lay_down(algorithm):
        if algorithm.n_iter == 7:
            save(algorithm, tmp_path / "run.npz")

    algorithm = started(0)
    algorithm.callback = lay_down
    for _ in range(7):
        algorithm.next()
    resumed = load(tmp_path / "run.npz", PROBLEM, termination=("n_gen", 40))
    assert np.array_equal(trail(resumed), trail(algorithm))


def test_a_finished_run_stays_finished(tmp_path):
    algorithm = started(40)
    save(algorithm, tmp_path / "run.npz")
    assert not load(tmp_path / "run.npz", PROBLEM, termination=("n_gen", 40)).has_next()
    assert load(tmp_path / "run.npz", PROBLEM, termination=Stalled(10)).has_next()


def test_settings_and_callbacks_come_back(tmp_path):
    algorithm = started(4, n_elites=3, b=2.5, form="power")
    save(algorithm, tmp_path / "run.npz")
    seen = []
    resumed = load(tmp_path / "run.npz", PROBLEM, termination=("n_gen", 40), callback=lambda a: seen.append(a.n_iter))
    resumed.next()
    assert resumed.settings == algorithm.settings
    assert seen == [5]


def test_a_failed_write_leaves_the_last_checkpoint(tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    algorithm = started(4)
    save(algorithm, path)
    whole = path.read_bytes()
    algorithm.next()

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OutputError, match="No space left on device"):
        save(algorithm, path)
    assert path.read_bytes() == whole
    assert list(tmp_path.iterdir()) == [path]


def test_a_missing_folder_is_said(tmp_path):
    with pytest.raises(OutputError, match="No such file or directory"):
        save(started(1), tmp_path / "nowhere" / "run.npz")


def test_cut_and_foreign_files_are_refused(tmp_path):
    path = tmp_path / "run.npz"
    save(started(2), path)
    whole = path.read_bytes()
    broken = [whole[:n] for n in (0, 1, 10, 300, len(whole) // 2, len(whole) - 1)]
    for at in np.random.default_rng(1).integers(200, len(whole) // 3, 40):
        flipped = bytearray(whole)
        flipped[at] ^= 0xFF
        broken.append(bytes(flipped))
    for content in broken:
        path.write_bytes(content)
        with pytest.raises(AlgorithmError, match=r"run\.npz is no whole state of a search"):
            load(path, PROBLEM, termination=("n_gen", 40))

    path.write_text("pose,point\n1,2\n")
    with pytest.raises(AlgorithmError):
        load(path, PROBLEM)
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(AlgorithmError):
        load(tmp_path / "array.npy", PROBLEM)
    np.savez(path, header=np.array('{"format": "robolaser-checkpoint/9"}'), **dict.fromkeys("XFGH", 0), born=0)
    with pytest.raises(AlgorithmError, match="robolaser-checkpoint/9"):
        load(path, PROBLEM)
    with pytest.raises(AlgorithmError, match="No such file"):
        load(tmp_path / "none.npz", PROBLEM)


def test_nothing_in_a_checkpoint_is_executed(tmp_path):
    np.savez(tmp_path / "run.npz", header=np.array([object()], dtype=object), allow_pickle=True)
    with pytest.raises(AlgorithmError):
        load(tmp_path / "run.npz", PROBLEM)


def test_a_checkpoint_of_other_data_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    save(started(2), path, fingerprint="scorbot")
    load(path, PROBLEM, termination=("n_gen", 40), fingerprint="scorbot")
    with pytest.raises(AlgorithmError, match="its fingerprint is scorbot, here it is panda"):
        load(path, PROBLEM, termination=("n_gen", 40), fingerprint="panda")
    with pytest.raises(AlgorithmError, match="number of its variables is 3, here it is 4"):
        load(path, get_problem("rastrigin", n_var=4), termination=("n_gen", 40), fingerprint="scorbot")
    with pytest.raises(AlgorithmError, match="its termination is MaximumGenerationTermination"):
        load(path, PROBLEM, fingerprint="scorbot")


def test_a_run_that_has_not_begun_has_no_checkpoint(tmp_path):
    with pytest.raises(AlgorithmError, match=r"Call next\(\) first"):
        save(started(0), tmp_path / "run.npz")


OTHER_PARTS = {
    "a repair": lambda: {"repair": RoundingRepair()},
    "a crossover": lambda: {"crossover": SBX(eta=7)},
    "a mutation": lambda: {"mutation": PM(eta=30)},
    "a selection": lambda: {"selection": RandomSelection()},
    "a survival": lambda: {"survival": FitnessSurvival()},
    "duplicates": lambda: {"eliminate_duplicates": True},
}


@pytest.mark.parametrize("parts", OTHER_PARTS.values(), ids=OTHER_PARTS)
def test_a_run_with_other_parts_is_resumed_with_them_and_not_without(tmp_path, parts):
    algorithm = started(10, **parts())
    save(algorithm, tmp_path / "run.npz")
    with pytest.raises(AlgorithmError, match="algorithm"):
        load(tmp_path / "run.npz", PROBLEM, termination=("n_gen", 40))
    resumed = load(tmp_path / "run.npz", PROBLEM, termination=("n_gen", 40), algorithm=RCGA(pop_size=12, **parts()))
    assert np.array_equal(trail(resumed), trail(algorithm))


def test_a_setting_of_a_part_that_differs_is_noticed(tmp_path):
    save(started(3, crossover=SBX(eta=7)), tmp_path / "run.npz")
    with pytest.raises(AlgorithmError, match=r"its crossover is SBX\(.*eta=7.*, here it is SBX\(.*eta=8"):
        load(tmp_path / "run.npz", PROBLEM, algorithm=RCGA(pop_size=12, crossover=SBX(eta=8)))


def test_the_number_of_children_is_kept(tmp_path):
    algorithm = started(5, n_offsprings=4)
    save(algorithm, tmp_path / "run.npz")
    assert np.array_equal(trail(load(tmp_path / "run.npz", PROBLEM, termination=("n_gen", 40))), trail(algorithm))


def test_only_the_papers_algorithm_leaves_checkpoints(tmp_path):
    other = GA(pop_size=6).setup(PROBLEM, termination=("n_gen", 3), seed=1)
    other.next()
    with pytest.raises(AlgorithmError, match="this is GA"):
        save(other, tmp_path / "run.npz")
    assert not (tmp_path / "run.npz").exists()
