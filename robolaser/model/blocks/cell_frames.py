"""The cameras and frames of all blocks in the cell and on the flange, for other programs."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.model.blocks.block import Block
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.sensors.in_cell import InCell
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

OfSensor = Sequence[tuple[Block, InCell]]  # the blocks of a sensor, one a session
Frames = dict[str, tuple[bool, Array]]  # by name, whether the flange carries it, and T_flange_frame or T_base_frame


def in_cell(blocks: Blocks, values: Values, perturb: Perturbation) -> InCell:
    """The sensors in the cell, for one candidate.

    Where sensors or sessions have different frames of one name, a later one's name begins with the sensor's or ends in
    the session's. The frames of the first session are published; the camera is the first one. The mount is of the first
    sensor on the flange, at each pose as in its session.
    """
    each = [
        [(block, block.sensor.in_cell(block.values(values), block.perturbed(perturb))) for block in of_sensor]
        for of_sensor in blocks.by_sensor
    ]
    cameras = (part.camera for of_sensor in each for _, part in of_sensor)
    frames: Frames = {}
    published: list[str] = []
    for of_sensor in each:
        own: Frames = {}
        for block, part in of_sensor:
            placed = {name: (True, T) for name, T in part.flange.items()}
            _add(own, placed | {name: (False, T) for name, T in part.base.items()}, "{}_" + block.session)
        called = _add(frames, own, of_sensor[0][0].name + "_{}")
        published += [called[name] for name in of_sensor[0][1].published]
    return InCell(
        flange={name: T for name, (rides, T) in frames.items() if rides},
        base={name: T for name, (rides, T) in frames.items() if not rides},
        published=published,
        mount=_mount(blocks, next((one for one in each if one[0][1].mount is not None), each[0])),
        camera=next((camera for camera in cameras if camera is not None), None),
    )


def _add(frames: Frames, more: Frames, other_name: str) -> dict[str, str]:
    """Add frames, those whose name is another frame's under their other name; returns the names that they have."""
    names = {}
    for name, (rides, T) in more.items():
        known_rides, known = frames.setdefault(name, (rides, T))
        names[name] = name if rides == known_rides and np.array_equal(known, T) else other_name.format(name)
        frames[names[name]] = rides, T
    return names


def _mount(blocks: Blocks, of_sensor: OfSensor) -> Array | None:
    mounts = [(block, part.mount) for block, part in of_sensor if part.mount is not None]
    if not mounts or all(np.array_equal(mounts[0][1], other) for _, other in mounts[1:]):
        return mounts[0][1] if mounts else None
    of_pose, sessions = blocks.dataset.session_of_pose, blocks.dataset.sessions
    assert sessions is not None  # else there is one mount
    T = np.broadcast_to(mounts[0][1], (len(mounts[0][1]), len(of_pose), 4, 4)).copy()
    for block, own in mounts:
        here = of_pose == sessions.names.index(block.session)
        T[:, here] = np.broadcast_to(own, T.shape)[:, here]
    return T
