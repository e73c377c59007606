"""What all commands share: types of what can be typed, what is shown, and how a program is ended from outside."""

import json
import math
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Annotated, Never, final

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from robolaser.errors import UsageError
from robolaser.report.printable import printable

RESULT = Group("Result", sort_key=1)  # the options that say where a result goes
Count = Annotated[int, Parameter(metavar="N", validator=Number(gte=1))]
Seed = Annotated[int, Parameter(metavar="N", validator=Number(gte=0))]
Port = Annotated[int, Parameter(metavar="N", validator=Number(gte=1, lte=65535))]


def _positive(_: object, value: float | None) -> None:
    if value is not None and not 0 < value < math.inf:  # nan is not either
        raise ValueError("Expected a finite number above 0.")


PositiveOption = Annotated[float, Parameter(validator=_positive)]
Deviation = Annotated[PositiveOption, Parameter(metavar="STD")]
ResultFlag = Annotated[bool, Parameter(group=RESULT)]
Typed = Annotated[str, Parameter(parse=False)]  # the command line, which a page repeats: passed in, not an option


def say(text: str) -> None:
    """Print text on standard output; control characters in it are written out."""
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
    """What a command shows.

    Attributes:
        json: Print nothing but the result, as JSON, on standard output.
        quiet: Print warnings and errors only.
    """

    json: bool = False
    quiet: bool = False

    def print(self, text: str) -> None:
        """Print a part of what people read."""
        if not (self.json or self.quiet):
            say(text)

    def show(self, result: Mapping[str, object] | str, summary: Callable[[], None]) -> None:
        """Print the result once: as JSON, or as what people read.

        Args:
            result: What is written as JSON, or the text of it.
            summary: Prints it for people.
        """
        if self.json:
            say(result.rstrip() if isinstance(result, str) else json.dumps(result, indent=1))
        elif not self.quiet:
            summary()

    def warn(self, *messages: str) -> None:
        """Say on standard error what is odd, but no error."""
        for message in messages:
            print(f"warning: {printable(message)}", file=sys.stderr)

    @contextmanager
    def progress(self) -> Iterator[Callable[[str, float], None]]:
        """Show how far a long command is, on a terminal and only there.

        Yields:
            A function of what is being done and of the share, 0 to 1, that is done.
        """
        if self.quiet:
            yield lambda what, share: None
            return
        from robolaser.report.progress_bar import progress_bar

        with progress_bar() as tell:
            yield tell


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
        """Those that were typed."""
        return {name: value for name, value in vars(self).items() if value is not None}


def refuse(why: str, options: Mapping[str, object]) -> None:
    """Refuse those of some options that were typed, as they mean nothing here.

    Args:
        why: The beginning of the sentence.
        options: By name, each with whether it was typed.

    Raises:
        UsageError: One was.
    """
    if idle := [option for option, given in options.items() if given]:
        raise UsageError(f"{why}: leave out {', '.join(idle)}.")


def shown_default(value: object) -> str | None:
    """What the help says of a default: nothing of an option that is off or empty."""
    if value is None or value is False or value == ():
        return None
    return f"{value:g}" if isinstance(value, float) else f"{value}"


@contextmanager
def ended_as_by_hand() -> Iterator[None]:
    """Whoever ends the program (a closed terminal, a batch system) ends it as Ctrl-C does: in good order."""

    def stop(number: int, frame: FrameType | None) -> Never:
        raise KeyboardInterrupt

    ends = [signal.SIGTERM] if sys.platform == "win32" else [signal.SIGTERM, signal.SIGHUP]
    before = {end: signal.signal(end, stop) for end in ends}
    try:
        yield
    finally:
        for end, action in before.items():
            signal.signal(end, action)
