"""The emulated SCORBOT speaks ACL as its reference guide has it, and moves as a machine does."""

import re
from pathlib import Path

import numpy as np
import pytest
from emulated_cell import cell_folder

from robolaser.data.cell_config import load_cell
from robolaser.emulator.acl import AclController
from robolaser.emulator.controller import FASTEST_RAD_S, RAMP, ArmFault, way_gone
from robolaser.emulator.emulated_cell import controller_of

REFERENCE = np.array([0, 0, 0, -np.pi / 2, 0])
DIRECTION = np.array([1, -1, 1, 1, -1])


class Terminal:
    """Someone at the keyboard, with a clock of their own."""

    def __init__(self, acl: AclController) -> None:
        self.acl = acl
        self.now_s = 0.0

    def type(self, line: str) -> str:
        """What the screen shows of a line and its answer."""
        return self.acl.receive(line.encode() + b"\r", self.now_s).decode()

    def answer(self, line: str) -> list[str]:
        """The lines between echo and prompt."""
        echo, prompt = line + "\r", ">"
        shown = self.type(line)
        assert shown.startswith(echo)
        assert shown.endswith(prompt)
        return shown.removeprefix(echo).removesuffix(prompt).split()

    def wait(self, seconds: float) -> str:
        """What appears meanwhile."""
        self.now_s += seconds
        return self.acl.poll(self.now_s).decode()

    def par(self, number: int) -> int:
        return int(re.search(rf"PAR {number}=(-?\d+)", self.type(f"SHOW PAR {number}"))[1])

    def counts(self, position: str = "POSITION") -> np.ndarray:
        return np.array([int(count) for _, count in re.findall(r"(\d)\s*:\s*(-?\d+)", self.type(f"LISTPV {position}"))])

    def angles(self) -> np.ndarray:
        """As the sheet says that a client works them out."""
        quarter, at_reference = (np.array([self.par(first + i) for i in range(5)]) for first in (33, 52))
        return REFERENCE + DIRECTION * (self.counts() - at_reference) * (np.pi / 2) / quarter

    def go(self, counts: np.ndarray, time: str = "") -> str:
        for axis, count in enumerate(counts, 1):
            assert "O.K." in self.type(f"SETPV P {axis} {count}")
        return self.type(f"MOVE P {time}")


@pytest.fixture
def terminal(tmp_path: Path) -> Terminal:
    return Terminal(controller_of(load_cell(cell_folder(tmp_path))))


@pytest.fixture
def ready(terminal: Terminal) -> Terminal:
    terminal.type("DEFP P")
    terminal.type("HERE P")
    return terminal


def test_every_key_comes_back_if_echo_is_on(terminal):
    assert terminal.acl.receive(b"LI", 0.0) == b"LI"
    assert terminal.type("STPV POSITION").startswith("STPV POSITION\r\r\n1:")
    terminal.acl._echo = False
    assert terminal.type("CON") == "\r\nO.K.\r\n>"
    terminal.type("ECHO")
    assert terminal.type("con") == "con\r\r\nO.K.\r\n>"


def test_an_empty_line_gives_a_prompt(terminal):
    assert terminal.type("") == "\r\r\n>"


@pytest.mark.parametrize(
    ("line", "error"),
    [
        ("FLY AWAY", "UNRECOGNIZED REQUEST"),
        ("MOVED P", "UNRECOGNIZED REQUEST"),  # for programs only
        ("MOVE P", "303"),
        ("LISTPV P", "303"),
        ("SETPV P 1 5", "303"),
        ("MOVE Q", "UNDEFINED"),
        ("SET OUT[99]=1", "BAD OUTPUT"),
    ],
)
def test_what_cannot_be_done_is_refused_with_stars(terminal, line, error):
    terminal.type("DEFP P")
    shown = terminal.type(line)
    assert "\r\n*** " in shown
    assert error in shown
    assert shown.endswith("\r\n>")


@pytest.mark.parametrize(("line", "error"), [("SETPV P 6 0", "310"), ("SETPV P 1 x", "312")])
def test_numbers_that_mean_no_place_are_refused(ready, line, error):
    before = ready.counts("P")
    assert f"*** ERROR {error}" in ready.type(line)
    assert np.array_equal(ready.counts("P"), before)


def test_counts_and_parameters_give_the_angles_that_the_encoders_see(ready):
    ready.go(np.array([1000, -2000, 1500, 800, -700]))
    for _ in range(6):
        assert np.allclose(ready.angles(), ready.acl.motor(ready.now_s), atol=0.51 * (np.pi / 2) / 19200)
        ready.wait(0.7)


def test_some_reference_counts_are_not_zero_and_some_encoders_turn_the_other_way(terminal):
    assert any(terminal.par(52 + i) for i in range(5))
    assert {np.sign(terminal.par(33 + i)) for i in range(5)} == {-1, 1}


def test_move_gives_its_prompt_at_once_and_arrives_later(ready):
    goal = np.array([2000, 1000, -500, 0, 300])
    assert ready.go(goal, "400").endswith("O.K.\r\n>")
    assert np.array_equal(ready.counts(), np.zeros(5))
    ready.wait(2.0)
    assert np.allclose(ready.counts(), goal / 2, atol=1)
    ready.wait(1.8)
    assert not np.array_equal(ready.counts(), goal)
    ready.wait(0.21)
    assert np.array_equal(ready.counts(), goal)


def test_movements_queue_up(ready):
    ready.go(np.array([1000, 0, 0, 0, 0]), "200")
    ready.go(np.array([0, 1000, 0, 0, 0]), "200")
    ready.wait(2.0)
    assert np.array_equal(ready.counts(), [1000, 0, 0, 0, 0])
    ready.wait(2.0)
    assert np.array_equal(ready.counts(), [0, 1000, 0, 0, 0])


def test_no_axis_turns_faster_than_it_can_whatever_time_is_asked_for(ready):
    ready.go(np.array([20000, 0, 0, 0, 0]), "1")
    at = []
    for _ in range(300):
        ready.wait(0.01)
        at.append(ready.acl.motor(ready.now_s)[0])
    assert np.abs(np.diff(at)).max() / 0.01 <= FASTEST_RAD_S * 1.001
    assert ready.counts()[0] == 20000


def test_ctrl_a_stops_the_arm_and_empties_the_queue(ready):
    ready.go(np.array([3000, 0, 0, 0, 0]), "300")
    ready.go(np.array([0, 3000, 0, 0, 0]), "300")
    ready.wait(1.0)
    ready.acl.receive(b"\x01", ready.now_s)
    stopped = ready.counts()
    assert 0 < stopped[0] < 3000
    ready.wait(60.0)
    assert np.array_equal(ready.counts(), stopped)


def test_beyond_its_limits_an_axis_does_not_go(ready):
    ready.go(np.array([40000, 0, 0, 0, 0]))
    assert "*** OUT OF RANGE axis 1" in ready.wait(0.1)
    ready.wait(60.0)
    assert ready.counts()[0] == 0
    assert "304" in ready.go(np.zeros(5, int))
    ready.type("CON")
    assert "O.K." in ready.go(np.zeros(5, int))


@pytest.mark.parametrize(
    ("fault", "line"), [(ArmFault.IMPACT, "IMPACT PROTECTION"), (ArmFault.THERMIC, "THERMIC OVERLOAD")]
)
def test_an_axis_that_gives_up_says_so_stops_the_arm_and_is_disabled(ready, fault, line):
    ready.go(np.array([3000, 3000, 0, 0, 0]), "400")
    ready.wait(2.0)
    ready.acl.inject(fault, 2, ready.now_s)
    assert ready.wait(0.0) == f"\r\n*** {line} axis 2\r\n"
    stopped = ready.counts()
    ready.wait(60.0)
    assert np.array_equal(ready.counts(), stopped)
    assert "*** ERROR 304" in ready.type("MOVE P")
    ready.type("CON")
    assert "O.K." in ready.type("MOVE P")
    ready.wait(60.0)
    assert np.array_equal(ready.counts(), [3000, 3000, 0, 0, 0])


def test_a_stalled_axis_stands_while_the_others_go_on(ready):
    ready.go(np.array([3000, 3000, 0, 0, 0]), "400")
    ready.wait(2.0)
    ready.acl.inject(ArmFault.STALL, 2, ready.now_s)
    assert ready.wait(60.0) == ""
    assert np.allclose(ready.counts(), [3000, 1500, 0, 0, 0], atol=1)


def test_homing_takes_minutes_and_ends_with_counts_at_zero(ready):
    ready.go(np.array([3000, -3000, 2000, 1000, 500]))
    ready.wait(60.0)
    assert ready.type("HOME").endswith("\r\n>")
    assert "HOMING IN PROGRESS" in ready.type("MOVE P")
    waited = 0.0
    while not (said := ready.wait(1.0)):
        waited += 1.0
    assert said == "\r\nHOMING COMPLETE (ROBOT)\r\n"
    assert 60 <= waited <= 180
    assert np.array_equal(ready.counts(), np.zeros(5))


def test_an_axis_that_does_not_find_its_home_is_named(ready):
    ready.acl.inject(ArmFault.HOMELESS, 3, 0.0)
    ready.type("HOME")
    assert ready.wait(200.0) == "\r\n*** HOME FAILURE AXIS 3\r\n"


def test_ctrl_a_ends_homing(ready):
    ready.type("HOME")
    ready.wait(10.0)
    ready.acl.receive(b"\x01", ready.now_s)
    stopped = ready.counts()
    assert ready.wait(200.0) == ""
    assert np.array_equal(ready.counts(), stopped)


def test_the_power_comes_back_without_positions_home_and_outputs(ready):
    ready.type("SET OUT[1]=1")
    ready.go(np.array([3000, 0, 0, 0, 0]))
    ready.wait(60.0)
    before = ready.acl.motor(ready.now_s)
    ready.acl.inject(ArmFault.REBOOT, 1, ready.now_s)
    assert ready.wait(0.0).endswith("SYSTEM READY !\r\n>")
    assert np.array_equal(ready.acl.motor(ready.now_s), before)
    assert np.array_equal(ready.counts(), np.zeros(5))
    assert "UNDEFINED" in ready.type("MOVE P")
    assert ready.acl.outputs(ready.now_s) == frozenset()
    ready.type("HOME")
    ready.wait(200.0)
    assert np.allclose(ready.angles(), ready.acl.motor(ready.now_s), atol=1e-4)


def test_outputs_switch(terminal):
    assert terminal.answer("SET OUT[1]=1") == ["O.K."]
    terminal.type("set out[3] = 1")
    assert terminal.acl.outputs(0.0) == {1, 3}
    terminal.type("SET OUT[1]=0")
    assert terminal.acl.outputs(0.0) == {3}


def test_the_power_comes_on_as_on_a_real_controller(terminal):
    """A SCORBOT-ER V: github.com/talos-rit/commander, digital_twin/Bingo_ER-V_Bringup_Runbook.md."""
    terminal.acl.inject(ArmFault.REBOOT, 1, 0.0)
    said = "----RAM TEST COMPLETE.\r\n\r\n----ROM TEST COMPLETE.\r\n\r\nUSER RAM CHECKPOINT ERROR !\r\n"
    assert terminal.wait(0.0) == f"\r\n{said}INSTALLING DEFAULT SETUP.\r\nSYSTEM READY !\r\n>"


def test_a_position_is_listed_in_columns(ready):
    for axis, count in enumerate((2441, 2153, -10311, -14394, 189), 1):
        ready.type(f"SETPV P {axis} {count}")
    counts, place, prompt = ready.type("LISTPV P").splitlines()[-3:]
    assert counts == "1: 2441    2: 2153    3:-10311   4:-14394   5: 189"
    assert re.fullmatch(r"X:[ -]\d+ +Y:[ -]\d+ +Z:[ -]\d+ +P:[ -]\d+ +R:[ -]\d+", place)
    assert prompt == ">"


def test_a_decoupled_arm_counts_links_in_the_world(tmp_path):
    acl = controller_of(load_cell(cell_folder(tmp_path, "er5plus")))
    acl.receive(b"DEFP P\rHERE P\rSETPV P 2 2000\rMOVE P\r", 0.0)
    turned = acl.motor(60.0) - acl.motor(0.0)
    assert turned[1] != 0.0
    np.testing.assert_allclose(turned[[0, 2, 3, 4]], [0.0, -turned[1], 0.0, 0.0], atol=1e-12)


def test_speed_rises_stays_and_falls():
    assert [way_gone(share) for share in (0.0, 0.5, 1.0)] == pytest.approx([0.0, 0.5, 1.0])
    shares = np.linspace(0, 1, 1001)
    speed = np.gradient([way_gone(share) for share in shares], shares)
    assert np.all(np.diff(speed[shares < RAMP]) > 0)
    assert np.allclose(speed[(shares > RAMP + 0.01) & (shares < 1 - RAMP - 0.01)], 1 / (1 - RAMP))
    assert np.all(np.diff(speed[shares > 1 - RAMP + 0.01]) < 0)
