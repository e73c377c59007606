"""`corrected.py`: the calibrated arm as one file of Python without dependencies."""

from pathlib import Path
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.export.corrected_arm import CorrectedArm
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import apply
from robolaser.model.blocks.cell_frames import base_frames, flange_frames
from robolaser.model.effects.effect import perturb_with
from robolaser.model.stages import Stage
from robolaser.robot.kinematics import Robot

LINE = "# " + "-" * 118 + "\n"
HEAD = '''"""{name}: the calibrated arm. Joint values in, poses of flange and sensor out.

    import corrected
    T_base_flange = corrected.flange([0.1, -0.5, 0.9])

Poses are 4 x 4 lists in metres, in the frame of the URDF's root link. Written by robolaser.
{notes}"""

import math
from collections.abc import Iterator, Sequence

Matrix = list[list[float]]
'''


def corrected_module(calibration: Calibration) -> str | None:
    """Joint values in, flange and sensor poses out, by the standard library alone; None without a robot.

    It does what the model does, with every effect of joints, links and base that has a `code`; a note names the others.
    The stated payload is its mean over the poses, and a mount that moves stands as at the first pose.
    """
    if calibration.model.dataset.robot is None:
        return None
    arm, model = CorrectedArm(calibration), calibration.model
    robot, run = arm.robot, model.run
    values = model.parameters.values(calibration.x[None])
    perturb = model.perturb(values)
    geometry = perturb_with(
        tuple(effect for one, effect in arm.effects if one.effect.in_urdf and one.effect.stage is Stage.LINKS), run
    )
    bends, moves, left_out = [], [], []
    for one, effect in arm.effects:
        code = effect.code(run)
        if code.startswith("lag("):
            bends.append(f"    {code}")
        elif code and one.effect.stage is Stage.JOINTS:
            bends += ["    for q, before, read in steps(path, readings):", f"        {code}"]
        elif code:
            moves.append(f"    {code}")
        elif not one.effect.in_urdf:
            left_out.append(arm.said(one))
    numbers: dict[str, Any] = {
        "JOINTS": list(robot.joints),
        "PLACEMENTS": geometry(Stage.LINKS, robot.placements[None, None])[0, 0].tolist(),
        "NOMINAL": robot.placements.tolist(),
        "AXES": robot.axes.tolist(),
        "SLIDES": robot.prismatic.tolist(),
        "CHAIN": list(robot.chain),
        "END": robot.end.tolist(),
        "MASSES": masses(robot, arm.stated_payload_kg),
        "GRAVITY": list(robot.gravity),
        "FRAMES": _listed(flange_frames(model.blocks, values, perturb)),
        "CELL": _listed(base_frames(model.blocks, values, perturb)),
    }
    source = Path(__file__).with_name("runtime.py").read_text(encoding="utf-8").partition(LINE)[2]
    notes = "".join(f"Not contained: {note}.\n" for note in left_out).replace("\\", "/").replace('"', "'")
    return "".join(
        [
            HEAD.format(name=_plain(model.dataset.name), notes=notes),
            "".join(f"{name} = {value!r}\n" for name, value in numbers.items()),
            "\n\ndef bend(path: list[list[float]], readings: list[list[float]]) -> None:\n",
            "\n".join(['    """Joint values as they are, in place of those read, along a path."""', *bends]),
            "\n\n\ndef move(T: Matrix, read: list[float]) -> Matrix:\n",
            "\n".join(['    """Where the flange is on what gives way under the arm."""', *moves, "    return T"]),
            source,
        ]
    )


def masses(robot: Robot, payload_kg: float) -> list[tuple[float, list[float]]]:
    """Mass [kg] and its centre [m] in the frame of each joint of the chain, the payload at the flange's origin."""
    tree = urdf.parse(robot.urdf)
    place = {robot.joints[i]: n for n, i in enumerate(robot.chain)}
    mass, moment = np.zeros(len(place)), np.zeros((len(place), 3))
    mass[-1], moment[-1] = payload_kg, payload_kg * robot.end[:3, 3]
    for link in tree.links.values():
        carrier, T = -1, np.eye(4)
        for joint in tree.path(link.name):
            T = T @ joint.origin
            if joint.name in place:
                carrier, T = place[joint.name], np.eye(4)
        if link.mass > 0 and carrier >= 0:
            mass[carrier] += link.mass
            moment[carrier] += link.mass * apply(T, link.com)
    centres = moment / np.where(mass > 0, mass, 1.0)[:, None]
    return [(m, centre) for m, centre in zip(mass.tolist(), centres.tolist(), strict=True)]


def _listed(frames: dict[str, Array]) -> dict[str, Any]:
    return {name: T.tolist() for name, T in frames.items()}


def _plain(text: str) -> str:
    return "".join(letter for letter in text if letter.isprintable()).replace("\\", "/").replace('"', "'")
