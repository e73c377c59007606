"""Whether the errors look like noise."""

import numpy as np
from matplotlib.figure import Figure

from robolaser.arrays import Array
from robolaser.report.canvas import FITTED, HELD_OUT, MUTED, NOISE, Picture, picture, plain_log
from robolaser.report.evidence import Evidence

BINS = 40
DRAWN = 200_000  # errors of noise, for a smooth curve


def distribution(evidence: Evidence) -> Picture | None:
    """Lengths of the errors beside those that known noise would make."""
    fitted, held_out = evidence.fitted_mm, evidence.held_out_mm
    noise = _drawn(evidence)
    everything = np.concatenate([part for part in (fitted, held_out, noise) if part is not None])
    everything = everything[everything > 0]
    if not len(everything):
        return None
    low, high = np.percentile(everything, 0.5), everything.max()
    edges = np.geomspace(max(low, high * 1e-6) * 0.8, high * 1.25, BINS)

    def share(errors: Array) -> Array:
        counts: Array = np.histogram(errors, edges)[0] / len(errors) * 100
        return counts

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        ax.set_xscale("log")
        if noise is not None:
            ax.stairs(share(noise), edges, fill=True, color=NOISE, alpha=0.35, label="noise alone")
        ax.stairs(share(fitted), edges, color=FITTED, linewidth=1.5, label="fitted")
        if held_out is not None:
            ax.stairs(share(held_out), edges, color=HELD_OUT, linewidth=1.2, label="held out")
        ax.set_xlim(edges[0], edges[-1])
        ax.set_xlabel("error of a point [mm]")
        ax.set_ylabel("share of the points [%]", color=MUTED)
        plain_log(ax.xaxis)
        figure.legend(loc="outside upper left", ncols=3)

    said = (
        "Grey: what the known noise alone would make of points like these. Where the curves leave the grey hill to the"
        " right, something other than that noise is at work; a far small hill is a few gross errors."
        if noise is not None
        else "No noise is known to compare with. One round hill is a good sign; a far small one is a few gross errors."
    )
    return picture(
        "Errors against noise",
        f"How large the errors of single points are. {said}",
        "Histograms of the error lengths, fitted and held out, beside those of noise.",
        paint,
    )


def _drawn(evidence: Evidence) -> Array | None:
    if evidence.noise is None:
        return None
    times = max(1, DRAWN // len(evidence.noise.sources[0].group))
    drawn = evidence.noise.draw(times, np.random.default_rng(0))
    lengths: Array = 1e3 * np.linalg.norm(drawn, axis=-1).ravel()
    return lengths
