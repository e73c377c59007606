"""Cells with faults that are not simulated by the effect library, and parts of the library that could pass for them."""

from functools import cache

from robolaser.diagnosis import Diagnosis, examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import Effect
from robolaser.robot.by_name import find_robot
from robolaser.trials.making import BlindDataset, make


@cache
def world(robot: str, kind: str, seed: int) -> BlindDataset:
    """A blind world."""
    return make(find_robot(robot), kind, seed=seed)


@cache
def seen(robot: str, kind: str, seed: int, without: tuple[str, ...] = ()) -> Diagnosis:
    """Its diagnosis."""
    return examine(world(robot, kind, seed).dataset, seed=0, without=without)


def true_effects(robot: str, kind: str, seed: int) -> set[tuple[str, str]]:
    """Its true effects."""
    return {(effect, where) for effect, where in world(robot, kind, seed).truth["effects"]}


def named(diagnosis: Diagnosis) -> set[tuple[str, str]]:
    """The named effects, with gross errors."""
    return {(found["effect"], found["where"]) for found in diagnosis_json(diagnosis)["effects"]}


def kinds(*names: str) -> list[type[Effect]]:
    """A part of the library: a diagnosis takes half as long with a few suspects as with all."""
    known = {one.name: one for one in EFFECTS}
    return [known[name] for name in names]
