"""MuJoCo's descriptions of robots (MJCF): compiled without their meshes, and as a URDF."""

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import exp_so3, from_quaternion, pose
from robolaser.plugins import extra
from robolaser.robot.urdf.elements import add_fixed, add_link, add_moving

TINY_KG = 1e-9  # mass that MuJoCo requires of a body whose mesh is missing; it is not written


def mjcf_urdf(path: Path) -> str:
    """The bodies, joints and named sites of an MJCF file as a URDF; meshes are not needed.

    A hinge becomes a revolute joint whose zero is MuJoCo's, a slide a prismatic one; a ball or free joint a floating
    one. A body whose mass follows from a missing mesh has none.
    """
    model, mujoco = compiled_mjcf(path)
    robot = ET.Element("robot", name=path.stem)
    names = _body_names(model)
    for body in range(model.nbody):
        mass = float(model.body_mass[body])
        add_link(robot, names[body], mass if mass > TINY_KG else 0.0, model.body_ipos[body])
        if body:
            _attach(robot, model, mujoco, body, names)
    for site in range(model.nsite):
        name = model.site(site).name
        if name and name not in names:
            add_link(robot, name)
            T = placement(model.site_pos[site], model.site_quat[site])
            add_fixed(robot, f"{name}_site", names[int(model.site_bodyid[site])], name, T)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode") + "\n"


def compiled_mjcf(path: Path) -> tuple[Any, Any]:
    """MuJoCo's model of an MJCF file, with all of its bodies, and the package.

    Raises:
        RobotError: MuJoCo does not read it, even without meshes.
        DependencyMissing: MuJoCo is not installed.
    """
    mujoco = extra("mujoco", f"{path.name} is for MuJoCo, which reads it: pip install 'robolaser[mujoco]'")

    def read() -> Any:
        spec = mujoco.MjSpec.from_file(str(path))
        spec.compiler.fusestatic = False
        return spec

    try:
        return read().compile(), mujoco
    except (ValueError, RuntimeError, mujoco.FatalError):
        pass  # a mesh is missing
    try:
        return _without_meshes(read(), mujoco).compile(), mujoco
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise RobotError(f"{path.name}: MuJoCo does not read it: {' '.join(str(error).split())}") from None


def _without_meshes(spec: Any, mujoco: Any) -> Any:
    """The same without shapes that need files, and without elements that may refer to them."""
    for geom in list(spec.geoms):
        if geom.type in (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_HFIELD):
            spec.delete(geom)
        else:
            geom.material = ""
    for family in ("keys", "sensors", "actuators", "tendons", "equalities", "pairs", "excludes", "skins", "meshes",
                   "hfields", "materials", "textures"):  # fmt: skip
        for part in list(getattr(spec, family)):
            spec.delete(part)
    spec.compiler.boundmass, spec.compiler.boundinertia = TINY_KG, TINY_KG
    return spec


def _body_names(model: Any) -> list[str]:
    names = [model.body(body).name or f"body_{body}" for body in range(model.nbody)]
    twice = {name for name in names if names.count(name) > 1}
    return [f"{name}_{number}" if name in twice else name for number, name in enumerate(names)]


def _attach(robot: ET.Element, model: Any, mujoco: Any, body: int, names: list[str]) -> None:
    """The chain of joints between a body and its parent; all links but the last have no mass."""
    parent, T = names[int(model.body_parentid[body])], placement(model.body_pos[body], model.body_quat[body])
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    for number in range(first, first + count):
        joint, kind = model.joint(number), int(model.jnt_type[number])
        name = joint.name or f"joint_{number}"
        child, slides = f"{name}_link", kind == mujoco.mjtJoint.mjJNT_SLIDE
        add_link(robot, child)
        if not slides and kind != mujoco.mjtJoint.mjJNT_HINGE:
            add_fixed(robot, name, parent, child, T, "floating")
            parent, T = child, np.eye(4)
            continue
        back = -float(model.qpos0[int(model.jnt_qposadr[number])]) * joint.axis  # from where the body is described
        at_zero = pose(np.eye(3), joint.pos + back) if slides else pose(exp_so3(back), joint.pos)
        lower, upper = map(float, joint.range) if bool(model.jnt_limited[number]) else (-math.inf, math.inf)
        add_moving(robot, name, parent, child, T @ at_zero, joint.axis, (lower, upper), slides=slides)
        parent, T = child, pose(np.eye(3), -joint.pos)
    add_fixed(robot, f"{names[body]}_placement", parent, names[body], T)


def placement(position: Array, wxyz: Array) -> Array:
    """Of positions (..., 3) [m] and quaternions as MuJoCo orders them, (..., 4) -> (..., 4, 4)."""
    return pose(from_quaternion(np.roll(wxyz, -1, axis=-1)), position)
