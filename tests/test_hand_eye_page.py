"""The page on hand-eye calibration does what it shows, with its real images, and is as exact as it says."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from robolaser.cli import main

ROOT = Path(__file__).parents[1]
PUBLISHED_PX = 1.251


def test_every_command_of_the_page_prints_what_the_page_shows():
    page = [sys.executable, str(ROOT / "docs" / "run_code_blocks.py"), str(ROOT / "docs" / "howto" / "hand-eye.md")]
    ran = subprocess.run(page, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hand-eye")
    source = ROOT / "examples" / "hand-eye"
    assert main(["import", str(source), "--extract", "--output", str(folder / "cell"), "--quiet"]) == 0
    assert main(["calibrate", str(folder / "cell"), "--output", str(folder / "result"), "--quiet"]) == 0
    return json.loads((folder / "result" / "calibration.json").read_text())


def test_corners_are_met_more_closely_than_was_published(result):
    corners = next(rows for rows in result["rows"] if rows["unit"] == "px")
    assert corners["rms"] < 1.15 < PUBLISHED_PX
    assert corners["held_out_rms"] < 2.0
    assert result["held_out_rms_m"] < 0.0011
