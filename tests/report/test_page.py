"""What the page of a calibration promises to whoever opens it."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from calibrated import arm, point, stripe

from robolaser.report import write_report
from robolaser.report.evidence import Evidence
from robolaser.report.page import page
from robolaser.report.words import command, judgement

HOSTILE = "<script>alert('$x_$')</script> & \"quotes\" $\\frac$ 測定\x07"
VOID = {"meta", "link", "br", "img", "hr", "input"}


class Reader(HTMLParser):
    """Collects what matters of a page."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.links, self.ids, self.texts = [], [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.links += [
            value for name, value in attrs if name in ("src", "href", "xlink:href", "srcset", "action", "data")
        ]
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture(scope="session")
def pages(calibrations):
    return {kind: page(one) for kind, one in calibrations.items()}


@pytest.fixture(params=["stripe", "point", "socket"])
def text(request, pages):
    return pages[request.param]


def test_the_page_needs_nothing_from_elsewhere(text):
    read = Reader(text)
    assert all(link.startswith(("#", "data:")) for link in read.links)
    assert not re.search(r"url\((?!#)|@import", text)
    assert not [tag for tag, _ in read.tags if tag in ("script", "iframe", "object", "embed")]
    assert not re.findall(r"https?://(?!www\.w3\.org/)", text)


def test_every_element_is_closed_and_every_id_its_own(text):
    read = Reader(text)
    assert not read.open
    assert len(set(read.ids)) == len(read.ids)
    for link in read.links:
        assert not link.startswith("#") or link[1:] in read.ids


def test_every_picture_is_sound_and_says_what_it_shows(text):
    pictures = re.findall(r"<svg role.*?</svg>", text, flags=re.DOTALL)
    assert len(pictures) >= 3
    for picture in pictures:
        root = ET.fromstring(picture.replace("<svg ", '<svg xmlns:xlink="http://www.w3.org/1999/xlink" ', 1))
        assert len(root.get("aria-label")) > 20
    assert text.count("<figcaption>") == len(pictures)


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
    assert command(Evidence(stripe(robot=arm(), effects=("joint_offset:bend",)))).endswith("--with joint_offset:bend")
