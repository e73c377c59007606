"""Whether the errors look like noise."""

import numpy as np

from robolaser.arrays import Array
from robolaser.report.chart import FITTED, HELD_OUT, NOISE, Chart, chart, colours, hover, layer, line, quantity, records
from robolaser.report.error_analysis import ErrorAnalysis

BINS = 40
DRAWN = 40_000  # errors of noise, for a smooth curve


def distribution(analysis: ErrorAnalysis) -> Chart | None:
    """Lengths of the errors beside those that known noise would make."""
    times = max(1, DRAWN // len(analysis.fitted_mm))
    noise = analysis.drawn_noise_mm(times, np.random.default_rng(0))
    of = {"noise alone": noise, "fitted": analysis.fitted_mm, "held out": analysis.held_out_mm}
    errors = {name: part for name, part in of.items() if part is not None}
    everything = np.concatenate(list(errors.values()))
    everything = everything[everything > 0]
    if not len(everything):
        return None
    low, high = np.percentile(everything, 0.5), everything.max()
    edges = np.geomspace(max(low, high * 1e-6) * 0.8, high * 1.25, BINS)
    bins = {name: _bins(part, edges, name) for name, part in errors.items()}
    x = quantity("from", "error of a point [mm]", log=True, domain=(edges[0], edges[-1]))
    encoding = {
        "x": x,
        "y": quantity("share", "share of the points [%]") | {"stack": None},
        "color": colours({name: {"noise alone": NOISE, "fitted": FITTED, "held out": HELD_OUT}[name] for name in bins}),
    }
    said = hover("series", **{"from": "from [mm]", "to": "to [mm]", "share": "share of the points [%]"})
    layers = []
    if "noise alone" in bins:
        area = {"type": "area", "interpolate": "step-after", "opacity": 0.35, "clip": True}
        layers.append(layer(area, bins["noise alone"], **encoding))
    lines = [row for name in bins for row in bins[name]]
    reading = (
        "Grey: what the known noise alone would make of points like these. If the curves extend beyond it to the"
        " right, there is another source of error; a small separate peak is a few gross errors."
        if "noise alone" in bins
        else "No noise is known to compare with. One smooth peak is a good sign; a small separate one is a few gross"
        " errors."
    )
    return chart(
        "Errors against noise",
        f"How large the errors of single points are. {reading}",
        "Histograms of the error lengths, fitted and held out, beside those of noise.",
        [*layers, layer(line(step=True, strokeWidth=1.6), lines, tooltip=said, **encoding)],
    )


def _bins(errors: Array, edges: Array, name: str) -> list[dict[str, float]]:
    share = np.histogram(errors, edges)[0] / len(errors) * 100
    return records(**{"from": edges, "to": np.append(edges[1:], np.nan), "share": np.append(share, 0), "series": name})
