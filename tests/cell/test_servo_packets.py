"""Packets of bus servos, as their makers print them."""

from pathlib import Path

import pytest
from emulated_cell import cell_folder

from robolaser.cell.servos import READ_ALL, Feetech, crc16
from robolaser.data.cell_config import load_cell
from robolaser.emulator.emulated_cell import controller_of


@pytest.mark.parametrize(
    "packet",
    [
        "FF FF FD 00 01 03 00 01 19 4E",  # ping
        "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15",  # read the present position
        "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0",  # its answer
    ],
)
def test_the_crc_is_that_of_the_e_manual(packet: str) -> None:
    *data, low, high = bytes.fromhex(packet)
    assert crc16(bytes(data)) == low + 256 * high


def test_a_sync_read_is_that_of_the_feetech_manual() -> None:
    assert Feetech().instruction(READ_ALL, bytes.fromhex("38 08 01 02")).hex(" ") == "ff ff fe 06 82 38 08 01 02 36"


def test_an_emulated_servo_answers_what_the_manual_asks(tmp_path: Path) -> None:
    servos = controller_of(load_cell(cell_folder(tmp_path, "feetech")))
    answers = servos.receive(bytes.fromhex("FF FF FE 06 82 38 08 01 02 36"), 0.0)
    assert answers[:14].hex(" ") == "ff ff 01 0a 00 00 08 00 00 00 00 00 00 ec"
    assert answers[14:].hex(" ") == "ff ff 02 0a 00 00 08 00 00 00 00 00 00 eb"
