"""A recording that is diagnosed while it is made."""

import json
import re
from pathlib import Path

import pytest
from virtual_cell import in_virtual_time

from robolaser.cli import main
from robolaser.commands.running_diagnosis import answer, in_a_line

CELL = Path(__file__).parents[2] / "examples" / "cell"
PLANNED = 4


def test_the_diagnosis_of_all_poses_is_shown_as_they_come(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording = tmp_path / "recording"
    with in_virtual_time(CELL):
        asked = [
            "record", str(CELL), "--output", str(recording), "--plan", str(PLANNED), "--move", "--diagnose",
            "--json",
        ]  # fmt: skip
        assert main(asked) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["poses"] == PLANNED
    assert re.match(rf"{PLANNED} poses: \w+.*; error on new poses [\d.]+ mm, noise alone [\d.]+ mm", told["diagnosis"])


def test_what_cannot_be_diagnosed_yet_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "dataset.toml").write_text('format = "robolaser-dataset/1"\n')
    assert answer(tmp_path).startswith("no diagnosis yet: ")


def test_a_line_says_who_leads_how_sure_and_which_pose_would_decide() -> None:
    found = {
        "verdict": "explained",
        "poses": {"used": 30, "all": 30},
        "gap_mm": {"after": 0.4, "noise_floor": 0.35},
        "effects": [{"effect": "backlash", "where": "elbow", "probability": 0.87}],
        "next_poses": [{"elbow": 1.5}],
    }
    assert in_a_line(found) == (
        "30 poses: explained; backlash at elbow 87%; error on new poses 0.4 mm, noise alone 0.35 mm;"
        " would decide: elbow 1.50 (rad or m)"
    )


def test_an_option_without_motion_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["record", str(CELL), "--output", "nowhere", "--watch", "4", "--diagnose"]) == 2
    assert "--diagnose" in capsys.readouterr().err
