"""The arm of `corrected.py`: what stands below the line is copied there, under an arm's own numbers."""

import math
from collections.abc import Iterator, Sequence

Matrix = list[list[float]]
JOINTS: list[str] = []
PLACEMENTS: list[Matrix] = []
NOMINAL: list[Matrix] = []
AXES: list[list[float]] = []
SLIDES: list[bool] = []
CHAIN: list[int] = []
END: Matrix = []
MASSES: list[tuple[float, list[float]]] = []
GRAVITY: list[float] = []
FRAMES: dict[str, Matrix] = {}
CELL: dict[str, Matrix] = {}


def bend(path: list[list[float]], readings: list[list[float]]) -> None:
    """Stand in for an arm's own."""


def move(T: Matrix, read: list[float]) -> Matrix:
    """Stand in for an arm's own."""
    return T


# ----------------------------------------------------------------------------------------------------------------------


def flange(q: Sequence[float], path: Sequence[Sequence[float]] = ()) -> Matrix:
    """T_base_flange (4 x 4) at the joint values q, in the order of JOINTS [rad or m].

    `path` are the joint values of the poses before, the oldest first: lost motion depends on them.
    """
    readings = [[float(value) for value in values] for values in (*path, q)]
    bent = [list(values) for values in readings]
    bend(bent, readings)
    return move(times(joint_frames(bent[-1], PLACEMENTS)[-1], END), readings[-1])


def sensor(q: Sequence[float], path: Sequence[Sequence[float]] = ()) -> dict[str, Matrix]:
    """Where the sensor's frames are in the base frame, by name (4 x 4); see `flange`."""
    T = flange(q, path)
    return {name: times(T, T_flange_frame) for name, T_flange_frame in FRAMES.items()} | CELL


def times(A: Matrix, B: Matrix) -> Matrix:
    """A B."""
    return [[sum(a * B[k][j] for k, a in enumerate(row)) for j in range(4)] for row in A]


def apply(T: Matrix, point: Sequence[float]) -> list[float]:
    """A point moved."""
    return [sum(t * x for t, x in zip(row, (*point, 1.0), strict=True)) for row in T[:3]]


def turned(axis: Sequence[float], angle: float) -> Matrix:
    """A turn about a unit axis (Rodrigues)."""
    x, y, z = axis
    s, c = math.sin(angle), math.cos(angle)
    v = 1.0 - c
    return [
        [c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0.0],
        [y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0.0],
        [z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]


def shifted(axis: Sequence[float], way: float) -> Matrix:
    """A shift along a unit axis."""
    return [[1.0, 0.0, 0.0, axis[0] * way], [0.0, 1.0, 0.0, axis[1] * way], [0.0, 0.0, 1.0, axis[2] * way],
            [0.0, 0.0, 0.0, 1.0]]  # fmt: skip


def joint_frames(q: Sequence[float], placements: Sequence[Matrix]) -> list[Matrix]:
    """T_base_joint along CHAIN, each joint moved by its value."""
    T, frames = turned((0.0, 0.0, 1.0), 0.0), []
    for i in CHAIN:
        motion = shifted(AXES[i], q[i]) if SLIDES[i] else turned(AXES[i], q[i])
        T = times(times(T, placements[i]), motion)
        frames.append(T)
    return frames


def cross(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """A x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    """A . b."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def borne(q: Sequence[float], joint: int, masses: Sequence[tuple[float, list[float]]]) -> float:
    """What a joint bears of masses [kg] at points of the links along CHAIN [Nm or N]."""
    frames, at = joint_frames(q, NOMINAL), CHAIN.index(joint)
    T = frames[at]
    axis = [dot(row[:3], AXES[joint]) for row in T[:3]]
    torque = 0.0
    for frame, (mass, centre) in list(zip(frames, masses, strict=True))[at:]:
        arm = [point - row[3] for point, row in zip(apply(frame, centre), T, strict=False)]
        torque -= mass * dot(axis if SLIDES[joint] else cross(axis, arm), GRAVITY)
    return torque


def steps(path: list[list[float]], readings: list[list[float]]) -> Iterator[tuple[list[float], ...]]:
    """Each pose along the path, the pose before it and its own readings."""
    was = [list(q) for q in path]
    return zip(path, [was[0], *was[:-1]], readings, strict=True)


def lag(path: list[list[float]], joint: int, lost_motion: float, start: float) -> None:
    """A joint driven through play; at the first pose it stands in the play at `start`, from -1 to 1."""
    half = abs(lost_motion) / 2
    ahead = half * start
    for q, before, _ in steps(path, path):
        ahead = min(max(ahead - (q[joint] - before[joint]), -half), half)
        q[joint] += math.copysign(1.0, lost_motion) * ahead


def sunk(q: Sequence[float], joint: int, compliance: float, payload: float, hardening: float) -> float:
    """How far a joint gives way under the gravity torque that it bears."""
    one_kg = [(0.0, [0.0, 0.0, 0.0])] * (len(CHAIN) - 1) + [(1.0, [row[3] for row in END[:3]])]
    wound = compliance * borne(q, joint, MASSES) + payload * borne(q, joint, one_kg)
    return wound * (1.0 - hardening * abs(wound))


def tipped(T: Matrix, q: Sequence[float], soft: Sequence[tuple[list[float], float]]) -> Matrix:
    """The flange on a base that turns about axes, by their compliance, under the overturning moment."""
    moment = [0.0, 0.0, 0.0]
    for frame, (mass, centre) in zip(joint_frames(q, NOMINAL), MASSES, strict=True):
        weight = [mass * g for g in GRAVITY]
        moment = [m + part for m, part in zip(moment, cross(apply(frame, centre), weight), strict=True)]
    turn = [sum(axis[i] * compliance * dot(axis, moment) for axis, compliance in soft) for i in range(3)]
    angle = math.sqrt(dot(turn, turn))
    return times(turned([t / angle for t in turn], angle), T) if angle > 0.0 else T
