"""Effects that a calibration found: each of a kind that is known here, at a place where that kind may sit, and once."""

from collections.abc import Sequence

from robolaser.errors import CalibrationUnreadable, EffectForeign
from robolaser.geometry.kinematics import Robot
from robolaser.model import effects as library
from robolaser.model.effects.effect import CandidateEffect
from robolaser.scan.entries import Entries


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
    found: list[CandidateEffect] = []
    for part in parts:
        name, where = part.text("effect"), part.text("where")
        if name not in kinds:
            raise EffectForeign(part.path, name, kinds)
        places = kinds[name].sites(robot)
        if where not in places:
            which = f"it can at {', '.join(places)}" if places else "its arm has no joint for it"
            raise CalibrationUnreadable(part.path, f"its {name} sits at '{where}', where it cannot: {which}")
        candidate_effect = CandidateEffect(kinds[name], where)
        if candidate_effect in found:
            raise CalibrationUnreadable(part.path, f"it has {name} at {where} twice")
        found.append(candidate_effect)
    return tuple(found)
