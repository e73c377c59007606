"""Postures worth a visit: from which the board and the stripe on it are seen, and which tell the most together."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Board, Dataset, Points, Poses
from robolaser.errors import DataError, PlanError
from robolaser.estimation.camera_views import CameraBoard, camera_board
from robolaser.geometry.inverse_kinematics import touching
from robolaser.geometry.kinematics import Robot
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.geometry.visibility import TILT, View, random_configurations
from robolaser.model.derivatives import jacobian_matrix
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.sensors import sensor_class
from robolaser.model.sensors.placements import SIX, motion
from robolaser.model.sensors.scanner_geometry import view_of

SPARE = 4  # candidates for each posture wanted,
LEAST_CANDIDATES, MOST_CANDIDATES = 60, 400  # within these bounds, but never fewer than are wanted
BATCH = 600  # postures tried at a time
BATCHES = 60  # for so many candidates as usual, and more in proportion
MARGIN = 0.04  # of the image, left free around the board
UNSURE_M = 0.03  # distance, in each direction, by which the board may lie elsewhere than it is stated to
SHIFTS_M = UNSURE_M * np.concatenate([np.eye(3), -np.eye(3)])
MOST_TRIED = 1800  # candidates, after which no more are sought that leave so much room
ASIDE = 0.3  # the stripe crosses the image's middle, or this share of its half beside it
Allowed = Callable[[Array], Bools]
"""Postures (n, j) to whether the arm may stand there, (n,)."""
ALONG = 7  # points of the stripe that stand for all of them
ERROR_M, ERROR_PX = 1e-4, 0.2  # of such a point, and of a camera's corner
MOST_SWAPS = 200


@final
@dataclass(frozen=True)
class _TargetView:
    """Where the target lies, and what looks at it."""

    robot: Robot
    view: View
    board: Board
    T_base_target: Array

    @property
    def size_m(self) -> Array:
        """From the first inner corner to the last."""
        return self.board.square_m * np.array([self.board.columns - 1, self.board.rows - 1])

    def candidates(self, wanted: int, allowed: Allowed, rng: np.random.Generator) -> Array:
        """Postures from which the whole board is in the image and the stripe falls on it, (≥ wanted, j).

        Of these, only such as keep the board in the image wherever it lies within `UNSURE_M`, if there are enough.

        Raises:
            PlanError: There are not enough.
        """
        enough = max(wanted, int(np.clip(SPARE * wanted, LEAST_CANDIDATES, MOST_CANDIDATES)))
        found, tried, seeing, roomy = np.empty((0, len(self.robot.joints))), 0, 0, np.empty(0, dtype=np.bool_)
        for _ in range(BATCHES * max(1, round(enough / MOST_CANDIDATES))):
            start = random_configurations(self.robot, BATCH, rng)
            start = start[self._turned_to_it(start)]
            inner = rng.uniform(0.1, 0.9, (len(start), 2)) * self.size_m
            goal = apply(self.T_base_target, np.pad(inner, ((0, 0), (0, 1))))
            place = self._in_flange(ASIDE * float(rng.choice([-1.0, 0.0, 1.0])))
            q, reached = touching(self.robot, lambda q: self.robot.forward(q[None])[0], place, goal, start)
            q = q[reached]
            q = q[self._sees(q)]
            tried, seeing, q = tried + BATCH, seeing + len(q), q[allowed(q)]
            found, roomy = np.concatenate([found, q]), np.append(roomy, self._sees_elsewhere(q))
            if roomy.sum() >= enough or len(found) >= max(MOST_TRIED, enough):
                break
        if len(found) < wanted:
            raise self._too_few(wanted, tried, seeing, len(found))
        return _with_room(found, roomy, wanted)[:enough]

    def _too_few(self, wanted: int, tried: int, seeing: int, allowed: int) -> PlanError:
        limits = f", and {allowed} of these are allowed" if allowed < seeing else ""
        narrow = "widen [limits] in cell.toml if it may, take a smaller --run-up, " if 2 * allowed < seeing else ""
        return PlanError(
            f"{self.robot.name} sees the whole board and the stripe on it from {seeing} of {tried} configurations that"
            f" were tried{limits}, but {wanted} are wanted. Ask for fewer poses, {narrow}move the board nearer to the"
            " middle of the arm's reach, or correct target.x ... in dataset.toml."
        )

    def _in_flange(self, aside: float) -> Array:
        """A point of the sheet on the flange, in the middle of the stripe or beside it, (3,) [m]."""
        v, across = self.view.values, 1 - self.view.along
        pitch, length = (v["s_u"], v["s_v"])[across], self.view.image_px[across]
        slope = aside * length / 2 * pitch / v["f"]
        depth = v["b"] / (slope + np.tan(v["theta"]))
        return apply(self.view.T_flange_camera, np.array([slope * depth, 0.0, depth]))

    def _cameras(self, q: Array) -> Array:
        """T_target_camera, (n, 4, 4)."""
        T: Array = inverse(self.T_base_target) @ self.robot.forward(q[None])[0] @ self.view.T_flange_camera
        return T

    def _turned_to_it(self, q: Array) -> Bools:
        """Postures that look at the target's plane so steeply that little turning is left to do, (n,)."""
        return np.asarray(np.abs(self._cameras(q)[:, 2, 2]) > np.cos(2 * TILT))

    def _sees_elsewhere(self, q: Array) -> Bools:
        """Whether postures see the whole board in all places that it may lie at, (n,)."""
        good: Bools = np.ones(len(q), dtype=np.bool_)
        for shift in SHIFTS_M:
            T = self.T_base_target.copy()
            T[:3, 3] += shift
            good &= replace(self, T_base_target=T)._sees(q)
        return good

    def _sees(self, q: Array) -> Bools:
        T = self._cameras(q)
        facing = np.sign(T[:, 2, 3])
        good: Bools = -facing * T[:, 2, 2] > np.cos(TILT)
        corners = np.pad(np.array([[0, 0], [0, 1], [1, 0], [1, 1]]) * self.size_m, ((0, 0), (0, 1)))
        shown = self.view.pixels(apply(inverse(T)[:, None], corners))
        good &= self.view.contains(shown, MARGIN).all(axis=1)
        frames = self.robot.joint_frames(q[None])[0][:, len(self.robot.chain) // 2 :, :3, 3]
        above = apply(inverse(self.T_base_target), frames)[..., 2]
        good &= (facing[:, None] * above > 0).all(axis=1)
        stripe = self.view.illuminated(T, 0.0, np.linspace(*self.view.stripe_range(), ALONG)[None])
        return np.asarray(good & np.isfinite(stripe).all(axis=(1, 2)))


def planned(
    description: Dataset, *, count: int, effects: Sequence[str] = (), allowed: Allowed | None = None, seed: int
) -> Array:
    """Postures from which a calibration learns the most: D-optimal (Fedorov 1972) among ones that see the board.

    Args:
        description: Robot, scanner, board, and where the board lies to a few centimetres (`target.x` ...).
        count: How many.
        effects: `EFFECT[:WHERE]` each, that are to be told apart from all else too.
        allowed: Where the arm may stand, besides its joints' limits; anywhere when absent.
        seed: Of the candidates.

    Returns:
        Joint values, (count, j) [rad or m], each next to the one before.

    Raises:
        DataError: The data set lacks a robot, a board, or where the board lies.
        PlanError: The arm sees the board from too few postures where it may stand.
        UsageError, EffectError: The effects cannot be.
    """
    may = allowed or (lambda q: np.ones(len(q), dtype=np.bool_))
    if not sensor_class(description.kind).has_laser_plane():
        seen = _camera_board(description)
        candidates = _seeing_board(seen, count, may, np.random.default_rng(seed))
        chosen = most_telling(_camera_slopes(description, seen, candidates, effects), count)
        return candidates[chosen][_short_way(candidates[chosen])]
    target_view = _target_view(description)
    candidates = target_view.candidates(count, may, np.random.default_rng(seed))
    chosen = most_telling(_slopes(description, target_view, candidates, effects), count)
    return candidates[chosen][_short_way(candidates[chosen])]


def most_telling(slopes: Array, count: int) -> Ints:
    """Choose blocks of rows whose sum of squares has the largest determinant.

    One after the other, then by exchange until no exchange helps (Fedorov 1972).

    Args:
        slopes: Derivatives of each block's residuals over their errors, by parameters over their uncertainty before
            any was measured, (k, r, d).
        count: How many, at most k.

    Returns:
        Numbers of the blocks, (count,).
    """
    if count == len(slopes):
        return np.arange(count)
    of_each = np.einsum("krd,kre->kde", slopes, slopes)
    known = np.eye(slopes.shape[2])
    chosen: list[int] = []
    for _ in range(count):
        gain = _gain(slopes, known)
        gain[chosen] = -np.inf
        chosen.append(int(gain.argmax()))
        known = known + of_each[chosen[-1]]
    for _ in range(MOST_SWAPS):
        best, swap = 1e-9, None
        for i, gone in enumerate(chosen):
            without = known - of_each[gone]
            gain = _gain(slopes, without)
            gain -= gain[gone]
            gain[chosen] = -np.inf
            if gain.max() > best:
                best, swap = float(gain.max()), (i, int(gain.argmax()))
        if swap is None:
            break
        known = known - of_each[chosen[swap[0]]] + of_each[swap[1]]
        chosen[swap[0]] = swap[1]
    return np.array(chosen, dtype=np.int64)


def _gain(slopes: Array, known: Array) -> Array:
    """By how much each block would raise the logarithm of the determinant, (k,)."""
    whitened = slopes @ np.linalg.inv(np.linalg.cholesky(known)).T
    inner = np.eye(slopes.shape[1]) + whitened @ np.swapaxes(whitened, 1, 2)
    return np.asarray(np.linalg.slogdet(inner)[1])


def _camera_board(description: Dataset) -> CameraBoard:
    pinhole = ("fx", "fy", "cx", "cy", *(f"hand_eye.{part}" for part in SIX))
    robot, board, size = _seen(description, pinhole)
    return camera_board(description, robot, board, size)


def _seeing_board(seen: CameraBoard, wanted: int, allowed: Allowed, rng: np.random.Generator) -> Array:
    """Postures from which the whole board is in the image, (≥ wanted, j).

    Raises:
        PlanError: There are not enough.
    """
    enough = max(wanted, int(np.clip(SPARE * wanted, LEAST_CANDIDATES, MOST_CANDIDATES)))
    found, seeing, roomy = np.empty((0, len(seen.robot.joints))), 0, np.empty(0, dtype=np.bool_)
    elsewhere = [_shifted(seen, shift) for shift in SHIFTS_M]
    for _ in range(BATCHES):
        q = seen.tried(BATCH, rng)
        q = q[seen.sees(q)]
        seeing, q = seeing + len(q), q[allowed(q)]
        found, roomy = np.concatenate([found, q]), np.append(roomy, np.all([one.sees(q) for one in elsewhere], axis=0))
        if roomy.sum() >= enough or len(found) >= max(MOST_TRIED, enough):
            break
    if len(found) < wanted:
        raise PlanError(
            f"In {seeing} of {BATCH * BATCHES} configurations of {seen.robot.name} that were tried the camera sees the"
            f" whole board, {len(found)} of them are allowed, but {wanted} are wanted. Ask for fewer poses, or correct"
            " hand_eye.x ... and target.x ... in dataset.toml."
        )
    return _with_room(found, roomy, wanted)[:enough]


def _shifted(seen: CameraBoard, shift: Array) -> CameraBoard:
    """The same camera with its board elsewhere."""
    moved = {name: seen.values[name] + by for name, by in zip(("target.x", "target.y", "target.z"), shift, strict=True)}
    return replace(seen, values={**seen.values, **moved})


def _with_room(found: Array, roomy: Bools, wanted: int) -> Array:
    """Only postures with room around the board, if there are as many as are wanted; else these first."""
    return found[roomy] if roomy.sum() >= wanted else found[np.argsort(~roomy, kind="stable")]


def _camera_slopes(description: Dataset, seen: CameraBoard, q: Array, effects: Sequence[str]) -> Array:
    """As `_slopes`, of a camera."""
    poses = Poses(tuple(map(str, range(len(q)))), time_s=np.arange(len(q), dtype=np.float64), q=q)
    dataset = replace(description, poses=poses, points=seen.points(q), time_is_order=True)
    model = Model(dataset, candidate_effects(effects, dataset))
    free = ~np.isin(model.parameters.names, model.sensor.held)
    slopes = (jacobian_matrix(model, model.parameters.nominal) * model.parameters.width / ERROR_PX)[:, free]
    return slopes.reshape(len(q), -1, int(free.sum()))


def _seen(description: Dataset, needed: Sequence[str]) -> tuple[Robot, Board, tuple[int, int]]:
    """The robot, the board and the images' size, if all is stated that is needed to look at it."""
    robot, board, size = description.robot, description.board, description.image_px
    if robot is None or size is None:
        raise _cannot_plan("the cell has no [robot], or no camera")
    if board is None:
        raise _cannot_plan("dataset.toml has no [board], so there is no target to look at")
    placement = [*needed, *(f"target.{part}" for part in SIX)]
    missing = [name for name in placement if name not in description.parameters]
    if missing:
        raise DataError(
            f"dataset.toml, [parameters] lacks {', '.join(missing)}: poses that see the target can only be planned"
            " where it is known to lie, to a few centimetres. State it with [target] placed = false, or give your own"
            " poses with --poses.",
            file="dataset.toml",
        )
    return robot, board, size


def _target_view(description: Dataset) -> _TargetView:
    robot, board, _ = _seen(description, ())
    values = {name: np.array([item.nominal]) for name, item in description.parameters.items()}
    return _TargetView(robot, view_of(description, values), board, motion(values, "target")[0])


def _cannot_plan(lacking: str) -> DataError:
    return DataError(f"Poses cannot be planned: {lacking}. Or give your own poses with --poses.", file="dataset.toml")


def _slopes(description: Dataset, target_view: _TargetView, q: Array, effects: Sequence[str]) -> Array:
    """What each posture would say of every parameter, (k, r, d): see `most_telling`."""
    n = len(q)
    T = inverse(target_view.T_base_target) @ target_view.robot.forward(q[None])[0] @ target_view.view.T_flange_camera
    lit = target_view.view.illuminated(T, 0.0, np.linspace(*target_view.view.stripe_range(), ALONG)[None])
    names = tuple(str(i) for i in range(ALONG)) * n
    points = Points(
        np.repeat(np.arange(n), ALONG),
        names,
        pixel=target_view.view.pixels(lit).reshape(-1, 2),
        xyz=apply(T[:, None], lit).reshape(-1, 3),
    )
    poses = Poses(tuple(map(str, range(n))), time_s=np.arange(n, dtype=np.float64), q=q)
    dataset = replace(description, poses=poses, points=points, time_is_order=True)
    model = Model(dataset, candidate_effects(effects, dataset))
    x = np.array([item.nominal for item in model.parameters.items])
    free = ~np.isin(model.parameters.names, model.sensor.held)
    slopes = (jacobian_matrix(model, x) * model.parameters.width / ERROR_M)[:, free]
    return slopes.reshape(n, 3 * ALONG, -1)


def _short_way(q: Array) -> Ints:
    """An order in which each is near the one before, (n, j) -> (n,)."""
    left, order = list(range(1, len(q))), [0]
    while left:
        away = np.abs(q[left] - q[order[-1]]).max(axis=1)
        order.append(left.pop(int(away.argmin())))
    return np.array(order, dtype=np.int64)
