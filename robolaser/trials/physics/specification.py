"""The URDF of an arm as MuJoCo's own model: a body a link, a foot below the root, and a bracket on the flange."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.errors import DependencyMissing
from robolaser.geometry import urdf
from robolaser.geometry.urdf.tree import Tree
from robolaser.robot.kinematics import Robot
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
    tree = urdf.parse(robot.urdf)
    spec = engine.MjSpec()
    spec.compiler.degree = False
    spec.option.gravity = np.array(robot.gravity)
    foot = spec.worldbody.add_body(name=FOOT, **_mass(LIGHTEST_KG))
    links = {tree.root: _add_link(foot, tree, tree.root, np.eye(4))}
    above = [tree.root]
    for parent in above:
        for joint in tree.joints.values():
            if joint.parent == parent:
                links[joint.child] = _add_link(links[parent], tree, joint.child, joint.origin)
                above.append(joint.child)
    bracket = links[robot.flange].add_body(name=BRACKET, **_mass(LIGHTEST_KG))
    bodies = {FOOT: foot, BRACKET: bracket, **{name: links[tree.joints[name].child] for name in robot.joints}}
    regular = {"armature": ARMATURE}
    turning, sliding = engine.mjtJoint.mjJNT_HINGE, engine.mjtJoint.mjJNT_SLIDE
    for i, hinge in enumerate(hinges):
        bodies[hinge.before].add_joint(
            name=hinge_name(i), type=turning, axis=hinge.axis, pos=hinge.at, armature=ARMATURE
        )
    for name in robot.joints:
        joint = tree.joints[name]
        kind = sliding if joint.kind == "prismatic" else turning
        bodies[name].add_joint(name=joint_name(name), type=kind, axis=joint.axis, **regular)
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


def _add_link(parent: Any, tree: Tree, name: str, origin: Array) -> Any:
    link = tree.links[name]
    x, y, z, w = Rotation.from_matrix(origin[:3, :3]).as_quat()
    return parent.add_body(
        name=body_name(name), pos=origin[:3, 3], quat=[w, x, y, z], ipos=link.com, **_mass(max(link.mass, LIGHTEST_KG))
    )


def _mass(mass: float) -> dict[str, Any]:
    return {"mass": mass, "inertia": [LEAST_INERTIA] * 3, "explicitinertial": True}
