"""The calibrated arm for MuJoCo (MJCF): rigid links, and additional joints for backlash, springs and couplings."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.export.bodies import RADIUS_M, BodyJoint, RigidBody, bodies
from robolaser.export.corrected_arm import CorrectedArm, comment
from robolaser.geometry.rigid_motion import to_quaternion
from robolaser.model.effects.mechanism import ElasticJoint, Footing, MimicJoint, Play
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf.elements import digits

RELAXES_S = 0.02  # settling time of an unloaded spring; its rest position does not depend on it
ROTOR = 0.1  # inertia of a body between two joints about one axis [kg m² or kg]: an engine requires some
HARD = {"solref": "0.004 1", "solimp": "0.9999 0.9999 0.001 0.5 2"}
"""The hardest constraints of MuJoCo with its usual step of 2 ms: they yield by some 1e-8 rad."""


def mjcf(calibration: Calibration) -> str | None:
    """The robot with corrected offsets and placements, and parts for effects in MuJoCo; None without a robot.

    Behind a joint `X` on its axis are `X_play`, `X_spring` and `X_follower` as far as the model has them, with a `_`
    appended to a name that the URDF has: the encoder reads the joint, the link is at their sum. Backlash is a range
    in which friction holds the side of approach; coupling an equality; compliance a spring; payload a body. A comment
    lists what is omitted. Joints that are no columns of q are fixed at neutral, meshes and actuators are omitted. The
    sensor's frames are bodies.
    """
    if calibration.model.dataset.robot is None:
        return None
    arm = CorrectedArm(calibration)
    root = ET.Element("mujoco", model=arm.robot.name)
    for note in arm.without_parts:
        root.append(ET.Comment(f" Not contained: {comment(note)}. "))
    ET.SubElement(root, "compiler", angle="radian", autolimits="true", balanceinertia="true", boundmass="1e-6",
                  boundinertia="1e-8")  # fmt: skip
    option = ET.SubElement(root, "option", gravity=digits(np.array(arm.robot.gravity)), integrator="implicitfast")
    if any(isinstance(part, Play) for part in arm.parts):
        option.set("noslip_iterations", "100")  # creeping friction would use up the play
        option.set("noslip_tolerance", "1e-16")  # by default it ends before two plays hold each other
    world = ET.SubElement(root, "worldbody")
    elements: dict[str, ET.Element] = {}
    mimics = []
    for body in bodies(arm.urdf, arm.robot):
        if body.parent is None:
            elements[body.name] = _root(world, arm, body)
        else:
            elements[body.name] = ET.SubElement(
                elements[body.parent], "body", {"name": body.name, **placement_attributes(body.T)}
            )
            if body.joint is not None:
                _joints(elements[body.name], body.joint, arm)
                mimics += [body.joint.follows] if body.joint.follows else []
        _mass(elements[body.name], body)
    if arm.payload_kg > 0:
        payload = ET.SubElement(elements[arm.robot.flange], "body", name=arm.unused_name("payload"))
        ball = digits(np.full(3, 0.4 * arm.payload_kg * RADIUS_M**2))
        ET.SubElement(payload, "inertial", pos="0 0 0", mass=repr(arm.payload_kg), diaginertia=ball)
    _constraints(root, arm, mimics)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _root(world: ET.Element, arm: CorrectedArm, body: RigidBody) -> ET.Element:
    """The body of the root link: MuJoCo's world, if it has that name and a rigid support."""
    footing = next((part for part in arm.parts if isinstance(part, Footing)), None)
    if body.name == "world" and footing is None:
        return world
    element = ET.SubElement(world, "body", name=arm.unused_name("footing") if body.name == "world" else body.name)
    if footing:
        for number, (axis, stiffness) in enumerate(zip(footing.axes, footing.stiffness, strict=True)):
            line = {"axis": digits(axis), "pos": digits(footing.at)}
            ET.SubElement(element, "joint", _spring(arm.unused_name(f"footing_{number}"), line, float(stiffness)))
    return element


def _joints(element: ET.Element, joint: BodyJoint, arm: CorrectedArm) -> None:
    line = {"axis": digits(joint.axis), "type": "slide" if joint.slides else "hinge"}
    limited = np.isfinite(joint.limits).all() and joint.limits[0] < joint.limits[1]
    limited = {"range": digits(joint.limits)} if limited else {}
    ET.SubElement(element, "joint", {"name": joint.name, **line, **limited})
    for part in arm.parts:
        if isinstance(part, Footing) or part.joint != joint.name:
            continue
        if isinstance(part, ElasticJoint):
            behind = _spring(arm.unused_name(f"{joint.name}_spring"), line, arm.stiffness(part))
        elif isinstance(part, Play):
            width = {"range": digits(np.array([-0.5, 0.5]) * part.width), **_hard("limit")}
            behind = {"name": arm.unused_name(f"{joint.name}_play"), **line, "armature": repr(ROTOR), **width}
        else:
            behind = {"name": _follower(arm, part), **line, "armature": repr(ROTOR)}
        ET.SubElement(element, "joint", behind)


def _follower(arm: CorrectedArm, part: MimicJoint) -> str:
    """The joint that follows another one behind a joint, which may follow several."""
    others = [one.other for one in arm.parts if isinstance(one, MimicJoint) and one.joint == part.joint]
    number = others.index(part.other)
    return arm.unused_name(f"{part.joint}_follower" + (f"_{number + 1}" if number else ""))


def _hard(kind: str = "") -> dict[str, str]:
    return {f"{key}{kind}": value for key, value in HARD.items()}


def _spring(name: str, line: Mapping[str, str], stiffness: float) -> dict[str, str]:
    """Critically damped: MuJoCo solves constraints as if undamped, and diverges where damping dominates."""
    damping, inertia = stiffness * RELAXES_S, stiffness * RELAXES_S**2 / 4
    return {"name": name, **line, "stiffness": repr(stiffness), "damping": repr(damping), "armature": repr(inertia)}


def _constraints(root: ET.Element, arm: CorrectedArm, mimics: Sequence[MimicJoint]) -> None:
    """Constraints between joints: gears that follow, and friction of links with play."""
    followers = [part for part in arm.parts if isinstance(part, MimicJoint)]
    plays = [part for part in arm.parts if isinstance(part, Play)]
    tied = [(_follower(arm, part), part) for part in followers]
    tied += [(mimic.joint, mimic) for mimic in mimics]
    if tied:
        equality = ET.SubElement(root, "equality")
        for name, part in tied:
            ratio = f"{part.offset!r} {part.ratio!r} 0 0 0"
            ET.SubElement(equality, "joint", {"joint1": name, "joint2": part.other, "polycoef": ratio, **_hard()})
    if plays:
        tendon = ET.SubElement(root, "tendon")
        for play in plays:
            rubs = {"name": f"{play.joint}_friction", "frictionloss": repr(play.friction), **_hard("friction")}
            fixed = ET.SubElement(tendon, "fixed", rubs)
            for joint in (play.joint, arm.unused_name(f"{play.joint}_play")):
                ET.SubElement(fixed, "joint", joint=joint, coef="1")


def _mass(element: ET.Element, body: RigidBody) -> None:
    if body.mass > 0 and element.tag == "body":
        terms = body.inertia[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
        inertial = ET.Element("inertial", pos=digits(body.com), mass=repr(body.mass), fullinertia=digits(terms))
        element.insert(0, inertial)


def placement_attributes(T: Array) -> dict[str, str]:
    """`pos` and `quat` of a placement (4, 4), exact to the last bit."""
    return {"pos": digits(T[:3, 3]), "quat": digits(np.roll(to_quaternion(T[:3, :3]), 1))}


BEYOND_PLAY: Final = 0.03  # end of a joint's move, longer than any play: earlier positions do not matter [rad, m]
WAY_S: Final = 0.1  # in which MuJoCo drives the ends of an arm's moves. A judgement: faster, a link slips in its play.
REST_S: Final = 2.0  # in which an arm comes to rest at most. A judgement: heavy arms swing on soft gears for a second.
ROUNDS: Final = 4  # in which springs find where they hold the links, each with a hundredth of the error before
STILL: Final = 1e-5  # speed and change of speed in a step below which an arm is at rest [rad/s, m/s]


def flange_by_mjcf(text: str, robot: Robot, paths: Array) -> Array:
    """T_base_flange of an MJCF at rest at the ends of paths, which decide the sides of plays, (n, p, j) -> (n, 4, 4).

    NaN where the simulation diverges: MuJoCo would reset, and would report that on the terminal and in a file of the
    current folder.
    """
    import mujoco  # noqa: PLC0415 - an extra

    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        return _simulated(mujoco.MjModel.from_xml_string(text), robot, paths)
    finally:
        mujoco.set_mju_user_warning(previous)


def _simulated(model: Any, robot: Robot, paths: Array) -> Array:
    import mujoco  # noqa: PLC0415 - an extra

    bad = [getattr(mujoco.mjtWarning, f"mjWARN_BAD{what}") for what in ("QPOS", "QVEL", "QACC")]
    state = mujoco.MjData(model)
    columns = [int(model.joint(name).qposadr[0]) for name in robot.joints]
    model.dof_armature[columns] = 1e6
    step_s, qpos, qvel = model.opt.timestep, state.qpos, state.qvel  # views, which take longer to get than to fill
    steps, rest = (round(duration / step_s) for duration in (WAY_S, REST_S))
    shares = (1.0 - np.cos(np.pi * np.arange(1, steps + 1) / steps))[:, None] / 2.0
    (springs,) = np.nonzero(model.jnt_stiffness)
    stiffness, sprung, loaded = model.jnt_stiffness[springs], model.jnt_qposadr[springs], model.jnt_dofadr[springs]
    flange, found = model.body(robot.flange).id, np.tile(np.eye(4), (len(paths), 1, 1))
    for T, path in zip(found, paths, strict=True):
        mujoco.mj_resetData(model, state)
        way = _ends(path)
        qpos[columns] = way[0]
        for _ in range(ROUNDS if len(springs) else 0):
            mujoco.mj_forward(model, state)
            qpos[sprung] = -state.qfrc_bias[loaded] / stiffness
        for before, then in pairwise(way if model.ntendon else way[-1:]):
            for now in before + shares * (then - before):
                qvel[columns] = (now - qpos[columns]) / step_s
                mujoco.mj_step(model, state)
        for _ in range(rest if model.nv > len(columns) else 0):
            qpos[columns], qvel[columns] = path[-1], 0.0
            mujoco.mj_step(model, state)
            if max(np.abs(qvel).max(), step_s * np.abs(state.qacc).max()) < STILL:
                break
        qpos[columns] = path[-1]
        mujoco.mj_forward(model, state)
        T[:3, :3], T[:3, 3] = state.xmat[flange].reshape(3, 3), state.xpos[flange]
        if any(state.warning[one].number for one in bad):
            return np.full_like(found, np.nan)
    return found


def _ends(path: Array) -> Array:
    """A path (p, j) with the same end and the same plays there, of short moves, from the last that all joints made."""
    moves = np.diff(path, axis=0)
    (all_moved,) = np.nonzero(np.abs(moves).min(axis=1) > BEYOND_PLAY)
    short = np.clip(moves, -BEYOND_PLAY, BEYOND_PLAY)[all_moved.max(initial=0) :]
    return np.concatenate([path[-1] - np.cumsum(short[::-1], axis=0)[::-1], path[-1:]])
