"""The page of a scan: one file that needs nothing else."""

from robolaser.report.cloud.charts import CHARTS
from robolaser.report.cloud.figures import figures, heading
from robolaser.report.page import drawn, render
from robolaser.scan import Scan
from robolaser.scan.quality import Quality


def page(scan: Scan, quality: Quality, *, command: str = "") -> str:
    """The page as HTML.

    Args:
        scan: Done.
        quality: Of its cloud.
        command: What to type to repeat it.
    """
    return render(
        "cloud.html",
        scan=scan,
        heading=heading(scan),
        lines=list(figures(scan, quality)),
        charts=drawn([make(quality) for make in CHARTS]),
        warnings=(*scan.warnings, *quality.doubts, *map(str, quality.missing)),
        looked_at=len(quality.vertices),
        command=command,
    )
