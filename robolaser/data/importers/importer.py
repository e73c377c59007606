"""The abstract importer of files of one kind, its options, and its result."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar, Final, final

from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.data.result_folder import Contents, write_results
from robolaser.data.writing import point_columns, pose_columns, save, texts_of
from robolaser.errors import UsageError, near
from robolaser.geometry.units import FACTORS, TIME
from robolaser.robot.kinematics import Robot

NONE: Final = ""  # quantity of pure numbers


ROWS_SHOWN: Final = 3
GENERAL: Final = ("name", "path_known", "further")  # the options that every importer takes


def stated_units(names: Sequence[str], option: str = "--units") -> dict[str, str]:
    """The units of lengths, angles and times that a list states, of each at most one; the option is for messages."""
    stated: dict[str, str] = {}
    for name in names:
        quantity = next((quantity for quantity, factors in FACTORS.items() if name in factors), None)
        if quantity is None:
            known = near(name, [unit for factors in FACTORS.values() for unit in factors])
            raise UsageError(f"{option}: no unit '{name}'.{known}")
        if stated.setdefault(quantity, name) != name:
            raise UsageError(f"{option}: {stated[quantity]} and {name} are both of {quantity}: name one.")
    return stated


def unit_of(stated: Mapping[str, str], quantity: str, column: str) -> str:
    """The unit of a quantity; times are in seconds unless stated, "" is that of pure numbers."""
    if quantity in (TIME, NONE):
        return stated.get(quantity, "s" if quantity else "")
    if quantity not in stated:
        how = f"State it with --units, {', '.join(list(FACTORS[quantity])[:3])} or another."
        raise UsageError(f"In which unit are {quantity}, such as {column}? {how}")
    return stated[quantity]


@final
@dataclass(frozen=True)
class ImportOptions:
    """Information about files; an importer uses what its files lack.

    Attributes:
        name: Name of the data set.
        robot: The arm of the joint angles; None: the files have flange poses.
        path_known: Whether the arm moved straight from each pose to the next.
        sensor: Kind of the sensor that measured the points.
        columns: Column of a file by the column of poses.csv or points.csv that it becomes, see `read_columns`.
        units: Units of lengths and angles, and of times: at most one each.
        units_of_file: Units of single files, by file name.
        separator: Separator of cells: a character, "tab" or "space"; None: that of the header.
        decimal: Decimal point.
        header_row: Row with the column names, counted from 1; 0: none, the columns are called 1, 2, 3 …
        euler: Sequence of axes of Euler angles: "ZYX" about rotating axes, "zyx" about fixed ones.
        point: Name of the measured point, if no column names it.
        ordered: Whether the rows are in the order of measurement, if no column has the times.
        further: Options of a single importer, by name; see `Importer.further`.

    Examples:
        >>> robolaser.ImportOptions(units=("mm", "deg"), robot=robolaser.find_robot("ur5e")).sensor
        'point'
    """

    name: str = "imported"
    robot: Robot | None = None
    path_known: bool = True
    sensor: str = "point"
    columns: Mapping[str, str] = field(default_factory=dict)
    units: tuple[str, ...] = ()
    units_of_file: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    separator: str | None = None
    decimal: str = "."
    header_row: int = 1
    euler: str | None = None
    point: str | None = None
    ordered: bool = False
    further: Mapping[str, str] = field(default_factory=dict)

    def units_in(self, file: str) -> tuple[str, ...]:
        """The units of a file, by its name."""
        return self.units_of_file.get(file, self.units)


@final
@dataclass(frozen=True)
class Imported:
    """The result of an importer, before anything is written."""

    dataset: Dataset  # in SI units
    # the source of each column, with its unit, by table and column; under "" that of all further columns of a table;
    # for dataset.toml, that of parameters or tables
    read_from: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()  # unused columns, fields and rows of the files, with the reason if it is not obvious
    images: Mapping[str, Contents] = field(default_factory=dict)  # each image's contents, by its path in the data set

    def checked(self) -> Dataset:
        """The data set as `load` reads it back, in no folder.

        Raises:
            DataError: It violates the format.
        """
        with TemporaryDirectory() as folder:
            save(self.dataset, folder)
            read = load(folder)
        return replace(read, folder=None, warnings=tuple(dict.fromkeys((*self.dataset.warnings, *read.warnings))))

    def write(self, folder: Path) -> None:
        """Write the data set with its images, completely or not at all.

        Raises:
            OutputError: Writing fails.
        """
        write_results(folder, {**self.images, **texts_of(self.dataset)})

    def shown(self) -> dict[str, dict[str, tuple[str, list[str]]]]:
        """The source of each column, and its first cells as they will be written, by table and column."""
        points = point_columns(self.dataset) if len(self.dataset.points) else ()
        found: dict[str, dict[str, tuple[str, list[str]]]] = {}
        for table, columns in (("poses.csv", pose_columns(self.dataset)), ("points.csv", points)):
            sources = self.read_from.get(table, {})
            for name, cells in columns:
                first = list(islice(cells, ROWS_SHOWN))
                found.setdefault(table, {})[name] = (sources.get(name, sources.get("", "")), first)
        return found


class Importer(ABC):
    """A kind of files that can become a data set.

    Nothing is guessed: missing information is an error that names the option for it. Nothing is written
    either; see `Imported.write`.

    Attributes:
        name: Its name in `--kind`.
        title: One line for `robolaser list importers`.
        further: Options of this importer only, typed as `--set NAME=VALUE`.
        takes: Fields of `ImportOptions` on reading that it uses; None: all.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    further: ClassVar[tuple[str, ...]] = ()
    takes: ClassVar[tuple[str, ...] | None] = None

    @final
    def check(self, options: ImportOptions, paths: Sequence[Path]) -> None:
        """Refuse options without an effect on these files.

        Raises:
            UsageError: The importer does not use one of them, or units are of another file.
        """
        files = [file.name for path in paths for file in ([path, *path.iterdir()] if path.is_dir() else [path])]
        for name in options.units_of_file:
            if name not in files:
                raise UsageError(f"--units {name}: no such file is read.{near(name, files, 5)}")
        for name in options.further:
            if name not in self.further:
                raise UsageError(
                    f"--set {name}: the importer {self.name} has no such option.{near(name, self.further)}"
                )
        if self.takes is None:
            return
        taken, default = (*GENERAL, *self.takes), ImportOptions()
        for name in (one.name for one in fields(options) if one.name not in taken):
            if getattr(options, name) != getattr(default, name):
                option = {"columns": "column", "units_of_file": "units"}.get(name, name).replace("_", "-")
                raise UsageError(f"--{option}: the importer {self.name} has no use for it. Leave it out.")

    @abstractmethod
    def recognises(self, path: Path) -> bool:
        """Whether a file or folder looks like one of this kind; by its name or its first bytes, at no cost."""

    @abstractmethod
    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read files that belong together.

        Raises:
            DataError: Names file, row and column of the fault.
            UsageError: An option is missing or makes no sense.
        """
