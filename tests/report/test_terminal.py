"""What is printed after a calibration."""

import io
from dataclasses import replace
from pathlib import Path

import pytest
from calibrated import arm, stripe
from rich.console import Console

from robolaser.estimation.identifiability import Unidentifiable
from robolaser.report.calibration.page import document
from robolaser.report.console import print_document


def printed(calibration, folder=None):
    file = io.StringIO()
    print_document(document(calibration, brief=True), folder, console=Console(file=file))
    return file.getvalue()


def test_the_summary_is_short_plain_and_leads_with_new_poses(calibration):
    text = printed(calibration)
    assert "\x1b" not in text
    assert text.index("on new poses") < text.index("known noise") < text.index("on fitted poses")
    assert len(text.splitlines()) < 35


def test_the_summary_names_effects_and_where_the_page_is(tmp_path):
    text = printed(stripe(robot=arm(), effects=("joint_offset:perturb",)), tmp_path)
    assert "joint offset of perturb" in text
    assert str(tmp_path / "report.html") in text


def test_names_are_not_taken_for_markup():
    assert "[bold]x[/bold]" in printed(stripe(name="[bold]x[/bold]"))


def test_what_cannot_be_separated_is_said_once():
    made = stripe()
    groups = (Unidentifiable(("f", "s_u"), ""), Unidentifiable(("b", "theta"), ""))
    text = printed(replace(made, unidentifiable=groups))
    assert text.count("cannot separate") == 1
    assert "These data cannot separate: f, s_u; b, theta" in text


def test_no_line_is_wider_than_the_columns_that_were_stated(calibration, monkeypatch):
    wide = max(map(len, printed(calibration).splitlines()))
    monkeypatch.setenv("COLUMNS", "60")
    assert max(map(len, printed(calibration).splitlines())) <= 60 < wide


@pytest.mark.parametrize("columns", ["", "0", "wide", "-5", "8.5"])
def test_columns_that_are_no_width_are_as_none(calibration, monkeypatch, columns):
    without = printed(calibration)
    monkeypatch.setenv("COLUMNS", columns)
    assert printed(calibration) == without


def test_the_path_of_the_page_stays_whole_in_narrow_lines(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    folder = Path("/a/folder/of which/the path/is longer than a line")
    assert f"Look at {folder}/report.html" in printed(stripe(), folder)
