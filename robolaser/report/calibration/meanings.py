"""What each parameter is, in a few words."""

import re
from collections.abc import Mapping

from robolaser.model.effects import EFFECTS

_SCANNER: Mapping[str, str] = {
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
}
_CAMERA: Mapping[str, str] = {
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
    """What a sensor's parameter is; empty for an unknown name."""
    if own := _SCANNER.get(name) or _CAMERA.get(name):
        return own
    if matched := _IN_SESSION.fullmatch(name):
        return f"{meaning(matched['parameter'])}, session {matched['session']}"
    thing, _, part = name.rpartition(".")
    part = _SIX.get(part, part)
    kind, _, which = thing.partition(".")
    meanings = {
        "target": "place of the target",
        "base": "robot base in the tracker's frame",
        "tool": "ball on the flange" if which == "ball" else f"point {which} on the flange",
        "socket": f"socket {which} in the base frame",
        "hand_eye": "sensor on the flange or in the cell",
        "ball": f"ball {which}",
    }
    return f"{meanings[kind]}, {part}" if kind in meanings else ""


def effect_meaning(effect: str) -> str:
    """What an effect is."""
    return {kind.name: kind.title for kind in EFFECTS}.get(effect, "")
