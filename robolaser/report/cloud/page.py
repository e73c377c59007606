"""The page a person looks at after a scan: one file that needs nothing else."""

from robolaser.report.cloud.lines import figures, heading
from robolaser.report.page import render
from robolaser.scan import Scan
from robolaser.scan.quality import Quality


def page(scan: Scan, quality: Quality, *, command: str = "") -> str:
    """The page as HTML.

    Args:
        scan: Done.
        quality: Of its cloud.
        command: What to type to repeat it.
    """
    from robolaser.report.cloud.pictures import PICTURES  # noqa: PLC0415 - Matplotlib is slow to import

    return render(
        "cloud.html",
        scan=scan,
        heading=heading(scan),
        lines=list(figures(scan, quality)),
        pictures=[drawn for draw in PICTURES if (drawn := draw(quality)) is not None],
        warnings=(*scan.warnings, *quality.doubts, *map(str, quality.missing)),
        looked_at=len(quality.vertices),
        command=command,
    )
