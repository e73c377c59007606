"""A robot by screws, independent of the package: products of exponentials, gravity torques as energy gradients.

Lynch, Park 2017, Modern Robotics, ch. 4.1.
"""

import xml.etree.ElementTree as ET

import numpy as np
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

SHIFT = 1e-30  # of the complex step, which has no cancellation


class Screws:
    """The arm of a plain URDF; `moved` replaces the origins of joints."""

    def __init__(self, text, joints, moved=None):
        robot = ET.fromstring(text.strip())
        self.joints, self.above = list(joints), {one.find("child").get("link"): one for one in robot.findall("joint")}
        self.links = {one.get("name"): one for one in robot.findall("link")}
        self.moved = moved or {}

    def way(self, link):
        """The joints between the base and a link, from the base."""
        way = []
        while link in self.above:
            way.insert(0, self.above[link])
            link = way[0].find("parent").get("link")
        return way

    def value(self, joint, row):
        """A joint's value: from its reading, from the joint that it mimics, or zero."""
        mimic = joint.find("mimic")
        if joint.get("name") in self.joints:
            return row[self.joints.index(joint.get("name"))]
        if mimic is None:
            return 0.0
        (leader,) = (one for one in self.above.values() if one.get("name") == mimic.get("joint"))
        return float(mimic.get("multiplier", 1)) * self.value(leader, row) + float(mimic.get("offset", 0))

    def link(self, name, row):
        """T_base_link at one configuration (j,)."""
        T, turned = np.eye(4), np.eye(4)
        for joint in self.way(name):
            T = T @ self.moved.get(joint.get("name"), origin(joint))
            if joint.get("type") != "fixed":
                turned = turned @ expm(screw(T, joint) * self.value(joint, row))
        return turned @ T

    def forward(self, q, flange):
        """T_base_flange, (n, 4, 4)."""
        return np.array([self.link(flange, row) for row in q])

    def weight_energy(self, row, gravity):
        """Potential energy of all masses at one configuration [J]."""
        energy = 0.0
        for name, link in self.links.items():
            body = link.find("inertial")
            if body is not None:
                energy -= (
                    float(body.find("mass").get("value")) * self.link(name, row)[:3] @ origin(body)[:, 3] @ gravity
                )
        return energy

    def torques(self, q, gravity=(0.0, 0.0, -9.81)):
        """Gravity torques of the joints, (n, j): the gradient of the energy, by complex steps."""
        steps = 1j * SHIFT * np.eye(len(self.joints))
        return np.array([[self.weight_energy(row + step, gravity).imag / SHIFT for step in steps] for row in q])


def origin(element):
    """The transform of an element's origin, (4, 4)."""
    found = element.find("origin")
    stated = {} if found is None else found.attrib
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", [float(x) for x in stated.get("rpy", "0 0 0").split()]).as_matrix()
    T[:3, 3] = [float(x) for x in stated.get("xyz", "0 0 0").split()]
    return T


def screw(T, joint):
    """The twist (4, 4) of a joint at T in the base frame."""
    stated = joint.find("axis")
    axis = np.array([float(x) for x in (stated.get("xyz") if stated is not None else "1 0 0").split()])
    x, y, z = T[:3, :3] @ (axis / np.linalg.norm(axis))
    twist = np.zeros((4, 4))
    if joint.get("type") == "prismatic":
        twist[:3, 3] = x, y, z
    else:
        twist[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
        twist[:3, 3] = -twist[:3, :3] @ T[:3, 3]
    return twist
