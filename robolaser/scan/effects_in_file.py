"""Effects that a calibration found: each is known here, at a location where it can be, and there once."""

from collections.abc import Sequence

from robolaser.errors import EffectError, near
from robolaser.model import effects as library
from robolaser.model.effects.effect import CandidateEffect
from robolaser.robot.kinematics import Robot
from robolaser.scan.json_object import JsonObject, unusable


def effects_in_file(parts: Sequence[JsonObject], robot: Robot | None) -> tuple[CandidateEffect, ...]:
    """The effects that a file names.

    Args:
        parts: Each names its `effect` and `where`.
        robot: The arm in which they may be; None where flange poses were measured.

    Raises:
        EffectError: One of them is not known here.
        DataError: One is where it cannot be, or twice at one location.
    """
    known = {effect.name: effect for effect in library.EFFECTS}
    found: list[CandidateEffect] = []
    for part in parts:
        name, where = part.text("effect"), part.text("where")
        if name not in known:
            raise EffectError(
                f"{part.path} has the effect '{name}' in its model, which is not known here.{near(name, known)} Install"
                " the package that provides it, or calibrate again without it."
            )
        locations = known[name].sites(robot)
        if where not in locations:
            which = f"it can be at {', '.join(locations)}" if locations else "its arm has no joint for it"
            raise unusable(part.path, f"its {name} is at '{where}', where it cannot be: {which}")
        candidate_effect = CandidateEffect(known[name], where)
        if candidate_effect in found:
            raise unusable(part.path, f"it has {name} at {where} twice")
        found.append(candidate_effect)
    return tuple(found)
