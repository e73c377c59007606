"""An arm in MuJoCo: rigid except for inserted springs, and at rest under its weight."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.errors import TrialError
from robolaser.plugins import extra
from robolaser.robot.kinematics import Robot
from robolaser.trials.synthetic.arm import SCANNER_AT

FOOT: Final = "(foot)"  # under the root link
BRACKET: Final = "(bracket)"  # between the flange and its load
LIGHTEST: Final[dict[str, Any]] = {"mass": 1e-9, "inertia": [1e-9] * 3, "explicitinertial": True}
ARMATURE = 1.0  # keeps the engine's inertia regular; at rest it does nothing
STEP = 1e-6  # of finite differences in Newton's method [rad or m]
SETTLED = 1e-12  # last step of a deflection [rad or m]
ROUNDS = 40


@final
@dataclass(frozen=True, eq=False)
class Spring:
    """A spring between a joint and its encoder, or a hinge without an encoder."""

    # the joint before which a hinge is, in whose frame (before it turns) axis and point are; or `FOOT` or `BRACKET`,
    # whose frames are those of the base and of the flange
    before: str
    stiffness: float  # [Nm/rad or N/m]
    axis: Array | None = None  # of the hinge, (3,); None: no hinge, the joint's own gear
    at: Array | None = None  # a point on it, (3,) [m]
    play: float = 0.0  # full width of the range with nearly no stiffness [rad or m]
    centring: float = 0.0  # stiffness within the play

    def torque(self, away: float) -> tuple[float, float]:
        """Its reaction to a deflection [Nm or N], and the derivative."""
        within = min(max(away, -self.play / 2), self.play / 2)
        slope = self.centring if self.play and within == away else self.stiffness
        return -self.centring * within - self.stiffness * (away - within), -slope


@final
class MujocoArm:
    """The arm of a URDF with its masses, held at commanded joint values.

    The base frame is that of the unloaded foot. Joints that the robot does not list stay at neutral. The load is on the
    bracket, at `SCANNER_AT`.
    """

    def __init__(self, robot: Robot, springs: Sequence[Spring] = (), load_kg: float = 0.0) -> None:
        self._engine, self._springs = mujoco(), springs
        spec, bodies, joints, soft = _specification(self._engine, robot, springs, load_kg)
        self._model = spec.compile()
        self._data = self._engine.MjData(self._model)
        self._columns, self._soft = (self._model.jnt_qposadr[[one.id for one in some]] for some in (joints, soft))
        self._bodies = [body.id for body in bodies]

    def weights(self, q: Array) -> Array:
        """Load of each spring in a rigid arm, (n, j) -> (n, s) [Nm or N]."""
        return np.array([self._borne(posture, np.zeros(len(self._springs))) for posture in q])

    def at_rest(self, q: Array) -> tuple[Array, Array]:
        """Poses of flange and bracket at rest for commanded joint values (n, j): two (n, 4, 4) in the base frame.

        Raises:
            TrialError: The arm is too heavy for its springs.
        """
        flange, bracket = (np.tile(np.eye(4), (len(q), 1, 1)) for _ in range(2))
        for row, posture in enumerate(q):
            self._settle(posture)
            for T, body in zip((flange, bracket), self._bodies, strict=True):
                T[row, :3, :3] = self._data.xmat[body].reshape(3, 3)
                T[row, :3, 3] = self._data.xpos[body]
        return flange, bracket

    def _settle(self, posture: Array) -> None:
        """Find the equilibrium of all springs by Newton's method."""
        away = np.zeros(len(self._springs))
        for _ in range(ROUNDS):
            borne = self._borne(posture, away)
            if not len(away):
                return  # the engine has placed all bodies
            torque, slope = np.array([spring.torque(by) for spring, by in zip(self._springs, away, strict=True)]).T
            softer = [(self._borne(posture, away + shift) - borne) / STEP for shift in STEP * np.eye(len(away))]
            step = np.linalg.solve(np.diag(slope) - np.transpose(softer), borne - torque)
            away = away + step
            if np.abs(step).max() < SETTLED:
                self._borne(posture, away)
                return
        raise TrialError(
            f"The arm does not come to rest at joint values {np.round(posture, 3).tolist()}: its springs are too soft"
            " for its weight. Make the fault smaller."
        )

    def _borne(self, posture: Array, away: Array) -> Array:
        """The weight on each spring at given deflections, (s,) [Nm or N]."""
        data = self._data
        data.qpos[:] = 0.0
        data.qpos[self._columns] = posture
        data.qpos[self._soft] += away
        self._engine.mj_forward(self._model, data)
        return np.array(data.qfrc_bias[self._soft])


def mujoco() -> Any:
    """The engine, which is slow to import; a `DependencyMissing` if it is not installed."""
    why = "MuJoCo, which moves the arms of the kind 'physics', is not installed: pip install 'robolaser[trials]'."
    return extra("mujoco", why)


def _specification(
    engine: Any, robot: Robot, springs: Sequence[Spring], load_kg: float
) -> tuple[Any, list[Any], list[Any], list[Any]]:
    """MuJoCo's own model (MjSpec): a body a link, a foot below the root, and a bracket on the flange.

    A joint's first link has the mass of all links up to the next joints.

    Returns:
        The model, the bodies of flange and bracket, the robot's joints, and those of the springs.
    """
    arm, spec = robot.by_pinocchio, engine.MjSpec()
    spec.compiler.degree = False
    spec.option.gravity = np.array(robot.gravity)
    bodies = {FOOT: spec.worldbody.add_body(**LIGHTEST)}
    links: dict[str, Any] = {}
    for link in arm.links:
        x, y, z, w = Rotation.from_matrix(link.T_parent_link[:3, :3]).as_quat()
        placed = {"pos": link.T_parent_link[:3, 3], "quat": [w, x, y, z]}
        links[link.name] = body = links.get(link.parent, bodies[FOOT]).add_body(**placed, **LIGHTEST)
        if link.joint is not None:
            body.mass, body.ipos = max(float(arm.masses[link.joint]), body.mass), arm.centres[link.joint]
            bodies[arm.moving[link.joint]] = body
    bodies[BRACKET] = links[robot.flange].add_body(**LIGHTEST)
    if load_kg:
        bodies[BRACKET].add_body(pos=SCANNER_AT, **{**LIGHTEST, "mass": load_kg})
    turning, sliding = engine.mjtJoint.mjJNT_HINGE, engine.mjtJoint.mjJNT_SLIDE
    hinges = {
        i: bodies[spring.before].add_joint(type=turning, axis=spring.axis, pos=spring.at, armature=ARMATURE)
        for i, spring in enumerate(springs)
        if spring.axis is not None
    }
    joints = {
        name: bodies[name].add_joint(type=sliding if slides else turning, axis=axis, armature=ARMATURE)
        for name, axis, slides in zip(robot.joints, robot.axes, robot.prismatic, strict=True)
    }
    soft = [hinges.get(i) or joints[spring.before] for i, spring in enumerate(springs)]
    return spec, [links[robot.flange], bodies[BRACKET]], list(joints.values()), soft
