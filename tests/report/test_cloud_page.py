"""What the page of a cloud predicts to whoever opens it."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from page_claims import HOSTILE, Reader, hovered, is_whole, sound_charts, titled

sys.path.insert(0, str(Path(__file__).parents[1] / "scan"))

from scanned import calibrated, dataset, line_centres, recorded, written

from robolaser.report.cloud import document, figures
from robolaser.report.console import printed
from robolaser.report.page import render
from robolaser.scan import prepare, read_calibration
from robolaser.scan.ply import VERTEX
from robolaser.scan.quality import measure


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    data = replace(dataset(poses=6), name=HOSTILE.replace("\x07", ""))
    scanner = read_calibration(written(calibrated(data), folder / "calibration"))
    made = prepare(scanner, recorded(data, folder / "recording", line_centres(data, per_pose=50)))
    for _ in made.cloud.pieces():
        pass
    return replace(made, warnings=("<b>beware</b>",))


def flat(count=2000):
    rng = np.random.default_rng(0)
    out = np.zeros(count, VERTEX)
    out["x"], out["y"], out["z"] = rng.uniform(0, 0.2, (3, count)) * [[1], [1], [0]] + rng.normal(0, 1e-4, (3, count))
    out["std"] = 1e-4
    return out


def without_std(vertices):
    vertices["std"] = np.nan
    return vertices


QUALITIES = {
    "flat": lambda: measure(flat(), plane=True),
    "unmeasured": lambda: measure(flat()),
    "unknown scatter": lambda: measure(without_std(flat())),
    "one point": lambda: measure(flat(1)),
}


@pytest.fixture(scope="module")
def pages(scan):
    return {name: render(document(scan, make()), HOSTILE) for name, make in QUALITIES.items()}


@pytest.fixture(params=QUALITIES)
def text(request, pages):
    return pages[request.param]


def test_the_page_is_whole(text):
    is_whole(text)


def test_every_chart_is_sound_and_says_what_it_shows(pages):
    drawn = {name: len(sound_charts(text)) for name, text in pages.items()}
    assert drawn == {"flat": 2, "unmeasured": 1, "unknown scatter": 1, "one point": 0}


def test_a_map_says_heights_under_the_pointer_and_stays_within_four_thousand_cells(pages):
    (layer,) = titled(pages["flat"])["Heights"]["layer"]
    assert hovered(titled(pages["flat"])["Heights"]) == {"x", "y", "value"}
    assert 100 < layer["data"]["values"].count("\n") < 4_000


@pytest.mark.parametrize("name", QUALITIES)
def test_the_terminal_says_what_the_page_says(scan, pages, name):
    brief = document(scan, QUALITIES[name](), brief=True)
    words = " ".join(printed(brief).split())
    shown = " ".join(" ".join(Reader(pages[name]).texts).split())
    lines = list(figures(scan, QUALITIES[name]()))
    assert len(lines) >= 2
    for text in (brief.setting, *(text for line in lines for text in (line.label, line.value, line.remark))):
        assert " ".join(text.split()) in words
        assert " ".join(text.split()) in shown.replace("\u2212", "−")
    assert f"{scan.cloud.counts.points} points" in words
    assert "nan" not in words
