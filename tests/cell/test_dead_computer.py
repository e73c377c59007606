"""A computer that dies while the arm moves, on a real pseudo terminal and in real time."""

import re
import subprocess
import sys
import time
from pathlib import Path

import serial
from emulated_cell import cell_folder

from robolaser.emulator.serving import EmulatorProcess

WAY = 17_601
"""Counts of axis 1 on the way that it is sent."""
MOVES = """
import sys
from dataclasses import replace
from robolaser.cell.arms import open_arm
from robolaser.cell.clock import WallClock
from robolaser.cell.motion import Mover
from robolaser.data.cell_config import load_cell

cell, clock = load_cell(sys.argv[1]), WallClock()
arm = open_arm(replace(cell, arm=replace(cell.arm, port=sys.argv[2])), clock)
mover = Mover(arm, cell.robot, 0.3, clock, cell.arm.unattended_s)
at = mover.resting("before")
print("moves", flush=True)
mover.move_and_wait(at + 1.2, "p", at)
"""


def counts(port: serial.SerialBase) -> list[int]:
    port.write(b"LISTPV POSITION\r")
    return [int(count) for count in re.findall(r"\d:\s*(-?\d+)", port.read_until(b">").decode())]


def test_after_kill_9_the_arm_stands_within_a_second(tmp_path: Path) -> None:
    folder = cell_folder(tmp_path)
    with EmulatorProcess(folder) as emulated:
        child = subprocess.Popen([sys.executable, "-c", MOVES, folder, emulated.arm], stdout=subprocess.PIPE)
        assert child.stdout is not None
        assert child.stdout.readline() == b"moves\n"
        time.sleep(1.7)
        child.kill()
        child.communicate()
        time.sleep(1.0)
        with serial.Serial(emulated.arm, 9600, timeout=2) as port:
            stands = counts(port)
            time.sleep(1.0)
            assert counts(port) == stands
    assert 0 < stands[0] < 0.8 * WAY
