import json
from dataclasses import asdict

import numpy as np
import pytest

from robolaser.benchmark.measures import RELATIVE as TOLERANCES
from robolaser.benchmark.result import ResultArrays
from robolaser.benchmark.standings.ranking import standings_of
from robolaser.benchmark.standings.table import Standings

BUDGET = 4000.0


def _arrays(speeds: dict[str, float], *, problems: int = 2, seeds: int = 12, seed: int = 0) -> ResultArrays:
    """Runs that take ten evaluations to each further target, or so many times more; infinitely slow ones fail."""
    rng = np.random.default_rng(seed)
    shape = (problems, len(speeds), seeds)
    pace = np.array(list(speeds.values()))[:, None, None]
    evaluations = np.cumsum(rng.gamma(4, 2.5, (*shape, len(TOLERANCES))), axis=-1) * pace
    evaluations = np.where(evaluations < BUDGET, np.ceil(evaluations), np.inf)
    return _of(evaluations, tuple(speeds))


def _of(evaluations: np.ndarray, algorithms: tuple[str, ...]) -> ResultArrays:
    p, _, s, _ = evaluations.shape
    there = ~np.isnan(evaluations[..., 0])
    reached = np.isfinite(evaluations).sum(axis=-1)
    spent = np.where(there, np.fmin(np.nan_to_num(evaluations[..., -1], nan=np.inf), BUDGET), np.nan)
    return ResultArrays(
        problems=tuple(f"problem {i}" for i in range(p)), algorithms=algorithms, seeds=tuple(range(1, s + 1)),
        tolerances=TOLERANCES, evaluations=evaluations, total_evaluations=spent, total_s=spent * 1e-3,
        final=np.where(there, np.append(np.inf, TOLERANCES)[reached], np.nan), failed=there & (reached == 0),
        headline=int(np.argmin(np.abs(TOLERANCES - 1e-2))), noisy=np.zeros(p, bool),
    )  # fmt: skip


def _ranked(arrays: ResultArrays, **more) -> Standings:
    return standings_of(arrays, family="calibration", **{"refused": {}} | more)


def _without(arrays: ResultArrays, algorithm: int, problem: int, seeds: slice = slice(None)) -> ResultArrays:
    evaluations = arrays.evaluations.copy()
    evaluations[problem, algorithm, seeds] = np.nan
    return _of(evaluations, arrays.algorithms)


SHAPES = [
    ({"only": 1.0}, 1, 1),
    ({"only": 1.0}, 3, 10),
    ({"one": 1.0, "other": 2.0}, 1, 1),
    ({"one": 1.0, "other": 2.0}, 2, 5),
    ({"one": 1.0, "other": 2.0, "hopeless": np.inf}, 2, 3),
    ({"hopeless": np.inf, "helpless": np.inf}, 2, 6),
    ({"hopeless": np.inf}, 1, 2),
    ({}, 2, 3),
]


@pytest.mark.parametrize(("speeds", "problems", "seeds"), SHAPES)
def test_whatever_there_is_of_runs_standings_are_plain_json_and_say_something(speeds, problems, seeds):
    found = _ranked(_arrays(speeds, problems=problems, seeds=seeds))
    json.dumps(asdict(found), allow_nan=False)
    for order in (found.order, *(each.order for each in found.by_problem)):
        assert order.answer.endswith(".")
        assert "None" not in order.answer
        assert "nan" not in order.answer
        assert len(order.places) == len(speeds)


def test_where_every_run_failed_the_answer_says_that_and_ranks_nobody():
    found = _ranked(_arrays({"ga": np.inf, "rcga": np.inf, "de": np.inf}))
    assert found.order.answer.startswith("Every run failed")
    assert "first place" not in found.order.answer


def test_one_whose_runs_all_failed_is_named_beside_the_ranking():
    answer = _ranked(_arrays({"fast": 1.0, "slow": 9.0, "broken": np.inf})).order.answer
    assert "fast is better than" in answer
    assert answer.endswith("Every run of broken failed.")


def test_runs_that_are_yet_to_be_made_are_no_runs():
    arrays = _arrays({"one": 1.0, "other": 2.0})
    found = _ranked(_of(np.full_like(arrays.evaluations, np.nan), arrays.algorithms))
    assert [standing.rank for standing in found.order.places] == [None, None]
    assert "too few runs" in found.order.answer
    assert found.by_problem[0].results[0].final is None


def test_the_faster_rank_before_the_slower_and_all_differ_significantly():
    found = _ranked(_arrays({"slow": 9.0, "fast": 1.0, "middling": 3.0}))
    for order in (found.order, found.by_problem[1].order):
        assert [standing.algorithm for standing in order.places] == ["fast", "middling", "slow"]
        assert [standing.rank for standing in order.places] == [1, 2, 3]
        assert all(pair.significant for pair in order.pairs)
        assert "fast is better than both others" in order.answer
        assert "middling comes next" in order.answer


def test_a_planted_ratio_is_in_the_answer():
    pair = _ranked(_arrays({"fast": 1.0, "slow": 3.0}, seeds=30)).order.pairs[0]
    assert (pair.one, pair.other) == ("fast", "slow")
    assert pair.ratio.lower < 3.0 < pair.ratio.upper
    assert pair.ratio.value == pytest.approx(3.0, rel=0.15)


def test_equals_do_not_differ_significantly_and_the_answer_says_so():
    found = _ranked(_arrays({"a": 1.0, "b": 1.0, "c": 1.0}))
    assert not any(pair.significant for pair in found.order.pairs)
    assert "no algorithm differs significantly from it" in found.order.answer


def test_solvers_that_do_not_differ_from_the_first_are_named():
    answer = _ranked(_arrays({"a": 1.0, "b": 1.02, "slow": 5.0})).order.answer
    assert "does not differ significantly from it" in answer
    assert "it is better than slow" in answer
    assert "b comes next" in answer


def test_with_too_few_seeds_the_answer_says_how_many_it_takes():
    found = _ranked(_arrays({"fast": 1.0, "slow": 9.0}, problems=1, seeds=3))
    assert not found.order.pairs[0].significant
    assert "with 3 seeds no difference can be significant" in found.order.answer
    assert "at least 4 are needed" in found.order.answer
    assert _ranked(_arrays({"fast": 1.0, "slow": 9.0}, problems=1, seeds=4)).order.pairs[0].significant


def test_where_nobody_reached_the_target_those_who_came_closer_rank_first():
    found = _ranked(_arrays({"far": 90.0, "near": 60.0}))
    assert found.order.places[0].algorithm == "near"
    assert found.order.places[0].solved == 0
    assert found.order.pairs[0].significant
    assert found.order.pairs[0].ratio.value is None
    assert "No algorithm reached the target" in found.order.answer


def test_ties_for_first_place_share_it():
    arrays = _arrays({"one": 1.0, "other": 1.0}, seeds=6)
    arrays.evaluations[:, 1] = arrays.evaluations[:, 0]
    arrays.final[:, 1] = arrays.final[:, 0]
    assert [standing.rank for standing in _ranked(arrays).order.places] == [1, 1]


def test_a_solver_that_never_reached_the_target_has_no_running_time():
    found = _ranked(_arrays({"fast": 1.0, "hopeless": np.inf}))
    last = found.by_problem[0].order.places[1]
    assert last.running_time.value is None
    assert last.failed == last.runs == 12
    assert last.success.value == 0.0
    assert last.success.upper > 0.2
    assert "hopeless comes next, and never reached the target where fast did" in found.order.answer


def test_the_mean_ratio_says_on_which_problems_it_rests():
    arrays = _arrays({"fast": 1.0, "slow": 3.0})
    evaluations = arrays.evaluations.copy()
    evaluations[1, 1] = np.inf
    found = _ranked(_of(evaluations, arrays.algorithms))
    assert found.order.pairs[0].ratio_problems == ("problem 0",)
    assert "on the 1 of 2 problems where both reached it" in found.order.answer
    assert found.by_problem[1].order.pairs[0].ratio.value is None
    assert found.by_problem[1].order.pairs[0].ratio_problems == ()


def test_who_lacks_a_problem_is_not_ranked_with_the_others_and_it_is_said_why():
    arrays = _without(_arrays({"a": 1.0, "b": 2.0, "picky": 0.5}), algorithm=2, problem=1)
    found = _ranked(arrays, refused={("problem 1", "picky"): "its cost is no sum of squares"})
    last = found.order.places[-1]
    assert (last.algorithm, last.rank, last.unranked) == ("picky", None, "its cost is no sum of squares")
    assert tuple(place.algorithm for place in found.order.places if place.rank) == ("a", "b")
    assert "Not ranked: picky." in found.order.answer
    assert found.by_problem[0].order.places[0].algorithm == "picky"
    assert "it has 0 of 12 runs on problem 1" in _ranked(arrays).order.places[-1].unranked


def test_while_runs_are_missing_the_blocks_that_are_complete_count():
    arrays = _without(_arrays({"a": 1.0, "b": 2.0}), algorithm=1, problem=0, seeds=slice(9, None))
    found = _ranked(arrays).order
    assert found.blocks == 24 - 3
    assert [standing.runs for standing in found.places] == [24, 21]


def test_the_order_of_asking_changes_nothing():
    arrays = _arrays({"a": 1.0, "b": 2.0, "c": 1.5}, seeds=8)
    turned = [2, 0, 1]
    other = _of(arrays.evaluations[:, turned], tuple("abc"[i] for i in turned))
    assert asdict(_ranked(arrays).order) == asdict(_ranked(other).order)


def test_who_takes_part_changes_no_running_time_and_no_comparison_of_others():
    few, more = _arrays({"a": 1.0, "b": 1.2}, seeds=8), _arrays({"a": 1.0, "b": 1.2, "c": 0.3}, seeds=8)
    less = _of(more.evaluations[:, :2], few.algorithms)
    with_c = {(pair.one, pair.other): pair for pair in _ranked(more).order.pairs}
    for pair in _ranked(less).order.pairs:
        other = with_c[pair.one, pair.other]
        assert (other.ratio, other.superiority, other.p) == (pair.ratio, pair.superiority, pair.p)
        assert other.p_adjusted >= pair.p_adjusted


def test_the_same_runs_give_the_same_intervals_and_more_samples_nearly_the_same(monkeypatch):
    arrays = _arrays({"a": 1.0, "b": 2.0})
    one = _ranked(arrays)
    assert one == _ranked(arrays)
    monkeypatch.setattr("robolaser.benchmark.statistics.running_time.SAMPLES", 3000)
    other = _ranked(arrays).order.pairs[0].ratio
    assert one.order.pairs[0].ratio != other
    assert one.order.pairs[0].ratio.lower == pytest.approx(other.lower, rel=0.1)
