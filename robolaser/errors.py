"""Every error a user can meet; each takes facts and writes its own sentence."""

import difflib
from collections.abc import Iterable
from pathlib import Path


class RobolaserError(Exception):
    """The data, the robot or a file said no; the message is for a person."""


def near(name: str, known: Iterable[str]) -> str:
    """Name the likeliest meant and all there are: " Did you mean 'tool0'? It has: base, tool0."."""
    names = list(known)
    close = difflib.get_close_matches(name, names, n=1)
    guess = f" Did you mean '{close[0]}'?" if close else ""
    return f"{guess} There are: {', '.join(names) if names else 'none'}."


class FileUnreadable(RobolaserError):
    """A file is missing or not what it should be."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"Cannot read {path}: {reason}.")


class FileUnwritable(RobolaserError):
    """The disk or the rights refuse a file."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(
            f"Cannot write {path}: {reason}. What was there before is unchanged; make room or choose another folder."
        )


class TableEmpty(RobolaserError):
    """A CSV file without a header."""

    def __init__(self, file: str) -> None:
        super().__init__(f"{file} is empty: its first row must name the columns.")


class ColumnMissing(RobolaserError):
    """A CSV file lacks a column."""

    def __init__(self, file: str, column: str, known: Iterable[str]) -> None:
        super().__init__(f"{file} has no column '{column}'.{near(column, known)}")


class ColumnTwice(RobolaserError):
    """Two columns share a name."""

    def __init__(self, file: str, column: str) -> None:
        super().__init__(f"{file} has two columns '{column}'; rename or delete one.")


class RowLength(RobolaserError):
    """A row has more or fewer cells than the header."""

    def __init__(self, file: str, line: int, cells: int, columns: int) -> None:
        super().__init__(f"{file}, row {line}: {cells} cells, but the header names {columns} columns.")


class BadCell(RobolaserError):
    """A cell holds something else than it should."""

    def __init__(self, file: str, line: int, column: str, cell: str, expected: str) -> None:
        shown = f"'{cell}'" if cell else "empty"
        super().__init__(f"{file}, row {line}, column {column}: {shown}, expected {expected}.")


class RowTwice(RobolaserError):
    """Two rows say the same."""

    def __init__(self, file: str, line: int, first: int, what: str) -> None:
        super().__init__(f"{file}, row {line}: {what} was already in row {first}. Delete one of the two.")


class PoseUnknown(RobolaserError):
    """A point's pose is not in poses.csv."""

    def __init__(self, line: int, pose: str, known: Iterable[str]) -> None:
        names = list(known)
        close = difflib.get_close_matches(pose, names, n=1)
        guess = f" Did you mean '{close[0]}'?" if close else ""
        super().__init__(
            f"points.csv, row {line}: no pose '{pose}' in poses.csv, which has {len(names)}.{guess} "
            "Add the pose or delete the row."
        )


class JointOutOfRange(RobolaserError):
    """A joint reading no robot could have made."""

    def __init__(self, line: int, joint: str, value: float, lower: float, upper: float, unit: str) -> None:
        hint = " Are these degrees?" if unit == "rad" else " Are these millimetres?"
        super().__init__(
            f"poses.csv, row {line}: q_{joint} is {value:.4g} {unit}, but the URDF limits {joint} to "
            f"{lower:.2f} .. {upper:.2f} {unit}.{hint}"
        )


class NotAPixel(RobolaserError):
    """A pixel that the image does not have."""

    def __init__(self, line: int, u_px: float, v_px: float, image_px: tuple[int, int]) -> None:
        super().__init__(
            f"points.csv, row {line}: pixel ({u_px:.6g}, {v_px:.6g}) lies outside the image of "
            f"{image_px[0]} x {image_px[1]} pixels. Correct the row, or [image] in dataset.toml."
        )


class TooFar(RobolaserError):
    """A length that looks like another unit."""

    def __init__(self, file: str, line: int, column: str, value: float) -> None:
        super().__init__(
            f"{file}, row {line}, column {column}: {value:.6g} m is farther than any arm reaches. "
            "Are these millimetres? Lengths are metres."
        )


class NotARotation(RobolaserError):
    """A quaternion whose length is not one."""

    def __init__(self, where: str, norm: float) -> None:
        super().__init__(
            f"{where}: the quaternion (x, y, z, w) has length {norm:.4g}, expected 1. "
            "Check the order of its four numbers, or normalise it."
        )


class SettingMissing(RobolaserError):
    """dataset.toml lacks a value."""

    def __init__(self, key: str, expected: str) -> None:
        super().__init__(f"dataset.toml lacks {key}: expected {expected}.")


class SettingWrong(RobolaserError):
    """dataset.toml holds a value of the wrong kind."""

    def __init__(self, key: str, value: object, expected: str) -> None:
        super().__init__(f"dataset.toml, {key}: {value!r}, expected {expected}.")


class FormatUnknown(RobolaserError):
    """A file of another format or a later version."""

    def __init__(self, file: str, found: object, expected: str) -> None:
        super().__init__(f"{file} has format {found!r}, but this program reads '{expected}'.")


class NotToml(RobolaserError):
    """dataset.toml cannot be parsed."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path} is not valid TOML: {reason}.")


class NotADataset(RobolaserError):
    """A folder without dataset.toml."""

    def __init__(self, folder: Path) -> None:
        what = "is not there" if not folder.exists() else "has no dataset.toml"
        super().__init__(f"{folder} {what}. A data set is a folder with dataset.toml, poses.csv and points.csv.")


class PathLeaves(RobolaserError):
    """A path in the data set points out of its folder."""

    def __init__(self, where: str, path: str) -> None:
        super().__init__(
            f"{where}: '{path}' leaves the data set's folder. Copy the file into it and name it relatively."
        )


class BoundsWrong(RobolaserError):
    """Bounds that are swapped or exclude the nominal value."""

    def __init__(self, name: str, nominal: float, lower: float, upper: float) -> None:
        why = "lower must be below upper" if not lower < upper else "the nominal value must lie between the bounds"
        super().__init__(
            f"dataset.toml, [parameters] {name}: nominal {nominal:g}, lower {lower:g}, upper {upper:g}; {why}."
        )


class ParameterMissing(RobolaserError):
    """A parameter that this kind of sensor needs is not given."""

    def __init__(self, missing: Iterable[str], kind: str) -> None:
        super().__init__(
            f"dataset.toml, [parameters] lacks {', '.join(missing)}: a {kind} sensor needs "
            "{ nominal, lower, upper } for each."
        )


class ParameterUnknown(RobolaserError):
    """A parameter that this kind of sensor does not have."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        super().__init__(f"dataset.toml, [parameters]: no parameter '{name}' here.{near(name, known)}")


class AngleTooLarge(RobolaserError):
    """An angle beyond a full turn."""

    def __init__(self, name: str, value: float) -> None:
        super().__init__(
            f"dataset.toml, [parameters] {name}: {value:g} rad is more than a full turn. Are these degrees?"
        )


class NoPoints(RobolaserError):
    """A recording without points."""

    def __init__(self, folder: Path | None) -> None:
        super().__init__(f"{folder} has no points.csv yet. Run `robolaser extract {folder}` first, or measure points.")


class NothingSeen(RobolaserError):
    """points.csv has no rows."""

    def __init__(self) -> None:
        super().__init__("points.csv has a header but no rows: there is nothing to calibrate from.")


class TargetUnseen(RobolaserError):
    """The camera cannot have seen the target where the data set says it is."""

    def __init__(self, line: int, pose: str, behind: int, rows: int) -> None:
        super().__init__(
            f"points.csv, row {line} (pose {pose}): with the nominal parameters the target point lies behind the "
            f"camera, as do {behind} of {rows} rows. Check the target's frame and units, bracket_quat and the flange."
        )


class TooFewPoses(RobolaserError):
    """Not enough poses for the parameters asked for."""

    def __init__(self, poses: int, needed: int, parameters: int) -> None:
        super().__init__(
            f"{poses} pose{'s' if poses != 1 else ''} with points cannot fix {parameters} parameters: "
            f"at least {needed} are needed. Measure more poses, turned and tilted against each other."
        )


class EffectUnknown(RobolaserError):
    """No effect of that name."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        super().__init__(f"No effect '{name}'.{near(name, known)}")


class PlaceUnknown(RobolaserError):
    """An effect has no meaning at that place."""

    def __init__(self, effect: str, where: str, known: Iterable[str]) -> None:
        super().__init__(f"{effect} cannot sit at '{where}'.{near(where, known)}")


class EffectSenseless(RobolaserError):
    """An effect that this data set's robot or sensor cannot have."""

    def __init__(self, effect: str, reason: str) -> None:
        super().__init__(f"{effect} has no meaning for these data: {reason}.")


class AlgorithmUnknown(RobolaserError):
    """No algorithm of that name."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        super().__init__(f"No algorithm '{name}'.{near(name, known)}")


class OutputExists(RobolaserError):
    """A result would be overwritten."""

    def __init__(self, path: Path) -> None:
        super().__init__(f"{path} holds a result already. Choose another --output, or overwrite it with --force.")


class NothingFound(RobolaserError):
    """No candidate had a finite misfit."""

    def __init__(self) -> None:
        super().__init__(
            "No set of parameters within the bounds puts the points at finite places. "
            "Check the bounds in [parameters], stripe_axis and the units."
        )


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
        super().__init__(
            f"{source} holds <{tag}>: it is a xacro file. Expand it first: xacro {source} > robot.urdf"
        )


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


class OperatorSetting(RobolaserError):
    """An operator or algorithm was given a setting that has no meaning."""

    def __init__(self, where: str, setting: str, value: object, expected: str) -> None:
        super().__init__(f"{where}: {setting} is {value!r}, expected {expected}.")


class ProgressUnknown(RobolaserError):
    """An operator that depends on time runs where nobody tells the time."""

    def __init__(self, operator: str) -> None:
        super().__init__(
            f"{operator} does not know how far the run has come: its algorithm does not pass itself on to"
            f" its operators (MOEAD and differential evolution do not). Tell it: {operator}(progress=...), a share"
            " of the run from 0 to 1 or a function without arguments that returns it."
        )


class BoundsMissing(RobolaserError):
    """Variables without finite bounds where an operator measures its steps by them."""

    def __init__(self, operator: str, variables: Iterable[int]) -> None:
        super().__init__(
            f"{operator} measures its steps by the distance to the bounds, but the problem gives variables"
            f" {', '.join(map(str, variables))} no finite ones. Give the problem finite xl and xu."
        )


class ManyObjectives(RobolaserError):
    """A search for one objective met a problem with several."""

    def __init__(self, where: str, objectives: int) -> None:
        super().__init__(
            f"{where} minimises one objective, but the problem has {objectives}."
            " Take NSGA2 or another multi-objective algorithm; robolaser's operators work in it."
        )


class CheckpointUnreadable(RobolaserError):
    """A file that is no checkpoint, or a damaged one."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path} is not a whole checkpoint: {reason}. Delete it to start the run anew.")


class CheckpointForeign(RobolaserError):
    """A checkpoint of another run than the one to be resumed."""

    def __init__(self, path: Path, what: str, found: object, expected: object) -> None:
        super().__init__(
            f"{path} belongs to another run: {what} is {found}, here it is {expected}."
            " Resume with what the run was started with, or delete the checkpoint to start anew."
        )


class CheckpointImpossible(RobolaserError):
    """A run of which no checkpoint can be taken."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"No checkpoint can be taken: {reason}.")


class ResidualsShape(RobolaserError):
    """A residual function that does not return one row for each candidate."""

    def __init__(self, candidates: int, shape: tuple[int, ...]) -> None:
        super().__init__(
            f"The residuals of {candidates} candidates have shape {shape}, expected ({candidates}, k):"
            " one row of k residuals for each candidate, the same k in every call."
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
        super().__init__(
            f"{source} has {len(ends)} ends: {', '.join(ends[:12])}{more}. Say which link is the flange."
        )


class ImageUnreadable(RobolaserError):
    """An image that is not there or cannot be decoded."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path}: {reason}. Name a grey or colour image that OpenCV reads, such as PNG.")


class ImageSize(RobolaserError):
    """An image of another size than the recording's."""

    def __init__(self, path: Path, found: tuple[int, int], expected: tuple[int, int]) -> None:
        super().__init__(
            f"{path} is {found[0]} x {found[1]} pixels, but width_px x height_px say {expected[0]} x {expected[1]}."
            " All images of a recording come from one camera at one size: correct the size or leave the image out."
        )


class NotARecording(RobolaserError):
    """A data set that points cannot be extracted from."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"There are no points to extract: {reason}.")


class NothingExtracted(RobolaserError):
    """No image gave a point."""

    def __init__(self, images: int, reasons: str) -> None:
        super().__init__(
            f"None of {images} images gave a point ({reasons}). Check [board] columns and rows (inner corners, not "
            "squares), stripe_axis, and that board and stripe are both in view."
        )


class Interrupted(RobolaserError):
    """Ctrl-C."""

    def __init__(self, folder: Path | None) -> None:
        kept = f" The search's state is in {folder}: go on with --resume." if folder else " Nothing was written."
        super().__init__(f"Stopped.{kept}")


class SearchStopped(RobolaserError):
    """A stopped search would be overwritten."""

    def __init__(self, folder: Path) -> None:
        super().__init__(
            f"{folder} holds a search that was stopped. Go on with --resume, or begin anew with --force."
        )


class TargetOutOfSight(RobolaserError):
    """An arm that cannot look at a target often enough."""

    def __init__(self, robot: str, wanted: int, tried: int, down: int, seeing: int, level: float) -> None:
        super().__init__(
            f"{robot}: {wanted} poses that see the target were asked for, {seeing} found. Of {tried} random postures"
            f" within the joint limits, {down} look down; the others of these miss the level z = {level:.3g} m of the"
            " base frame or show the stripe outside the image. Ask for fewer poses, or for another level of the"
            " target or turn of the camera on the flange (bracket_quat)."
        )


class BentOutOfSight(RobolaserError):
    """Effects so large that the target leaves the image."""

    def __init__(self, robot: str, wanted: int, tried: int, good: int) -> None:
        super().__init__(
            f"{robot}: {wanted} poses were asked for, but of {tried} planned ones only {good} still do their job with"
            " the effects in place. Take smaller effects, or ask for fewer poses."
        )


class NothingReached(RobolaserError):
    """A place that an arm cannot reach from enough sides."""

    def __init__(self, robot: str, place: Iterable[float], wanted: int, tried: int, found: int) -> None:
        at = ", ".join(f"{part:.3f}" for part in place)
        super().__init__(
            f"{robot}: from {tried} starts within the joint limits, {found} postures reach the socket at ({at}) m,"
            f" but {wanted} were asked for. Ask for fewer poses, or take another seed."
        )


class EffectSizeUnclear(RobolaserError):
    """An effect to be simulated without a size that can be read."""

    def __init__(self, text: str) -> None:
        super().__init__(
            f"'{text}' does not say an effect and its size: expected NAME[:WHERE]=SIZE in SI units, such as"
            " joint_offset:joint_2=0.002."
        )


class EffectTooLarge(RobolaserError):
    """An effect to be simulated far beyond what it is in the world."""

    def __init__(self, effect: str, number: str, size: float, bound: float, unit: str) -> None:
        hint = " Are these degrees?" if unit == "rad" else " Are these millimetres?" if unit == "m" else ""
        super().__init__(f"{effect}: {number} is {size:g} {unit}, but its bounds are ±{bound:g} {unit}.{hint}")


class DemandSenseless(RobolaserError):
    """Something that a simulated cell cannot have."""

    def __init__(self, what: str, value: object, expected: str) -> None:
        super().__init__(f"A cell cannot be simulated with {what} {value!r}: expected {expected}.")


class NoCamera(RobolaserError):
    """A camera's file was asked for, from a sensor that has none."""

    def __init__(self, kind: str) -> None:
        super().__init__(f"A sensor of kind '{kind}' has no camera to describe; only 'stripe' has one.")
