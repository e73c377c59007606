"""Whatever an arm answers, its driver gives a value or a sentence; whatever a controller hears, it goes on."""

import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import bench
import numpy as np
import pytest
from fake_ur import UrRig
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robolaser.data.cell_config import Cell
from robolaser.emulator.emulated_cell import controller_of
from robolaser.errors import RobolaserError

ONE_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
"""Nothing is written to it."""
ON_A_LINE = ["acl", "lss", "dynamixel", "feetech"]
PIECES = st.binary(max_size=12) | st.sampled_from(
    [
        b"",
        b">",
        b"\r\n>",
        b"***",
        b"*** IMPACT PROTECTION AXIS 9\r\n",
        b"1:99999999999999999999 ",
        b"9" * 5000,
        b"\xff\xff\xfd\0",
    ]
)
"""What comes in place of a byte."""
UNDISTURBED = {"acl": (b"\x01\rSHOW PAR 33\r", b"PAR 33="), "lss": (b"\r#1QD\r", b"*1QD")}
"""What is answered after any noise; a binary packet may be taken for the rest of another one."""


class Damaged(bench.Bench):
    """A wire on which some bytes are lost, and others come that nobody sent."""

    def __init__(self, cell: Cell, instead: Mapping[int, bytes]) -> None:
        super().__init__(controller_of(cell), bench.Jumping(), baud=cell.arm.baud)
        self._instead, self._count = instead, 0

    def read(self, size: int) -> bytes:
        data = super().read(size)
        heard = b"".join(self._instead.get(self._count + i, data[i : i + 1]) for i in range(len(data)))
        self._count += len(data)
        return heard


def driven(cell: Cell, rig: Any) -> None:
    """All that is asked of an arm."""
    with suppress(RobolaserError):
        arm = bench.arm_on(rig, cell)
        q = arm.read()
        assert np.isfinite(q).all()
        assert len(q) == len(cell.robot.joints)
        arm.start_move(q + 0.05, 2.0)
        rig.clock.wait(1.0)
        arm.poll_faults()
        arm.read()
        arm.stop()
        arm.home()
        arm.close()


@pytest.mark.parametrize("kind", ON_A_LINE)
@ONE_FOLDER
@given(instead=st.dictionaries(st.integers(0, 120) | st.integers(0, 1500), PIECES, max_size=6))
def test_any_answers_are_understood_or_named(tmp_path_factory: Any, kind: str, instead: Mapping[int, bytes]) -> None:
    cell = cell_of(tmp_path_factory, kind)
    driven(cell, Damaged(cell, instead))


@pytest.mark.parametrize("kind", ON_A_LINE)
@ONE_FOLDER
@given(
    heard=st.lists(
        max_size=20,
        elements=st.binary(max_size=40)
        | st.sampled_from(
            [b"\r", b"#1D", b"\xff\xff\xfd\0\xfe", b"SPEED ", b"HERE P", b"MOVE P", b"SETPV ", b"SET OUT[", b"9" * 5000]
        ),
    )
)
def test_an_emulated_controller_hears_anything(tmp_path_factory: Any, kind: str, heard: list[bytes]) -> None:
    controller = controller_of(cell_of(tmp_path_factory, kind))
    for second, data in enumerate(heard):
        controller.receive(data, float(second))
        assert np.isfinite(controller.motor(float(second))).all()
    question, answer = UNDISTURBED.get(kind, (b"", b""))
    assert answer in controller.receive(question, 1000.0)


ANGLES = st.floats(-7, 7) | st.sampled_from([math.nan, math.inf])


@ONE_FOLDER
@given(
    q=st.lists(ANGLES, max_size=7) | st.lists(ANGLES, min_size=5, max_size=5), modes=st.lists(st.integers(), max_size=7)
)
def test_any_readings_of_a_library_are_taken_or_named(tmp_path_factory: Any, q: list[float], modes: list[int]) -> None:
    cell = cell_of(tmp_path_factory, "ur")
    rig: Any = UrRig(cell, bench.Jumping())
    rig.getActualQ = lambda: [rig.clock.wait(0.002), q][1]
    rig.isProtectiveStopped = lambda: True
    rig.getJointMode = lambda: modes
    driven(cell, rig)


KNOWN: dict[str, Cell] = {}


def cell_of(tmp_path_factory: Any, kind: str) -> Cell:
    if kind not in KNOWN:
        KNOWN[kind] = bench.cell(Path(tmp_path_factory.mktemp("cell")), kind)
    return KNOWN[kind]
