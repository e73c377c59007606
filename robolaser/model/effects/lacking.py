"""What data may lack that an effect needs; each sentence says why it cannot be tested, "" means nothing is lacking."""

from robolaser.data.dataset import Dataset
from robolaser.model.effects.course import rise
from robolaser.model.effects.surface import THIN, plane_of
from robolaser.model.effects.weight import payload


def no_robot(dataset: Dataset) -> str:
    """Joint angles were not read."""
    return "" if dataset.robot is not None else "no joint angles in the data, only poses of the flange"


def no_weight(dataset: Dataset) -> str:
    """Nothing says what the joints bear."""
    if dataset.robot is None:
        return no_robot(dataset)
    known = dataset.robot.has_masses or payload(dataset.poses).any()
    return "" if known else "no masses in the URDF"


def no_order(dataset: Dataset) -> str:
    """It is not known which pose came first."""
    return "" if dataset.poses.time_s is not None else "the order of the poses is not known"


def no_path(dataset: Dataset) -> str:
    """It is not known from where the arm came to each pose."""
    if dataset.robot is None:
        return no_robot(dataset)
    return no_order(dataset) or ("" if dataset.path_known else "the path between the poses is not known")


def no_warming(dataset: Dataset) -> str:
    """Neither a thermometer nor the time tells how far things had warmed up."""
    return "" if rise(dataset.poses) is not None else no_order(dataset)


def no_velocities(dataset: Dataset) -> str:
    """The arm stood still, or nobody knows how it moved."""
    if dataset.robot is None:
        return no_robot(dataset)
    if dataset.poses.qd is None:
        return "no joint velocities in the data"
    return "" if dataset.poses.qd.any() else "the arm stood still at every exposure"


def no_stripe(dataset: Dataset, part: str) -> str:
    """Another kind of sensor, which has no such part."""
    return "" if dataset.kind == "stripe" else f"only a stripe scanner has a {part}"


def no_flat_target(dataset: Dataset) -> str:
    """The points are not those of a flat target, or of one with flat steps."""
    xyz = dataset.points.xyz
    if dataset.kind != "stripe" or xyz is None:
        return no_stripe(dataset, "printed target")
    return "" if plane_of(xyz).flatness < THIN else "the target points do not lie in one plane, nor in parallel ones"
