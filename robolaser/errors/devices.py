"""Arms, lines and cameras that cannot be reached, or do not do what they are told."""

from collections.abc import Iterable, Sequence

from robolaser.errors.base import RobolaserError, near


class ArmUnknown(RobolaserError):
    """No language of that name."""

    def __init__(self, kind: str, known: Iterable[str]) -> None:
        super().__init__(f"cell.toml, [arm] kind: no arm speaks '{kind}'.{near(kind, known)}")


class OutputMissing(RobolaserError):
    """An output that the arm's controller does not have."""

    def __init__(self, kind: str, output: int, outputs: int) -> None:
        has = f"has outputs 1 to {outputs}" if outputs else "switches nothing; take [laser] out"
        super().__init__(f"cell.toml, [laser] output: {output}, but an arm of kind '{kind}' {has}.")


class PortUnusable(RobolaserError):
    """A port that cannot be opened."""

    def __init__(self, port: str, reason: str, there: Sequence[str]) -> None:
        found = f"This machine has: {', '.join(there)}." if there else "No serial port is to be seen on this machine."
        super().__init__(
            f"Cannot open port {port}: {reason}. {found} Check the cable, that no other program holds the port and that"
            " you may use it (on Linux: group dialout), and name it in cell.toml, [arm] port, or with --port."
        )


class LineLost(RobolaserError):
    """The line to the arm is silent or gone."""

    def __init__(self, port: str, reason: str) -> None:
        super().__init__(
            f"The line to the arm on {port} is lost: {reason}."
            " Check plug, power and that [arm] baud and flow in cell.toml are the controller's."
        )


class LineFlooded(RobolaserError):
    """A device that talks without end."""

    def __init__(self, port: str, received: int) -> None:
        super().__init__(
            f"The arm on {port} talks without end: {received} bytes and no answer among them."
            " Stop what runs in the controller and check [arm] baud in cell.toml."
        )


class AnswerUnclear(RobolaserError):
    """A device answers, but not to what it was asked."""

    def __init__(self, port: str, command: str, answer: str, tries: int) -> None:
        super().__init__(
            f"The arm on {port} answered '{command}' {tries} times with what cannot be understood, at last"
            f" {answer[-60:]!r}. Check [arm] kind and baud in cell.toml, and the cable's shield."
        )


class ArmRefused(RobolaserError):
    """The controller says that it cannot do something."""

    def __init__(self, port: str, command: str, said: str, meaning: str) -> None:
        why = f": {meaning}" if meaning else ""
        super().__init__(f"The arm on {port} refused '{command}' with '{said}'{why}. See to it before going on.")


class ArmAlarm(RobolaserError):
    """The controller or a servo reports trouble by itself."""

    def __init__(self, port: str, joint: str, said: str, advice: str) -> None:
        super().__init__(f"The arm on {port} reports '{said}' ({joint}). {advice}")


class ArmRestarted(RobolaserError):
    """The controller was off in between."""

    def __init__(self, port: str) -> None:
        super().__init__(
            f"The controller on {port} has started anew: its counts may no longer mean the same angles."
            " Home the arm (home = true in cell.toml, [arm]) before going on."
        )


class ParameterSenseless(RobolaserError):
    """A controller's parameter that no arm has."""

    def __init__(self, port: str, parameter: str, value: int, expected: str) -> None:
        super().__init__(
            f"The controller on {port} says {parameter} = {value}, expected {expected}."
            " Check its parameters and that cell.toml names the right arm."
        )


class ArmDiffers(RobolaserError):
    """The robot has more joints than its controller moves, or none at all."""

    def __init__(self, kind: str, joints: int, most: int) -> None:
        super().__init__(
            f"cell.toml, [arm] kind '{kind}' moves up to {most} joints, but dataset.toml, [robot] joints lists"
            f" {joints}. List the joints that this controller moves, base first."
        )


class HomeNotFound(RobolaserError):
    """The search for home ended without it."""

    def __init__(self, port: str, reason: str) -> None:
        super().__init__(
            f"The arm on {port} did not find its home: {reason}. Move it clear of its stops by hand and try again."
        )


class MovedMeanwhile(RobolaserError):
    """A recording is to be gone on with, and the arm is not where it was left."""

    def __init__(self, joint: str, stands: str, stood: str) -> None:
        super().__init__(
            f"{joint} stands at {stands}, but when this recording was left it stood at {stood}. If the controller was"
            " off in between, its counts mean other angles now: home the arm (home = true in cell.toml, [arm])."
        )


class NotArrived(RobolaserError):
    """The arm rests elsewhere than it was sent, or goes on and on."""

    def __init__(self, place: str, joint: str, stands: str, goal: str, reason: str) -> None:
        super().__init__(
            f"On the way to {place}, {joint} {reason} at {stands}, not {goal}."
            " Look for what holds it, and whether its motors are on."
        )


class Strayed(RobolaserError):
    """The arm leaves the way that was checked."""

    def __init__(self, place: str, joint: str, stands: str, off: str, start: str, goal: str) -> None:
        super().__init__(
            f"On the way to {place}, {joint} is at {stands}, {off} off the straight way from {start} to {goal} that was"
            " checked: it sticks, does not keep step with the others, or goes elsewhere."
            " Look for what holds it, and check [arm] direction and reference_rad in cell.toml, and the line."
        )


class Restless(RobolaserError):
    """The arm does not stand still."""

    def __init__(self, when: str, joint: str, moved: str) -> None:
        super().__init__(
            f"{when}, {joint} moved by {moved}. Wait until the arm rests, and let no other program move it."
        )


class PlanUnsafe(RobolaserError):
    """Poses that break the limits of the cell."""

    def __init__(self, violations: Sequence[str], *, run_up: bool, most: int = 12) -> None:
        shown = "".join(f"\n  {violation}" for violation in violations[:most])
        rest = f"\n  ... and {len(violations) - most} more" if len(violations) > most else ""
        super().__init__(
            f"No pose was gone to, for the plan breaks the cell's limits:{shown}{rest}\n"
            f"Leave these poses out{', or take a smaller --run-up' if run_up else ''}; if the limits are wrong, correct"
            " [limits] in cell.toml or the URDF's."
        )


class PosesUnusable(RobolaserError):
    """A file that gives no poses for this arm."""

    def __init__(self, file: str, reason: str) -> None:
        super().__init__(f"{file} gives no poses for this arm: {reason}.")


class PoseFar(RobolaserError):
    """A pose that no arm can mean."""

    def __init__(self, file: str, line: int, column: str, value: float, lower: float, upper: float, unit: str) -> None:
        hint = "Are these degrees?" if unit == "rad" else "Are these millimetres?"
        super().__init__(
            f"{file}, row {line}: {column} is {value:.4g} {unit}, but the URDF limits it to {lower:.2f} .. {upper:.2f}"
            f" {unit}. {hint}"
        )


class CameraUnusable(RobolaserError):
    """A camera that cannot be opened."""

    def __init__(self, source: object, reason: str) -> None:
        super().__init__(
            f"Cannot open camera {source}: {reason}. Check its cable or address, that no other program holds it, and"
            " name it in cell.toml, [camera] source, or with --camera."
        )


class CameraLost(RobolaserError):
    """A camera that gives no more images."""

    def __init__(self, source: object, reason: str) -> None:
        super().__init__(f"Camera {source} gives no more images: {reason}. Check its cable and power.")


class CameraFrozen(RobolaserError):
    """A live camera that shows the same image again and again."""

    def __init__(self, source: object, frames: int, seconds: float) -> None:
        super().__init__(
            f"Camera {source} is frozen: {frames} images in {seconds:.1f} s were the same to the last pixel, which"
            " no live camera does. Unplug it and plug it in again."
        )


class CameraSize(RobolaserError):
    """A camera whose images have another size than the cell says."""

    def __init__(self, source: object, found: tuple[int, int], expected: tuple[int, int]) -> None:
        super().__init__(
            f"Camera {source} gives images of {found[0]} x {found[1]} pixels, but dataset.toml, [image] says"
            f" {expected[0]} x {expected[1]}. Set the camera to that size, or correct [image]."
        )


class Overexposed(RobolaserError):
    """An image that is mostly white."""

    def __init__(self, source: object, share: float) -> None:
        super().__init__(
            f"Camera {source} is overexposed: {share:.0%} of the image is white."
            " Set a shorter exposure or less gain in cell.toml, [camera], or close the aperture."
        )


class PlanDiffers(RobolaserError):
    """A recording that was begun with another plan."""

    def __init__(self, folder: object, what: str) -> None:
        super().__init__(
            f"{folder} was begun with another plan: {what}. Go on with --resume alone, which keeps to the plan there,"
            " or choose another --output."
        )


class CellDiffers(RobolaserError):
    """A recording that was begun in another cell."""

    def __init__(self, folder: object, what: str) -> None:
        super().__init__(
            f"{folder} was begun in another cell: {what}. Go on with the cell as it was, or choose another --output."
        )


class OutputIsCell(RobolaserError):
    """A recording would be written over a cell."""

    def __init__(self, folder: object) -> None:
        super().__init__(f"{folder} is a cell: a recording there would overwrite it. Choose another --output.")


class NothingToResume(RobolaserError):
    """A folder in which no recording was begun."""

    def __init__(self, folder: object) -> None:
        super().__init__(f"{folder} has no plan.csv, so no recording was begun there. Begin one without --resume.")


class RecordingStopped(RobolaserError):
    """A recording that ended before its last pose, and where the robot is."""

    def __init__(self, cause: str, standing: str, folder: object, done: int | None, planned: int) -> None:
        kept = (
            "Nothing was recorded yet."
            if done is None
            else f"{done} of {planned} poses are in {folder}. Go on with the next by --resume."
        )
        super().__init__(f"{cause}\n{standing}\n{kept}")
