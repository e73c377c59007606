"""Cells with faults that are not simulated by the effect library."""

from functools import cache

from robolaser.diagnosis import Diagnosis, examine
from robolaser.diagnosis.result_json import diagnosis_json
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
