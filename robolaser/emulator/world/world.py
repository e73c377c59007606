"""The world that an emulated cell holds: the true arm, scanner and solids, and where they are now."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.emulator.servo_loop import ServoLoop
from robolaser.emulator.world.faults import TrackedBacklash
from robolaser.emulator.world.printed_board import PrintedBoard
from robolaser.emulator.world.scene import Image, Scene
from robolaser.trials.synthetic.arm import ScrewArm
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun

SAME_PLACE_M = 1e-5  # the camera's place, and its turn in radians, within which speckle stays the same


@final
class EmulatedWorld:
    """A world as it is; backlash remembers the way the arm came.

    Args:
        arm: As its URDF has it.
        scene: Solids, camera and laser without faults.
        truth: The sensor's true numbers, by name, SI.
        faults: In what the cell is not what its model says, in the order in which they act.
        loop: How the joints follow their commands; None: exactly.
    """

    def __init__(
        self,
        arm: ScrewArm,
        scene: Scene,
        truth: Mapping[str, float],
        faults: Sequence[FaultModel] = (),
        loop: ServoLoop | None = None,
    ) -> None:
        self.arm, self.faults, self.loop, self._truth = arm, tuple(faults), loop, truth
        self._motor: Array | None = None
        run, light = self._run(np.zeros(arm.count)), scene.light
        for fault in self.faults:
            light = light and fault.light(light, run)
        self.scene = replace(scene, light=light)
        self._rendered: tuple[bytes, Array, Array] | None = None

    def follow(self, motor: Array) -> None:
        """Go on to where the encoders are now, straight from where they were, (j,) [rad].

        The first call puts the arm there, in the middle of all play.
        """
        motor = np.asarray(motor, dtype=np.float64)
        if self._motor is not None and not np.array_equal(motor, self._motor):
            moves, run = motor - self._motor, self._run(motor)
            self.faults = tuple(
                fault.moved(float(moves[run.column(fault.where)])) if isinstance(fault, TrackedBacklash) else fault
                for fault in self.faults
            )
        self._motor = motor.copy()

    @property
    def q(self) -> Array:
        """True joint angles, (j,) [rad]; the arm is at zero until it was told to follow."""
        run = self._run(np.zeros(self.arm.count) if self._motor is None else self._motor)
        q = run.q
        for fault in self.faults:
            q = fault.joints(q, run)
        one: Array = q[0]
        return one

    @property
    def T_base_flange(self) -> Array:  # noqa: N802 - the field's symbol
        """True pose of the flange, (4, 4)."""
        T: Array = self.arm.forward(self.q[None])[0]
        return T

    @property
    def T_base_camera(self) -> Array:  # noqa: N802 - the field's symbol
        """True pose of the camera, (4, 4)."""
        T: Array = self.T_base_flange @ self.scene.eye.optics.mount
        return T

    def photograph(self, rng: np.random.Generator, *, lit: bool) -> Image:
        """Take a picture from where the arm is: fresh noise in each, the same speckle while nothing moves.

        Args:
            rng: Source of the noise.
            lit: Whether the laser is on.

        Returns:
            (height, width).
        """
        T = self.T_base_camera
        place = T.tobytes()
        if self._rendered is None or self._rendered[0] != place:
            self._rendered = place, *self.scene.render(T)
        _, room, laser = self._rendered
        grain = np.random.default_rng(zlib.crc32(np.rint(T / SAME_PLACE_M).astype(np.int64).tobytes()))
        return self.scene.expose(room, laser if lit else np.zeros_like(laser), rng=rng, grain=grain)

    def truth(self) -> dict[str, float]:
        """The true numbers, by the names that a calibration and a diagnosis give them, SI.

        The sensor's; the board's placement, `target.x` to `target.psi`, if there is one; each fault as
        `NAME:WHERE`.
        """
        target: dict[str, float] = {}
        for board in self.scene.solids:
            if isinstance(board, PrintedBoard):
                turns = Rotation.from_matrix(board.T_base_board[:3, :3]).as_euler("XYZ")
                values = [*board.T_base_board[:3, 3].tolist(), *turns.tolist()]
                names = (f"target.{name}" for name in ("x", "y", "z", "w", "phi", "psi"))
                target = dict(zip(names, values, strict=True))
        faults = {f"{fault.effect}:{fault.where}": fault.size for fault in self.faults}
        return {**self._truth, **target, **faults}

    def _run(self, motor: Array) -> SyntheticRun:
        """What a fault may depend on, at rest at one configuration."""
        q = motor[None]
        return SyntheticRun(self.arm, q, np.zeros_like(q), np.zeros(1), np.zeros(3), radius=1.0, payload_kg=0.0)
