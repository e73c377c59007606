"""Effects that a calibration found: each of a kind that is known here, at a place where that kind may sit, and once."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.errors import CalibrationUnreadable, EffectForeign
from robolaser.geometry.kinematics import Robot
from robolaser.model import effects as library
from robolaser.model.effects.effect import CandidateEffect
from robolaser.scan.entries import Entries

SITES = ("camera", "laser", "hand_eye", "target", "base", "timing", "image", "tool")
POSES = 25  # more than any effect asks for
SIDE = 5  # points along a side of the target: enough for a plane


def effects_in_file(parts: Sequence[Entries], robot: Robot | None) -> tuple[CandidateEffect, ...]:
    """The effects that a file names.

    Args:
        parts: Each names its `effect` and `where`.
        robot: The arm that they may sit in; None where flange poses were measured.

    Raises:
        EffectForeign: A kind is not known here.
        CalibrationUnreadable: One sits where it cannot, or twice at one place.
    """
    kinds = {kind.name: kind for kind in library.EFFECTS}
    cell = complete(robot)
    joints = () if robot is None else robot.joints
    found: list[CandidateEffect] = []
    for part in parts:
        name, where = part.text("effect"), part.text("where")
        if name not in kinds:
            raise EffectForeign(part.path, name, kinds)
        places = kinds[name].places(cell)
        if not places and joints:  # a kind from elsewhere that looks at columns of its own: anything that has a name
            places = (*SITES, *joints)
        if where not in places:
            which = f"it can at {', '.join(places)}" if places else kinds[name].missing(cell)
            raise CalibrationUnreadable(part.path, f"its {name} sits at '{where}', where it cannot: {which}")
        candidate_effect = CandidateEffect(kinds[name], where)
        if candidate_effect in found:
            raise CalibrationUnreadable(part.path, f"it has {name} at {where} twice")
        found.append(candidate_effect)
    return tuple(found)


def complete(robot: Robot | None) -> Dataset:
    """Data of a scanner on an arm that lack nothing an effect may look at: where it has no place, it never has."""
    run = np.arange(float(POSES))
    names, loaded = tuple(map(str, range(POSES))), np.ones(POSES)
    poses = Poses(names, run, None, None, np.eye(4)[None].repeat(POSES, 0), payload_kg=loaded, temperature_c=run)
    if robot is not None:
        q = run[:, None] * np.ones(len(robot.joints))
        poses = replace(poses, q=q, qd=np.ones_like(q), T_base_flange=None)
    grid = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE), [0.0]), axis=-1).reshape(-1, 3)
    n = len(grid)
    points = Points(np.arange(n) % POSES, tuple(map(str, range(n))), pixel=grid[:, :2], xyz=grid)
    return Dataset("", poses, points, robot=robot, image_px=(SIDE, SIDE))
