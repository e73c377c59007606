"""Faults come when they are asked for, do what they are named for, and are the same for the same seed."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from emulated_cell import cell_folder

from robolaser.data.cell_config import load_cell
from robolaser.emulator.emulated_cell import EmulatedCell, controller_of
from robolaser.emulator.faults import KINDS, Fault, FaultyController, read_fault
from robolaser.errors import UsageError

ASK = b"LISTPV POSITION\r"


@pytest.fixture
def arm(tmp_path: Path) -> Callable[..., FaultyController]:
    cell = load_cell(cell_folder(tmp_path))

    def make(*faults: str, seed: int = 1) -> FaultyController:
        return FaultyController(controller_of(cell), [read_fault(text) for text in faults], np.random.default_rng(seed))

    return make


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_can_be_asked_for_by_name_alone(kind: str) -> None:
    assert read_fault(kind) == Fault(kind, KINDS[kind])


def test_amount_and_moment_are_read_as_written() -> None:
    assert read_fault("impact:3@12") == Fault("impact", 3, commands=(12, np.inf))
    assert read_fault("late:2.5@7-9") == Fault("late", 2.5, commands=(7, 9))
    assert read_fault("silent@>5s") == Fault("silent", 0, seconds=(5, np.inf))
    assert read_fault("flood:8@>2s-4.5s") == Fault("flood", 8, seconds=(2, 4.5))


@pytest.mark.parametrize("text", ["lost:2", "impact:0", "stall:1.5", "late:", "late@5s", "late@", "",
                                  "late@12-3", "lost@>9s-3s"])  # fmt: skip
def test_nonsense_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(UsageError, match=r"For example: lost:0\.1"):
        read_fault(text)


def test_an_unknown_fault_is_refused_with_the_likeliest_meant() -> None:
    with pytest.raises(UsageError, match="Did you mean 'garbage'"):
        read_fault("garbege")


def test_an_axis_that_is_not_there_cannot_fail(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="axes 1 to 5"):
        EmulatedCell(cell_folder(tmp_path), faults=["stall:6"])


def test_servos_have_no_home_to_miss(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="do no homing"):
        EmulatedCell(cell_folder(tmp_path, "lss"), faults=["homing:2"])


def test_faults_that_are_not_there_change_nothing(arm: Callable[..., FaultyController]) -> None:
    assert arm("lost@9", "garbage@>5s", "late@9", "flood@9").receive(ASK, 0.0) == arm().receive(ASK, 0.0)


def test_a_fault_begins_with_the_command_that_was_named(arm: Callable[..., FaultyController]) -> None:
    one = arm("silent@3-4")
    assert [bool(one.receive(ASK, float(i))) for i in range(6)] == [True, True, False, False, True, True]


def test_a_fault_begins_at_the_second_that_was_named(arm: Callable[..., FaultyController]) -> None:
    one = arm("silent@>2s-4s")
    assert [bool(one.receive(ASK, t)) for t in (1.9, 2.1, 3.9, 4.1)] == [True, False, False, True]


def test_the_same_seed_loses_the_same_bytes(arm: Callable[..., FaultyController]) -> None:
    first, again, other = (arm("lost:0.2", "garbage:0.1", seed=seed).receive(ASK, 0.0) for seed in (4, 4, 5))
    assert first == again != other


def test_lost_bytes_are_missing_and_garbage_is_between_the_rest(arm: Callable[..., FaultyController]) -> None:
    whole = arm().receive(ASK * 20, 0.0)
    lost = arm("lost:0.1").receive(ASK * 20, 0.0)
    strewn = arm("garbage:0.1").receive(ASK * 20, 0.0)
    assert len(lost) == pytest.approx(0.9 * len(whole), rel=0.02)
    assert len(strewn) == pytest.approx(1.1 * len(whole), rel=0.02)
    left = iter(strewn)
    assert all(byte in left for byte in whole)


def test_what_is_misheard_never_came_back_as_an_echo(arm: Callable[..., FaultyController]) -> None:
    assert 20 < len(arm("misheard:0.5").receive(b"X" * 100, 0.0)) < 80


def test_late_answers_come_after_the_next_question(arm: Callable[..., FaultyController]) -> None:
    one = arm("late:3@2-2")
    prompt = one.receive(b"\r", 0.0)
    assert one.receive(ASK, 1.0) == b""
    assert one.receive(b"\r", 2.0) == b""
    assert one.poll(3.9) == b""
    late = one.poll(4.1)
    assert late.startswith(ASK)
    assert late.endswith(prompt)


def test_a_flood_does_not_end(arm: Callable[..., FaultyController]) -> None:
    one = arm("flood:1000@>1s")
    heard = [len(one.poll(t)) for t in np.arange(0, 10, 0.1)]
    assert sum(heard[:10]) == 0
    assert sum(heard) == pytest.approx(9000, rel=0.05)
    assert all(heard[13:])


def test_a_cut_line_neither_hears_nor_speaks_and_the_arm_goes_on(arm: Callable[..., FaultyController]) -> None:
    one = arm("cut@5")
    for line in (b"DEFP P\r", b"HERE P\r", b"SETPV P 1 2000\r", b"MOVE P 300\r"):
        assert one.receive(line, 0.0)
    assert one.receive(ASK, 1.0) == b""
    assert one.cut(1.0)
    began = one.motor(1.0)
    assert one.poll(2.0) == one.receive(b"\x01", 2.0) == b""
    assert not np.array_equal(one.motor(3.0), began)


@pytest.mark.parametrize(
    ("fault", "line"), [("impact:2@4", b"IMPACT PROTECTION axis 2"), ("thermic:4@4", b"THERMIC OVERLOAD axis 4")]
)
def test_a_blow_strikes_once(arm: Callable[..., FaultyController], fault: str, line: bytes) -> None:
    one = arm(fault)
    for command in (b"DEFP P\r", b"HERE P\r", b"\r"):
        one.receive(command, 0.0)
    assert one.poll(0.5) == b""
    one.receive(b"\r", 1.0)
    assert line in one.poll(1.0)
    one.receive(b"CON\r", 2.0)
    assert b"O.K." in one.receive(b"MOVE P\r", 2.0)
    assert one.poll(3.0) == b""
