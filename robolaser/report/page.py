"""Pages: templates filled, with everything a browser needs inside; one file that can be mailed."""

import json
import re
from functools import cache
from importlib import resources
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from typing import Any

import jinja2
from markupsafe import Markup

from robolaser.report.chart import CONFIG, Chart
from robolaser.report.printable import printable

ASSETS = "report/assets"
SCRIPTS = ("vega.min.js", "vega-lite.min.js", "draw.js")
MADE_BY_A_MAP = "//# sourceMappingURL"


def render(template: str, **facts: Any) -> str:
    """Fill a template of this package; whatever comes from data is escaped."""
    text: str = _environment().get_template(template).render(version=version(), **facts)
    has_charts = '<figure class="chart">' in text
    scripts = [_script(name) for name in SCRIPTS] if has_charts else []
    look = json.dumps(CONFIG, separators=(",", ":"))
    tail = [f'<script type="application/json" id="chart-look">{look}</script>'] if has_charts else []
    tail += [f"<script>{script}</script>" for script in scripts]
    return printable(text).replace("</body>", "\n".join([*tail, "</body>"]))


def drawn(charts: list[Chart | None]) -> list[Chart]:
    """The charts that have something to show."""
    return [one for one in charts if one is not None]


def version() -> str:
    """The version of robolaser that wrote the page."""
    try:
        return installed("robolaser")
    except PackageNotFoundError:
        return "of a source tree"


def minus(text: str) -> str:
    """Numbers with a proper minus sign; hyphens between letters stay."""
    return re.sub(r"(?<![\w-])-(?=\d)", "\u2212", text)


def code(text: str) -> Markup:
    """Text between backticks as code."""
    parts = text.split("`")
    return Markup("").join(Markup("<code>{}</code>").format(part) if i % 2 else part for i, part in enumerate(parts))


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("robolaser", "report/templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"minus": minus, "code": code}
    return environment


@cache
def _script(name: str) -> str:
    """A script of this package, without the pointer to its source map, which is not there."""
    text = (resources.files("robolaser") / ASSETS / name).read_text(encoding="utf-8")
    return text.partition(MADE_BY_A_MAP)[0]
