"""Charts of a result for a notebook: one Vega-Lite specification without the page's style sheet."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from textwrap import wrap
from typing import Any, Final, final

from robolaser.plugins import extra
from robolaser.report.chart import CONFIG, PAPER, Chart, Spec

STYLE: Final = "report/templates/style.css"
SCHEMA: Final = "https://vega.github.io/schema/vega-lite/v5.json"  # version that JupyterLab and others draw
VEGA_LITE: Final = "application/vnd.vegalite.v5+json"
DRAWN_BY: Final = "5.20"  # version of Vega-Lite that makes still pictures
WIDTH_PX, LETTERS = 560, 95  # of a chart, and of a line below its title


@final
@dataclass(frozen=True)
class Plots:
    """Charts of a result; a notebook shows them.

    Attributes:
        titles: Titles of the charts.
        spec: All of them in Vega-Lite's language; a notebook that supports it draws them interactively.
    """

    titles: tuple[str, ...]
    spec: Spec

    @property
    def svg(self) -> str:
        """All of them as one still picture.

        Raises:
            DependencyMissing: vl-convert is not installed.
        """
        missing = "Still pictures of charts need vl-convert: pip install 'robolaser[notebook]'."
        return str(extra("vl_convert", missing).vegalite_to_svg(self.spec, vl_version=DRAWN_BY))

    def __repr__(self) -> str:
        """Their titles, a line each."""
        return "\n".join(self.titles)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        still = {"image/svg+xml": self.svg} if find_spec("vl_convert") else {}
        return {VEGA_LITE: self.spec, **still, "text/plain": repr(self)}  # HTML would be preferred


def plots(charts: Sequence[Chart]) -> Plots:
    """Charts one below the other, in a page's light colours."""
    drawn = [
        {
            "title": {"text": chart.title, "anchor": "start", "subtitle": wrap(chart.caption, LETTERS)},
            "width": WIDTH_PX,
            **{key: chart.spec[key] for key in ("description", "height", "layer")},
        }
        for chart in charts
    ]
    apart = {"scale": {"color": "independent"}, "legend": {"color": "independent"}}
    look = CONFIG | {"background": PAPER}
    width = [{"name": "width", "value": WIDTH_PX}]  # for scales of equal axes
    whole = {"$schema": SCHEMA, "params": width, "vconcat": drawn, "resolve": apart, "config": look}
    return Plots(tuple(chart.title for chart in charts), json.loads(_by_day(json.dumps(whole))))


def _by_day(text: str) -> str:
    """The text with the light colours of the style sheet's variables."""
    sheet = (resources.files("robolaser") / STYLE).read_text(encoding="utf-8").partition("}")[0]
    colours = dict(re.findall(r"(--[\w-]+): (#\w+);", sheet))
    return re.sub(r"var\((--[\w-]+)\)", lambda named: colours[named[1]], text)
