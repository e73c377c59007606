"""A document as a page: one HTML file with everything a browser needs inside, which can be mailed."""

import json
import re
from functools import cache
from html import unescape
from importlib import resources
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from typing import Final

import jinja2
from markupsafe import Markup

from robolaser.report.chart import CONFIG, Chart
from robolaser.report.document import Charts, Document
from robolaser.report.printable import printable

ASSETS: Final = "report/assets"
FOR_CHARTS: Final = ("vega.min.js", "vega-lite.min.js")
OURS: Final = ("page.js", "charts.js", "scenes.js")
MADE_BY_A_MAP: Final = "//# sourceMappingURL"
CHART: Final = re.compile(
    r'<figure class="chart">\s*<h3>(.*?)</h3>.*?<script type="application/json">(.*?)</script>\s*'
    r"<figcaption>(.*?)</figcaption>",
    re.DOTALL,
)


def render(document: Document, command: str = "") -> str:
    """The document as HTML, with the command that repeats it; all text from data is escaped."""
    names = (*FOR_CHARTS, *OURS) if any(isinstance(one, Charts) for one in document.blocks) else OURS
    scripts = [_script(name) for name in names]
    text = _environment().get_template("document.html").render(document=document, command=command, version=version())
    look = json.dumps(CONFIG, separators=(",", ":"))
    tail = [f'<script type="application/json" id="chart-look">{look}</script>']
    tail += [f"<script>{script}</script>" for script in scripts]
    return printable(text).replace("</body>", "\n".join([*tail, "</body>"]))


def fragment(document: Document) -> str:
    """The answer and the terminal's content, for a notebook."""
    return printable(_environment().get_template("notebook.html").render(document=document))


def charts_in(page: str) -> list[Chart]:
    """The charts of a written page."""
    return [Chart(unescape(title), unescape(caption), json.loads(spec)) for title, spec, caption in CHART.findall(page)]


def version() -> str:
    """The version of robolaser that wrote the page."""
    try:
        return installed("robolaser")
    except PackageNotFoundError:
        return "of a source tree"


def prose(text: str) -> Markup:
    """Text with proper minus signs, and code between backticks."""
    return Markup("").join(
        Markup("<code>{}</code>").format(part) if i % 2 else minus(part) for i, part in enumerate(text.split("`"))
    )


def minus(text: str) -> str:
    """Numbers with a proper minus sign; hyphens between letters stay."""
    return re.sub(r"(?<![\w-])-(?=\d)", "\u2212", text)


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("robolaser", "report/templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"minus": minus, "prose": prose, "kind": lambda block: type(block).__name__.lower()}
    return environment


@cache
def _script(name: str) -> str:
    """A script of this package, without the reference to its absent source map."""
    return (resources.files("robolaser") / ASSETS / name).read_text(encoding="utf-8").partition(MADE_BY_A_MAP)[0]
