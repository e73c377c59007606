"""An arm with the offsets and placements of joints that were found, as far as a URDF can say them."""

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import perturb_with
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.robot.kinematics import Robot


def corrected_robot(model: Model, x: Array) -> Robot | None:
    """The data set's arm as it is at x (d,); None without one, and the arm itself where no effect changes its URDF.

    Offsets move a joint's zero: its limits then count from the new one.
    """
    robot, values = model.dataset.robot, model.parameters.values(x[None])
    written = tuple(one.at(values) for one in model.effects if one.effect.in_urdf)
    if robot is None or not written:
        return robot
    perturb = perturb_with(written, model.run)
    offset = perturb(Stage.JOINTS, np.zeros((1, 1, len(robot.joints))))[0, 0]
    return robot.with_placements(perturb(Stage.LINKS, robot.placements[None, None])[0, 0], offset)
