"""Faults on demand, written `kind[:amount][@when]`, and a controller that has them."""

import re
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.emulator.controller import ArmFault, Controller
from robolaser.errors import UsageError, near

LINE = {
    "garbage": 0.05,  # chance that a byte from the controller is followed by a random one
    "lost": 0.05,  # chance that a byte from the controller never arrives
    "misheard": 0.05,  # chance that a byte to the controller never arrives
    "late": 3.0,  # delay of answers [s]
    "silent": 0.0,  # it executes commands without answers
    "flood": 5000.0,  # it sends without end [bytes/s]
    "cut": 0.0,  # the line is disconnected
}
ARM = {fault.value: 1.0 for fault in ArmFault}
KINDS = LINE | ARM  # every kind with its usual amount
_FORM = re.compile(
    r"(?P<kind>\w+)(?::(?P<amount>\d+(?:\.\d+)?))?"
    r"(?:@(?:(?P<first>\d+)(?:-(?P<last>\d+))?|>(?P<begin>\d+(?:\.\d+)?)s(?:-(?P<end>\d+(?:\.\d+)?)s)?))?"
)
LARGEST_FLOOD = 8192  # most bytes of a flood per call


@final
@dataclass(frozen=True)
class Fault:
    """One fault and when it is active."""

    kind: str  # one of `KINDS`
    amount: float  # a chance, seconds, an axis from 1, ... by its kind
    commands: tuple[float, float] = (0.0, np.inf)  # from and up to which received command
    seconds: tuple[float, float] = (0.0, np.inf)  # from and up to when, on the controller's clock

    def is_active(self, now_s: float, heard: int) -> bool:
        """Whether it is active now, after `heard` commands."""
        return self.commands[0] <= heard <= self.commands[1] and self.seconds[0] <= now_s <= self.seconds[1]


def read_fault(text: str) -> Fault:
    """Parse a fault: `lost:0.1`, `impact:3@12`, `silent@>5s`, `late:2.5@7-9`, `flood@>2s-4s`.

    Raises:
        UsageError: There is no such kind, the syntax is wrong, or the amount is impossible.
    """
    match = _FORM.fullmatch(text)
    if match is None:
        raise not_a_fault(text, "expected kind[:amount][@when], when = N or N-M commands, >Ts or >Ts-Us")
    kind = match["kind"]
    if kind not in KINDS:
        raise UsageError(f"--fault {kind}: there is no such fault.{near(kind, KINDS)}")
    amount = float(match["amount"] or KINDS[kind])
    if kind in ("garbage", "lost", "misheard") and amount > 1:
        raise not_a_fault(text, f"a chance of {amount:g} is more than 1")
    if kind in ARM and (amount < 1 or amount % 1):
        raise not_a_fault(text, f"axes are numbered 1, 2, ..., not {amount:g}")
    commands = float(match["first"] or 0), float(match["last"] or np.inf)
    seconds = float(match["begin"] or 0), float(match["end"] or np.inf)
    for first, last in (commands, seconds):
        if first > last:
            raise not_a_fault(text, f"it would end at {last:g}, before it begins at {first:g}")
    return Fault(kind, amount, commands, seconds)


def not_a_fault(text: str, reason: str) -> UsageError:
    """The error of an invalid fault."""
    return UsageError(f"--fault {text}: {reason}. For example: lost:0.1, impact:3@12, silent@>5s, late:2.5@7-9.")


@final
class FaultyController:
    """Forwards a controller's data with faults; motors and outputs are those of the controller."""

    def __init__(self, controller: Controller, faults: Sequence[Fault], rng: np.random.Generator) -> None:
        self._controller = controller
        self.command_mark, self.motor = controller.command_mark, controller.motor
        self.outputs, self.inject = controller.outputs, controller.inject
        self._faults = tuple(faults)
        self._arm_faults = [fault for fault in faults if fault.kind in ARM]
        self._rng = rng
        self._on_the_way: deque[tuple[float, bytes]] = deque()
        self._flooded_s: float | None = None
        self.heard = 0  # commands so far

    def cut(self, now_s: float) -> bool:
        """Whether the line is disconnected."""
        return self._there("cut", now_s) is not None

    def receive(self, data: bytes, now_s: float) -> bytes:
        """Pass received bytes on with faults, and return the part of the answer that arrives."""
        if self.cut(now_s):
            return b""
        misheard = self._there("misheard", now_s)
        if misheard is not None:
            data = self._thinned(data, misheard.amount)
        self.heard += data.count(self.command_mark)
        answer = self._controller.receive(data, now_s)
        self._strike(now_s)
        return self._send(answer, now_s)

    def poll(self, now_s: float) -> bytes:
        """Return other data that arrives by now."""
        self._strike(now_s)
        data = self._send(self._controller.poll(now_s), now_s)
        while self._on_the_way and self._on_the_way[0][0] <= now_s:
            data += self._on_the_way.popleft()[1]
        return b"" if self.cut(now_s) else data + self._flood(now_s)

    def _there(self, kind: str, now_s: float) -> Fault | None:
        return next((f for f in self._faults if f.kind == kind and f.is_active(now_s, self.heard)), None)

    def _strike(self, now_s: float) -> None:
        for fault in [fault for fault in self._arm_faults if fault.is_active(now_s, self.heard)]:
            self._arm_faults.remove(fault)
            self._controller.inject(ArmFault(fault.kind), int(fault.amount), now_s)

    def _send(self, data: bytes, now_s: float) -> bytes:
        """The part of the data that arrives at once, with faults."""
        if not data or self.cut(now_s) or self._there("silent", now_s) is not None:
            return b""
        lost, garbage, late = (self._there(kind, now_s) for kind in ("lost", "garbage", "late"))
        if lost is not None:
            data = self._thinned(data, lost.amount)
        if garbage is not None:
            data = self._strewn(data, garbage.amount)
        if late is None and not self._on_the_way:
            return data
        self._on_the_way.append((now_s + (0.0 if late is None else late.amount), data))
        return b""

    def _thinned(self, data: bytes, chance: float) -> bytes:
        return np.frombuffer(data, np.uint8)[self._rng.random(len(data)) >= chance].tobytes()

    def _strewn(self, data: bytes, chance: float) -> bytes:
        after = np.flatnonzero(self._rng.random(len(data)) < chance) + 1
        return np.insert(np.frombuffer(data, np.uint8), after, self._rng.integers(0, 256, len(after))).tobytes()

    def _flood(self, now_s: float) -> bytes:
        flood = self._there("flood", now_s)
        if flood is None:
            self._flooded_s = None
            return b""
        since = now_s if self._flooded_s is None else self._flooded_s
        size = min(int((now_s - since) * flood.amount), LARGEST_FLOOD)
        if size or self._flooded_s is None:
            self._flooded_s = now_s
        return self._rng.integers(0x20, 0x7F, size, dtype=np.uint8).tobytes()
