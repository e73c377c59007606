"""Universal Robots' arms, by RTDE: the package ur-rtde."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import Any, ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock
from robolaser.cell.failures import alarm, joints_differ, line_lost, refused
from robolaser.data.cell_config import Cell
from robolaser.errors import ArmError
from robolaser.plugins import extra

STEP = 1e-5  # readings of a joint at rest differ by less [rad]
RAMP = 0.25  # share of a motion's time in which it gains speed
SLOWEST, GENTLEST = 0.001, 0.05  # least commanded speed and acceleration [rad/s, rad/s2]
BRAKING = 2.0  # when it is stopped [rad/s2]
STALE_S = 1.0  # a controller sends 125 or 500 readings a second
POLL_S = 0.005
VIOLATION, FAULT = 251, 252  # joint modes of a joint in trouble
ADVICE = "Look for what it ran into, and unlock it at the teach pendant."


@final
class UrArm(Arm):
    """An arm whose teach pendant is in remote control."""

    outputs: ClassVar[int | None] = 8
    synchronous_read: ClassVar[bool] = True
    absolute_encoders: ClassVar[bool] = True

    def __init__(self, address: str, joints: Sequence[str], clock: Clock) -> None:
        missing = f"The arm at {address} is of kind 'ur', which needs the package ur-rtde: pip install 'robolaser[ur]'."
        control, io, receive = (extra(f"rtde_{part}", missing) for part in ("control", "io", "receive"))
        self._address, self._joints, self._clock = address, tuple(joints), clock
        self._stamp = -1.0
        with ExitStack() as ends:
            try:
                self._receive: Any = receive.RTDEReceiveInterface(address)
                ends.callback(_end, self._receive.disconnect)
                self._control: Any = control.RTDEControlInterface(address)
                ends.callback(_end, self._control.disconnect)
                ends.callback(_end, self._control.stopScript)
                self._io: Any = io.RTDEIOInterface(address)
                ends.callback(_end, self._io.disconnect)
            except RuntimeError as error:
                raise ArmError(
                    f"Cannot open the arm at {address}: {error}. Check its address ([arm] port in cell.toml, or"
                    " --port), that it is switched on, and that its teach pendant is in remote control."
                ) from None
            found = len(self.read())
            if found != len(joints):
                raise joints_differ("ur", len(joints), found)
            self._ends = ends.pop_all()
        self.step = np.full(len(joints), STEP)

    @classmethod
    def open(cls, cell: Cell, clock: Clock) -> Self:
        """Connect with the controller."""
        return cls(cell.arm.port, cell.robot.joints, clock)

    def read(self) -> Array:
        """Read the joint angles, (j,)."""
        began = self._clock.now()
        while True:
            with self._on_line():
                stamp = float(self._receive.getTimestamp())
                if stamp != self._stamp and self._receive.isConnected():
                    self._stamp = stamp
                    q = np.array(self._receive.getActualQ(), dtype=np.float64)
                    if np.isfinite(q).all():
                        return q
            if self._clock.now() - began > STALE_S:
                raise line_lost(self._address, f"no reading for {STALE_S:.0f} s")
            self._clock.wait(POLL_S)

    def poll_faults(self) -> None:
        """Raise a protective or emergency stop, with its joint."""
        with self._on_line():
            stopped = self._receive.isProtectiveStopped() or self._receive.isEmergencyStopped()
            modes = self._receive.getJointMode() if stopped else ()
        if stopped:
            guilty = [joint for joint, mode in zip(self._joints, modes, strict=False) if mode in (VIOLATION, FAULT)]
            raise alarm(self._address, ", ".join(guilty) or "no joint is named", "protective or emergency stop", ADVICE)

    def start_move(self, q: Array, seconds: float) -> None:
        """Start a motion to angles, (j,)."""
        way = float(np.abs(q - self.read()).max())
        speed = max(SLOWEST, way / (seconds * (1 - RAMP)))
        with self._on_line():
            acceleration = max(GENTLEST, speed / (RAMP * seconds))
            self._heard(self._control.moveJ(q.tolist(), speed, acceleration, asynchronous=True), "moveJ")

    def stop(self) -> None:
        """Stop at the current position; a lost connection is renewed, which ends the program that moves it."""
        with self._on_line():
            for end in (self._receive, self._control):
                if not end.isConnected() and not end.reconnect():
                    raise line_lost(self._address, "it cannot be connected again")
            self._control.stopJ(BRAKING, asynchronous=True)

    def home(self) -> None:
        """Nothing: its encoders are absolute."""

    def switch(self, output: int, *, on: bool) -> None:
        """Switch an output, over a new connection if the old one is lost: digital output 0 is the first."""
        with self._on_line():
            if not self._io.setStandardDigitalOut(output - 1, on):
                self._io.reconnect()
                self._heard(self._io.setStandardDigitalOut(output - 1, on), "setStandardDigitalOut")

    def close(self) -> None:
        """Disconnect; the program that moves it ends."""
        self._ends.close()

    def _heard(self, done: object, command: str) -> None:
        """Check the package's return value: False where the controller did not take a command."""
        if not done:
            raise refused(self._address, command, "False", "look at the teach pendant: is it in remote control?")

    @contextmanager
    def _on_line(self) -> Iterator[None]:
        """Raise the package's connection errors as errors of the arm."""
        try:
            yield
        except RuntimeError as error:
            raise line_lost(self._address, str(error)) from None


def _end(what: Callable[[], Any]) -> None:
    """Call a function that disconnects; errors of a lost connection are ignored."""
    with suppress(RuntimeError):
        what()
