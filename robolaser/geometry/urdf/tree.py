"""The links of a robot and the joints that hold them together, from one root."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.errors import RobotError, near

MOST_LISTED = 12  # names of a robot's links or joints in a message
MOVING = ("revolute", "continuous", "prismatic")
KINDS = (*MOVING, "fixed", "floating", "planar")


def unknown_frame(source: str, frame: str, known: Iterable[str]) -> RobotError:
    """The error of a frame that the robot does not have."""
    return RobotError(f"No frame '{frame}' in {source}.{near(frame, known, MOST_LISTED)}")


def unknown_joint(source: str, joint: str, known: Iterable[str]) -> RobotError:
    """The error of a joint that the robot does not have, or that does not move."""
    return RobotError(f"No moving joint '{joint}' in {source}.{near(joint, known, MOST_LISTED)}")


@final
@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body: all that gravity needs of it."""

    name: str
    mass: float  # [kg]
    com: Array  # centre of mass in the link frame, (3,) [m]


@final
@dataclass(frozen=True, eq=False)
class Joint:
    """What holds a link on the one before it."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Array  # placement on the parent link, (4, 4)
    axis: Array  # unit axis in the joint frame, (3,)
    lower: float  # [rad] or [m]; -inf for continuous joints
    upper: float  # [rad] or [m]; inf for continuous joints
    follows: str | None  # the joint that this one mimics

    @property
    def moves(self) -> bool:
        """Whether one number moves it."""
        return self.kind in MOVING


@final
@dataclass(frozen=True, eq=False)
class Tree:
    """A checked URDF: one tree of links, held together by joints."""

    name: str
    source: str
    root: str
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    above: Mapping[str, Joint]  # the joint that carries each link but the root

    def path(self, link: str) -> list[Joint]:
        """Joints from the root to `link`, in that order.

        Raises:
            RobotError: There is no such link.
        """
        if link not in self.links:
            raise unknown_frame(self.source, link, self.links)
        up = []
        while link != self.root:
            up.append(self.above[link])
            link = up[-1].parent
        return up[::-1]

    def leaves(self) -> list[str]:
        """Links that carry no other."""
        parents = {joint.parent for joint in self.joints.values()}
        return [link for link in self.links if link not in parents]
