"""Postures to measure: the board and the stripe on it are visible, and together they are the most informative."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Poses
from robolaser.errors import PlanError
from robolaser.estimation.board_visibility import BoardObserver, board_observer
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model, jacobian_matrix

SPARE = 4  # candidates for each posture wanted,
LEAST_CANDIDATES, MOST_CANDIDATES = 60, 400  # within these bounds, but never fewer than are wanted
BATCH = 600  # postures tried at a time
BATCHES = 60  # for so many candidates as usual, and more in proportion
UNSURE_M = 0.03  # distance, in each direction, by which the board may be off its stated position
MOST_TRIED = 1800  # candidates, after which no more with so much room are sought
Allowed = Callable[[Array], Bools]  # postures (n, j) to whether they are allowed, (n,)
MOST_SWAPS = 200


def planned(
    description: Dataset,
    *,
    count: int,
    effects: Sequence[str] = (),
    allowed: Allowed | None = None,
    unsure_m: float = UNSURE_M,
    seed: int,
) -> Array:
    """The most informative postures for a calibration: D-optimal (Fedorov 1972) among those that see the board.

    Args:
        description: Robot, scanner, board, and the board's position to a few centimetres (`target.x` ...).
        count: How many.
        effects: `EFFECT[:WHERE]` each, to be distinguished from all else too.
        allowed: Postures that are allowed, besides the joints' limits; all when absent.
        unsure_m: By how much the board may be off its stated position [m].
        seed: Of the candidates.

    Returns:
        Joint values, (count, j) [rad or m], each next to the one before.

    Raises:
        DataError: The data set lacks a robot, a board, or the board's position.
        PlanError: Too few allowed postures see the board.
        UsageError, EffectError: The effects are not possible.
    """
    may = allowed or (lambda q: np.ones(len(q), dtype=np.bool_))
    view = board_observer(description)
    candidates = _candidates(view, count, may, unsure_m, np.random.default_rng(seed))
    chosen = candidates[most_telling(_slopes(description, view, candidates, effects), count)]
    return chosen[_short_way(chosen)]


def _candidates(view: BoardObserver, wanted: int, allowed: Allowed, unsure_m: float, rng: np.random.Generator) -> Array:
    """Postures from which the whole board is seen, (≥ wanted, j).

    If there are enough, only those that keep the board in the image anywhere within `unsure_m`.
    """
    enough = max(wanted, int(np.clip(SPARE * wanted, LEAST_CANDIDATES, MOST_CANDIDATES)))
    found, tried, seeing, roomy = np.empty((0, len(view.robot.joints))), 0, 0, np.empty(0, dtype=np.bool_)
    elsewhere = [view.with_board_moved(unsure_m * axis) for axis in np.concatenate([np.eye(3), -np.eye(3)])]
    for _ in range(BATCHES * max(1, round(enough / MOST_CANDIDATES))):
        q = view.tried(BATCH, rng)
        q = q[view.sees(q)]
        tried, seeing, q = tried + BATCH, seeing + len(q), q[allowed(q)]
        found, roomy = np.concatenate([found, q]), np.append(roomy, np.all([one.sees(q) for one in elsewhere], axis=0))
        if roomy.sum() >= enough or len(found) >= max(MOST_TRIED, enough):
            break
    if len(found) < wanted:
        raise PlanError(view.too_few(wanted, tried, seeing, len(found)))
    return (found[roomy] if roomy.sum() >= wanted else found[np.argsort(~roomy, kind="stable")])[:enough]


def _slopes(description: Dataset, view: BoardObserver, q: Array, effects: Sequence[str]) -> Array:
    """The information of each posture on every parameter, (k, r, d): see `most_telling`."""
    poses = Poses(tuple(map(str, range(len(q)))), time_s=np.arange(len(q), dtype=np.float64), q=q)
    dataset = replace(description, poses=poses, points=view.points(q), time_is_order=True)
    model = Model(dataset, candidate_effects(effects, dataset))
    free = ~np.isin(model.parameters.names, model.blocks.held)
    slopes = (jacobian_matrix(model, model.parameters.nominal) * model.parameters.width / view.error)[:, free]
    return slopes.reshape(len(q), -1, int(free.sum()))


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
    """Increase of the logarithm of the determinant by each block, (k,)."""
    whitened = slopes @ np.linalg.inv(np.linalg.cholesky(known)).T
    inner = np.eye(slopes.shape[1]) + whitened @ np.swapaxes(whitened, 1, 2)
    return np.asarray(np.linalg.slogdet(inner)[1])


def _short_way(q: Array) -> Ints:
    """An order in which each is near the one before, (n, j) -> (n,)."""
    left, order = list(range(1, len(q))), [0]
    while left:
        away = np.abs(q[left] - q[order[-1]]).max(axis=1)
        order.append(left.pop(int(away.argmin())))
    return np.array(order, dtype=np.int64)
