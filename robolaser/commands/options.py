"""Types of what can be typed, and how the options of several commands are shown in their help."""

import math
from typing import Annotated

from cyclopts import Group, Parameter
from cyclopts.validators import Number

RESULT = Group("Result", sort_key=1)  # the options that say where a result goes

Count = Annotated[int, Parameter(metavar="N", validator=Number(gte=1))]
Seed = Annotated[int, Parameter(metavar="N", validator=Number(gte=0))]
Port = Annotated[int, Parameter(metavar="N", validator=Number(gte=1, lte=65535))]
Positive = Annotated[float, Parameter(validator=Number(gt=0, lt=math.inf))]
Force = Annotated[bool, Parameter(group=RESULT)]
Resume = Annotated[bool, Parameter(group=RESULT)]
Typed = Annotated[str, Parameter(parse=False)]
"""The command line as it was typed, which a page repeats: passed in, not an option."""


def stated(**options: float | None) -> dict[str, float]:
    """Those that were typed."""
    return {name: value for name, value in options.items() if value is not None}


def shown_default(value: object) -> str | None:
    """What the help says of a default: nothing of an option that is off or empty."""
    if value is None or value is False or value == ():
        return None
    return f"{value:g}" if isinstance(value, float) else f"{value}"
