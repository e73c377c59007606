"""What every effect must keep to; a new file in robolaser/model/effects is tested without an edit."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any, cast

import numpy as np
import pytest
from cells import on_flange_poses

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.duals import Dual
from robolaser.model.effects import EFFECTS, candidate_effects
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.run import RunSummary, continued
from robolaser.model.forward_model import Model
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

KINDS = ("stripe", "camera", "point", "pose", "profile", "socket")
ROUNDING_M = 1e-15  # placements of joints that differ from pose to pose are multiplied in another order


@cache
def cell(kind: str) -> Dataset:
    points = 12 if kind == "camera" else 3
    arm = find_robot("scorbot_er7")
    return simulate(
        arm, kind=kind, poses=6, points=points, noise=Noise(), options=CellOptions(speed=0.1), seed=3
    ).dataset


def rounding(model: Model, metres: float) -> float:
    """A rounding error of points [m], in the unit of the sensor's rows."""
    return metres * (1e4 if model.blocks.sensor.format.unit == "px" else 1.0)


@cache
def homes(kind: type[Effect]) -> list[Model]:
    """A model for each kind of sensor in which the effect has a meaning, at a place in the middle of the arm."""
    cells = [(one, kind.locations(one)) for one in map(cell, KINDS)]
    return [Model(one, (CandidateEffect(kind, places[len(places) // 2]),)) for one, places in cells if places]


@pytest.fixture(params=EFFECTS, ids=lambda kind: kind.name)
def effect(request: pytest.FixtureRequest) -> type[Effect]:
    kind: type[Effect] = request.param
    return kind


def columns(model: Model, candidate_effect: CandidateEffect, numbers: tuple[Any, ...]) -> list[int]:
    return model.parameters.columns(candidate_effect.key(each.name) for each in numbers)


def nonlinear_only(model: Model, seed: int = 0) -> Array:
    """Three candidates at the nominal model, the nonlinear parameters anywhere within their bounds."""
    rng = np.random.default_rng(seed)
    x = np.repeat(model.parameters.nominal[None], 3, axis=0)
    for candidate_effect in model.effects:
        at = columns(model, candidate_effect, candidate_effect.effect.nonlinear_parameters())
        x[:, at] = rng.uniform(model.parameters.lower[at], model.parameters.upper[at], (3, len(at)))
    return x


def candidates(model: Model, seed: int = 0) -> Array:
    """The same with effects of the size of their prior scale."""
    x, rng = nonlinear_only(model, seed), np.random.default_rng(seed + 1)
    for candidate_effect in model.effects:
        prior_scale = [size for *_, size in candidate_effect.effect.amplitudes()]
        x[:, columns(model, candidate_effect, candidate_effect.effect.amplitudes())] = (
            rng.uniform(0.5, 1.0, (3, len(prior_scale))) * prior_scale
        )
    return x


def test_it_has_a_meaning_somewhere_and_a_reference(effect: type[Effect]) -> None:
    assert homes(effect)
    assert effect.reference
    assert effect.title


def test_its_words_make_sentences(effect: type[Effect]) -> None:
    candidate = CandidateEffect(effect, "joint_3")
    for words in (candidate.clause, candidate.remedy):
        assert len(words) > 15
        assert "{" not in words
    assert effect.clause != Effect.clause
    assert effect.caveat
    assert not effect.caveat.endswith(".")
    assert candidate.remedy.endswith(".")


def test_an_effect_without_a_clause_of_its_own_is_described_by_its_title() -> None:
    made = type("Unheard", (Effect,), {"title": "the floor gives way", "__module__": "__main__"})
    assert CandidateEffect(made, "base").clause == "base: the floor gives way"


def test_its_prior_scale_lies_within_its_bounds(effect: type[Effect]) -> None:
    for _, _, lower, bound, prior_scale in effect.amplitudes():
        assert 0 < prior_scale < bound
        assert lower in (-bound, 0.0)


def test_at_zero_nothing_changes_whatever_the_nonlinear_parameters(effect: type[Effect]) -> None:
    for model in homes(effect):
        x = nonlinear_only(model)
        plain = Model(model.dataset).residuals(x[:, : -len(model.effect_parameters)])
        np.testing.assert_allclose(model.residuals(x), plain, rtol=0, atol=rounding(model, ROUNDING_M))


def passing(model: Model, x: Array) -> Array:
    """What passes the stage of the model's only effect, before it."""
    seen: list[Array] = []

    def note(value: Array) -> Array:
        seen.append(value)
        return value

    values = model.parameters.values(x)
    perturb = Perturbation(((model.effects[0].effect.stage, note), *model.perturb(values).steps))
    model.blocks.residuals(values, model.flange(values, perturb), perturb)
    return seen[-1]


def test_its_derivatives_by_its_parameters_and_by_what_passes_are_those_of_differences(effect: type[Effect]) -> None:
    for model in homes(effect):
        parameters, stage = model.effect_parameters, effect.stage
        x = candidates(model)[:, -len(parameters) :]
        value = passing(model, candidates(model))
        way = np.random.default_rng(5).normal(size=value.shape) * (1e-5 if stage is Stage.IMAGE else 1e-2)

        def acts(numbers: Array, value: Any, model: Model = model) -> Any:
            values = dict(zip(model.effect_parameters.names, numbers.T, strict=True))
            return model.perturb(values)(model.effects[0].effect.stage, value)

        count = len(parameters)
        duals = {name: Dual(x[:, i], np.ones((1, len(x))), (i,)) for i, name in enumerate(parameters.names)}
        found: Any = model.perturb(cast("Values", duals))(stage, cast("Array", Dual(value, way[None], (count,))))
        steps = np.vstack([1e-6 * np.diag(parameters.width), np.zeros(count)])
        for number, (step, along) in enumerate(zip(steps, [*np.zeros(count), 1e-4], strict=True)):
            size = along or step.max()
            expected = (acts(x + step, value + along * way) - acts(x - step, value - along * way)) / (2 * size)
            slope = found.slopes[found.of.index(number)] if number in found.of else np.zeros(expected.shape)
            np.testing.assert_allclose(slope, expected, rtol=1e-4, atol=1e-5 * np.abs(expected).max(initial=1e-9))


def test_the_grid_of_its_nonlinear_parameters_lies_within_their_bounds(effect: type[Effect]) -> None:
    for model in homes(effect):
        for candidate_effect in model.effects:
            grid = effect.grid(model.dataset, candidate_effect.where)
            assert grid.shape == (len(grid), len(effect.nonlinear_parameters()))
            assert len(grid) >= 1
            for values, each in zip(grid.T, effect.nonlinear_parameters(), strict=True):
                lower, upper, nominal = each.lower, each.upper, each.nominal
                assert lower <= nominal <= upper
                assert ((values >= lower) & (values <= upper)).all()


def test_what_cannot_be_tested_has_a_reason_and_no_location(effect: type[Effect]) -> None:
    whole = cell("stripe")
    flange_only = on_flange_poses(whole)
    untimed = replace(whole, poses=replace(whole.poses, time_s=None))
    still = replace(whole, poses=replace(whole.poses, qd=None))
    for dataset in (
        whole,
        flange_only,
        untimed,
        still,
        replace(whole, path_known=False),
        cell("camera"),
        cell("point"),
        cell("pose"),
        cell("profile"),
        cell("socket"),
    ):
        assert bool(effect.missing(dataset)) is not bool(effect.locations(dataset))
        assert not effect.missing(dataset).endswith(".")


def test_it_is_smooth_where_it_vanishes(effect: type[Effect]) -> None:
    for model in homes(effect):
        nominal, changed = nonlinear_only(model), candidates(model)
        step = changed - nominal
        zero = model.residuals(nominal)
        forth, back = (model.residuals(nominal + sign * 1e-3 * step) - zero for sign in (1, -1))
        np.testing.assert_allclose(forth, -back, rtol=0, atol=1e-2 * np.abs(forth).max() + 1e-13)


def test_at_its_prior_scale_residuals_change(effect: type[Effect]) -> None:
    for model in homes(effect):
        nominal = model.residuals(model.parameters.nominal[None])
        assert np.abs(model.residuals(candidates(model)) - nominal).max() > 1e-6


def test_one_candidate_changes_as_it_does_in_a_population(effect: type[Effect]) -> None:
    for model in homes(effect):
        x = candidates(model)
        alone = np.concatenate([model.residuals(x[i : i + 1]) for i in range(len(x))])
        np.testing.assert_allclose(model.residuals(x), alone, rtol=0, atol=rounding(model, 1e-15))


def test_one_pose_changes_as_it_does_among_many_unless_it_depends_on_the_trajectory(effect: type[Effect]) -> None:
    for model in [] if effect.depends_on_trajectory else homes(effect):
        x = candidates(model)
        chosen = np.arange(len(model.dataset.poses)) == 2
        whole = dict(zip(model.parameters.names, x.T, strict=True))
        one = Model(model.dataset.of_poses(chosen), model.effects).sharing(model.sensor_parameters)
        rows = chosen[model.dataset.points.pose]
        own = np.stack([whole[name] for name in one.parameters.names], axis=-1)
        np.testing.assert_allclose(one.residuals(own), model.residuals(x)[:, rows], rtol=0, atol=rounding(model, 1e-12))


def test_in_another_run_it_acts_or_says_why_not(effect: type[Effect]) -> None:
    for model in homes(effect):
        dataset = model.dataset
        later = replace(dataset, poses=replace(dataset.poses, time_s=dataset.poses.time_s + 1.0))
        (candidate,) = model.effects
        found = candidate.at(model.parameters.values(candidates(model)[:1]))
        carried = found.carried_to(continued(RunSummary.of(dataset), later), RunSummary.of(dataset))
        if carried.effect is None:
            assert carried.doubt
        else:
            assert isinstance(carried.effect, effect)
            assert carried.effect.where == candidate.where
        assert not carried.doubt.endswith(".")


def test_what_a_urdf_can_hold_moves_joints(effect: type[Effect]) -> None:
    assert not effect.in_urdf or effect.stage in (Stage.JOINTS, Stage.LINKS)


@pytest.mark.parametrize("kind", KINDS)
def test_values_of_a_sensor_pass_exactly_the_stages_that_it_declares(kind: str) -> None:
    passed = set()

    def watch(stage: Stage) -> Callable[[Array], Array]:
        return lambda value: (passed.add(stage), value)[1]

    model = Model(cell(kind))
    values = model.parameters.values(model.parameters.nominal[None])
    perturb = Perturbation(tuple((stage, watch(stage)) for stage in Stage))
    model.blocks.residuals(values, model.flange(values), perturb)
    assert passed == model.blocks.sensor.stages - {Stage.JOINTS, Stage.LINKS, Stage.FLANGE}


def test_effects_of_different_stages_compose_in_any_order() -> None:
    chosen = candidate_effects(["laser_roll", "joint_offset:joint_2", "link_geometry:joint_3"], cell("stripe"))
    assert len({candidate_effect.effect.stage for candidate_effect in chosen}) == len(chosen)
    forth, back = Model(cell("stripe"), chosen), Model(cell("stripe"), chosen[::-1])
    x = candidates(forth)
    order = [forth.parameters.names.index(name) for name in back.parameters.names]
    np.testing.assert_array_equal(forth.residuals(x), back.residuals(x[:, order]))


def test_without_a_location_an_effect_is_meant_at_every_joint() -> None:
    chosen = candidate_effects(["joint_offset"], cell("stripe"))
    assert [candidate_effect.where for candidate_effect in chosen] == [f"joint_{i}" for i in range(1, 6)]


def test_names_come_in_alphabetical_order_and_once() -> None:
    assert all(a.name < b.name for a, b in pairwise(EFFECTS))
