"""What stands in the cell and sits on the flange, as all blocks have it: cameras and frames for other programs."""

from collections.abc import Callable, Mapping

import numpy as np

from robolaser.arrays import Array
from robolaser.model.blocks.block import Block
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.sensors.in_cell import CameraView, InCell
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

Frames = dict[str, Array]


def camera_of(blocks: Blocks, values: Values, perturb: Perturbation) -> CameraView | None:
    """The first camera as programs that know pinholes see it, one candidate; None where there is none."""
    cameras = (_of_block(block, values, perturb).camera for block in blocks)
    return next((camera for camera in cameras if camera is not None), None)


def flange_frames(blocks: Blocks, values: Values, perturb: Perturbation) -> Frames:
    """T_flange_frame of what sits on the flange, by name, one candidate.

    Where sensors or sessions have different frames of one name, a later one's name begins with the sensor's or ends in
    the session's.
    """
    return _frames(blocks, lambda block: _of_block(block, values, perturb).flange)


def base_frames(blocks: Blocks, values: Values, perturb: Perturbation) -> Frames:
    """T_base_frame of what stands in the cell and belongs into a URDF, named alike, one candidate."""
    return _frames(blocks, lambda block: _of_block(block, values, perturb).base)


def _of_block(block: Block, values: Values, perturb: Perturbation) -> InCell:
    return block.sensor.in_cell(block.values(values), block.perturbed(perturb))


def _frames(blocks: Blocks, of: Callable[[Block], Mapping[str, Array]]) -> Frames:
    frames: Frames = {}
    for of_sensor in blocks.by_sensor:
        own: Frames = {}
        for block in of_sensor:
            _add(own, of(block), "{}_" + block.session)
        _add(frames, own, of_sensor[0].name + "_{}")
    return frames


def _add(frames: Frames, more: Mapping[str, Array], other_name: str) -> None:
    for name, T in more.items():
        if not np.array_equal(frames.setdefault(name, T), T):
            frames[other_name.format(name)] = T


def published_frames(blocks: Blocks, values: Values, perturb: Perturbation) -> tuple[str, ...]:
    """Frames of flange and base, by name, that ROS is told of by commands of their own; as in the first session."""
    return tuple(name for of_sensor in blocks.by_sensor for name in _of_block(of_sensor[0], values, perturb).published)


def mount_of(blocks: Blocks, values: Values, perturb: Perturbation) -> Array | None:
    """T_flange_camera of the first sensor that the flange carries, (c, n or 1, 4, 4), at each pose as in its session.

    None where there is none.
    """
    each = blocks.by_sensor
    of_sensor = next((one for one in each if Stage.MOUNT in one[0].sensor.stages), each[0])
    found = [(one, _of_block(one, values, perturb).mount) for one in of_sensor]
    mounts = [(one, mount) for one, mount in found if mount is not None]
    if not mounts or all(np.array_equal(mounts[0][1], other) for _, other in mounts[1:]):
        return mounts[0][1] if mounts else None
    of_pose, sessions = blocks.dataset.session_of_pose, blocks.dataset.sessions
    assert sessions is not None  # else there is one mount
    T = np.broadcast_to(mounts[0][1], (len(mounts[0][1]), len(of_pose), 4, 4)).copy()
    for one, own in mounts:
        here = of_pose == sessions.names.index(one.session)
        T[:, here] = np.broadcast_to(own, T.shape)[:, here]
    return T
