"""The world that an emulated cell holds: the true arm, scanner and solids, and where they are now."""

import zlib
from collections.abc import Mapping
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.servo_loop import ServoLoop
from robolaser.emulator.world.scene import Image, Scene
from robolaser.trials.synthetic.arm import ScrewArm

SAME_PLACE_M = 1e-5  # the camera's place, and its turn in radians, within which speckle stays the same


@final
class EmulatedWorld:
    """A world as it is; backlash remembers the way the arm came.

    Args:
        arm: As its URDF has it.
        scene: Solids, camera and laser.
        truth: The sensor's true numbers, by name, SI.
        faults: Sizes by name and joint [rad]: `joint_offset` of an encoder's zero, and `backlash`, by half of which the
            link trails its motor on the side that it came from.
        loop: How the joints follow their commands; None: exactly.
    """

    def __init__(
        self,
        arm: ScrewArm,
        scene: Scene,
        truth: Mapping[str, float],
        faults: Mapping[tuple[str, str], float],
        loop: ServoLoop | None = None,
    ) -> None:
        self.arm, self.scene, self.truth, self.faults, self.loop = arm, scene, truth, faults, loop
        self._offset, play = (
            np.array([faults.get((name, joint), 0.0) for joint in arm.joints]) for name in ("joint_offset", "backlash")
        )
        self._half_play = play / 2
        self._none = np.zeros(arm.count)
        self._at: tuple[Array, Array] | None = None
        """Where the encoders are, and how far links trail; replaced as a whole, as images are taken meanwhile."""
        self._rendered: tuple[bytes, Array, Array] | None = None

    def follow(self, motor: Array) -> None:
        """Go on to where the encoders are now, straight from where they were, (j,) [rad].

        The first call puts the arm there, in the middle of all play.
        """
        before, lag = self._at or (motor, self._none)
        self._at = np.array(motor, dtype=np.float64), np.clip(lag + motor - before, -self._half_play, self._half_play)

    @property
    def q(self) -> Array:
        """True joint angles, (j,) [rad]; the arm is at zero until it was told to follow."""
        motor, lag = self._at or (self._none, self._none)
        return np.asarray(motor + self._offset - lag)

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
        """A picture, (height, width), from where the arm is: noise is new, speckle the same while nothing moves."""
        T = self.T_base_camera
        place = T.tobytes()
        if self._rendered is None or self._rendered[0] != place:
            self._rendered = place, *self.scene.render(T)
        _, room, laser = self._rendered
        grain = np.random.default_rng(zlib.crc32(np.rint(T / SAME_PLACE_M).astype(np.int64).tobytes()))
        return self.scene.expose(room, laser if lit else np.zeros_like(laser), rng=rng, grain=grain)
