"""The emulated smart servos answer what they are asked, and nothing else."""

from pathlib import Path

import numpy as np
import pytest
from emulated_cell import cell_folder

from robolaser.data.cell_config import load_cell
from robolaser.emulator.controller import FASTEST_RAD_S, ArmFault
from robolaser.emulator.emulated_cell import controller_of
from robolaser.emulator.lss import LssController

REFERENCE = np.array([0, 0, 0.2, 0, 0])
DIRECTION = np.array([1, 1, -1, 1, 1])


@pytest.fixture
def servos(tmp_path: Path) -> LssController:
    return controller_of(load_cell(cell_folder(tmp_path, "lss")))


def angles(servos: LssController, now_s: float) -> np.ndarray:
    """As the sheet says that a client works them out."""
    shown = [int(servos.receive(f"#{i}QD\r".encode(), now_s)[4:]) for i in range(1, 6)]
    return REFERENCE + DIRECTION * np.deg2rad(np.array(shown) / 10)


def test_the_answer_has_the_form_of_the_question(servos: LssController) -> None:
    servos.receive(b"#1D-450T2000\r", 0.0)
    assert servos.receive(b"#1QD\r", 5.0) == b"*1QD-450\r"
    assert servos.receive(b"#1Q\r", 5.0) == b"*1Q6\r"


@pytest.mark.parametrize("line", [b"#9QD\r", b"#254QD\r", b"#1XYZ\r", b"QD\r", b"##\r", b"\r", b"#1D100\r", b"#1H\r"])
def test_nothing_else_comes_back(servos: LssController, line: bytes) -> None:
    assert servos.receive(line, 0.0) == b""
    assert servos.poll(10.0) == b""


def test_what_is_shown_are_the_angles_that_the_encoders_see(servos: LssController) -> None:
    for i, goal in enumerate((300, -200, 450, -100, 900), 1):
        servos.receive(f"#{i}D{goal}T4000\r".encode(), 0.0)
    for now_s in np.linspace(0, 5, 11):
        assert np.allclose(angles(servos, now_s), servos.motor(now_s), atol=np.deg2rad(0.051))


def test_a_travel_takes_the_time_asked_for(servos: LssController) -> None:
    servos.receive(b"#1D300T4000\r", 1.0)
    assert servos.motor(3.0)[0] == pytest.approx(np.deg2rad(15))
    assert servos.motor(4.5)[0] < np.deg2rad(30)
    assert servos.motor(5.0)[0] == pytest.approx(np.deg2rad(30))


def test_no_servo_turns_faster_than_it_can(servos: LssController) -> None:
    servos.receive(b"#1D900T1\r", 0.0)
    at = [servos.motor(t)[0] for t in np.arange(0, 4, 0.01)]
    assert np.abs(np.diff(at)).max() / 0.01 <= FASTEST_RAD_S * 1.001


def test_no_servo_turns_faster_than_it_was_told_to_and_says_so(servos: LssController) -> None:
    assert servos.receive(b"#1SD100\r", 0.0) == b""
    assert servos.receive(b"#1QSD\r", 0.0) == b"*1QSD100\r"
    servos.receive(b"#1D300T1\r#2D300T1\r", 0.0)
    at = np.array([servos.motor(t)[:2] for t in np.arange(0, 5, 0.01)])
    fastest = np.abs(np.diff(at, axis=0)).max(axis=0) / 0.01
    assert fastest[0] <= np.deg2rad(10.0) * 1.001 < fastest[1]
    servos.inject(ArmFault.REBOOT, 1, 9.0)
    assert servos.receive(b"#1QSD\r", 12.0) != b"*1QSD100\r"


def test_a_servo_says_whether_it_travels_or_holds(servos: LssController) -> None:
    servos.receive(b"#1D300T4000\r", 0.0)
    assert [servos.receive(b"#1Q\r", t) for t in (2.0, 4.5)] == [b"*1Q4\r", b"*1Q6\r"]


def test_all_halt_at_once(servos: LssController) -> None:
    for i in range(1, 6):
        servos.receive(f"#{i}D300T4000\r".encode(), 0.0)
    servos.receive(b"#254H\r", 2.0)
    stopped = servos.motor(2.0)
    assert np.array_equal(servos.motor(60.0), stopped)
    assert servos.receive(b"#3Q\r", 60.0) == b"*3Q6\r"


def test_beyond_its_limits_a_servo_stops_and_says_so(servos: LssController) -> None:
    servos.receive(b"#1D1700T1000\r", 0.0)
    assert servos.motor(60.0)[0] == pytest.approx(np.deg2rad(125))
    assert servos.receive(b"#1Q\r", 60.0) == b"*1Q7\r"


@pytest.mark.parametrize(("fault", "status"), [(ArmFault.STALL, 8), (ArmFault.IMPACT, 9), (ArmFault.THERMIC, 10)])
def test_a_servo_in_trouble_stands_and_says_which(servos: LssController, fault: ArmFault, status: int) -> None:
    servos.receive(b"#2D300T4000\r", 0.0)
    servos.inject(fault, 2, 2.0)
    stopped = servos.motor(2.0)[1]
    assert servos.motor(60.0)[1] == stopped
    assert servos.receive(b"#2Q\r", 60.0) == f"*2Q{status}\r".encode()


def test_after_the_power_came_back_servos_are_silent_then_limp_and_know_their_angles(servos: LssController) -> None:
    servos.receive(b"#2D300T1000\r", 0.0)
    before = servos.motor(9.0)
    servos.inject(ArmFault.REBOOT, 1, 9.0)
    assert servos.receive(b"#2QD\r", 9.5) == b""
    assert servos.receive(b"#2Q\r", 12.0) == b"*2Q1\r"
    assert np.allclose(angles(servos, 12.0), before, atol=np.deg2rad(0.051))
