"""What every effect must keep to; a new file in robolaser/effects is tested without an edit."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.dataset import Dataset, Noise
from robolaser.effects import EFFECTS, suspects
from robolaser.effects.effect import Effect, Suspect
from robolaser.robots import find_robot
from robolaser.scanner import Model
from robolaser.simulate import simulate


@cache
def cell(kind: str) -> Dataset:
    return simulate(find_robot("scorbot_er7"), kind=kind, poses=6, points=3, noise=Noise(), seed=3).dataset


def homes(kind: type[Effect]) -> list[Model]:
    """A model for each kind of sensor in which the effect has a meaning, at its last place there."""
    cells = [cell(sensor) for sensor in ("stripe", "point", "socket")]
    return [Model(one, (Suspect(kind, kind.places(one)[-1]),)) for one in cells if kind.places(one)]


@pytest.fixture(params=EFFECTS, ids=lambda kind: kind.name)
def effect(request: pytest.FixtureRequest) -> type[Effect]:
    kind: type[Effect] = request.param
    return kind


def candidates(model: Model, seed: int = 0) -> Array:
    """Three candidates near the nominal model with effects of typical size."""
    rng = np.random.default_rng(seed)
    x = np.repeat(model.parameters.nominal[None], 3, axis=0)
    first = len(x[0]) - len(model.effect_parameters)
    typical = [size for suspect in model.suspects for *_, size in suspect.kind.declared()]
    x[:, first:] = rng.uniform(0.5, 1.0, (3, len(typical))) * typical
    return x


def test_it_has_a_meaning_somewhere_and_a_reference(effect: type[Effect]) -> None:
    assert homes(effect)
    assert effect.reference
    assert effect.title


def test_its_typical_size_lies_within_its_bounds(effect: type[Effect]) -> None:
    for _, _, bound, typical in effect.declared():
        assert 0 < typical < bound


def test_at_zero_nothing_bends(effect: type[Effect]) -> None:
    for model in homes(effect):
        x = model.parameters.nominal[None]
        assert np.array_equal(model.residuals(x), Model(model.dataset).residuals(x[:, : -len(model.effect_parameters)]))


def test_at_its_typical_size_something_bends(effect: type[Effect]) -> None:
    for model in homes(effect):
        nominal = model.residuals(model.parameters.nominal[None])
        assert np.abs(model.residuals(candidates(model)) - nominal).max() > 1e-6


def test_one_candidate_bends_as_it_does_in_a_population(effect: type[Effect]) -> None:
    for model in homes(effect):
        x = candidates(model)
        alone = np.concatenate([model.residuals(x[i : i + 1]) for i in range(len(x))])
        np.testing.assert_allclose(model.residuals(x), alone, rtol=0, atol=1e-15)


def test_one_pose_bends_as_it_does_among_many(effect: type[Effect]) -> None:
    for model in homes(effect):
        x = candidates(model)
        chosen = np.arange(len(model.dataset.poses)) == 2
        whole = dict(zip(model.parameters.names, x.T, strict=True))
        one = Model(model.dataset.of_poses(chosen), model.suspects)
        rows = chosen[model.dataset.points.pose]
        own = np.stack([whole[name] for name in one.parameters.names], axis=-1)
        np.testing.assert_allclose(one.residuals(own), model.residuals(x)[:, rows], rtol=0, atol=1e-12)


def test_effects_of_different_seams_compose_in_any_order() -> None:
    chosen = suspects(["laser_roll", "joint_offset:joint_2", "link_geometry:joint_3"], cell("stripe"))
    assert len({suspect.kind.seam for suspect in chosen}) == len(chosen)
    forth, back = Model(cell("stripe"), chosen), Model(cell("stripe"), chosen[::-1])
    x = candidates(forth)
    order = [forth.parameters.names.index(name) for name in back.parameters.names]
    np.testing.assert_array_equal(forth.residuals(x), back.residuals(x[:, order]))


def test_without_a_place_an_effect_is_meant_at_every_joint() -> None:
    chosen = suspects(["joint_offset"], cell("stripe"))
    assert [suspect.where for suspect in chosen] == [f"joint_{i}" for i in range(1, 6)]


def test_names_come_in_alphabetical_order_and_once() -> None:
    assert all(a.name < b.name for a, b in pairwise(EFFECTS))
