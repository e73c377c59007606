"""What is said of each kind of sensor, of its noise, and of a data set that it measured."""

from collections.abc import Mapping

from robolaser.data.dataset import Dataset

DOES: Mapping[str, str] = {
    "stripe": "the scanner places points",
    "point": "the model predicts tracked points",
    "socket": "the model puts the ball",
}
MEASURED_BY: Mapping[str, str] = {
    "stripe": "laser stripe scanner",
    "point": "tracked points on the flange",
    "socket": "ball in fixed sockets",
}
KNOWN: Mapping[str, str] = {"stripe": "known point", "point": "measured point", "socket": "socket"}
FRAME: Mapping[str, str] = {"stripe": "base frame", "point": "tracker's frame", "socket": "base frame"}
SOURCES: Mapping[str, tuple[str, str]] = {
    "pixel": ("line centre in the image", "px"),
    "target": ("target points", "m"),
    "point": ("tracked points", "m"),
    "seat": ("seat of the ball", "m"),
    "joint": ("joint readings", "rad"),
    "probe": ("tracker's probe, position", "m"),
    "probe_turn": ("tracker's probe, rotation", "rad"),
    "flange": ("flange poses, position", "m"),
    "flange_turn": ("flange poses, rotation", "rad"),
}
"""What each source of noise disturbs, and the unit of its standard deviation."""


def setting(dataset: Dataset) -> str:
    """What was measured, with which arm, and how much of it."""
    arm = f"robot {dataset.robot.name}" if dataset.robot else "measured flange poses"
    poses = len(set(dataset.points.pose.tolist()))
    return f"{MEASURED_BY[dataset.kind]}, {arm}, {len(dataset.points)} points in {poses} poses"
