"""What is said of a diagnosis: verdict, advice, and the lines on the terminal."""

import io
from dataclasses import replace

import pytest
from calibrated import arm, stripe
from diagnosed import MADE, of
from rich.console import Console

from robolaser.diagnosis.summary_text import sentence
from robolaser.report.diagnosis import print_diagnosis
from robolaser.report.diagnosis.advice import to_do
from robolaser.report.digits import percent


@pytest.fixture(params=MADE)
def diagnosis(request):
    return MADE[request.param]()


def printed(diagnosis, folder=None):
    file = io.StringIO()
    print_diagnosis(diagnosis, folder, console=Console(file=file))
    return file.getvalue()


def test_a_verdict_says_millimetres_and_what_noise_gives(diagnosis):
    assert diagnosis.sentence.count(" mm") >= 2
    assert "noise alone gives 0.11 mm" in diagnosis.sentence
    assert diagnosis.sentence.endswith(".")


def test_gross_errors_are_counted_in_the_verdict():
    assert "One row" in MADE["no_gap"]().sentence
    assert "2 rows" in MADE["explained"]().sentence


def test_what_poses_cannot_tell_is_admitted():
    assert "do not tell joint_offset at perturb from encoder_scale at perturb" in MADE["explained"]().sentence


def test_every_verdict_leads_to_something_to_do(diagnosis):
    said = to_do(diagnosis)
    assert said
    for found in diagnosis.findings:
        assert any(
            one.startswith(f"{found.candidate_effect.effect.name} at {found.candidate_effect.where}") for one in said
        )


def test_what_is_unlikely_is_said_so_and_not_to_be_repaired():
    diagnosis = MADE["unexplained"]()
    (found,) = diagnosis.findings
    doubtful = replace(found, probability=0.01)
    said = sentence(
        "unexplained", [doubtful], diagnosis.where, diagnosis.gap, diagnosis.repeatability, diagnosis.outliers
    )
    assert "perhaps the zero of perturb is off" in said
    assert "perhaps" not in diagnosis.sentence
    assert "Do not repair it yet" in to_do(replace(diagnosis, findings=(doubtful,)))[0]


def test_the_terminal_takes_some_twenty_lines_of_plain_text(diagnosis, tmp_path):
    text = printed(diagnosis, tmp_path)
    assert "\x1b" not in text
    assert len(text.splitlines()) <= 24
    assert str(tmp_path / "report.html") in text.replace("\n", "")
    for found in diagnosis.findings:
        assert f"{found.candidate_effect.effect.name}:{found.candidate_effect.where}" in text


def test_names_are_not_taken_for_markup():
    assert "[bold]x[/bold]" in printed(of(stripe(name="[bold]x[/bold]", robot=arm()), "no_gap"))


@pytest.mark.parametrize(("share", "said"), [(0.998, "99.8 %"), (1.0, "> 99.9 %"), (0.0, "< 0.1 %"), (0.5, "50 %")])
def test_nothing_is_certain(share, said):
    assert percent(share) == said
