"""Robot descriptions in other formats than URDF, read as an equivalent URDF."""

import contextlib
import io
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.data.importers.robots.dh_table import read_dh_table
from robolaser.errors import RobotError, UsageError
from robolaser.geometry.rigid_motion import exp_so3, from_quaternion, pose
from robolaser.plugins import extra
from robolaser.robot import by_name
from robolaser.robot.by_name.description import Convention
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf.elements import add_fixed, add_link, add_moving

_BEGINNING = 4000


@final
@dataclass(frozen=True)
class DescriptionOptions:
    """Information of the user that a robot's file lacks."""

    dh: Convention | None = None  # of a table of Denavit-Hartenberg numbers: "standard" or "modified"
    units: tuple[str, ...] = ()  # of its lengths and angles
    xacro: Mapping[str, str] = field(default_factory=dict)  # arguments of a xacro file, by name


def find_robot(
    name_or_path: str | Path,
    *,
    flange: str | None = None,
    joints: Sequence[str] | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    options: DescriptionOptions | None = None,
) -> Robot:
    """Load a robot by its name or by the path of its description.

    That is a URDF, a xacro file, an MJCF file, or a table of Denavit-Hartenberg numbers as CSV or TOML.

    Args:
        name_or_path: A name of `robolaser list robots`, with or without its maker, or a path.
        flange: The link that carries the sensor. Default: a known robot's own; from a path, the one link
            that carries no other.
        joints: The columns of q. Default: a known robot's own; from a path, or with another flange, all
            that move the flange.
        gravity: In the base frame, (3,) [m/s²].
        options: Information that the file lacks.

    Raises:
        UsageError: Neither a known name nor a file; or information is missing.
        RobotError: A file with several ends, and no flange; or the robot, flange or joints are not usable, see
            `Robot.from_urdf`.
        DataError: The file cannot be read.
        DependencyMissing: The package of the robot or for the file is not installed.

    Examples:
        >>> robolaser.find_robot("ur5e").joints[0]
        'shoulder_pan_joint'
    """
    read = partial(_urdf_of, stated=options or DescriptionOptions())
    return by_name.find_robot(name_or_path, flange=flange, joints=joints, gravity=gravity, read=read)


def _urdf_of(path: Path, stated: DescriptionOptions) -> str:
    if path.suffix in (".csv", ".toml"):
        return read_dh_table(path, stated.dh, stated.units)
    text = read_text(path, ROBOT_BYTES)
    if "<mujoco" in text[:_BEGINNING]:
        return _mjcf_urdf(path)
    if path.suffix == ".xacro" or "<xacro:" in text:
        return _expanded(path, stated.xacro)
    return text


_UNDEFINED = re.compile(r"Undefined substitution argument (?P<name>\S+)")
MOST_PARENTS = 4  # folders above the file in which a package is sought that the file names by `$(find ...)`


def _expanded(path: Path, arguments: Mapping[str, str]) -> str:
    """The URDF of a xacro file, with arguments as in `xacro FILE NAME:=VALUE`.

    `$(find PACKAGE)` is a folder of that name near the file; else that of an installed ROS.
    """
    missing = f"{path.name} is a xacro file, which needs: pip install 'robolaser[ros]'"
    xacro, substitution_args = extra("xacro", missing), extra("xacro.substitution_args", missing)
    messages = io.StringIO()
    try:
        with contextlib.redirect_stderr(messages), _packages_near(path, substitution_args):
            document: str = xacro.process_file(str(path), mappings=dict(arguments)).toxml()
    except Exception as error:  # xacro evaluates Python
        text = " ".join(str(error).split()) or type(error).__name__
        if undefined := _UNDEFINED.search(text):
            name = undefined["name"]
            message = f"{path.name} asks for the argument {name}. State it with --xacro-arg {name}=VALUE."
            raise UsageError(message) from None
        raise RobotError(f"{path.name}: xacro does not expand it: {text}") from None
    return document


@contextlib.contextmanager
def _packages_near(path: Path, substitution_args: Any) -> Iterator[None]:
    """Let xacro find packages near the file; it has no argument for this."""
    installed = substitution_args._eval_find

    def find(package: str) -> str:
        for folder in list(path.resolve().parents)[:MOST_PARENTS]:
            there = folder if folder.name == package else folder / package
            if there.is_dir():
                return str(there)
        try:
            return str(installed(package))
        except Exception:  # of any type where ROS is absent
            raise RobotError(
                f"the package {package} is missing. Put its folder next to that of {path.name}, or source the ROS"
                " workspace that has it."
            ) from None

    substitution_args._eval_find = find
    substitution_args._eval_dict["find"] = find
    try:
        yield
    finally:
        substitution_args._eval_find = installed
        substitution_args._eval_dict["find"] = installed


TINY_KG = 1e-9  # mass that MuJoCo requires of a body whose mesh is missing; it is not written


def _mjcf_urdf(path: Path) -> str:
    """The bodies, joints and named sites of an MJCF file as a URDF; meshes are not needed.

    A hinge becomes a revolute joint whose zero is MuJoCo's, a slide a prismatic one; a ball or free joint a floating
    one. A body whose mass follows from a missing mesh has none.
    """
    model, mujoco = _compiled(path)
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
            T = _placement(model.site_pos[site], model.site_quat[site])
            add_fixed(robot, f"{name}_site", names[int(model.site_bodyid[site])], name, T)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode") + "\n"


def _compiled(path: Path) -> tuple[Any, Any]:
    mujoco = extra("mujoco", f"{path.name} is for MuJoCo, which reads it: pip install 'robolaser[mujoco]'")
    try:
        return mujoco.MjSpec.from_file(str(path)).compile(), mujoco
    except (ValueError, RuntimeError, mujoco.FatalError):
        pass  # a mesh is missing
    try:
        return _without_meshes(mujoco.MjSpec.from_file(str(path)), mujoco).compile(), mujoco
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
    parent, T = names[int(model.body_parentid[body])], _placement(model.body_pos[body], model.body_quat[body])
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


def _placement(position: Array, wxyz: Array) -> Array:
    return pose(from_quaternion(np.roll(wxyz, -1)), position)
