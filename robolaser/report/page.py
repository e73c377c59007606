"""A document as a page: one HTML file with everything a browser needs inside, which can be mailed."""

import base64
import hashlib
import json
import re
from collections.abc import Sequence
from functools import cache
from importlib import resources
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from typing import Final

import jinja2
from markupsafe import Markup

from robolaser.report.chart import CONFIG, Chart
from robolaser.report.document import Block, Charts, Document
from robolaser.report.notebook_charts import by_day
from robolaser.report.printable import printable
from robolaser.report.scene import Scene
from robolaser.report.still_chart import still as still_chart
from robolaser.report.still_scene import still as still_scene

ASSETS: Final = "report/assets"
FOR_CHARTS: Final = ("vega.min.js", "vega-lite.min.js", "vega-interpreter.js")
OURS: Final = ("page.js", "charts.js", "scenes.js")
MADE_BY_A_MAP: Final = "//# sourceMappingURL"
POLICY: Final = "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; style-src 'unsafe-inline'"
"""What a page may do: nothing from elsewhere, no code but its own scripts, which are named by their hashes."""


def render(document: Document) -> str:
    """The document as HTML; whatever comes from data is escaped."""
    names = (*FOR_CHARTS, *OURS) if any(isinstance(one, Charts) for one in document.blocks) else OURS
    scripts = [_script(name) for name in names]
    hashes = " ".join(f"'sha256-{_hash(name)}'" for name in names)
    sections = [section for section in document.sections if section.blocks]
    text: str = (
        _environment()
        .get_template("document.html")
        .render(document=document, sections=sections, version=version(), policy=f"{POLICY}; script-src {hashes}")
    )
    look = json.dumps(CONFIG, separators=(",", ":"))
    tail = [f'<script type="application/json" id="chart-look">{look}</script>']
    tail += [f"<script>{script}</script>" for script in scripts]
    return printable(text).replace("</body>", "\n".join([*tail, "</body>"]))


def fragment(document: Document) -> str:
    """The answer and what a terminal would show, for a notebook."""
    text: str = _environment().get_template("notebook.html").render(document=document)
    return printable(text)


def stills(charts: Sequence[Chart]) -> str:
    """Charts for a notebook: SVG on white, in the colours of a page by day."""
    text: str = _environment().get_template("stills.html").render(charts=charts)
    return printable(by_day(text))


def version() -> str:
    """The version of robolaser that wrote the page."""
    try:
        return installed("robolaser")
    except PackageNotFoundError:
        return "of a source tree"


def prose(text: str) -> Markup:
    """Text with proper minus signs, and what stands between backticks as code."""
    parts = text.split("`")
    return Markup("").join(
        Markup("<code>{}</code>").format(part) if i % 2 else minus(part) for i, part in enumerate(parts)
    )


def minus(text: str) -> str:
    """Numbers with a proper minus sign; hyphens between letters stay."""
    return re.sub(r"(?<![\w-])-(?=\d)", "\u2212", text)


def _still(shown: Chart | Scene) -> Markup:
    return still_scene(shown) if isinstance(shown, Scene) else still_chart(shown)


def _kind(block: Block) -> str:
    return type(block).__name__.lower()


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("robolaser", "report/templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"minus": minus, "prose": prose, "kind": _kind, "still": _still}
    return environment


@cache
def _script(name: str) -> str:
    """A script of this package, without the pointer to its source map, which is not there."""
    text = (resources.files("robolaser") / ASSETS / name).read_text(encoding="utf-8")
    return text.partition(MADE_BY_A_MAP)[0]


@cache
def _hash(name: str) -> str:
    return base64.b64encode(hashlib.sha256(_script(name).encode()).digest()).decode()
