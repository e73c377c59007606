"""A small cell, built once."""

import numpy as np
import pytest

from robolaser.robot.by_name import find_robot
from robolaser.trials.building import Ranges, World, build

SMALL = Ranges(poses=(12, 14), points=(6, 6))


@pytest.fixture(scope="session")
def built() -> World:
    return build(find_robot("scorbot_er7"), SMALL, np.random.default_rng(4), moving=True)
