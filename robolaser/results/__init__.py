"""Results of `calibrate`, `diagnose` and `compare` in Python: they print, show, tabulate and save themselves."""

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final

from robolaser.bounded_reading import read_text
from robolaser.calibration.saved import FILES, numbers_of
from robolaser.data.result_folder import json_text, results_in, write_results, write_text
from robolaser.errors import UsageError, near
from robolaser.report.console import print_document, printed
from robolaser.report.document import Charts, Document
from robolaser.report.page import charts_in, fragment
from robolaser.report.plots import Plots, plots
from robolaser.results.difference import Difference, between
from robolaser.robot.kinematics import Robot

if TYPE_CHECKING:
    import pandas as pd

PAGE: Final = "report.html"
FINDING: Final = [
    "effect", "where", "probability", "parameters", "gap_mm_before", "gap_mm_after", "gap_mm_without",
    "indistinguishable_from",
]  # fmt: skip
Files = Mapping[str, str | None]


class Record(dict[str, Any]):
    """A dictionary whose entries are attributes, too."""

    def __init__(self, contents: Mapping[str, Any]) -> None:
        super().__init__({key: _recorded(value) for key, value in contents.items()})

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"No '{name}'.{near(name, self)}") from None

    def __dir__(self) -> list[str]:
        """Methods and entries, for completion at a prompt."""
        return [*super().__dir__(), *filter(str.isidentifier, self)]


class Result(ABC):
    """A result.

    Attributes:
        command: The command that writes such results.
    """

    command: ClassVar[str]

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The contents of its JSON file."""

    @abstractmethod
    def to_frame(self) -> "pd.DataFrame":
        """A row for each parameter of a calibration, effect of a diagnosis, or run of a comparison."""

    @abstractmethod
    def files(self, *, command: str = "") -> Files:
        """The files of the result by name; None for one that this result does not have.

        Args:
            command: The command line that repeats it.
        """

    @abstractmethod
    def _document(self, *, brief: bool) -> Document | None:
        """The report; None for a loaded result."""

    def __str__(self) -> str:
        """The summary that the command prints."""
        document = self._document(brief=True)
        return self._read_back() if document is None else printed(document)

    def _read_back(self) -> str:
        return str(self.to_frame().to_string())

    def print(self, folder: Path) -> None:
        """Print the summary, in colour on a terminal, and the path of a saved report."""
        if document := self._document(brief=True):
            print_document(document, folder)

    def save(self, folder: str | Path) -> None:
        """Write the files of the command.

        Raises:
            OutputError: The folder cannot be written to, or a file of that name is not an earlier result.
        """
        files, path = self.files(), Path(folder)
        with results_in(path, command=self.command, files=list(files), force=True) as claim:
            write_results(path, {**dict.fromkeys(claim(())), **files})

    def report(self, path: str | Path) -> None:
        """Write the report, one HTML page.

        Raises:
            OutputError: The file cannot be written.
        """
        write_text(Path(path), self.files().get(PAGE) or f"<!doctype html><meta charset=utf-8>{self._repr_html_()}")

    def plot(self, *titles: str) -> Plots:
        """The charts of the report.

        Args:
            titles: Select charts by the beginnings of words in their titles, such as an effect and a joint:
                `plot("backlash", "elbow_joint")`; default: all.

        Raises:
            UsageError: No title matches.
        """
        document = self._document(brief=False)
        if document is None:
            known = charts_in(self.files().get(PAGE) or "")
        else:
            known = [chart for block in document.blocks if isinstance(block, Charts) for chart in block.charts]
        patterns = [re.compile(rf"\b{re.escape(title.replace('_', ' '))}", re.IGNORECASE) for title in titles]
        shown = [one for one in known if all(each.search(one.title.replace("_", " ")) for each in patterns)]
        if not shown:
            raise UsageError(f"No chart '{' '.join(titles)}'.{near(' '.join(titles), [one.title for one in known])}")
        return plots(shown)

    def __repr__(self) -> str:
        """The summary, as shown at a prompt."""
        return str(self).rstrip("\n")

    def _repr_html_(self) -> str:
        document = self._document(brief=True)
        return f"<pre>{escape(str(self))}</pre>" if document is None else fragment(document)


class FittedResult(Result, Record):
    """A result that reads like its JSON file, by key or by attribute."""

    def __init__(self, contents: Mapping[str, Any], folder: Path | None = None) -> None:
        super().__init__(contents)
        self._folder = folder

    def value(self, name: str) -> float:
        """The estimated value of a parameter, or of an effect's: `laser_roll.laser.angle`.

        Raises:
            UsageError: There is no parameter of that name.
        """
        numbers = numbers_of(self)
        if name not in numbers:
            raise UsageError(f"No parameter '{name}'.{near(name, numbers)}")
        return float(numbers[name]["value"])

    def to_frame(self) -> "pd.DataFrame":
        """A row for each effect."""
        import pandas as pd  # noqa: PLC0415 - half a second that summaries and files do without

        return pd.DataFrame(self.to_dict()["effects"], columns=FINDING)

    def _read_back(self) -> str:
        said = self.get("sentence", "the numbers of effects")
        return f"{self.dataset}: {said}\n{self.to_frame().to_string()}\n"

    @property
    def robot(self) -> Robot | None:
        """The corrected arm: `forward`, `jacobian` and `inverse`, in batches; None where there is none."""
        return None

    def compare(self, other: "FittedResult") -> Difference:
        """Compare two results: changed numbers, in standard errors, and the flange.

        Raises:
            UsageError: One is a calibration, the other a diagnosis.
        """
        before, after = (one._of_data() | one.to_dict() for one in (self, other))
        return between(before, after, (self.robot, other.robot))

    def _of_data(self) -> dict[str, Any]:
        """Information on the data that is not in its JSON file."""
        return {}

    def to_dict(self) -> dict[str, Any]:
        """The contents of its JSON file."""
        return dict(json.loads(json.dumps(self)))

    def _saved(self, names: Sequence[str]) -> Files:
        """The files of a loaded result: its JSON file, which names the others, last."""
        own, folder = FILES[self["format"]], self._folder
        beside = {
            name: read_text(folder / name) if folder is not None and (folder / name).is_file() else None
            for name in names
            if name != own
        }
        return {**beside, own: json_text(self.to_dict())}


def _recorded(value: Any) -> Any:
    if isinstance(value, Mapping):
        return Record(value)
    is_list = isinstance(value, Sequence) and not isinstance(value, str)
    return [_recorded(one) for one in value] if is_list else value
