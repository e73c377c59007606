"""The cameras and frames of all blocks in the cell and on the flange, for other programs."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.model.blocks.block import Block
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.sensors.in_cell import InCell
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

OfSensor = Sequence[tuple[Block, InCell]]  # the blocks of a sensor, one a session


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
    return InCell(
        flange=_frames(each, lambda part: part.flange),
        base=_frames(each, lambda part: part.base),
        published=[name for of_sensor in each for name in of_sensor[0][1].published],
        mount=_mount(blocks, next((one for one in each if Stage.MOUNT in one[0][0].sensor.stages), each[0])),
        camera=next((camera for camera in cameras if camera is not None), None),
    )


def _frames(each: Sequence[OfSensor], of: Callable[[InCell], Mapping[str, Array]]) -> dict[str, Array]:
    frames: dict[str, Array] = {}
    for of_sensor in each:
        own: dict[str, Array] = {}
        for block, part in of_sensor:
            _add(own, of(part), "{}_" + block.session)
        _add(frames, own, of_sensor[0][0].name + "_{}")
    return frames


def _add(frames: dict[str, Array], more: Mapping[str, Array], other_name: str) -> None:
    for name, T in more.items():
        if not np.array_equal(frames.setdefault(name, T), T):
            frames[other_name.format(name)] = T


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
