"""What the page of a diagnosis promises to whoever opens it."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from calibrated import arm, stripe
from diagnosed import MADE, of
from page_claims import is_logarithmic, is_whole, rows, said, scenes, series, sound_charts, titled

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.cause_words import named
from robolaser.diagnosis.result import DetectionLimit, WrongInput
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.geometry.rigid_motion import inverse
from robolaser.model.sensors import scanner_geometry
from robolaser.report.cell_poses import CellPoses
from robolaser.report.diagnosis.charts import steps
from robolaser.report.diagnosis.page import document, figures, suspected
from robolaser.report.diagnosis.rows import gross_table
from robolaser.report.digits import millimetres, percent
from robolaser.report.page import render
from robolaser.report.setting import limit_table, untestable
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate


def page(diagnosis, command=""):
    return render(document(diagnosis), command)


@pytest.fixture(scope="module")
def made():
    return {name: make() for name, make in MADE.items()}


@pytest.fixture(scope="module")
def pages(made):
    return {name: page(one, command="robolaser diagnose cell --output result") for name, one in made.items()}


@pytest.fixture(params=MADE)
def name(request):
    return request.param


@pytest.fixture
def text(name, pages):
    return pages[name]


@pytest.fixture
def diagnosis(name, made):
    return made[name]


def test_the_page_is_whole(text):
    is_whole(text)


def test_every_chart_is_sound_and_says_what_it_shows(text):
    assert len(sound_charts(text)) + len(scenes(text)) >= 3


def test_the_answer_comes_first_then_the_doubt_then_the_evidence(text, diagnosis):
    lead = diagnosis.sentence.partition(". ")[0]
    assert text.index("<header>") < text.replace("&#39;", "'").index(lead) < text.index("<main>")
    headings = re.findall(r"<h2>(.*?)</h2>", text)
    wanted = ("What was found", "What to do", "What is not certain", "Step by step", "Errors", "Noise")
    order = [headings.index(one) for one in wanted if one in headings]
    assert order == sorted(order)
    assert len(order) >= 4


def test_every_sentence_of_the_verdict_is_on_the_page(text, diagnosis):
    for sentence in diagnosis.sentence.rstrip(".").split(". "):
        assert sentence in said(text)


def test_every_effect_has_value_error_probability_gaps_and_a_caveat(text, diagnosis):
    section = re.search(r"<h2>What was found</h2>.*?</section>", text, flags=re.DOTALL)
    assert bool(section) == bool(diagnosis.findings)
    if not section:
        return
    rows = section[0].split("<tr ")[2:]
    assert len(rows) == len(diagnosis.findings)
    for row, found in zip(rows, diagnosis.findings, strict=True):
        assert named(found.candidate_effect).lower() in row.lower()
        assert row.count("±") == len([one for one in found.parameters.values() if one.std is not None])
        assert percent(found.probability) in row
        assert row.count(" mm") >= 3
        assert re.search(r'class="note">[^<]{10,}', row)


def test_rivals_gross_errors_and_what_cannot_be_tested_are_listed(pages, made):
    words = said(pages["explained"])
    assert "Encoder scale of perturb" in words
    assert "Latency" in words
    assert "no joint velocities in the data" in words
    dataset = made["explained"].dataset
    for row in made["explained"].outliers:
        pose, point = dataset.poses.names[dataset.points.pose[row]], dataset.points.names[row]
        assert f"{pose} {point} points.csv {row + 1} " in words


def test_what_was_not_found_is_bounded_in_units_that_people_read(made):
    diagnosis = made["explained"]
    first, rival = diagnosis.limits[0].candidate_effect, diagnosis.limits[1].candidate_effect
    one = DetectionLimit(first, "lost_motion", np.radians(0.01), "rad", np.radians(0.03), rival, 2e-4)
    missed = DetectionLimit(first, "lost_motion", None, "rad")
    table = limit_table([one, missed, replace(missed, is_imitated=True)])
    assert [[cell.text for cell in row] for row in table.cells] == [
        ["backlash", first.where, "0.01°", "0.03°", "0.2 mm", named(rival)],
        ["backlash", first.where, "never", "never", "", ""],
        ["backlash", first.where, "never, since what was found imitates it", "never", "", ""],
    ]


def test_each_reason_why_effects_cannot_be_tested_stands_once():
    untested = {"latency": "no velocities", "backlash": "no order", "base_shift": "no order"}
    assert untestable(untested).rows == [("Latency", "no velocities"), ("Backlash, base shift", "no order")]


def test_the_waterfall_hangs_together_from_nominal_to_noise(diagnosis):
    bars = steps(diagnosis)
    hanging = [bar for bar in bars if bar.before is not None]
    assert bars[0].after == hanging[0].before == pytest.approx(1e3 * diagnosis.gap.nominal_m)
    for one, following in pairwise(hanging):
        assert one.after == pytest.approx(following.before)
    assert bars[-2].after == pytest.approx(hanging[-1].after) == pytest.approx(1e3 * diagnosis.gap.after_m)
    assert bars[-1].after == pytest.approx(1e3 * diagnosis.gap.noise_floor_m)


def test_every_suspected_place_is_highlighted_and_without_a_gap_none(diagnosis):
    marked = suspected(diagnosis)
    assert {found.candidate_effect.where for found in diagnosis.findings} <= set(marked)
    assert bool(marked) == (diagnosis.verdict != "no_gap")


def test_the_drawn_scanner_hangs_on_the_drawn_flange_in_every_pose():
    diagnosis = of(stripe(robot=arm(), effects=("joint_offset:perturb",)))
    model = diagnosis.model
    cell = CellPoses(model, diagnosis.x)
    values = model.parameters.values(diagnosis.x[None])
    mount = model.blocks.sensor.in_cell(values, model.perturb(values)).mount[0, 0]
    flange = model.flange(values)[0]
    np.testing.assert_allclose(cell.line(np.arange(len(flange)))[:, -1], flange[:, :3, 3], atol=1e-12)
    np.testing.assert_allclose((inverse(flange) @ cell.camera)[:, :3, 3], [mount[:3, 3]] * len(flange), atol=1e-12)


def test_arrows_lead_from_what_is_known_to_where_the_model_puts_it(made):
    diagnosis = made["without_robot"]
    model = diagnosis.model
    cell = CellPoses(model, diagnosis.x)
    values = model.parameters.values(diagnosis.x[None])
    perturb = model.perturb(values)
    seen = scanner_geometry.in_base(model.dataset, values, model.flange(values, perturb), perturb)[0]
    np.testing.assert_allclose(cell.known + cell.shifts(model.residuals(diagnosis.x[None])[0]), seen, atol=1e-9)


def test_charts_show_every_step_and_every_pose(text, diagnosis):
    shown = titled(text)
    gap = shown["How far the gap shrinks"]
    assert {row["step"] for row in rows(gap) if "step" in row} == {step.label for step in steps(diagnosis)}
    poses = shown["Errors of each pose"]
    assert {row["pose"] for row in rows(poses) if "pose" in row} == set(diagnosis.observed.poses.names)
    assert is_logarithmic(poses, "y")
    assert ("before" in series(poses)) == bool(diagnosis.findings)


def test_gaps_have_a_logarithmic_axis(pages):
    assert is_logarithmic(titled(pages["explained"])["How far the gap shrinks"], "x")


def test_joints_and_points_have_names_under_the_pointer(pages):
    (scene,) = scenes(pages["explained"])
    arrows = [shape for shape in scene["shapes"] if shape["kind"] == "arrows"]
    assert {shape["series"] for shape in arrows} == {"before", "after"}
    assert all("pose p" in name and "error" in name for shape in arrows for name in shape["names"])


def test_a_gross_error_is_named_by_the_row_of_its_own_sensors_file(made):
    cell = simulate("scorbot_er7", kind="stripe+camera", poses=5, points=6, seed=1).dataset
    corner = int(cell.sensors[1].rows[3])
    table = gross_table(replace(made["explained"], dataset=cell, outliers=np.array([2, corner])))
    assert [row[-2:] for row in table.rows] == [("points.csv", "3"), ("corners.csv", "4")]


def test_the_page_of_several_sessions_draws_what_each_tracker_saw_in_the_base_frame():
    """Each tracker stands elsewhere, and each session has a tool of its own."""
    robot = find_robot("scorbot_er7")
    made = simulate(
        robot, kind="point", poses=8, noise=Noise(point_m=2e-5), options=CellOptions(sessions=2), seed=3
    ).dataset
    apart = replace(made, sessions=replace(made.sessions, own=("base.*", "tool.*")))
    found = examine(apart, [], seed=1)
    assert "base.x@session-2" in found.model.parameters.names
    assert page(found)
    drawn = CellPoses(found.model, found.x)
    reach = np.linalg.norm(apart.flange()[:, :3, 3], axis=1).max()
    assert np.linalg.norm(drawn.known, axis=1).max() < reach + 0.3
    assert np.linalg.norm(drawn.tip - drawn.flange[:, :3, 3], axis=1).max() < 0.2


@pytest.mark.parametrize("is_held", [False, True])
def test_what_is_called_calibrated_is_what_the_file_calls_so(diagnosis, is_held):
    if is_held:  # without effects, the error is another one once the data set is corrected
        wrong = WrongInput("held_parameter", "camera", "camera", 0.99, {}, 7e-4, diagnosis.gap.after_m)
        gap = replace(diagnosis.gap, calibrated_m=7e-4)
        diagnosis = replace(diagnosis, wrong_input=wrong, gap=gap, outliers=diagnosis.outliers[:0])
    shown = {figure.label: figure.value for figure in figures(diagnosis)}
    assert shown["calibrated"] == millimetres(diagnosis_json(diagnosis)["gap_mm"]["calibrated"] / 1e3)
    assert millimetres(diagnosis.gap.after_m) in shown.values()
    assert ("data set corrected" in shown) == (is_held and not diagnosis.model.effects)


def test_where_no_pose_is_held_out_the_errors_of_the_fit_are_not_shown(diagnosis):
    few = replace(diagnosis, gap=replace(diagnosis.gap, is_held_out=False))
    assert not {"calibrated", "with the effects"} & {figure.label for figure in figures(few)}
    assert "Which errors stand out" in page(diagnosis)
    assert "Which errors stand out" not in page(few)


def test_where_nobody_gave_a_nominal_model_nothing_is_said_to_come_from_one(made):
    diagnosis = made["explained"]
    diagnosis = replace(diagnosis, gap=replace(diagnosis.gap, nominal_m=None))
    assert diagnosis_json(diagnosis)["gap_mm"]["nominal"] is None
    (nominal,) = [figure for figure in figures(diagnosis) if figure.label == "nominal model"]
    assert (nominal.value, nominal.share) == ("none", None)
    assert next(step.label for step in steps(diagnosis)) == "parameters fitted"
    assert "There is no nominal model" in page(diagnosis)
