"""calibration.yaml: the corrected arm as Universal Robots' ROS driver and description take a robot's kinematics."""

import re
import xml.etree.ElementTree as ET
from hashlib import sha256
from typing import Final

from robolaser.calibration.result import Calibration
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf.checking import read_xml

LINKS: Final = {
    "shoulder": "shoulder_pan_joint",
    "upper_arm": "shoulder_lift_joint",
    "forearm": "elbow_joint",
    "wrist_1": "wrist_1_joint",
    "wrist_2": "wrist_2_joint",
    "wrist_3": "wrist_3_joint",
}
"""The makers' names of the links, and the joint of the URDF whose origin each is."""
NUMBERS: Final = (("xyz", ("x", "y", "z")), ("rpy", ("roll", "pitch", "yaw")))


def ur_calibration(calibration: Calibration) -> str | None:
    """The file; None where the arm is none of theirs, or nothing that it can hold was found."""
    robot, corrected = calibration.model.dataset.robot, calibration.robot
    if robot is None or corrected is None or corrected is robot or tuple(robot.joints) != tuple(LINKS.values()):
        return None
    origins = {joint: origin for joint, origin in _origins(read_xml(corrected.urdf)).items() if joint in robot.joints}
    lines = []
    for name, joint in LINKS.items():
        lines.append(f"  {name}:\n")
        for attribute, keys in NUMBERS:
            values = origins[joint].get(attribute, "0 0 0").split()
            lines += [f"    {key}: {float(value)!r}\n" for key, value in zip(keys, values, strict=True)]
    digest = sha256("".join(lines).encode()).hexdigest()[:20]
    return f"kinematics:\n{''.join(lines)}  hash: calib_{digest}\n"


def with_ur_calibration(robot: Robot, text: str) -> Robot:
    """The arm as its description makes it from a calibration.yaml.

    Args:
        robot: The nominal arm.
        text: The file.
    """
    root = read_xml(robot.urdf)
    for name, joint in LINKS.items():
        own = text.partition(f"  {name}:\n")[2]
        for attribute, keys in NUMBERS:
            values = (re.search(rf"^    {key}: (\S+)$", own, re.MULTILINE) for key in keys)
            _origins(root)[joint].set(attribute, " ".join(found[1] for found in values if found))
    urdf = ET.tostring(root, encoding="unicode")
    return Robot.from_urdf(urdf, flange=robot.flange, joints=robot.joints, gravity=robot.gravity)


def _origins(root: ET.Element) -> dict[str, ET.Element]:
    """The origins of the joints of a URDF, by name; made where one has none."""
    found = {}
    for joint in root.findall("joint"):
        origin = joint.find("origin")
        found[joint.get("name", "")] = ET.SubElement(joint, "origin") if origin is None else origin
    return found
