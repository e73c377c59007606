"""The report of a scan."""

from robolaser.report.cloud.charts import CHARTS
from robolaser.report.cloud.figures import figures, heading
from robolaser.report.cloud.scene import cloud_scene
from robolaser.report.digits import millimetres
from robolaser.report.document import Block, Document, Figures, Notes, Section, Text, charts
from robolaser.report.page import render
from robolaser.scan import Scan
from robolaser.scan.quality import Quality

READING = (
    "A point's `std` in the cloud is how far noise moves it, by the calibration's noise model; what that model did not"
    " explain counts as noise of the joints. Errors that neighbours share do not show in the scatter, but they do on"
    " bodies of known size."
)


def document(scan: Scan, quality: Quality, *, command: str = "") -> Document:
    """The report.

    Args:
        scan: Done.
        quality: Of its cloud.
        command: What to type to repeat it.
    """
    warnings = (*scan.warnings, *quality.doubts, *map(str, quality.missing))
    lines, counts = figures(scan, quality), scan.cloud.counts
    used = f"{len(quality.vertices)} of {counts.points} points, evenly taken, were used for these figures."
    left_out: list[Block] = [Text(used, "quiet")] if len(quality.vertices) < counts.points else []
    scene = cloud_scene(quality)
    return Document(
        scan.recording.name,
        "scanned",
        heading(scan),
        lead(quality),
        "",
        [Figures(lines), Text(READING, "quiet")],
        [
            Section("Warnings", [Notes(warnings, "warnings")] if warnings else []),
            Section("The cloud", [*([scene] if scene else []), *charts([make(quality) for make in CHARTS]), *left_out]),
        ],
        command=command,
    )


def lead(quality: Quality) -> str:
    """How far noise moves the points."""
    if quality.scatter_m != quality.scatter_m:  # NaN
        return "How far noise moves the points is not known."
    return f"Noise moves half of the points by less than {millimetres(quality.scatter_m)}."


def page(scan: Scan, quality: Quality, *, command: str = "") -> str:
    """The page as HTML.

    Args:
        scan: Done.
        quality: Of its cloud.
        command: What to type to repeat it.
    """
    return render(document(scan, quality, command=command))
