"""An arm as MuJoCo sees it: rigid but for springs that are put into it, and at rest under its weight."""

from collections.abc import Mapping, Sequence
from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import TrialError
from robolaser.robot.kinematics import Robot
from robolaser.trials.forward_differences import forward_differences
from robolaser.trials.physics.elements import BRACKET, Gear, Load, SpringHinge
from robolaser.trials.physics.specification import body_name, hinge_name, joint_name, mujoco, specification

STEP = 1e-6  # of the differences that Newton's method rests on [rad or m]
SETTLED = 1e-12  # last step of a coordinate [rad or m]
ROUNDS = 40


@final
class MujocoArm:
    """The arm of a URDF with its masses, held at the joint values that are commanded.

    The base frame is that of the unloaded foot.

    Args:
        robot: Names the URDF, its joints and its flange.
        hinges: Springs between bodies.
        gears: By joint; the others are rigid.
        load: On the bracket.

    Raises:
        DependencyMissing: MuJoCo is not installed.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        hinges: Sequence[SpringHinge] = (),
        gears: Mapping[str, Gear] | None = None,
        load: Load | None = None,
    ) -> None:
        self._engine = mujoco()
        self._gears = dict(gears or {})
        self._model = specification(self._engine, robot, hinges, self._gears, load).compile()
        self._data = self._engine.MjData(self._model)
        for i, hinge in enumerate(hinges):
            self._model.joint(hinge_name(i)).stiffness[:] = hinge.stiffness
        for name, gear in self._gears.items():
            self._model.joint(joint_name(name)).stiffness[:] = 0.0 if gear.servo or gear.play else gear.stiffness
        self._columns = self._coordinates(map(joint_name, robot.joints))
        self._soft = self._coordinates([*map(hinge_name, range(len(hinges))), *map(joint_name, self._gears)])
        self._flange = self._model.body(body_name(robot.flange)).id
        self._bracket = self._model.body(BRACKET).id

    def weights(self, q: Array) -> Array:
        """What each hinge, then each gear, must bear in a rigid arm, (n, j) -> (n, s) [Nm or N]."""
        borne = np.empty((len(q), len(self._soft)))
        for row, posture in enumerate(q):
            self._command(posture)
            self._engine.mj_forward(self._model, self._data)
            borne[row] = self._data.qfrc_bias[self._soft]
        return borne

    def at_rest(self, q: Array) -> tuple[Array, Array]:
        """Where flange and bracket come to rest for commanded joint values (n, j): two (n, 4, 4) in the base frame.

        Raises:
            TrialError: The arm is too heavy for its springs.
        """
        flange, bracket = (np.tile(np.eye(4), (len(q), 1, 1)) for _ in range(2))
        for row, posture in enumerate(q):
            self._settle(posture)
            for T, body in ((flange, self._flange), (bracket, self._bracket)):
                T[row, :3, :3] = self._data.xmat[body].reshape(3, 3)
                T[row, :3, 3] = self._data.xpos[body]
        return flange, bracket

    def _coordinates(self, names: Any) -> Any:
        """Where joints of the engine's model stand in its vectors: each has one coordinate."""
        return np.array([self._model.joint(name).qposadr[0] for name in names], dtype=np.int64)

    def _command(self, posture: Array) -> None:
        """Nothing deflected, every spring and servo at its command."""
        data, model = self._data, self._model
        data.qpos[:] = 0.0
        data.qpos[self._columns] = posture
        model.qpos_spring[:] = data.qpos
        for name, gear in self._gears.items():
            if gear.servo:
                data.ctrl[model.actuator(name).id] = data.qpos[model.joint(joint_name(name)).qposadr[0]]

    def _settle(self, posture: Array) -> None:
        """Newton's method on the forces along everything that gives way."""
        self._command(posture)
        commanded = self._data.qpos[self._soft].copy()
        away = np.zeros(len(commanded))
        for _ in range(ROUNDS):
            here = self._forces(commanded + away)
            if not len(away):
                return  # the engine has placed all bodies
            slopes = forward_differences(
                lambda steps, at=commanded + away: np.stack([self._forces(at + step) for step in steps]),  # type: ignore[misc]
                np.full(len(away), STEP),
                here,
            )
            for i, gear in enumerate(self._gears.values(), start=len(away) - len(self._gears)):
                if gear.play:
                    torque, slope = gear.torque(float(away[i]))
                    here[i] += torque
                    slopes[i, i] += slope
            step = np.linalg.solve(slopes, -here)
            away = away + step
            if np.abs(step).max() < SETTLED:
                self._forces(commanded + away)
                return
        raise TrialError(
            f"The arm does not come to rest at joint values {np.round(posture, 3).tolist()}: its springs are too soft"
            " for its weight. Make the fault smaller."
        )

    def _forces(self, soft: Array) -> Array:
        """What the engine says would move each soft coordinate at these values, (s,) [Nm or N]."""
        data = self._data
        data.qpos[self._soft] = soft
        self._engine.mj_forward(self._model, data)
        return np.asarray((data.qfrc_passive + data.qfrc_actuator - data.qfrc_bias)[self._soft])
