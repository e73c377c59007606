"""Charts in Vega-Lite's language as a notebook draws them: one specification, without the page's style sheet."""

import json
import re
from collections.abc import Sequence
from importlib import resources
from textwrap import wrap
from typing import Any, Final

from markupsafe import escape

from robolaser.report.chart import CONFIG, INK, PAPER, SWITCH, ZOOM, Chart, Spec
from robolaser.report.printable import printable
from robolaser.report.still_chart import WIDTH, still

STYLE: Final = "report/templates/style.css"
SCHEMA: Final = "https://vega.github.io/schema/vega-lite/v5.json"
"""What JupyterLab and its kin draw."""
WIDTH_PX, LETTERS = 560, 95
"""Of a chart, and of a line below its title."""


def notebook_spec(charts: Sequence[Chart]) -> Spec:
    """Charts one below the other, in the colours of a page by day."""
    drawn = [
        {
            "title": {"text": chart.title, "anchor": "start", "subtitle": wrap(chart.caption, LETTERS)},
            "width": WIDTH_PX,
            **{key: _own(chart.spec[key], number, chart.spec["height"]) for key in ("description", "height", "layer")},
        }
        for number, chart in enumerate(charts)
    ]
    apart = {"scale": {"color": "independent"}, "legend": {"color": "independent"}}
    look = CONFIG | {"background": PAPER}
    whole = {"$schema": SCHEMA, "vconcat": drawn, "resolve": apart, "config": look}
    spec: Spec = json.loads(by_day(json.dumps(whole)))
    return spec


def notebook_svg(charts: Sequence[Chart]) -> str:
    """The same as one still picture."""
    parts, top = [], 0.0
    for chart in charts:
        title = f'<text x="4" y="{top + 16}" font-family="sans-serif" fill="{INK}">{escape(chart.title)}</text>'
        size = f'<svg y="{top + 24}" width="{WIDTH}" height="{chart.spec["height"]}" '
        parts += [title, str(still(chart)).replace("<svg ", size, 1)]
        top += chart.spec["height"] + 40
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{top}">'
    paper = f'<rect width="100%" height="100%" fill="{PAPER}"/>'
    return printable(by_day("".join([head, paper, *parts, "</svg>"])))


def by_day(text: str) -> str:
    """The text with the colours that the style sheet's variables have by day."""
    sheet = (resources.files("robolaser") / STYLE).read_text(encoding="utf-8").partition("}")[0]
    colours = dict(re.findall(r"(--[\w-]+): (#\w+);", sheet))
    return re.sub(r"var\((--[\w-]+)\)", lambda named: colours[named[1]], text)


def _own(part: Any, number: int, height: float) -> Any:
    """A part of a chart's specification with its selections named apart, and its size in place of its signals."""
    if isinstance(part, list):
        return [_own(one, number, height) for one in part]
    if not isinstance(part, dict):
        return part
    made = {key: value if key == "values" else _own(value, number, height) for key, value in part.items()}
    for key in made.keys() & {"name", "param"}:
        made[key] = f"{made[key]}_{number}" if made[key] in (SWITCH["name"], ZOOM["name"]) else made[key]
    if "expr" in made:
        made["expr"] = re.sub(r"\bheight\b", f"{height}", re.sub(r"\bwidth\b", f"{WIDTH_PX}", made["expr"]))
    return made
