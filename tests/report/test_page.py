"""What the page of a calibration promises to whoever opens it."""

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from calibrated import arm, point, stripe
from page_claims import HOSTILE, Reader, is_closed_and_its_ids_are_its_own, needs_nothing_from_elsewhere, sound_pictures

from robolaser.report import write_report
from robolaser.report.evidence import Evidence
from robolaser.report.page import page
from robolaser.report.words import command, judgement


@pytest.fixture(scope="session")
def pages(calibrations):
    return {kind: page(one) for kind, one in calibrations.items()}


@pytest.fixture(params=["stripe", "point", "socket"])
def text(request, pages):
    return pages[request.param]


def test_the_page_needs_nothing_from_elsewhere(text):
    needs_nothing_from_elsewhere(text)


def test_every_element_is_closed_and_every_id_its_own(text):
    is_closed_and_its_ids_are_its_own(text)


def test_every_picture_is_sound_and_says_what_it_shows(text):
    assert len(sound_pictures(text)) >= 3


def test_tables_name_their_columns_and_rows(text):
    tables = re.findall(r"<table.*?</table>", text, flags=re.DOTALL)
    assert tables
    for table in tables:
        assert 'scope="col"' in table
        assert 'scope="row"' in table


def test_every_parameter_is_named(calibrations, pages):
    for kind, calibration in calibrations.items():
        said = " ".join(Reader(pages[kind]).texts)
        assert all(name in said for name in calibration.model.parameters.names)


def test_the_first_figure_is_the_error_on_new_poses_and_the_second_the_noise(text):
    assert text.index("<dt>on new poses") < text.index("<dt>noise alone") < text.index("<dt>on fitted poses")


def test_a_page_is_small(text):
    assert len(text.encode()) < 3_000_000


def test_names_from_data_stay_text():
    for calibration in (stripe(name=HOSTILE), point(name=HOSTILE, names=(HOSTILE, "</title>"))):
        read = Reader(page(calibration))
        assert not [tag for tag, _ in read.tags if tag == "script"]
        assert "<script>alert" in "".join(read.texts)


def test_pictures_of_thousands_of_points_stay_small():
    few = stripe(robot=arm())
    points = few.model.dataset.points
    again = np.tile(np.arange(len(points)), 100)
    model = replace(few.model, dataset=replace(few.model.dataset, points=points.take(again)))
    many = replace(few, model=model, residuals=few.residuals[again], held_out=few.held_out[again])
    assert len(page(many).encode()) < 3_000_000


def test_a_page_is_written_without_noise_search_or_held_out_poses(tmp_path):
    bare = stripe()
    dataset = replace(bare.model.dataset, noise=type(bare.model.dataset.noise)(), source="", licence="")
    noise = {"pixel": 0.1, "target": 5e-5, "flange": 1e-5, "flange_turn": 1e-5}
    bare = replace(bare, model=replace(bare.model, dataset=dataset), noise=noise, history=None, held_out=None)
    write_report(bare, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "unknown" in text
    assert "Convergence" not in text


def test_the_same_calibration_gives_the_same_page(calibrations, pages):
    assert page(calibrations["point"]) == pages["point"]


@pytest.mark.parametrize(("size", "word"), [(1.0, "What is left is noise"), (10.0, "something is unmodelled")])
def test_errors_are_judged_by_the_noise(size, word):
    calibration = stripe(robot=arm())
    noise = Evidence(calibration).noise.draw(1, np.random.default_rng(0))[0]
    calibration = replace(calibration, residuals=size * noise, held_out=1.05 * size * noise)
    assert word in judgement(Evidence(calibration))


def test_few_poses_for_many_parameters_are_named():
    calibration = stripe(robot=arm())
    calibration = replace(calibration, held_out=3 * calibration.residuals)
    assert "too few" in judgement(Evidence(calibration))


def test_reporting_leaves_the_global_state_of_pyplot_alone():
    program = "import sys, robolaser.report, robolaser.report.pictures;sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_the_command_that_repeats_a_run_names_its_effects_and_its_length():
    everywhere = command(Evidence(stripe(robot=arm(), effects=("joint_offset", "laser_roll"))))
    assert everywhere.endswith("--generations 20 --with joint_offset --with laser_roll")
    assert command(Evidence(stripe(robot=arm(), effects=("joint_offset:perturb",)))).endswith(
        "--with joint_offset:perturb"
    )
