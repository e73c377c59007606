"""Robots that are unknown, and URDFs that are broken or hostile."""

import difflib
from collections.abc import Iterable

from robolaser.errors.base import RobolaserError, near


def _near_few(name: str, known: Iterable[str], most: int = 12) -> str:
    """As `near`, with the likeliest names only where there are many."""
    names = list(known)
    if len(names) <= most:
        return near(name, names)
    few = difflib.get_close_matches(name[:100], names, n=most, cutoff=0.0)
    return f"{near(name, few)[:-1]}, and {len(names) - len(few)} more."


class UrdfError(RobolaserError):
    """A URDF that cannot be a robot."""


class UrdfNotXml(UrdfError):
    """The text breaks off or breaks the rules of XML."""

    def __init__(self, source: str, line: int, column: int, reason: str) -> None:
        super().__init__(
            f"{source}, line {line}, column {column}: not well-formed XML ({reason}). Is the file complete?"
        )


class UrdfNotText(UrdfError):
    """The file's bytes are not the text they should be."""

    def __init__(self, source: str, reason: str) -> None:
        super().__init__(f"{source} cannot be read as UTF-8 text: {reason}. Save it as UTF-8.")


class UrdfUnsafe(UrdfError):
    """The XML asks for something no URDF needs and a reader should not do."""

    def __init__(self, source: str, line: int, what: str) -> None:
        super().__init__(f"{source}, line {line}: {what}, which no URDF needs and robolaser refuses. Remove it.")


class UrdfTooLarge(UrdfError):
    """More of something than any robot has."""

    def __init__(self, source: str, what: str, limit: int) -> None:
        super().__init__(f"{source} has more than {limit} {what}: too large for a robot. Is it the right file?")


class NotARobot(UrdfError):
    """The XML is of something else."""

    def __init__(self, source: str, root: str) -> None:
        super().__init__(f"{source} starts with <{root}>, but a URDF starts with <robot>. Is it the right file?")


class UrdfUnexpandedXacro(UrdfError):
    """A recipe for a URDF instead of the URDF."""

    def __init__(self, source: str, tag: str) -> None:
        super().__init__(f"{source} holds <{tag}>: it is a xacro file. Expand it first: xacro {source} > robot.urdf")


class UrdfUnnamed(UrdfError):
    """A link or joint without a usable name."""

    def __init__(self, source: str, kind: str, count: int, reason: str) -> None:
        super().__init__(f"{source}: {kind} number {count} {reason}. Each {kind} needs a short name of its own.")


class UrdfDuplicate(UrdfError):
    """Two links or two joints of one name."""

    def __init__(self, source: str, kind: str, name: str) -> None:
        super().__init__(f"{source} has two {kind}s named '{name}'. Rename one.")


class UrdfMissingLink(UrdfError):
    """A joint that hangs on a link which is not there."""

    def __init__(self, source: str, joint: str, role: str, link: str | None, known: Iterable[str]) -> None:
        said = f"has no <{role} link=...>." if link is None else f"has the {role} link '{link}', which is not there."
        super().__init__(f"{source}: joint '{joint}' {said}{_near_few(link or '', known)}")


class UrdfNotATree(UrdfError):
    """Links that do not hang together as one tree from one root."""

    def __init__(self, source: str, fact: str) -> None:
        super().__init__(f"{source}: {fact}. The links of a URDF form one tree that starts at one root link.")


class UrdfBadNumbers(UrdfError):
    """An attribute that should hold numbers."""

    def __init__(self, source: str, where: str, text: str | None, expected: str) -> None:
        said = "is missing" if text is None else f"is '{text[:60]}'"
        hint = " Expand the file with xacro first." if text and "${" in text else ""
        super().__init__(f"{source}: {where} {said}; expected {expected}.{hint}")


class UrdfJointKind(UrdfError):
    """A joint of a kind that cannot be used there."""

    def __init__(self, source: str, joint: str, kind: str | None, usable: Iterable[str]) -> None:
        said = "has no type" if kind is None else f"is of type '{kind[:60]}'"
        super().__init__(f"{source}: joint '{joint}' {said}; usable here: {', '.join(usable)}.")


class UrdfLimits(UrdfError):
    """Joint limits that leave no room."""

    def __init__(self, source: str, joint: str, fact: str) -> None:
        super().__init__(f"{source}: joint '{joint}' {fact}. Give <limit lower=... upper=...> in rad or m.")


class UnknownFrame(RobolaserError):
    """A frame the robot does not have."""

    def __init__(self, source: str, frame: str, known: Iterable[str]) -> None:
        super().__init__(f"No frame '{frame}' in {source}.{_near_few(frame, known)}")


class UnknownJoint(RobolaserError):
    """A joint the robot does not have, or that does not move."""

    def __init__(self, source: str, joint: str, known: Iterable[str]) -> None:
        super().__init__(f"No moving joint '{joint}' in {source}.{_near_few(joint, known)}")


class RepeatedJoint(RobolaserError):
    """One joint listed twice."""

    def __init__(self, source: str, joint: str) -> None:
        super().__init__(f"Joint '{joint}' of {source} is listed twice. List each joint once.")


class FrameExists(RobolaserError):
    """A new frame of a name that is taken."""

    def __init__(self, source: str, frame: str) -> None:
        super().__init__(f"{source} has a frame '{frame}' already. Choose another name for the new one.")


class NothingMoves(RobolaserError):
    """A flange that none of the joints moves."""

    def __init__(self, source: str, flange: str, known: Iterable[str]) -> None:
        super().__init__(
            f"{source}: none of the listed joints moves the flange '{flange}'."
            f" Joints that do: {', '.join(known) or 'none'}."
        )


class FollowerNotListed(RobolaserError):
    """A joint coupled to another one, on the way to the flange, whose angle nobody gives."""

    def __init__(self, source: str, joint: str, leader: str) -> None:
        super().__init__(
            f"{source}: on the way to the flange, joint '{joint}' follows '{leader}' (mimic), which robolaser"
            f" does not compute. List '{joint}' among the joints and give its angle too."
        )


class RobotUnknown(RobolaserError):
    """No robot of that name."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        super().__init__(f"No robot '{name}'.{near(name, known)} Or give the path of a .urdf file.")


class RobotNotInstalled(RobolaserError):
    """A robot whose files come with an optional package."""

    def __init__(self, name: str, package: str, path: str) -> None:
        super().__init__(
            f"Robot '{name}' needs {path} of the package {package}, which is not there:"
            f" pip install --upgrade 'robolaser[robots]'"
        )


class FlangeNotSaid(RobolaserError):
    """A URDF with several ends and no word on which one carries the sensor."""

    def __init__(self, source: str, leaves: Iterable[str]) -> None:
        ends = list(leaves)
        more = f", and {len(ends) - 12} more" if len(ends) > 12 else ""
        super().__init__(f"{source} has {len(ends)} ends: {', '.join(ends[:12])}{more}. Say which link is the flange.")
