"""From data to parameters: the optimum is found, kept within bounds, and its doubts are told."""

import json
import re
from dataclasses import replace
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
from calibrated import arm
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.optimize import minimize

from robolaser.algorithms import RCGA
from robolaser.algorithms.registry import ALGORITHMS
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.checks import setup_warning
from robolaser.calibration.initialization import descend_until_agreed, find_start
from robolaser.calibration.plan import Plan
from robolaser.calibration.pymoo_search import CHECKPOINT, search
from robolaser.calibration.result import Calibration, as_json
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import AlgorithmError, EstimationError, UsageError
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.export.files import exported
from robolaser.model.effects import candidate_effects
from robolaser.model.effects.backlash import Backlash
from robolaser.model.forward_model import Model
from robolaser.operators import ArithmeticCrossover, NonUniformMutation
from robolaser.parameters import Parameter
from robolaser.problems import ReducedCalibration, ScannerCalibration
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, Simulated, paper, simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5)
BREEDING = Plan(algorithm="rcga", generations=80)


@pytest.fixture(scope="module")
def experiment() -> Simulated:
    return paper(find_robot("scorbot_er7"), seed=4)


@pytest.fixture(scope="module")
def calibrated(experiment: Simulated) -> Calibration:
    return calibrate(experiment.dataset)


@pytest.fixture(scope="module")
def bred(experiment: Simulated) -> Calibration:
    return calibrate(experiment.dataset, BREEDING)


@pytest.fixture(scope="module")
def rolled() -> Simulated:
    arm = find_robot("scorbot_er7")
    return simulate(
        arm, poses=16, points=8, noise=NOISE, effects={"laser_roll": 0.05}, options=CellOptions(placed=False), seed=5
    )


def test_the_search_ends_where_a_descent_from_the_truth_does(experiment, calibrated):
    model = Model(experiment.dataset)
    truth = np.array([experiment.truth[name] for name in model.parameters.names])
    best = solve(Problem.of(model), model.fix_gauge(truth)[None])
    assert calibrated.objective_m2 == pytest.approx(best.cost[0], rel=1e-6)


def test_the_papers_algorithm_ends_where_the_default_does(calibrated, bred):
    assert (calibrated.algorithm, bred.algorithm) == ("screening", "rcga")
    assert bred.objective_m2 == pytest.approx(calibrated.objective_m2, rel=1e-6)
    assert len(bred.history.best) == BREEDING.generations


@pytest.mark.parametrize("seed", [1, 7, 11])
def test_members_from_anywhere_agree_along_a_curved_valley(seed):
    """With 25 points and two bounds active the last steps are many; ends that are no optimum would not agree."""
    model = Model(paper(find_robot("scorbot_er7"), seed=seed).dataset)
    problem = ReducedCalibration(model)
    candidates, _ = search(problem, RCGA(), generations=60, seed=1)
    members = problem.completed(candidates[:8])
    ends = solve(Problem.of(model), np.array([model.fix_gauge(member) for member in members]))
    assert np.sum(ends.cost <= ends.cost.min() * (1 + 1e-6)) >= len(members) - 1
    assert ends.converged.all()


def test_the_result_keeps_to_the_bounds_and_f_to_its_nominal_value(calibrated):
    parameters = calibrated.model.parameters
    assert (calibrated.x >= parameters.lower).all()
    assert (calibrated.x <= parameters.upper).all()
    assert calibrated.x[0] == parameters.nominal[0]
    assert np.isnan(calibrated.std[0])


def test_a_mistyped_parameter_is_answered_with_the_one_that_was_meant(calibrated):
    with pytest.raises(UsageError, match=r"No parameter 'theeta'\. Did you mean 'theta'"):
        calibrated.value("theeta")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"weights": "nosie"}, "nosie"),
        ({"weights": "noise", "polish": False}, "leave out one"),
        ({"generations": 0}, "1 generation or more, not 0"),
    ],
)
def test_options_that_could_not_act_are_refused(options, said):
    with pytest.raises(UsageError, match=said):
        Plan(**options)


def test_the_gauge_is_named(calibrated):
    assert {"f", "s_u", "s_v", "k"} in [set(one.parameters) for one in calibrated.unidentifiable]


@pytest.fixture(scope="module")
def distorted() -> Simulated:
    return simulate("ur5", poses=20, noise=NOISE, seed=3)


@pytest.fixture(scope="module")
def distorted_rms_m(distorted: Simulated) -> float:
    return calibrate(distorted.dataset).rms_m


@pytest.mark.parametrize("known", [("s_u",), ("s_u", "s_v"), ("k",)])
def test_the_focal_length_is_found_where_the_pitch_of_pixels_is_known(distorted, distorted_rms_m, known):
    made = distorted
    assert made.truth["k"] > 100.0
    c = {"f": 0.92, "s_u": 0.92, "s_v": 0.92, "k": 0.92**-2}  # the same camera
    stated = {name: made.truth[name] * c[name] for name in known}
    fixed = {name: Parameter(name, "", value, value, value) for name, value in stated.items()}
    found = calibrate(replace(made.dataset, parameters={**made.dataset.parameters, **fixed}))
    assert found.rms_m == pytest.approx(distorted_rms_m, rel=0.02)
    i = found.model.parameters.names.index("f")
    assert found.std[i] < 1e-3
    assert found.x[i] == pytest.approx(0.92 * made.truth["f"], abs=4 * found.std[i])


def test_the_error_on_unseen_poses_is_larger_than_on_seen_ones(calibrated):
    assert calibrated.held_out_rms_m > calibrated.rms_m


def test_a_parameter_on_its_bound_is_named_in_a_warning(experiment):
    given = dict(experiment.dataset.parameters)
    beyond = experiment.truth["u_0"] + 15.0
    given["u_0"] = replace(given["u_0"], lower=beyond, upper=beyond + 30.0, nominal=beyond + 10.0)
    found = calibrate(replace(experiment.dataset, parameters=given), Plan(algorithm="gauss-newton"))
    assert found.on_bound[3]
    assert np.isnan(found.std[3])
    assert any("u_0 ended on one of its bounds" in warning for warning in found.warnings)


def test_bounds_that_nobody_can_widen_are_not_to_be_widened():
    made = simulate(
        "ur5", kind="point", poses=20, noise=Noise(point_m=1e-5), effects={"joint_coupling:elbow_joint": 2e-3}
    )
    found = calibrate(made.dataset, Plan(effects=("joint_coupling:elbow_joint",)))
    (warning,) = (warning for warning in found.warnings if "joint_coupling.elbow_joint.other ended" in warning)
    assert warning.endswith("one of its bounds, which are the effect's own: it has no standard error.")


def test_the_same_seed_gives_the_same_result_to_the_last_bit(experiment, calibrated):
    again = calibrate(experiment.dataset)
    assert np.array_equal(again.x, calibrated.x)
    assert np.array_equal(again.std, calibrated.std, equal_nan=True)


@pytest.mark.parametrize("name", ALGORITHMS)
def test_a_seed_repeats_every_algorithms_search_to_the_last_bit(name, experiment):
    """Also 0, which some algorithms take for the clock."""
    model, plan = Model(experiment.dataset), Plan(algorithm=name, seed=0, generations=3, polish=False)
    first, again = (find_start(model, plan) for _ in range(2))
    assert np.array_equal(first.x, again.x)


def test_an_effect_in_the_model_brings_the_error_on_unseen_poses_down_to_the_noise(rolled):
    without = calibrate(rolled.dataset, Plan(algorithm="gauss-newton"))
    with_it = calibrate(rolled.dataset, Plan(algorithm="gauss-newton", effects=("laser_roll",)))
    assert without.held_out_rms_m > 3 * with_it.held_out_rms_m
    assert with_it.value("laser_roll.laser.angle") == pytest.approx(0.05, abs=5 * with_it.std[-1])


def test_weights_by_noise_come_closer_to_the_truth(rolled):
    """Over several noises the efficient estimate errs less, where plain J listens to the depth's noise."""
    errors = {"plain": [], "noise": []}
    for seed in range(3):
        arm = find_robot("scorbot_er7")
        made = simulate(arm, poses=12, points=8, noise=Noise(pixel_px=0.3, target_m=1e-5), seed=seed)
        for weights, found in errors.items():
            result = calibrate(made.dataset, Plan(algorithm="gauss-newton", weights=weights))
            truth = Model(made.dataset).fix_gauge(np.array([made.truth[n] for n in result.model.parameters.names]))
            found.append(np.sqrt((((result.x - truth) / result.model.parameters.width) ** 2).sum()))
    assert np.mean(errors["noise"]) < np.mean(errors["plain"])


def test_a_stopped_search_goes_on_to_the_same_result(experiment, bred, tmp_path, monkeypatch):
    monkeypatch.setattr("robolaser.calibration.pymoo_search.SECONDS_BETWEEN_CHECKPOINTS", 0.0)

    def stop(what: str, share: float) -> None:
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        calibrate(experiment.dataset, BREEDING, state=tmp_path, progress=stop)
    assert (tmp_path / CHECKPOINT).exists()
    resumed = calibrate(experiment.dataset, BREEDING, state=tmp_path, resume=True)
    assert np.array_equal(resumed.x, bred.x)
    assert np.array_equal(resumed.history.best, bred.history.best)
    with pytest.raises(AlgorithmError):
        calibrate(experiment.dataset, replace(BREEDING, seed=9), state=tmp_path, resume=True)
    tilted = replace(experiment.dataset, bracket_quat=(0.01, 0.0, 0.0, np.sqrt(1 - 1e-4)))
    with pytest.raises(AlgorithmError, match=r"Resume with the data and options .* or delete the checkpoint"):
        calibrate(tilted, BREEDING, state=tmp_path, resume=True)


@pytest.mark.parametrize("algorithm", [None, "de", "rcga"])
def test_where_every_parameter_is_known_the_error_is_stated_all_the_same(experiment, algorithm):
    given, truth = experiment.dataset.parameters, experiment.truth
    known = {name: replace(given[name], nominal=truth[name], lower=truth[name], upper=truth[name]) for name in given}
    found = calibrate(replace(experiment.dataset, parameters=known), Plan(algorithm=algorithm))
    assert {name: found.value(name) for name in given} == truth
    assert np.isnan(found.std).all()
    assert found.held_out_rms_m == pytest.approx(found.rms_m)
    assert [w for w in found.warnings if "nothing to search for: every parameter is fixed" in w] or algorithm is None


def test_too_few_poses_say_how_many_are_needed(experiment):
    one = experiment.dataset.of_poses(np.arange(5) == 2)
    with pytest.raises(EstimationError, match="at least 2"):
        calibrate(one, Plan(algorithm="gauss-newton"))


@pytest.mark.parametrize("kind", ["point", "pose", "profile", "socket"])
def test_trackers_and_sockets_start_from_a_closed_form(kind):
    noise = Noise(point_m=2e-5, angle_rad=1e-4, joint_rad=1e-5)
    made = simulate(find_robot("ur5"), kind=kind, poses=20, noise=noise, seed=1)
    found = calibrate(made.dataset)
    assert found.algorithm == "gauss-newton"
    assert found.rms_m < 1e-4
    for name, value, std in zip(found.model.parameters.names, found.x, found.std, strict=True):
        assert value == pytest.approx(made.truth[name], abs=6 * std), name
    assert (
        as_json(found)["parameters"][{"socket": "tool.ball.x", "profile": "hand_eye.x"}.get(kind, "base.x")]["nominal"]
        is None
    )


@pytest.mark.parametrize("stated", [None, Noise()])
@pytest.mark.parametrize("kind", ["point", "pose"])
def test_shots_of_an_only_reflector_say_as_much_as_their_mean(kind, stated):
    noise, options = Noise(point_m=3e-5, angle_rad=1e-4, joint_rad=2e-5), CellOptions(repeats=3, stated=stated)
    shots = simulate("ur5", kind=kind, poses=30, points=1, noise=noise, options=options, seed=1).dataset
    means = replace(AveragedData.of(shots).dataset, noise=Noise())
    one, other = calibrate(shots), calibrate(means)
    assert np.abs((one.x - other.x) / other.std).max() < 0.1
    np.testing.assert_allclose(one.std, other.std, rtol=0.2)


def test_poles_among_the_members_do_not_stop_the_descents(experiment):
    model = Model(experiment.dataset)
    pole = model.parameters.nominal.copy()
    pole[7], pole[4] = 0.0, experiment.dataset.points.pixel[0, 1]
    assert not np.isfinite(model.cost(pole[None])[0])
    x, _ = descend_until_agreed(Problem.of(model), np.stack([pole, model.parameters.nominal]))
    assert np.isfinite(model.cost(x[None])[0])


@pytest.mark.parametrize("question", [ScannerCalibration, lambda dataset: ReducedCalibration(Model(dataset))])
def test_the_problem_is_any_pymoo_algorithms(experiment, question):
    problem = question(experiment.dataset)
    algorithm = GA(
        pop_size=40, crossover=ArithmeticCrossover(prob=0.85), mutation=NonUniformMutation(prob_var=0.1, b=5)
    )
    result = minimize(problem, algorithm, ("n_gen", 30), seed=1)
    assert len(problem.names) == problem.n_var
    whole = problem.completed(result.X[None]) if isinstance(problem, ReducedCalibration) else result.X[None]
    assert problem.model.cost(whole)[0] == pytest.approx(result.F[0])
    assert (problem.xl <= result.X).all()
    assert (problem.xu >= result.X).all()


def test_centimetres_or_many_parameters_on_bounds_mean_a_wrong_description_of_the_cell(experiment):
    points = experiment.dataset.points
    shuffled = replace(points, xyz=points["xyz"][::-1].copy())
    found = calibrate(replace(experiment.dataset, points=shuffled), Plan(algorithm="gauss-newton"))
    warning = found.warnings[0]
    assert "Do not use this result" in warning
    assert "stripe_axis" in warning
    assert "unit" in warning
    assert warning == found.setup_warning
    urdf, *others = exported(found).values()
    assert urdf is not None
    assert not any(others)


@pytest.mark.parametrize(
    ("ended", "rms_m", "said"),
    [
        (10, 1e-4, r"^10 of 14 parameters ended on their bounds: the bounds exclude the best fit, or"),
        (0, 0.03, r"^Fitted points are 3 cm off"),
        (10, 0.03, r"^10 of 14 parameters .*\. Fitted points are 3 cm off"),
    ],
)
def test_the_warning_of_a_wrong_description_states_what_it_rests_on(experiment, ended, rms_m, said):
    model = Model(experiment.dataset)
    warning = setup_warning(model, np.arange(len(model.parameters)) < ended, rms_m)
    assert re.search(said, warning)
    assert ("no real arm" in warning) == (rms_m > 0.01)


def test_a_sound_cell_gets_no_such_warning(calibrated):
    assert calibrated.setup_warning is None


def test_effects_on_their_bounds_are_no_wrong_description_of_the_cell():
    dataset = simulate("ur5", kind="point", poses=20, seed=1).dataset
    model = Model(dataset, candidate_effects(["joint_compliance"], dataset))
    ended = np.array([name.endswith("payload") for name in model.parameters.names])
    assert ended.sum() == 6
    assert setup_warning(model, ended, 1e-4) is None


def test_sizes_at_a_joint_that_slides_are_lengths():
    effects = "joint_offset:lift", "backlash:turn", "backlash:lift", "link_geometry:lift"
    dataset = simulate(arm(), kind="point", poses=20, effects={"backlash:lift": 1e-3}, seed=1).dataset
    found = as_json(calibrate(dataset, Plan(effects=effects)))["effects"]
    assert [next(iter(one["parameters"].values()))["unit"] for one in found] == ["m", "rad", "m", "m"]
    assert found[-1]["parameters"]["turn_x"]["unit"] == "rad"
    assert found[2]["parameters"]["lost_motion"]["value"] == pytest.approx(1e-3, rel=1e-3)
    named = diagnosis_json(examine(dataset, [Backlash], seed=1))
    assert {(one["where"], one["parameters"]["lost_motion"]["unit"]) for one in named["effects"]} == {("lift", "m")}
    sound = diagnosis_json(examine(simulate(arm(), kind="point", poses=20, seed=1).dataset, [Backlash], seed=1))
    assert {one["where"] for one in sound["detection_limits"] if one["unit"] == "m"} == {"lift"}


def test_known_distances_hold_in_a_fit_and_wrong_ones_show():
    made = simulate(find_robot("ur5"), kind="socket", poses=30, noise=Noise(point_m=2e-5, joint_rad=1e-4), seed=1)
    pairs = made.dataset.distances_m
    assert pairs

    def apart(found: Calibration, one: str, other: str) -> float:
        a, b = (np.array([found.value(f"socket.{name}.{axis}") for axis in "xyz"]) for name in (one, other))
        return float(np.linalg.norm(a - b))

    found = calibrate(made.dataset)
    entries = as_json(found)
    jsonschema.validate(entries, json.loads(files("robolaser").joinpath("schemas/calibration.schema.json").read_text()))
    of_sockets, of_distances = entries["rows"]
    assert of_sockets == {
        "sensor": "socket", "rows": 30, "rms": found.rms_m, "held_out_rms": found.held_out_rms_m, "unit": "m"
    }  # fmt: skip
    left = [distance - apart(found, one, other) for one, other, distance in pairs]
    assert of_distances.pop("rms") == pytest.approx(np.sqrt(np.mean(np.square(left))))
    assert of_distances == {"sensor": "distances", "rows": len(pairs), "held_out_rms": None, "unit": "m"}
    for one, other, distance in pairs:
        assert apart(found, one, other) == pytest.approx(distance, abs=1e-4)
    wrong = tuple((one, other, 10 * distance) for one, other, distance in pairs)
    assert calibrate(replace(made.dataset, distances_m=wrong)).rms_m > 10 * found.rms_m


def test_effects_refer_to_all_rows_also_where_a_search_starts_with_few_of_each_image():
    effects, options = {"focus_breathing:camera": 0.02}, CellOptions(placed=False)
    noise = Noise(pixel_px=0.1)
    made = simulate("ur5", kind="camera", poses=60, points=12, noise=noise, options=options, effects=effects, seed=2)
    found = calibrate(made.dataset, Plan(effects=tuple(effects)))
    at = found.model.parameters.names.index("focus_breathing.camera.breathing")
    assert found.x[at] == pytest.approx(0.02, abs=3.0 * found.std[at])
    assert found.std[at] < 0.003
