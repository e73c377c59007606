"""The picture of the page that explains a report: a diagnosis with a number at each section, as a browser shows it.

Run from the repository's root: .venv/bin/python docs/pictures/report.py, with Chromium installed.
"""

import re
import shutil
import tempfile
from contextlib import chdir
from itertools import count
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from robolaser.cli import main

PICTURE = Path(__file__).resolve().with_name("report.png")
EFFECT, NOISE = "encoder_eccentricity:joint_2=1e-3", "3e-5"
SIMULATED = ["simulate", "--robot", "scorbot_er7", "--sensor", "point", "--poses", "12", "--seed", "3"]
MARK = (
    '<span style="display:inline-block;width:1.7em;height:1.7em;line-height:1.7em;border-radius:50%;text-align:center;'
    'background:#c0492b;color:#fff;font:bold 0.9rem/1.7em sans-serif;margin-right:0.5em">{}</span>'
)
WIDTH, COLOURS = 1180, 128


def marked(html: str) -> str:
    """The page with its title and sections numbered."""
    numbers = count(1)
    return re.sub(r"(<h[12][^>]*>)", lambda heading: heading[1] + MARK.format(next(numbers)), html)


def photographed(page: Path, picture: Path) -> None:
    """The whole page, once its charts and its scene are drawn, in as many colours as a drawing needs."""
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": WIDTH, "height": 900})
        tab.goto(page.as_uri())
        tab.wait_for_timeout(4000)
        tab.screenshot(path=picture, full_page=True)
        browser.close()
    Image.open(picture).convert("RGB").quantize(COLOURS).save(picture, optimize=True)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        main([*SIMULATED, "--effect", EFFECT, "--point-m", NOISE, "--quiet", "--output", "arm"])
        main(["diagnose", "arm", "--output", "why", "--quiet"])
        page = Path(folder, "why", "report.html")
        page.write_text(marked(page.read_text(encoding="utf-8")), encoding="utf-8")
        photographed(page, PICTURE)
