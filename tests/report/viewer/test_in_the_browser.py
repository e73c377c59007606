"""The scene in a real browser without a screen: it is drawn, and follows what is touched."""

import shutil
import time

import cv2
import numpy as np
import pytest
from scanned import calibrated as made
from scanned import dataset

from robolaser.report.cell_poses import CellPoses
from robolaser.report.viewer.cells import nominal_cell
from robolaser.report.viewer.scene import downsampled
from robolaser.report.viewer.serving import ViewerApp
from robolaser.scan.ply import VERTEX

pytest.importorskip("viser")
playwright = pytest.importorskip("playwright.sync_api")
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
PATIENCE_S = 120.0  # graphics without a card on a busy machine
SIZE = {"width": 640, "height": 420}
SCENE = {"x": 0, "y": 140, "width": 320, "height": 280}  # beside the panel, below the note on slow graphics
CHANGED = 0.003  # share of pixels

pytestmark = [
    pytest.mark.skipif(BROWSER is None, reason="no browser is installed"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]


@pytest.fixture(scope="module")
def app():
    data = dataset()
    calibration = made(data, ["joint_offset:joint_2"], {"joint_offset.joint_2.offset": 0.15})
    cloud = np.zeros(5000, VERTEX)
    cloud["x"], cloud["y"], cloud["z"] = np.random.default_rng(0).uniform(0.2, 0.4, (3, 5000))
    served = ViewerApp((nominal_cell(data), CellPoses(calibration.model, calibration.x)), downsampled(cloud))
    yield served
    served.stop()


@pytest.fixture(scope="module")
def page(app):
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=FLAGS)
        opened = browser.new_page(viewport=SIZE)
        opened.set_default_timeout(1000 * PATIENCE_S)
        opened.wrong = []
        opened.on("pageerror", lambda error: opened.wrong.append(str(error)))
        opened.goto(app.url)
        opened.wait_for_selector("canvas")
        opened.get_by_text("joint_2").wait_for()
        yield opened
        browser.close()


def seen(page):
    return cv2.imdecode(np.frombuffer(page.screenshot(clip=SCENE), np.uint8), cv2.IMREAD_COLOR).astype(int)


def settled(page, unlike=None):
    """The scene once it rests, and differs from another."""
    end, before = time.monotonic() + PATIENCE_S, seen(page)
    while time.monotonic() < end:
        page.wait_for_timeout(150)
        now = seen(page)
        if np.array_equal(now, before) and (unlike is None or differs(now, unlike)):
            return now
        before = now
    raise AssertionError("the scene never rests" if unlike is None else "nothing changed")


def differs(one, other):
    return (np.abs(one - other).max(axis=2) > 20).mean() > CHANGED


def test_the_scene_follows_sliders_switch_and_boxes(page):
    start = settled(page, unlike=np.full((SCENE["height"], SCENE["width"], 3), 255))
    colours = start.reshape(-1, 3)
    assert (colours[:, 2] - colours[:, :2].max(axis=1) > 60).sum() > 30, "no laser"
    assert "root mean square" in page.inner_text("body")

    joint = page.get_by_text("joint_2").locator("xpath=ancestor::*[.//*[@role='slider']][1]")
    joint.locator("input:visible").fill("-20")
    joint.locator("input:visible").press("Enter")
    turned = settled(page, unlike=start)

    page.locator("input[value=calibrated]").first.click()
    page.get_by_role("option", name="nominal").click()
    other = settled(page, unlike=turned)

    page.get_by_text("robot", exact=True).locator("xpath=ancestor::*[.//input][1]").locator("input").click(force=True)
    settled(page, unlike=other)
    assert page.wrong == []
