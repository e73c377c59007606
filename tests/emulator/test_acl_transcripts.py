"""What real controllers and the guide print, replayed on the emulated one."""

import re
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
}
BOOT = (  # A SCORBOT-ER V: github.com/talos-rit/commander, digital_twin/Bingo_ER-V_Bringup_Runbook.md
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


def test_a_decoupled_arm_counts_links_in_the_world(tmp_path: Path) -> None:
    acl = controller_of(load_cell(cell_folder(tmp_path, "er5plus")))
    assert isinstance(acl, AclController)
    acl.receive(b"DEFP P\rHERE P\rSETPV P 2 2000\rMOVE P\r", 0.0)
    before, after = acl.motor(0.0), acl.motor(60.0)
    turned = after - before
    assert turned[1] != 0.0
    np.testing.assert_allclose(turned[[0, 2, 3, 4]], [0.0, -turned[1], 0.0, 0.0], atol=1e-12)
