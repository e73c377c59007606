"""The URDF of an arm as MuJoCo's own model: a body a link, a foot below the root, and a bracket on the flange."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.errors import DependencyMissing
from robolaser.robot.kinematics import Robot
from robolaser.robot.pinocchio_model import Link, PinocchioModel
from robolaser.trials.physics.elements import BRACKET, FOOT, Gear, Load, SpringHinge

LIGHTEST_KG, LEAST_INERTIA, ARMATURE = 1e-9, 1e-9, 1.0  # keep the engine's inertia regular; at rest they do nothing


def mujoco() -> Any:
    """The engine, which is slow to import.

    Raises:
        DependencyMissing: It is not installed.
    """
    try:
        import mujoco as engine  # noqa: PLC0415 - an extra, and slow to import
    except ImportError:
        raise DependencyMissing(
            "MuJoCo, which moves the arms of the kind 'physics', is not installed: pip install 'robolaser[trials]'."
        ) from None
    return engine


def specification(
    engine: Any, robot: Robot, hinges: Sequence[SpringHinge], gears: Mapping[str, Gear], load: Load | None
) -> Any:
    """An editable model (MjSpec) with the robot's joints and all that is soft; it has no stiffness yet.

    Joints that the robot does not list stay at neutral.
    """
    arm = robot.by_pinocchio
    spec = engine.MjSpec()
    spec.compiler.degree = False
    spec.option.gravity = np.array(robot.gravity)
    foot = spec.worldbody.add_body(name=FOOT, **_mass(LIGHTEST_KG))
    links: dict[str, Any] = {}
    for link in arm.links:
        links[link.name] = _add_link(links.get(link.parent, foot), arm, link)
    moved = {arm.moving[link.joint]: links[link.name] for link in arm.links if link.joint is not None}
    bracket = links[robot.flange].add_body(name=BRACKET, **_mass(LIGHTEST_KG))
    bodies = {FOOT: foot, BRACKET: bracket, **moved}
    regular = {"armature": ARMATURE}
    turning, sliding = engine.mjtJoint.mjJNT_HINGE, engine.mjtJoint.mjJNT_SLIDE
    for i, hinge in enumerate(hinges):
        bodies[hinge.before].add_joint(
            name=hinge_name(i), type=turning, axis=hinge.axis, pos=hinge.at, armature=ARMATURE
        )
    for name, axis, slides in zip(robot.joints, robot.axes, robot.prismatic, strict=True):
        bodies[name].add_joint(name=joint_name(name), type=sliding if slides else turning, axis=axis, **regular)
    for name, gear in gears.items():
        if gear.servo:
            servo = spec.add_actuator(name=name, target=joint_name(name), trntype=engine.mjtTrn.mjTRN_JOINT)
            servo.biastype = engine.mjtBias.mjBIAS_AFFINE
            servo.gainprm[0], servo.biasprm[1] = gear.stiffness, -gear.stiffness
    if load is not None:
        bracket.add_body(name="load", pos=load.at, **_mass(load.mass))
    return spec


def body_name(link: str) -> str:
    """Of a link's body."""
    return f"link {link}"


def joint_name(joint: str) -> str:
    """Of a joint of the URDF."""
    return f"joint {joint}"


def hinge_name(number: int) -> str:
    """Of a spring hinge."""
    return f"hinge {number}"


def _add_link(parent: Any, arm: PinocchioModel, link: Link) -> Any:
    """The body of a link; a joint's first link has the mass of all that the joint moves up to the next joints."""
    x, y, z, w = Rotation.from_matrix(link.T_parent_link[:3, :3]).as_quat()
    mass, com = (0.0, np.zeros(3)) if link.joint is None else (float(arm.masses[link.joint]), arm.centres[link.joint])
    return parent.add_body(
        name=body_name(link.name), pos=link.T_parent_link[:3, 3], quat=[w, x, y, z], ipos=com,
        **_mass(max(mass, LIGHTEST_KG)),
    )  # fmt: skip


def _mass(mass: float) -> dict[str, Any]:
    return {"mass": mass, "inertia": [LEAST_INERTIA] * 3, "explicitinertial": True}
