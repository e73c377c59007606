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
from dataclasses import replace
from threading import Event, Thread

import numpy as np

from robolaser.cell.arm import arm_class
from robolaser.cell.clock import Clock
from robolaser.cell.motion import Mover
from robolaser.data.cell_config import load_cell

def opened(folder, port):
    cell, clock = load_cell(folder), Clock()
    cell = replace(cell, arm=replace(cell.arm, port=port))
    arm = arm_class(cell).open(cell, clock)
    mover = Mover(arm, cell.robot, float(sys.argv[1]), clock, cell.arm.unattended_s)
    at, read, moves = mover.resting("before"), arm.read, Event()

    def reports():
        q = read()
        if abs(q - at).max() > 0.02:
            moves.set()
        return q

    arm.read = reports
    goes = lambda: mover.move_and_wait(at + np.array([float(sys.argv[2]), 0, 0, 0, 0]), "p", at)
    return Thread(target=goes), moves

arms = [opened(*words) for words in zip(sys.argv[3::2], sys.argv[4::2])]
for arm, _ in arms:
    arm.start()
for _, moves in arms:
    moves.wait()
print("under way", flush=True)
"""


def test_after_kill_9_every_arm_stands_within_a_second(tmp_path: Path) -> None:
    """All by one program, each on a pseudo terminal of its own; Universal Robots' have none (test_every_arm.py)."""
    kinds = sorted(set(ARMS) - {"ur", "er5plus"})
    cells = {kind: load_cell(cell_folder(tmp_path, kind)) for kind in kinds}
    with ExitStack() as stack:
        ports = {kind: stack.enter_context(EmulatorProcess(cells[kind].folder)).arm for kind in kinds}
        asked = [SPEED_RAD_S, WAY_RAD, *(word for kind in kinds for word in (cells[kind].folder, ports[kind]))]
        child = stack.enter_context(Popen([sys.executable, "-c", MOVES, *map(str, asked)], stdout=PIPE))
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
