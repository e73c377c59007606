"""The parameters as rows of a table: value and error, bounds, and caveats."""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from robolaser.calibration.result import Calibration
from robolaser.report.digits import measured, plain
from robolaser.report.document import TableCell

FIXED, ON_BOUND, UNDETERMINED = "fixed", "on its bound", "not determined by these data"
CORRELATED = "hardly distinguishable from others"


def parameter_rows(calibration: Calibration) -> tuple[list[Sequence[TableCell]], list[Sequence[TableCell]]]:
    """The sensor's parameters: with bounds from the user, and started from a closed form.

    Cells: name, value, nominal value, bounds and caveat; the latter have no nominal value.
    """
    model = calibration.model
    given: list[Sequence[TableCell]] = []
    placed: list[Sequence[TableCell]] = []
    for i, item in enumerate(model.parameters.items[: len(model.parameters) - len(model.effect_parameters)]):
        name = TableCell(item.name, below=[text] if (text := meaning(item.name)) else [])
        value, caveat = TableCell(_measured(calibration, i)), note(calibration, i)
        if item.given:
            nominal = TableCell(plain(item.nominal, item.unit))
            within = [] if item.fixed else [f"{plain(item.lower, item.unit)} to {plain(item.upper, item.unit)}"]
            given.append((name, value, nominal, TableCell(below=within, note=caveat)))
        else:
            placed.append((name, value, TableCell(note=caveat)))
    return given, placed


def effect_rows(calibration: Calibration) -> list[Sequence[TableCell]]:
    """The numbers of the effects in the model: name, value, standard deviations from zero, and caveat."""
    from robolaser.diagnosis.cause_words import named  # noqa: PLC0415 - brings all of a diagnosis

    names = calibration.model.parameters.names
    rows: list[Sequence[TableCell]] = []
    for one in calibration.model.effects:
        for item in one.parameters.items:
            i = names.index(item.name)
            value, std = float(calibration.x[i]), float(calibration.std[i])
            away = abs(value) / std if np.isfinite(std) and std > 0 else None
            which = f"{named(one)}, {item.name.rpartition('.')[2].replace('_', ' ')}"
            what, size = TableCell(which, below=[one.effect.title]), TableCell(_measured(calibration, i))
            clear = TableCell("" if away is None else f"{away:.1f}", order=away)
            rows.append((what, size, clear, TableCell(note=note(calibration, i))))
    return rows


def _measured(calibration: Calibration, i: int) -> str:
    return measured(float(calibration.x[i]), float(calibration.std[i]), calibration.model.parameters.items[i].unit)


def note(calibration: Calibration, i: int) -> str:
    """The caveat about the i-th parameter; may be empty."""
    name = calibration.model.parameters.names[i]
    if name in calibration.model.blocks.held:
        return FIXED
    if calibration.on_bound[i]:
        return ON_BOUND
    if not np.isfinite(calibration.std[i]):
        return UNDETERMINED
    held = set(calibration.model.blocks.fixed)
    shared = [set(direction.parameters) for direction in calibration.unidentifiable if name in direction.parameters]
    if any(not held & names for names in shared):
        return CORRELATED
    item = calibration.model.parameters.items[i]
    started = "" if item.given or not item.origin else f"started from {item.origin}"
    return f"given {' and '.join(sorted(held))}" if shared else started


_OF_CAMERAS: Mapping[str, str] = {
    "f": "effective focal length",
    "s_u": "pixel pitch along image u",
    "s_v": "pixel pitch along image v",
    "u_0": "principal point, u",
    "v_0": "principal point, v",
    "k": "radial lens distortion",
    "b": "baseline, camera to laser plane",
    "theta": "tilt of the laser plane",
    "w": "camera turned on the flange, 1st angle",
    "phi": "camera turned on the flange, 2nd angle",
    "psi": "camera turned on the flange, 3rd angle",
    "t_x": "camera on the flange, x",
    "t_y": "camera on the flange, y",
    "t_z": "camera on the flange, z",
    "fx": "focal length along image u",
    "fy": "focal length along image v",
    "cx": "principal point, u",
    "cy": "principal point, v",
    "k1": "radial lens distortion, 1st term",
    "k2": "radial lens distortion, 2nd term",
    "k3": "radial lens distortion, 3rd term",
    "p1": "decentred lens, 1st term",
    "p2": "decentred lens, 2nd term",
}
_SIX = {"w": "1st angle", "phi": "2nd angle", "psi": "3rd angle"}
_IN_SESSION = re.compile(r"(?P<parameter>.+\.(?:x|y|z|w|phi|psi))@(?P<session>.+)")


def meaning(name: str) -> str:
    """The meaning of a sensor's parameter; empty for an unknown name."""
    if own := _OF_CAMERAS.get(name):
        return own
    if matched := _IN_SESSION.fullmatch(name):
        return f"{meaning(matched['parameter'])}, session {matched['session']}"
    thing, _, part = name.rpartition(".")
    part = _SIX.get(part, part)
    kind, _, which = thing.partition(".")
    meanings = {
        "target": "pose of the target",
        "base": "robot base in the tracker's frame",
        "tool": "ball on the flange" if which == "ball" else f"point {which} on the flange",
        "socket": f"socket {which} in the base frame",
        "hand_eye": "sensor on the flange or in the cell",
        "ball": f"ball {which}",
    }
    return f"{meanings[kind]}, {part}" if kind in meanings else ""
