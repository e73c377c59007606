"""The emulator as a process: opened as a serial port, and ended by whoever started it."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
import serial
from emulated_cell import cell_folder
from emulator_process import EmulatorProcess

from robolaser.cli import main

LATE_S = 30.0
"""On a busy machine all comes, if late."""


def ask(port: serial.SerialBase, line: str) -> str:
    port.write(line.encode() + b"\r")
    return port.read_until(b">").decode(errors="replace")


def counts(port: serial.SerialBase) -> str:
    return ask(port, "LISTPV POSITION").splitlines()[2]


def test_a_client_opens_the_arm_drives_it_and_comes_back_and_bytes_come_at_the_speed_of_the_line(tmp_path):
    with EmulatorProcess(cell_folder(tmp_path)) as emulated:
        assert emulated.camera is None
        with serial.serial_for_url(emulated.arm, 9600, timeout=LATE_S) as port:
            for line in ("DEFP P", "HERE P", "SETPV P 1 200", "MOVE P 50"):
                assert "O.K." in ask(port, line)
            until = time.monotonic() + LATE_S
            while not counts(port).startswith("1: 200 ") and time.monotonic() < until:
                time.sleep(0.02)
        with serial.serial_for_url(emulated.arm, 9600, timeout=LATE_S) as port:
            assert counts(port).startswith("1: 200 ")
            began = time.monotonic()
            answer = ask(port, "LISTPV POSITION")
            assert time.monotonic() - began > 0.8 * len(answer) / 960


def test_a_pulled_plug_ends_the_line(tmp_path):
    with (
        EmulatorProcess(cell_folder(tmp_path), faults=["cut@2"]) as emulated,
        serial.Serial(emulated.arm, 9600, timeout=LATE_S) as port,
    ):
        assert counts(port).startswith("1: 0 ")
        with pytest.raises((serial.SerialException, OSError)):  # noqa: PT012 - which of them notices is up to the system
            for _ in range(20):
                ask(port, "LISTPV POSITION")


@pytest.mark.parametrize("end", ["stdin", "term", "interrupt"])
def test_it_ends_when_its_starter_ends_it(tmp_path, end):
    process = subprocess.Popen(
        [sys.executable, "-m", "robolaser", "emulate", str(cell_folder(tmp_path))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        arm = os.open(json.loads(process.stdout.readline())["arm"], os.O_RDWR | os.O_NOCTTY)
        if end != "stdin":
            process.send_signal(signal.SIGTERM if end == "term" else signal.SIGINT)
            process.wait(timeout=LATE_S)
        assert process.communicate(timeout=LATE_S) == ("", "")
        assert process.returncode == 0
        assert not os.read(arm, 1)  # the far end is gone; another terminal may have its name by now
        os.close(arm)
    finally:
        process.kill()


@pytest.mark.parametrize(("fault", "said"), [("lost:9", "more than 1"), ("flod", "Did you mean 'flood'")])
def test_what_it_cannot_emulate_it_says_in_one_sentence(tmp_path, fault, said, capsys):
    assert main(["emulate", str(cell_folder(tmp_path)), "--fault", fault]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
