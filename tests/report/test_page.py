"""What the page of a calibration promises to whoever opens it."""

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from calibrated import KINDS, arm, point, stripe
from page_claims import (
    HOSTILE,
    Reader,
    is_logarithmic,
    is_small,
    is_whole,
    rows,
    runs_only_our_own_scripts,
    scenes,
    series,
    sound_charts,
    titled,
)

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.data.stated_noise import Noise
from robolaser.report.calibration.page import document
from robolaser.report.error_analysis import ErrorAnalysis
from robolaser.report.page import render
from robolaser.simulation import CellOptions, simulate


def page(calibration, command=""):
    return render(document(calibration), command)


@pytest.fixture(scope="session")
def pages(calibrations):
    return {kind: page(one) for kind, one in calibrations.items()}


@pytest.fixture(params=KINDS)
def text(request, pages):
    return pages[request.param]


def test_the_page_is_whole(text):
    is_whole(text)


def test_every_chart_is_sound_and_says_what_it_shows(text):
    assert sound_charts(text)
    assert scenes(text)


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
    assert text.index("<dt>on new poses") < text.index("<dt>known noise") < text.index("<dt>on fitted poses")


def test_fitted_and_held_out_errors_have_an_entry_in_the_legend_each_and_a_logarithmic_axis(pages):
    shown = titled(pages["stripe"])
    assert series(shown["Errors of each pose"]) == ["fitted", "held out"]
    assert is_logarithmic(shown["Errors of each pose"], "y")


def test_every_point_and_every_pose_has_a_name_under_the_pointer(calibrations, pages):
    for kind, calibration in calibrations.items():
        shown = titled(pages[kind])
        (scene,) = scenes(pages[kind])
        (arrows,) = (shape for shape in scene["shapes"] if shape["kind"] == "arrows")
        assert len(arrows["at"]) == len(arrows["names"]) == len(calibration.model.dataset.points)
        assert all("pose " in name and "point" in name and "error" in name for name in arrows["names"])
        names = {row["pose"] for row in rows(shown["Errors of each pose"])}
        assert names == set(calibration.model.dataset.poses.names)


def test_the_caption_says_where_on_the_axis_the_largest_poses_are(calibrations, pages):
    names = list(calibrations["point"].model.dataset.poses.names)
    largest = re.search(r"Largest: (.*?)\.", " ".join(Reader(pages["point"]).texts))[1].split(", ")
    assert len(largest) == 3
    for name, number in (re.fullmatch(r"(\S+) \(at (\d+)\)", one).groups() for one in largest):
        assert names[int(number) - 1] == name


def test_names_from_data_stay_text():
    for calibration in (stripe(name=HOSTILE), point(name=HOSTILE, names=(HOSTILE, "</title>"))):
        text = page(calibration, command=HOSTILE)
        runs_only_our_own_scripts(text)
        assert "<script>alert" in "".join(Reader(text).texts)


def test_charts_of_thousands_of_points_stay_small():
    few = stripe(robot=arm())
    points = few.model.dataset.points
    again = np.tile(np.arange(len(points)), 100)
    model = replace(few.model, dataset=replace(few.model.dataset, points=points.take(again)))
    is_small(page(replace(few, model=model, residuals=few.residuals[again], held_out=few.held_out[again])))


def test_a_page_is_written_without_noise_or_held_out_poses():
    bare = stripe()
    dataset = replace(bare.model.dataset, noise=type(bare.model.dataset.noise)(), source="", licence="")
    noise = {"pixel": 0.1, "target": 5e-5, "flange": 1e-5, "flange_turn": 1e-5}
    bare = replace(bare, model=replace(bare.model, dataset=dataset), noise=noise, history=None, held_out=None)
    assert "unknown" in page(bare)


def test_the_same_calibration_gives_the_same_page(calibrations, pages):
    assert page(calibrations["point"]) == pages["point"]


@pytest.mark.parametrize(("size", "word"), [(1.0, "The remaining error is noise"), (10.0, "something is unmodelled")])
def test_errors_are_judged_by_the_noise(size, word):
    calibration = stripe(robot=arm())
    root = np.linalg.cholesky(ErrorAnalysis(calibration).noise.covariances)
    noise = np.einsum("mij,mj->mi", root, np.random.default_rng(0).normal(size=root.shape[:2]))
    calibration = replace(calibration, residuals=size * noise, held_out=1.05 * size * noise)
    assert word in ErrorAnalysis(calibration).judgement


def test_few_poses_for_many_parameters_are_named():
    calibration = stripe(robot=arm())
    calibration = replace(calibration, held_out=3 * calibration.residuals)
    assert "too few" in ErrorAnalysis(calibration).judgement


def test_what_all_pages_share_loads_no_physics():
    program = "import sys, robolaser.report.page; sys.exit(bool({'scipy', 'pinocchio', 'numba'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_the_page_says_what_was_typed():
    assert "robolaser calibrate &#39;my cell&#39; --output result" in page(
        stripe(robot=arm()), command="robolaser calibrate 'my cell' --output result"
    )


def test_gross_errors_that_a_weighed_fit_leaves_out_do_not_keep_the_page_from_being_written():
    dataset = simulate(arm(), kind="point", poses=30, points=1, noise=Noise(point_m=2e-5), seed=1).dataset
    xyz = dataset.points.xyz.copy()
    xyz[7] += 5e-3
    result = calibrate(replace(dataset, points=replace(dataset.points, xyz=xyz)), Plan(weights="noise"))
    assert len(result.fitted_model.dataset.points) < len(dataset.points)
    assert sound_charts(page(result))


def test_a_size_that_repeats_contradict_is_not_called_stated():
    noise, options = Noise(pixel_px=0.3), CellOptions(repeats=4)
    made = simulate("scorbot_er7", kind="stripe", poses=20, noise=noise, seed=1, options=options).dataset
    calibration = calibrate(replace(made, noise=replace(made.noise, pixel_px=0.03)))
    assert calibration.noise["pixel"] == pytest.approx(0.3, rel=0.1)
    assert ErrorAnalysis(calibration).known_noise["pixel"] == "from repeats"
