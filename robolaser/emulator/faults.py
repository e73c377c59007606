"""Faults on demand, written `kind[:amount][@when]`."""

import re
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.emulator.controller import ArmFault
from robolaser.errors import UsageError, near

LINE = {
    "garbage": 0.05,  # chance that a byte answered is followed by a random one
    "lost": 0.05,  # chance that a byte answered never arrives
    "misheard": 0.05,  # chance that a byte sent to the controller never arrives
    "late": 3.0,  # answers come so much later [s]
    "silent": 0.0,  # it works on and answers nothing
    "flood": 5000.0,  # it sends so much by itself and does not end [bytes/s]
    "cut": 0.0,  # the plug is pulled
}
ARM = {fault.value: 1.0 for fault in ArmFault}
CAMERA = {
    "camera_frozen": 0.0,  # the same frame over and over
    "camera_gone": 0.0,  # the stream ends
    "camera_size": 0.5,  # frames are so much smaller or larger
    "camera_over": 20.0,  # so much more light
    "camera_dark": 0.02,  # so much less light
    "camera_late": 1.0,  # frames come so much later [s]
}
KINDS = LINE | ARM | CAMERA
"""Every kind with its usual amount."""
_FORM = re.compile(
    r"(?P<kind>\w+)(?::(?P<amount>\d+(?:\.\d+)?))?"
    r"(?:@(?:(?P<first>\d+)(?:-(?P<last>\d+))?|>(?P<begin>\d+(?:\.\d+)?)s(?:-(?P<end>\d+(?:\.\d+)?)s)?))?"
)


@final
@dataclass(frozen=True)
class Fault:
    """One fault and when it is there.

    Attributes:
        kind: One of `KINDS`.
        amount: A chance, seconds, an axis from 1, ... as the kind wants.
        commands: From and up to which command that the controller hears.
        seconds: From and up to when, on the controller's clock.
    """

    kind: str
    amount: float
    commands: tuple[float, float] = (0.0, np.inf)
    seconds: tuple[float, float] = (0.0, np.inf)

    def is_active(self, now_s: float, heard: int) -> bool:
        """Whether it is active now, after so many commands."""
        return self.commands[0] <= heard <= self.commands[1] and self.seconds[0] <= now_s <= self.seconds[1]


def read_fault(text: str) -> Fault:
    """Read what was asked for: `lost:0.1`, `impact:3@12`, `silent@>5s`, `late:2.5@7-9`, `camera_over@>2s-4s`.

    Raises:
        UsageError: There is no such kind, it is not written as a fault is, or the amount is impossible.
    """
    said = _FORM.fullmatch(text)
    if said is None:
        raise not_a_fault(text, "expected kind[:amount][@when], when = N or N-M commands, >Ts or >Ts-Us")
    kind = said["kind"]
    if kind not in KINDS:
        raise UsageError(f"--fault {kind}: there is no such fault.{near(kind, KINDS)}")
    amount = float(said["amount"] or KINDS[kind])
    if kind in ("garbage", "lost", "misheard") and amount > 1:
        raise not_a_fault(text, f"a chance of {amount:g} is more than 1")
    if kind in ARM and (amount < 1 or amount % 1):
        raise not_a_fault(text, f"axes are numbered 1, 2, ..., not {amount:g}")
    if kind == "camera_size" and amount == 0:
        raise not_a_fault(text, "a frame of no size cannot be sent")
    commands = float(said["first"] or 0), float(said["last"] or np.inf)
    seconds = float(said["begin"] or 0), float(said["end"] or np.inf)
    for first, last in (commands, seconds):
        if first > last:
            raise not_a_fault(text, f"it would end at {last:g}, before it begins at {first:g}")
    return Fault(kind, amount, commands, seconds)


def not_a_fault(text: str, reason: str) -> UsageError:
    """The error of a fault that makes no sense."""
    return UsageError(f"--fault {text}: {reason}. For example: lost:0.1, impact:3@12, silent@>5s, late:2.5@7-9.")
