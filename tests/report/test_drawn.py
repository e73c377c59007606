"""Pages as they are drawn: by Vega without a browser, and in a real one where it is installed."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from calibrated import KINDS
from compared import judged, pair
from diagnosed import MADE
from page_claims import scenes, titled
from PIL import Image

from robolaser.report.calibration.page import document as calibration_document
from robolaser.report.chart import FITTED
from robolaser.report.comparison.page import document as comparison_document
from robolaser.report.diagnosis.page import document as diagnosis_document
from robolaser.report.document import Document, Section
from robolaser.report.page import render
from robolaser.report.scene import Scene, dots

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
MARKS = ".mark-symbol path, .mark-line path, .mark-rule line, .mark-rect path"


def compared():
    comparison = pair()
    return comparison_document(comparison, judged(comparison))


def scanned():
    shapes = [dots(np.random.default_rng(0).uniform(size=(200, 3)), FITTED, size=2.0)]
    return Document("cloud", "scanned", "", "Points.", "", [], [Section("Cloud", [Scene("t", "c", "a", shapes)])])


PAGES = {
    "calibration": lambda: calibration_document(KINDS["stripe"]()),
    "diagnosis": lambda: diagnosis_document(MADE["explained"]()),
    "comparison": compared,
    "scan": scanned,
}


@pytest.fixture(scope="module")
def pages():
    return {name: render(make()) for name, make in PAGES.items()}


@pytest.mark.parametrize("name", PAGES)
def test_vega_draws_every_chart(name, pages):
    vega = pytest.importorskip("vl_convert")
    for title, spec in titled(pages[name]).items():
        svg = vega.vegalite_to_svg(spec | {"width": 500})
        assert svg.count("<path") > 5, title
        assert "NaN" not in svg, title


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api")
    if BROWSER is None:
        pytest.skip("no browser is installed")
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox", "--disable-gpu"])
        yield opened
        opened.close()


@pytest.fixture(scope="module")
def shown(browser, pages, tmp_path_factory):
    """Opens a page; gives it and what the browser complained of."""

    def opened(name, **look):
        file = tmp_path_factory.mktemp(name) / "page.html"
        file.write_text(pages[name], encoding="utf-8")
        tab = browser.new_page(**look)
        complaints = []
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on("request", lambda one: one.url.startswith("http") and complaints.append(one.url))
        tab.goto(file.as_uri())
        tab.wait_for_function(
            "document.querySelectorAll('.plot svg').length == document.querySelectorAll('.plot').length"
        )
        return tab, complaints

    return opened


@pytest.fixture(scope="module")
def calibration(shown):
    return shown("calibration")[0]


@pytest.fixture(scope="module")
def diagnosis(shown):
    return shown("diagnosis")


pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]


@pytest.mark.parametrize("name", PAGES)
def test_a_browser_draws_every_chart_without_a_complaint_and_within_a_phones_width(name, shown):
    tab, complaints = shown(name, viewport={"width": 390, "height": 800}, color_scheme="dark")
    assert not complaints
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    assert all(is_drawn(canvas) for canvas in tab.query_selector_all("canvas"))
    for plot in tab.query_selector_all(".plot"):
        assert plot.query_selector_all(MARKS)
    widths = tab.eval_on_selector_all(".stacked tbody th", "heads => heads.map(head => head.offsetWidth)")
    assert all(width == 0 or width > 130 for width in widths)  # names are not squeezed by long values


def is_drawn(canvas):
    """Does a canvas show some hundred pixels that are not empty?"""
    pixels = "c.getContext('2d').getImageData(0, 0, c.width, c.height).data"
    return canvas.evaluate(f"c => {pixels}.filter((v, i) => i % 4 == 3 && v).length") > 300


def drawing(tab):
    return tab.locator("canvas").first.evaluate("c => c.toDataURL()")


def test_a_scene_turns_when_dragged_and_says_what_is_under_the_pointer(diagnosis):
    tab, complaints = diagnosis
    canvas = tab.locator("canvas").first
    canvas.scroll_into_view_if_needed()
    before, box = drawing(tab), canvas.bounding_box()
    tab.mouse.move(box["x"] + 100, box["y"] + 100)
    tab.mouse.down()
    tab.mouse.move(box["x"] + 200, box["y"] + 120)
    tab.mouse.up()
    assert drawing(tab) != before
    for step in range(40, int(box["height"]), 6):
        tab.mouse.move(box["x"] + box["width"] / 2 + step % 30, box["y"] + step)
        if tab.is_visible("#under-pointer"):
            break
    assert tab.inner_text("#under-pointer")
    assert not complaints


def test_errors_grow_with_the_slider_and_each_series_can_be_switched_off(diagnosis):
    tab, _ = diagnosis
    seen = [drawing(tab)]
    tab.locator(".controls input[type=range]").fill("1")
    seen.append(drawing(tab))
    tab.locator(".controls label", has_text="before").locator("input").uncheck()
    seen.append(drawing(tab))
    assert len(set(seen)) == 3


def test_a_click_on_a_mark_shows_its_pose_and_its_image_in_the_scene(browser, shown, pages, tmp_path):
    calibration = KINDS["stripe"]()
    dataset = calibration.model.dataset
    (tmp_path / "images").mkdir()
    for name in dataset.poses.names:
        Image.new("L", dataset.image_px, 60).save(tmp_path / "images" / f"{name}.png")
    images = tuple(f"images/{name}.png" for name in dataset.poses.names)
    dataset = replace(dataset, folder=tmp_path, poses=replace(dataset.poses, image=images))
    made = replace(calibration, model=replace(calibration.model, dataset=dataset))
    pages["with images"] = render(calibration_document(made))
    tab, complaints = shown("with images")
    tab.locator("figure.chart", has_text="Errors of each pose").locator(".mark-symbol path").nth(3).click()
    assert tab.locator("figure.scene select").input_value() == "pose p3"
    assert tab.locator(".photo img").get_attribute("alt") == "Image of pose p3"
    assert tab.locator(".photo img").evaluate("image => image.decode().then(() => image.naturalWidth)") > 100
    assert (
        tab.locator(".photo circle").count() == tab.locator(".photo line").count() == (dataset.points.pose == 3).sum()
    )
    line = tab.locator(".photo line").first
    ends = []
    for step in ("-1", "0", "1"):
        tab.locator(".controls input[type=range]").fill(step)
        ends.append(line.evaluate("one => Math.hypot(one.x2.baseVal.value - one.x1.baseVal.value,"
                                  " one.y2.baseVal.value - one.y1.baseVal.value)"))  # fmt: skip
    assert ends == pytest.approx([ends[1] / 10, ends[1], ends[1] * 10], rel=1e-3)
    assert not complaints


def test_a_click_on_a_columns_head_sorts_by_it_and_another_turns_the_order_round(calibration):
    section = calibration.locator("section", has=calibration.locator("h2", has_text="Which errors stand out"))
    column = section.locator("tbody td:nth-child(4)")
    head = section.locator("thead button", has_text="fitted")
    for sign in (1, -1):
        head.click()
        errors = [sign * float(text.removesuffix(" mm")) for text in column.all_inner_texts()]
        assert errors == sorted(errors)


def test_a_mark_says_its_pose_under_the_pointer(calibration):
    figure = calibration.locator("figure.chart", has_text="Errors of each pose")
    figure.locator(".mark-symbol path").first.hover()
    calibration.wait_for_selector("#under-pointer:not([hidden])")
    assert "pose: p" in calibration.inner_text("#under-pointer")


def test_a_click_on_the_legend_fades_the_other_series(calibration):
    figure = calibration.locator("figure.chart", has_text="Errors of each pose")
    before = figure.inner_html()
    figure.locator(".role-legend-label text", has_text="held out").click()
    handle = figure.element_handle()
    calibration.wait_for_function("([figure, before]) => figure.innerHTML != before", arg=[handle, before])
    assert 'opacity="0.06"' in figure.inner_html()


def test_without_scripts_every_chart_is_said_in_a_sentence(browser, pages, tmp_path):
    (tmp_path / "page.html").write_text(pages["diagnosis"], encoding="utf-8")
    tab = browser.new_context(java_script_enabled=False).new_page()
    tab.goto((tmp_path / "page.html").as_uri())
    text = tab.content()
    for spec in titled(pages["diagnosis"]).values():
        assert spec["description"].split(",")[0] in text.replace("−", "-")
    assert scenes(pages["diagnosis"])[0]["alt"].split(",")[0] in text
