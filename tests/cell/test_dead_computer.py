"""A computer that dies while the arm moves, on a real pseudo terminal and in real time."""

import sys
import time
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path
from subprocess import PIPE, Popen

import numpy as np
from emulated_cell import ARMS, cell_folder
from emulator_process import EmulatorProcess
from serial import Serial

from robolaser.cell.arm import arm_class
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import load_cell
from robolaser.emulator.emulated_cell import controller_of

ASK = b"LISTPV POSITION\r"
SPEED_RAD_S = 0.3
WAY_RAD = 1.6  # takes ten seconds
MOVES = """
import sys
import numpy as np
from dataclasses import replace
from robolaser.cell.arm import arm_class
from robolaser.cell.clock import Clock
from robolaser.cell.motion import Mover
from robolaser.data.cell_config import load_cell

cell, clock = load_cell(sys.argv[1]), Clock()
cell = replace(cell, arm=replace(cell.arm, port=sys.argv[2]))
arm = arm_class(cell).open(cell, clock)
mover = Mover(arm, cell.robot, float(sys.argv[3]), clock, cell.arm.unattended_s)
at = mover.resting("before")
read = arm.read

def reports():
    q = read()
    if abs(q - at).max() > 0.02:
        print("under way", flush=True)
    return q

arm.read = reports
print("ready", flush=True)
sys.stdin.readline()
mover.move_and_wait(at + np.array([float(sys.argv[4]), 0, 0, 0, 0]), "p", at)
"""


def test_after_kill_9_every_arm_stands_within_a_second(tmp_path: Path) -> None:
    """All at once, each on a pseudo terminal of its own; Universal Robots' arms have none (test_every_arm.py)."""
    kinds = sorted(set(ARMS) - {"ur", "er5plus"})
    cells = {kind: load_cell(cell_folder(tmp_path, kind)) for kind in kinds}
    with ExitStack() as stack:
        ports = {kind: stack.enter_context(EmulatorProcess(cells[kind].folder)).arm for kind in kinds}
        children = []
        for kind in kinds:
            asked = [sys.executable, "-c", MOVES, cells[kind].folder, ports[kind], SPEED_RAD_S, WAY_RAD]
            children.append(stack.enter_context(Popen([str(word) for word in asked], stdin=PIPE, stdout=PIPE)))
        for child in children:
            assert child.stdout is not None
            assert child.stdout.readline() == b"ready\n"
        for child in children:
            assert child.stdin is not None
            child.stdin.write(b"\n")
            child.stdin.flush()
        for child in children:
            assert child.stdout is not None
            assert child.stdout.readline() == b"under way\n"
            child.kill()
        time.sleep(1.0)
        for kind in kinds:
            cell = replace(cells[kind], arm=replace(cells[kind].arm, port=ports[kind]))
            if kind == "acl":  # to open it would stop it
                with Serial(ports[kind], 9600, timeout=30) as line:
                    line.write(b"XQ\r")  # makes what was left half typed unknown
                    line.read_until(b">")
                    first, second = ((line.write(ASK), line.read_until(b">"), time.sleep(0.3))[1] for _ in range(2))
                    assert first == second
            with closing(arm_class(cell).open(cell, Clock())) as arm:
                stands = arm.read()
                time.sleep(0.3)
                np.testing.assert_array_equal(arm.read(), stands)
                gone = stands[0] - controller_of(cell).motor(0.0)[0]
            assert 0.01 < gone < 0.9 * WAY_RAD, kind
