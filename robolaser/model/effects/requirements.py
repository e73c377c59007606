"""Requirements of effects on a data set: each function returns why the data do not meet it, "" if they do."""

from typing import final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.data.path_velocities import known_velocities, without_velocity
from robolaser.model.effects.joints import turning_joints
from robolaser.model.effects.run import gravity_of, temperature_rise
from robolaser.model.effects.target_plane import THIN, plane_of
from robolaser.model.sensors import fitted_lens, is_of_scanner, sensor_class
from robolaser.model.sensors.in_cell import is_static
from robolaser.model.stages import Stage

MOST_LISTED = 6  # poses in a reason
ALIKE = 0.9  # rank correlation of time and a joint's angle (Spearman) from which they are not told apart. A judgement
SHUFFLE = "poses in random order"
PARTS = {
    Stage.MOUNT: "bracket",
    Stage.PIXELS: "camera",
    Stage.IMAGE: "camera",
    Stage.LASER_PLANE: "laser plane",
    Stage.POINTS: "laser plane",
    Stage.TARGET: "target",
}
"""The parts of a sensor through which values pass at a stage."""


@final
class SensorLacks(str):
    """Why no sensor of a kind can have an effect; other reasons concern the data."""

    __slots__ = ()


@final
class DataLack(str):
    """A reason that other data would remove; `remedy` names them."""

    remedy: str

    def __new__(cls, reason: str, remedy: str) -> "DataLack":
        """What is missing, and what would have to be recorded or stated."""
        made = super().__new__(cls, reason)
        made.remedy = remedy
        return made

    def __reduce__(self) -> tuple[type["DataLack"], tuple[str, str]]:
        """The arguments of a copy."""
        return DataLack, (str(self), self.remedy)


NO_JOINTS = DataLack(
    "no joint angles in the data, only poses of the flange",
    "joint readings (columns q_<joint> of poses.csv, with [robot] in dataset.toml) instead of flange poses",
)
NO_MASSES = DataLack(
    "no masses in the URDF", "masses of the links in the URDF, or of what the flange carries (column payload_kg)"
)
NO_ORDER = DataLack("the order of the poses is not known", "when each pose was measured (column time_s)")
NO_PATH = DataLack(
    "the path between the poses is not known",
    'poses between which the arm went straight, joint by joint ([robot] path = "consecutive")',
)
NO_VELOCITIES = DataLack(
    "no joint velocities in the data",
    "the velocity of each joint at the exposure (columns qd_<joint>), or poses that follow one another in motion",
)
NO_MOTION = DataLack(
    "the flange's poses do not follow one another in motion", "flange poses with times, several a second while it moves"
)
AT_REST = DataLack("the arm stood still at every exposure", "exposures while the arm moves, with its velocities")
NOT_FLAT = DataLack(
    "the target points do not lie in one plane, nor in parallel ones", "a flat target, or one with flat steps"
)


def passes(stage: Stage, dataset: Dataset) -> str:
    """Values of this robot and sensor pass the stage."""
    if stage in (Stage.JOINTS, Stage.LINKS):
        return joint_angles(dataset)
    stages = sensor_class(dataset.kind).stages_in(dataset)
    return "" if stage in stages else SensorLacks(f"a {dataset.format.title} has no {PARTS.get(stage, 'flange')}")


def known_ranges(dataset: Dataset) -> str:
    """A camera sees points of a target at known positions."""
    return passes(Stage.IMAGE, dataset) or passes(Stage.TARGET, dataset)


def no_mount(dataset: Dataset) -> str:
    """The flange carries no sensor: for a sensor there is `hand_eye_sag`."""
    mounted = not passes(Stage.MOUNT, dataset)
    return "the sensor is on the flange: the effects of its bracket cover this" if mounted else ""


def laser_plane(dataset: Dataset) -> str:
    """A laser plane intersects the surface."""
    return passes(Stage.LASER_PLANE, dataset)


def camera_alone_on_flange(dataset: Dataset) -> str:
    """The alternative is the camera's bracket: a laser plane on it, or a stand in the cell, would drift likewise."""
    is_alone = bool(laser_plane(dataset)) and not is_of_scanner(dataset) and not is_static(dataset)
    return (
        ""
        if is_alone
        else SensorLacks(
            "only a camera alone on the flange shows it: elsewhere its bracket, stand or laser drifts alike"
        )
    )


def centred_lens(dataset: Dataset) -> str:
    """The sensor's own parameters do not have a decentred lens."""
    own = {"p1", "p2"} & fitted_lens(dataset)
    return "the sensor's own p1 and p2 are fitted and describe it" if own else ""


def free_radial_term(dataset: Dataset) -> str:
    """The sensor's own parameters do not have all radial terms."""
    own = {"k2", "k3"} <= fitted_lens(dataset)
    return "the sensor's own k1, k2 and k3 are fitted and describe it" if own else ""


def joint_angles(dataset: Dataset) -> str:
    """Joint angles were read."""
    return "" if dataset.robot is not None else NO_JOINTS


def turning_joint(dataset: Dataset) -> str:
    """A joint of the arm turns, and does not slide."""
    return "" if turning_joints(dataset.robot) else "this arm has no revolute joint"


def masses(dataset: Dataset) -> str:
    """The loads of the joints are known."""
    payload = dataset.poses.payload_kg
    known = dataset.robot is not None and (dataset.robot.has_masses or (payload is not None and payload.any()))
    return joint_angles(dataset) or ("" if known else NO_MASSES)


def weight(dataset: Dataset) -> str:
    """The direction of gravity is known."""
    return "" if gravity_of(dataset).any() else "no gravity in the data"


def own_lengths(dataset: Dataset) -> str:
    """The sensor measures lengths, and sees no target with given ones."""
    stages = sensor_class(dataset.kind).stages_in(dataset)
    measures = Stage.TARGET in stages and Stage.PIXELS not in stages
    return "" if measures else SensorLacks(f"a {dataset.format.title} has no lengths of its own")


def pose_order(dataset: Dataset) -> str:
    """The order of the poses is known."""
    return "" if dataset.poses.time_s is not None else NO_ORDER


def order_of_its_own(dataset: Dataset) -> str:
    """The order of the poses is known, and is not that of a joint's angle."""
    q, seen = dataset.poses.q, np.unique(dataset.points.pose)
    if (reason := pose_order(dataset)) or dataset.robot is None or q is None or len(seen) < 2:
        return reason
    assert dataset.poses.time_s is not None  # the order is known
    ranks = np.argsort(np.argsort(np.column_stack([dataset.poses.time_s, q])[seen], axis=0, kind="stable"), axis=0)
    moves = np.ptp(q[seen], axis=0) > 0
    alike = np.abs(np.asarray(np.corrcoef(ranks, rowvar=False))[0, 1:]) * moves
    if alike.max() < ALIKE:
        return ""
    joint = dataset.robot.joints[int(np.argmax(alike))]
    return DataLack(f"{joint} moves one way in the course of the run: its error looks like a drift", SHUFFLE)


def path(dataset: Dataset) -> str:
    """The path to each pose is known."""
    return joint_angles(dataset) or pose_order(dataset) or ("" if dataset.path_known else NO_PATH)


def warm_up(dataset: Dataset) -> str:
    """Temperatures or times determine the progress of the warm-up."""
    return "" if temperature_rise(dataset.poses) is not None else pose_order(dataset)


def velocities(dataset: Dataset) -> str:
    """The arm moved at some exposures, with known velocity."""
    if dataset.poses.qd is None:
        return NO_VELOCITIES if dataset.robot is not None else NO_MOTION
    if len(unknown := without_velocity(dataset)):
        names = ", ".join(dataset.poses.names[pose] for pose in unknown[:MOST_LISTED])
        return DataLack(
            f"the arm's velocity is not known at {len(unknown)} poses with points, which have no neighbours in time"
            f" (pose {names}{', …' if len(unknown) > MOST_LISTED else ''})",
            "the velocity of each joint at the exposure (columns qd_<joint>), or data without these poses",
        )
    qd = known_velocities(dataset)
    return "" if qd is not None and qd.any() else AT_REST


def flat_target(dataset: Dataset) -> str:
    """A camera sees points of a flat target, or of one with flat steps; a target without points may be flat."""
    if reason := passes(Stage.PIXELS, dataset):
        return reason
    flat = not len(dataset.points) or dataset.points.xyz is None or plane_of(dataset.points.xyz).flatness < THIN
    return "" if flat else NOT_FLAT
