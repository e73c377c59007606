"""What `calibrate`, `diagnose` and `compare` give in Python: results that print, show, tabulate and save themselves."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final, Protocol, final

if TYPE_CHECKING:
    import pandas as pd

EXPORTED: Final = (
    "robot.urdf", "robot_corrected.urdf", "camera.yaml", "static_transform.sh", "easy_handeye2.calib",
    "robot_corrected.xml", "robot_corrected.sdf", "corrected.py",
)  # fmt: skip
"""What a calibration leaves for other programs."""
CALIBRATION_FILES: Final = ("calibration.json", "report.html", *EXPORTED)
DIAGNOSIS_FILES: Final = ("diagnosis.json", *CALIBRATION_FILES)
VEGA_LITE: Final = "application/vnd.vegalite.v5+json"


@final
@dataclass(frozen=True)
class Plots:
    """Charts of a result; a notebook shows them.

    Attributes:
        titles: What each is called.
        html: All of them with their captions, drawn as SVG: it needs neither scripts nor a network.
        spec: All of them in Vega-Lite's language; a notebook that knows it draws them to be zoomed and pointed at.
        svg: All of them without captions, for a notebook that does not.
    """

    titles: tuple[str, ...]
    html: str
    spec: dict[str, Any]
    svg: str

    def __repr__(self) -> str:
        """Their titles, a line each."""
        return "\n".join(self.titles)

    def _repr_html_(self) -> str:
        return self.html

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        return {VEGA_LITE: self.spec, "image/svg+xml": self.svg, "text/plain": repr(self)}  # HTML would be preferred


class Looks(Protocol):
    """What shows results, a module above all that make them."""

    def dict_of(self, result: "Result") -> dict[str, Any]: ...  # noqa: D102 - as the methods of a result

    def frame_of(self, result: "Result") -> "pd.DataFrame": ...  # noqa: D102

    def save(self, result: "Result", folder: Path) -> None: ...  # noqa: D102

    def report(self, result: "Result", path: Path) -> None: ...  # noqa: D102

    def plots_of(self, result: "Result", title: str) -> Plots: ...  # noqa: D102

    def summary_of(self, result: "Result") -> str: ...  # noqa: D102

    def html_of(self, result: "Result") -> str: ...  # noqa: D102


class Result:
    """A result.

    Attributes:
        looks: Loads what shows results, when a result is asked for its looks; the package says what that is.
    """

    looks: ClassVar[Callable[[], Looks]]

    def to_dict(self) -> dict[str, Any]:
        """What its JSON file holds."""
        return Result.looks().dict_of(self)

    def to_frame(self) -> "pd.DataFrame":
        """A row for each parameter of a calibration, effect of a diagnosis, or run of a comparison."""
        return Result.looks().frame_of(self)

    def save(self, folder: str | Path) -> None:
        """Write the files that the command of this name writes.

        Raises:
            OutputError: The folder cannot be written to, or holds a file of such a name that is no earlier result.
        """
        Result.looks().save(self, Path(folder))

    def report(self, path: str | Path) -> None:
        """Write the report, one HTML page.

        Raises:
            OutputError: The file cannot be written.
        """
        Result.looks().report(self, Path(path))

    def plot(self, title: str = "") -> Plots:
        """The charts of the report.

        Args:
            title: Only those whose title has these words; all of them by default.

        Raises:
            UsageError: There is none of that title, or this result was read back from files, which hold no charts.
        """
        return Result.looks().plots_of(self, title)

    def __str__(self) -> str:
        """The summary that the command prints."""
        return Result.looks().summary_of(self)

    def __repr__(self) -> str:
        """The summary, too: what a person sees who names a result at a prompt."""
        return str(self).rstrip("\n")

    def _repr_html_(self) -> str:
        return Result.looks().html_of(self)
