"""Placements as the data set gives them, and where the data put them: a bracket may be mounted the other way round."""

from collections.abc import Mapping, Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import EstimationError
from robolaser.geometry.rigid_motion import inverse, log_so3
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import SIX, motion

FULL_TURN = 2.0 * np.pi
FAR = 0.1
"""Of the bounds' width: a closed form misses by less, so that what it puts farther beyond a bound is elsewhere."""


def start_of_data(model: Model) -> tuple[Sequence[Array], tuple[str, ...]]:
    """Where a fit may start beside the nominal values, and what to say where the data set's bounds exclude that.

    Args:
        model: Its sensor finds parameters in closed form, of which the data set may give some.

    Returns:
        The parameters (d,) within the bounds, where the data set gives others; and a sentence for each placement that
        lies beyond them.
    """
    items, derived = model.parameters.items, model.blocks.derived
    stated = {item.name: item for item in items if item.name in derived and item.given and not item.fixed}
    nominal = {item.name: np.array([item.nominal]) for item in items}
    if not stated:
        return [], ()
    try:
        closed = model.completed({name: value for name, value in nominal.items() if name not in derived})
    except EstimationError:
        return [], ()
    found = {name: float(closed[name][0] if name in closed else value[0]) for name, value in nominal.items()}
    for place in {name.rpartition(".")[0] for name in stated}:
        found |= _nearest_angles(found, {name: item.nominal for name, item in stated.items()}, place)
    beyond = {
        name.rpartition(".")[0]
        for name, item in stated.items()
        if "." in name and max(item.lower - found[name], found[name] - item.upper) > FAR * (item.upper - item.lower)
    }
    sentences = tuple(_sentence(place, nominal, found) for place in sorted(beyond))
    x = np.array([np.clip(found[item.name], item.lower, item.upper) for item in items])
    return [x], sentences


def _nearest_angles(found: Mapping[str, float], given: Mapping[str, float], frame: str) -> dict[str, float]:
    """The three angles of a rotation, of all that mean the same those nearest to the given ones."""
    names = [f"{frame}.{part}" for part in SIX[3:]]
    if any(name not in found or name not in given for name in names):
        return {}
    w, phi, psi = (found[name] for name in names)
    near = np.array([given[name] for name in names])
    same = np.array([[w, phi, psi], [w + np.pi, np.pi - phi, psi + np.pi]])
    same += FULL_TURN * np.round((near - same) / FULL_TURN)
    nearest = same[int(np.argmin(np.abs(same - near).sum(axis=1)))]
    return dict(zip(names, nearest.tolist(), strict=True))


def _sentence(place: str, nominal: Mapping[str, Array], found: Mapping[str, float]) -> str:
    there = {name: np.array([value]) for name, value in found.items()}
    parts = [f"{place}.{part}" for part in SIX if f"{place}.{part}" in found]
    if len(parts) == len(SIX):
        apart = inverse(motion(nominal, place)) @ motion(there, place)
        turn, shift = float(np.linalg.norm(log_so3(apart[0, :3, :3]))), float(np.linalg.norm(apart[0, :3, 3]))
        far = f"{np.degrees(turn):.0f}° and {1e3 * shift:.0f} mm"
    else:
        shift = float(np.linalg.norm([found[name] - nominal[name][0] for name in parts]))
        far = f"{1e3 * shift:.0f} mm"
    return (
        f"The data put {place} {far} from its nominal value, outside the bounds: it is not where [parameters] says."
        f" Delete {place}.* there, or correct it."
    )
