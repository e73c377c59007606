"""Shared parts of all commands: types of options, output, and termination from outside."""

import json
import math
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Never, final

from cyclopts import Group, Parameter, Token
from cyclopts.validators import Number

from robolaser.errors import UsageError
from robolaser.report.printable import printable

if TYPE_CHECKING:
    from robolaser.data.dataset import Dataset

RESULT = Group("Result", sort_key=1)  # the options on where a result is written


def _whole(_: object, tokens: Sequence[Token]) -> int:
    value = tokens[0].value
    if not value.removeprefix("-").isdecimal():  # cyclopts rounds
        raise ValueError(f"'{value}' is no whole number.")
    return int(value)


Whole = Annotated[int, Parameter(converter=_whole, metavar="N")]
Count = Annotated[Whole, Parameter(validator=Number(gte=1))]
Seed = Annotated[
    Whole,
    Parameter(validator=Number(gte=0), help="Seed of random numbers; the same one gives the same result."),
]
Flange = Annotated[str | None, Parameter(metavar="FRAME", help="Frame of a robot's file that carries the sensor.")]
Port = Annotated[Whole, Parameter(validator=Number(gte=1, lte=65535))]


def _positive(_: object, value: float | None) -> None:
    if value is not None and not 0 < value < math.inf:  # nan is not either
        raise ValueError("Expected a finite number above 0.")


PositiveOption = Annotated[float, Parameter(validator=_positive)]
Deviation = Annotated[PositiveOption, Parameter(metavar="STD")]
ResultFlag = Annotated[bool, Parameter(group=RESULT)]
Force = Annotated[bool, Parameter(group=RESULT, help="Overwrite an earlier result of this command; never other files.")]
Typed = Annotated[str, Parameter(parse=False)]  # the command line, for the page: passed in, not an option


def say(text: str) -> None:
    """Print text on standard output, with escaped control characters."""
    print(printable(text), flush=True)


def aligned(rows: Sequence[Sequence[str]], side: Callable[[str, int], str] = str.ljust) -> list[str]:
    """Lines of a table: the first column to the left, the others to the `side`."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    justified = [[row[0].ljust(widths[0]), *map(side, row[1:], widths[1:])] for row in rows]
    return ["  ".join(row).rstrip() for row in justified]


@final
@Parameter(name="*", group=Group("Terminal", sort_key=2))
@dataclass(frozen=True)
class Terminal:
    """The output of a command.

    Attributes:
        json: Print nothing but the result, as JSON, on standard output.
        quiet: Print warnings and errors only.
    """

    json: bool = False
    quiet: bool = False

    def print(self, text: str) -> None:
        """Print a part of the text."""
        if not (self.json or self.quiet):
            say(text)

    def show(self, result: Mapping[str, object] | str, summary: Callable[[], None]) -> None:
        """Print the result once: as JSON or as text.

        Args:
            result: For JSON, or its JSON text.
            summary: Prints it as text.
        """
        if self.json:
            say(result.rstrip() if isinstance(result, str) else json.dumps(result, indent=1))
        elif not self.quiet:
            summary()

    def warn(self, *messages: str) -> None:
        """Print warnings on standard error."""
        for message in messages:
            print(f"warning: {printable(message)}", file=sys.stderr)

    def progress(self) -> AbstractContextManager[Callable[[str, float], None]]:
        """Show the progress of a long command, on a terminal only, by calls with the current step and its share."""
        if self.quiet:
            return nullcontext(lambda what, share: None)
        from robolaser.report.progress_bar import progress_bar

        return progress_bar()


@final
@Parameter(name="*", group=Group("Noise, one standard deviation", sort_key=0))
@dataclass(frozen=True)
class NoiseOptions:
    """The noise of measurements.

    Attributes:
        pixel_px: Of a pixel coordinate.
        target_m: Of a target point's coordinate.
        joint_rad: Of a joint angle.
        point_m: Of a coordinate that a tracker or a profile sensor measures.
        angle_rad: Of a tracked body's rotation, about each axis.
    """

    pixel_px: Deviation | None = None
    target_m: Deviation | None = None
    joint_rad: Deviation | None = None
    point_m: Deviation | None = None
    angle_rad: Deviation | None = None

    @property
    def typed(self) -> dict[str, float]:
        """The typed options."""
        return {name: value for name, value in vars(self).items() if value is not None}

    def unused(self, dataset: "Dataset") -> tuple[str, ...]:
        """A warning of typed options that no sensor of a data set has a use for, if any."""
        used = {"joint_rad"}
        for columns in (one.data.format.columns for one in dataset.sensors):
            used |= {"pixel_px", "target_m"} if "pixel" in columns else {"point_m"} if columns else set()
            used |= {"angle_rad"} if "quaternion" in columns else set()
        idle = [f"--{name.replace('_', '-')}" for name in self.typed if name not in used]
        return (f"A {dataset.format.title} has no such noise, so it is not used: {', '.join(idle)}",) if idle else ()


def refuse(why: str, options: Mapping[str, object]) -> None:
    """Refuse typed options that have no meaning here.

    Args:
        why: The beginning of the sentence.
        options: By name, each with whether it was typed.

    Raises:
        UsageError: One was typed.
    """
    if idle := [option for option, given in options.items() if given]:
        raise UsageError(f"{why}: leave out {', '.join(idle)}.")


def shown_default(value: object) -> str | None:
    """The default in the help: none for an option that is off or empty."""
    if value is None or value is False or value == ():
        return None
    return f"{value:g}" if isinstance(value, float) else f"{value}"


@contextmanager
def ended_as_by_hand() -> Iterator[None]:
    """End the program on any termination signal (a closed terminal, a batch system) as on Ctrl-C."""

    def stop(number: int, frame: FrameType | None) -> Never:
        raise KeyboardInterrupt

    ends = [signal.SIGTERM] if sys.platform == "win32" else [signal.SIGTERM, signal.SIGHUP]
    before = {end: signal.signal(end, stop) for end in ends}
    try:
        yield
    finally:
        for end, action in before.items():
            signal.signal(end, action)
