"""What real controllers and the guide print, replayed on the emulated one; and what others' programs read of it."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from emulated_cell import cell_folder

from robolaser.data.cell_config import load_cell
from robolaser.emulator.acl import AclController
from robolaser.emulator.controller import ArmFault
from robolaser.emulator.emulated_cell import controller_of

ANSWERS = {
    # ACL reference guide for Controller-A, p. 3-104
    "SHOW PAR 261": "PAR 261=10\r\nO.K.\r\n>",
    # A SCORBOT-ER V: github.com/talos-rit/commander, digital_twin/Bingo_ER-V_Bringup_Runbook.md
    "VER": "--- ESHED ROBOTEC ---\r\nVERSION: 1.31\r\nDATE : 15/08/89\r\n>",
}
BOOT = (  # the same
    "----RAM TEST COMPLETE.\r\n\r\n----ROM TEST COMPLETE.\r\n\r\nUSER RAM CHECKPOINT ERROR !\r\n"
    "INSTALLING DEFAULT SETUP.\r\nSYSTEM READY !\r\n>"
)
LAB = (2441, 2153, -10311, -14394, 189)
LISTED = "1: 2441    2: 2153    3:-10311   4:-14394   5: 189"
"""As a student of a course "Robotics 22-23" noted it of a real SCORBOT in a published program, actions.py."""


@pytest.fixture
def acl(tmp_path: Path) -> AclController:
    made = controller_of(load_cell(cell_folder(tmp_path)))
    assert isinstance(made, AclController)
    for line in ("DEFP INIT", "HERE INIT", *(f"SETPV INIT {axis} {count}" for axis, count in enumerate(LAB, 1))):
        assert "O.K." in typed(made, line)
    return made


def typed(acl: AclController, line: str, now_s: float = 0.0) -> str:
    return acl.receive(line.encode() + b"\r", now_s).decode()


@pytest.mark.parametrize(("line", "answer"), ANSWERS.items())
def test_answers_are_those_of_the_guide_and_of_a_real_controller(acl: AclController, line: str, answer: str) -> None:
    assert typed(acl, line) == f"{line}\r\r\n{answer}"


def test_the_power_comes_on_as_on_a_real_controller(acl: AclController) -> None:
    acl.inject(ArmFault.REBOOT, 1, 0.0)
    assert acl.poll(0.0).decode() == f"\r\n{BOOT}"


def test_a_position_is_listed_as_in_a_laboratory(acl: AclController) -> None:
    counts, place, prompt = typed(acl, "LISTPV INIT").splitlines()[-3:]
    assert counts == LISTED
    assert re.fullmatch(r"X:[ -]\d+ +Y:[ -]\d+ +Z:[ -]\d+ +P:[ -]\d+ +R:[ -]\d+", place)
    assert prompt == ">"


def test_a_program_of_others_reads_the_place(acl: AclController) -> None:
    """As github.com/murillo-teixeira/surgical-bot does: one blank or a minus after each colon."""
    pattern = r"\s*".join(rf"{name}:([\s-]\d+)" for name in "XYZPR")
    assert re.search(pattern, typed(acl, "LISTPV INIT"))


def test_another_program_reads_counts_and_encoders(acl: AclController) -> None:
    """As github.com/Mestre-Verde/scorbot-er-vii-esp32-webcontrol does: eight numbers of five or six signs a line."""
    found = re.search(r"\s*".join(rf"{axis}:\s*(-?\d+)" for axis in range(1, 6)), typed(acl, "LISTPV INIT"))
    assert found is not None
    assert tuple(map(int, found.groups())) == LAB
    acl.receive(b"SHOW ENCO\r", 0.0)
    first, second = acl.poll(0.7).decode().split("\r")[1:]
    assert first == second
    assert len(re.findall(r"-?\d{5,6}", first)) == 8
    assert acl.receive(b"\x03", 0.8).endswith(b">")


def test_a_third_program_takes_the_words_between_echo_and_prompt(acl: AclController) -> None:
    words = typed(acl, "LISTPV INIT ").replace(": ", ":").split()[2:-1]
    assert [int(value) for _, value in (word.split(":") for word in words)][:5] == list(LAB)


def test_a_fourth_program_waits_for_the_echo_of_each_key_and_joins_what_blanks_part(acl: AclController) -> None:
    """As github.com/alu0100825893/ScorbotSimulator does (SerialController.cs): a key is the sign before a colon."""
    for key in b"listpv init":
        assert acl.receive(bytes([key]), 0.0) == bytes([key])
    answer = acl.receive(b"\r", 0.0).decode().partition(">")[0]
    joined = "".join("".join(line.split()) for line in answer.split("\r")[1:])
    keys = [found.start() - 1 for found in re.finditer(":", joined)]
    assert "".join(joined[at] for at in keys) == "12345XYZPR"
    assert [int(joined[at + 2 : end]) for at, end in pairwise(keys[:6])] == list(LAB)


def test_a_fifth_program_finds_the_place_in_the_second_line_after_the_echo(acl: AclController) -> None:
    """As github.com/AcaAac/ScorbotERVII-Ackerman-Control does (LAB1/VF.py), with at most one blank after a colon."""
    place = typed(acl, "LISTPV INIT").split("\n")[2]
    assert len(re.findall(r"[XYZPR]: ?(-?\d+)", place)) == 5


def test_shift_moves_one_axis_of_a_position(acl: AclController) -> None:
    assert "O.K." in typed(acl, "SHIFT INIT BY 1 -42")
    assert "1: 2399 " in typed(acl, "LISTPV INIT")


def test_a_decoupled_arm_counts_links_in_the_world(tmp_path: Path) -> None:
    acl = controller_of(load_cell(cell_folder(tmp_path, "er5plus")))
    assert isinstance(acl, AclController)
    acl.receive(b"DEFP P\rHERE P\rSETPV P 2 2000\rMOVE P\r", 0.0)
    before, after = acl.motor(0.0), acl.motor(60.0)
    turned = after - before
    assert turned[1] != 0.0
    np.testing.assert_allclose(turned[[0, 2, 3, 4]], [0.0, -turned[1], 0.0, 0.0], atol=1e-12)
