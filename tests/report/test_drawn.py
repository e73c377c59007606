"""Pages as they are drawn: by Vega without a browser, and in a real one where it is installed."""

import shutil

import pytest
from calibrated import KINDS
from compared import judged, pair
from diagnosed import MADE
from page_claims import titled

from robolaser.report.calibration import page as calibration_page
from robolaser.report.comparison import page as comparison_page
from robolaser.report.diagnosis import page as diagnosis_page

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
MARKS = ".mark-symbol path, .mark-line path, .mark-rule line, .mark-rect path"


def compared():
    comparison = pair()
    return comparison_page(comparison, judged(comparison))


PAGES = {
    "calibration": lambda: calibration_page(KINDS["stripe"]()),
    "diagnosis": lambda: diagnosis_page(MADE["explained"]()),
    "comparison": compared,
}


@pytest.fixture(scope="module")
def pages():
    return {name: make() for name, make in PAGES.items()}


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


@pytest.fixture
def shown(browser, pages, tmp_path):
    """Opens a page; gives it and what the browser complained of."""

    def opened(name, **look):
        (tmp_path / "page.html").write_text(pages[name], encoding="utf-8")
        tab = browser.new_page(**look)
        complaints = []
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on("request", lambda one: one.url.startswith("http") and complaints.append(one.url))
        tab.goto((tmp_path / "page.html").as_uri())
        tab.wait_for_function(
            "document.querySelectorAll('.plot svg').length == document.querySelectorAll('.plot').length"
        )
        return tab, complaints

    return opened


pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]


@pytest.mark.parametrize("name", PAGES)
def test_a_browser_draws_every_chart_without_a_complaint_and_within_a_phones_width(name, shown):
    tab, complaints = shown(name, viewport={"width": 390, "height": 800}, color_scheme="dark")
    assert not complaints
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    for plot in tab.query_selector_all(".plot"):
        assert plot.query_selector_all(MARKS)


def test_a_mark_says_its_pose_under_the_pointer(shown):
    tab, _ = shown("calibration")
    figure = tab.locator("figure.chart", has_text="Errors of each pose")
    figure.locator(".mark-symbol path").first.hover()
    tab.wait_for_selector("#under-pointer:not([hidden])")
    assert "pose: p" in tab.inner_text("#under-pointer")


def test_a_click_on_the_legend_fades_the_other_series(shown):
    tab, _ = shown("calibration")
    figure = tab.locator("figure.chart", has_text="Errors of each pose")
    before = figure.inner_html()
    figure.locator(".role-legend-label text", has_text="held out").click()
    tab.wait_for_function("([figure, before]) => figure.innerHTML != before", arg=[figure.element_handle(), before])
    assert 'opacity="0.06"' in figure.inner_html()


def test_without_scripts_every_chart_is_said_in_a_sentence(browser, pages, tmp_path):
    (tmp_path / "page.html").write_text(pages["diagnosis"], encoding="utf-8")
    tab = browser.new_context(java_script_enabled=False).new_page()
    tab.goto((tmp_path / "page.html").as_uri())
    text = tab.content()
    for spec in titled(pages["diagnosis"]).values():
        assert spec["description"].split(",")[0] in text.replace("−", "-")
