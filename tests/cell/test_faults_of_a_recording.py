"""Faults on the way from pose to pose: a clear message, an arm that stands, a recording that goes on."""

import re
from pathlib import Path

import pytest
from terminal import Rig, emulated


@pytest.fixture
def acl(tmp_path: Path) -> Rig:
    return Rig(tmp_path, "acl")


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("impact:2@45", "joint_2"),
        ("stall:3@45", "joint_3"),
        ("silent@52", "is lost"),
        ("cut@52", "is lost"),
        ("flood:100000@52", "without end"),
        ("reboot@52", "restarted"),
    ],
)
def test_after_a_fault_the_recording_is_gone_on_with(
    acl: Rig, fault: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with emulated(acl, fault) as port:
        assert acl.record("--poses", str(acl.poses), "--move", port=port) == 1
    message = capsys.readouterr().err
    assert said in message
    assert re.search(r"It is at joint_1 -?\d|could not be seen to stop|position is not known", message)
    assert ("position is not known" in message) == (fault == "reboot@52")
    assert "--resume" in message or "Nothing was recorded" in message
    there = (acl.out / "plan.csv").exists()
    done = acl.names() if there else []
    acl.home_first()
    with emulated(acl) as port:
        assert acl.record("--poses", str(acl.poses), "--move", *(["--resume"] if there else []), port=port) == 0
    assert acl.names() == ["a", "b", "c"]
    assert acl.names()[: len(done)] == done
