"""Fixtures and order of all tests."""

import gc
import os
import signal
from collections.abc import Iterator

import pytest
from hypothesis import settings
from threadpoolctl import threadpool_limits

from robolaser.arrays import Array, Bools
from robolaser.robot import inverse_kinematics
from robolaser.robot.kinematics import Robot
from robolaser.simulation.sensors import camera

settings.register_profile("fast", max_examples=10, derandomize=True, deadline=None, database=None)
settings.register_profile("long", max_examples=20_000, deadline=None, database=None, print_blob=True)
settings.load_profile(os.environ.get("GENERATED", "fast"))


LONGEST = (
    "test_journeys.py", "test_blind_worlds.py", "test_tutorials.py", "test_blind_motion.py",
    "test_unsound_instruments.py", "test_misread.py", "test_local_unknown.py", "test_held_parameters.py",
    "test_repeatability.py", "test_delivered_files.py", "test_what_cannot_be_tested.py", "test_simulation.py",
    "test_scanner_with_corners.py", "test_false_all_clear.py", "test_compare_command.py",
    "test_what_yields_or_follows.py", "test_every_motion_effect.py", "test_evidence.py", "test_odd_torques.py",
    "test_results.py", "test_runs_repeat.py", "test_blind_run.py", "test_hobby_page.py", "test_every_operator.py",
    "test_images_to_points.py", "test_every_sensor.py", "test_new_cell.py", "test_publishing.py", "test_calibrate.py",
    "test_batches.py", "test_soak.py", "test_cli.py", "test_watched_cell.py", "test_recordings_extracted.py",
    "test_cameras_diagnosed.py", "test_thinning.py", "test_per_session.py", "test_one_model.py",
    "test_expensive_problems.py", "test_reference.py", "test_held_and_lost.py",
)  # fmt: skip
"""The slowest files: they start first, so that no processor waits for them at the end."""


def pytest_configure(config: pytest.Config) -> None:
    """Keep the order of files: xdist would start with those that have the most tests, not with the slowest."""
    config.option.loadscopereorder = False


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Start with the slowest files; tests of a file keep their order."""
    items.sort(key=lambda item: LONGEST.index(item.path.name) if item.path.name in LONGEST else len(LONGEST))


def pytest_collection_finish() -> None:
    """Spare what all tests imported from each garbage collection: a full one would look through a million objects."""
    gc.freeze()


@pytest.fixture(autouse=True, scope="session")
def one_thread() -> Iterator[None]:
    """Use one thread for linear algebra: small matrices are slower on two, and far slower on a busy machine."""
    with threadpool_limits(limits=1, user_api="blas"):
        yield


@pytest.fixture(autouse=True, scope="session")
def no_power_cut() -> Iterator[None]:
    """Skip fsync, which takes milliseconds for each row of each recording."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.fsync", lambda descriptor: None)
        yield


@pytest.fixture(autouse=True, scope="session")
def postures_are_sought_once() -> Iterator[None]:
    """Cache the positions of simulated sensors: they follow from arm and seed, and take longer than all else."""
    sought, found = inverse_kinematics.touching, dict[tuple[object, ...], tuple[Array, Bools]]()

    def touching(
        robot: Robot, tool: Array, goal: Array, q: Array, *, still: Bools | None = None
    ) -> tuple[Array, Bools]:
        arm = robot.urdf, robot.flange, robot.joints, robot.placements.tobytes()
        key = *arm, *(part.tobytes() for part in (tool, goal, q)), repr(still)
        if key not in found:
            found[key] = sought(robot, tool, goal, q, still=still)
        return found[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(camera, "touching", touching)
        patch.setattr(inverse_kinematics, "touching", touching)
        yield


@pytest.fixture(autouse=True, scope="session")
def wide() -> Iterator[None]:
    """Keep output as wide as in a file: `readline`, which pytest loads, exports the terminal's width to workers."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("COLUMNS", raising=False)
        yield


@pytest.fixture(autouse=True, scope="session")
def interruptible() -> None:
    """Let programs of tests obey Ctrl-C, which they would ignore if a script runs the tests in the background."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
