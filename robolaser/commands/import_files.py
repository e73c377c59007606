"""robolaser import: from files of other programs to a data set."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, final

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from robolaser.commands.terminal import RESULT, Flange, Force, ResultFlag, Terminal, Whole, aligned, refuse, say
from robolaser.errors import UsageError

if TYPE_CHECKING:
    from robolaser.data.importers import Imported, ImportOptions
    from robolaser.robot.kinematics import Robot

ROBOT = Group("Robot", sort_key=0)
TABLES = Group("How files are read", sort_key=1)


@final
@Parameter(name="*", group=ROBOT)
@dataclass(frozen=True)
class RobotOptions:
    """The arm of the joint readings.

    Attributes:
        robot: A robot of `robolaser list robots`, or a file: URDF, xacro, MJCF, or Denavit-Hartenberg parameters.
            Default: none, the files contain flange poses.
        dh: Whether a table of Denavit-Hartenberg parameters is standard or modified (Craig's).
        xacro: An argument of a xacro file; may be given again.
    """

    robot: Annotated[str | None, Parameter(metavar="NAME_OR_FILE")] = None
    flange: Flange = None
    dh: Literal["standard", "modified"] | None = None
    xacro: Annotated[tuple[str, ...], Parameter(name="--xacro-arg", metavar="NAME=VALUE")] = ()

    def find(self, units: tuple[str, ...]) -> "Robot | None":
        """The arm; lengths and angles of its file have these units, unless it states others."""
        from robolaser.data.importers.robots import DescriptionOptions, find_robot

        if self.robot is not None:
            described = DescriptionOptions(self.dh, units, _pairs("--xacro-arg", self.xacro))
            return find_robot(self.robot, flange=self.flange, options=described)
        idle = {"--flange": self.flange, "--dh": self.dh, "--xacro-arg": " ".join(self.xacro)}
        for option, value in idle.items():
            if value:
                raise UsageError(f"{option} {value}: of which robot? Name it with --robot.")
        return None


@final
@Parameter(name="*", group=TABLES)
@dataclass(frozen=True)
class TableOptions:
    """How files are read.

    Attributes:
        columns: Read a column of poses.csv or points.csv from this column of the file; may be given again.
        units: Units of lengths, angles and times in the files, such as mm,deg,ms; of one file, dh.csv:m,rad. May be
            given again.
        separator: Separator of cells: a character, tab or space. Default: that of the header.
        decimal: Decimal point.
        header_row: Row with the column names; 0: none, the columns are called 1, 2, 3.
        euler: Sequence of axes of Euler angles: ZYX about rotating axes, zyx about fixed axes.
        point: Name of the measured point, if no column names it.
        ordered: The rows are in the order in which they were measured; no column has the times.
    """

    columns: Annotated[tuple[str, ...], Parameter(name="--column", metavar="COLUMN=NAME")] = ()
    units: Annotated[tuple[str, ...], Parameter(metavar="[FILE:]UNIT,...")] = ()
    separator: Annotated[str | None, Parameter(metavar="SIGN")] = None
    decimal: Annotated[str, Parameter(metavar="SIGN")] = "."
    header_row: Annotated[Whole, Parameter(validator=Number(gte=0))] = 1
    euler: Annotated[str | None, Parameter(metavar="AXES")] = None
    point: Annotated[str | None, Parameter(metavar="NAME")] = None
    ordered: bool = False


# names of the files to be written, the function that writes them into a folder, JSON, and a sentence
Read = tuple[Sequence[str], Callable[[Path], None], dict[str, object], str]


def import_files(
    sources: Annotated[tuple[Path, ...], Parameter(name="SOURCE", required=True)] = (),
    /,
    *,
    output: Annotated[Path, Parameter(metavar="DATASET", group=RESULT)],
    kind: Annotated[str | None, Parameter(metavar="NAME")] = None,
    robot: RobotOptions = RobotOptions(),
    path: Literal["consecutive", "unknown"] = "consecutive",
    sensor: Annotated[str, Parameter(metavar="KIND")] = "point",
    tables: TableOptions = TableOptions(),
    further: Annotated[tuple[str, ...], Parameter(name="--set", metavar="NAME=VALUE")] = (),
    extract: ResultFlag = False,
    dry_run: ResultFlag = False,
    force: Force = False,
    terminal: Terminal = Terminal(),
) -> None:
    """Convert your files to a data set; shows how each column is read before anything is written.

    For example:

        robolaser import log.csv --robot arm.urdf --units mm,deg --column q_joint_1=A1 --output cell
        robolaser import poses.txt points.txt --units mm,deg --column poses.x_m=X --output cell
        robolaser import cell.samples cell.calib --output cell
        robolaser import cell.mcap --robot ur10e --set mount=flange --set tolerance_s=0.02 --output cell
        robolaser import episodes --robot so101.urdf --flange gripper --sensor motion --units deg --output log

    Args:
        sources: Files or folders of a kind of `robolaser list importers`. Tables: one, one of poses and one of points,
            or several with a row for each pose.
        output: Folder for the data set.
        kind: One of `robolaser list importers`. Default: the one that recognises the files.
        path: Whether the arm moved straight from each pose to the next in time, or on an unknown path.
        sensor: Sensor that measured the points, of `robolaser list sensors`; motion for the log of a moving arm.
        further: An option of the importer, see `robolaser list importers`; may be given again.
        extract: Also detect the board in the images, as `robolaser extract` does.
        dry_run: Show how the files are read, and write nothing.
    """
    from robolaser.data.result_folder import results_in

    options = replace(
        _options(robot, tables),
        name=output.resolve().name,
        path_known=path == "consecutive",
        sensor=sensor,
        further=_pairs("--set", further),
    )
    if sensor == "motion":
        idle = {"--euler": tables.euler, "--point": tables.point, "--ordered": tables.ordered, "--extract": extract,
                "--kind": kind, "--path": path != "consecutive",
                "--units FILE:UNIT": options.units_of_file}  # fmt: skip
        refuse("These are logs of a moving arm", idle)
        files, write, result, sentence = _motion(sources, options, terminal)
    else:
        flags = {"extract": extract, "dry_run": dry_run}
        files, write, result, sentence = _measured(sources, kind, options, terminal, **flags)
    if not dry_run:
        inputs = [*sources, *(file for file in [Path(robot.robot or "")] if file.is_file())]
        with results_in(output, command="import", files=files, inputs=inputs, force=force):
            write(output)
    ended = "Nothing was written: leave out --dry-run." if dry_run else f"Wrote {output}"
    terminal.show({"dataset": None if dry_run else str(output), **result}, lambda: say(f"{sentence}. {ended}"))


def _options(robot: RobotOptions, tables: TableOptions) -> "ImportOptions":
    """Import options; the arm's file has its own units, or the common ones except that of time."""
    from robolaser.data.importers import ImportOptions
    from robolaser.geometry.units import FACTORS, TIME

    of_all, of_file = _units(tables.units)
    of_robot = of_file.pop(Path(robot.robot or "").name, tuple(unit for unit in of_all if unit not in FACTORS[TIME]))
    arm, columns = robot.find(of_robot), _pairs("--column", tables.columns)
    stated = vars(tables) | {"columns": columns, "units": of_all, "units_of_file": of_file}
    return ImportOptions(robot=arm, **stated)


def _measured(
    sources: Sequence[Path],
    kind: str | None,
    options: "ImportOptions",
    terminal: Terminal,
    *,
    extract: bool,
    dry_run: bool,
) -> Read:
    """Import points of a sensor, or images of them."""
    from robolaser.data.importers import importer_for
    from robolaser.data.writing import files_of
    from robolaser.diagnosis.preparation import gross_mistakes

    importer = importer_for(sources, kind)
    importer.check(options, sources)
    imported = importer.read(sources, options)
    if extract and not imported.images:
        raise UsageError(f"--extract: {importer.name} found no images. Leave it out.")
    read_back, shown = imported.checked(), imported.shown()
    terminal.print(_text(imported, shown))
    if extract and not dry_run:
        imported = _with_points(imported, terminal)
        read_back = imported.dataset
    mistakes = gross_mistakes(read_back) if len(read_back.points) else ()
    warnings = list(dict.fromkeys((*read_back.warnings, *mistakes)))
    terminal.warn(*warnings)
    rows, number = len(read_back.points), len(read_back.poses)
    result = {
        "importer": importer.name,
        "poses": number,
        "points": rows,
        "columns": {
            table: {name: {"read_from": source, "first": first} for name, (source, first) in columns.items()}
            for table, columns in shown.items()
        },
        "left_out": list(imported.left_out),
        "warnings": warnings,
    }
    files = (*files_of(imported.dataset), *imported.images)
    return files, imported.write, result, f"{rows} point{'s' * (rows != 1)} in {number} pose{'s' * (number != 1)}"


def _motion(sources: Sequence[Path], options: "ImportOptions", terminal: Terminal) -> Read:
    """Import logs of a moving arm as one, and check it as it is read back."""
    from tempfile import TemporaryDirectory

    from robolaser.data.result_folder import write_results
    from robolaser.motion.importing import import_motion
    from robolaser.motion.reading import MOTION_FOLDER, load_motion, motion_texts

    if options.robot is None:
        raise UsageError("A log of a moving arm needs its arm: name it with --robot.")
    log, columns = import_motion(sources, options.robot, options)
    terminal.print("\n".join(f"{column}: {source}" for column, source in columns.items()))
    texts = motion_texts(log)
    with TemporaryDirectory() as folder:
        write_results(Path(folder), dict(texts))
        warnings = load_motion(folder).warnings
    terminal.warn(*warnings)
    result = {"rows": len(log), "series": len(log.series), "columns": columns, "warnings": list(warnings)}
    sentence = f"{len(log)} rows in {len(log.series)} series of {options.robot.name}"
    return MOTION_FOLDER, lambda folder: write_results(folder, dict(texts)), result, sentence


def _with_points(imported: "Imported", terminal: Terminal) -> "Imported":
    """The same with the points of its images; nothing is written where they show none."""
    from tempfile import TemporaryDirectory

    from robolaser.data.loading import load
    from robolaser.vision.target_corners import points_of_target

    with TemporaryDirectory() as scratch, terminal.progress() as progress:
        folder = Path(scratch) / "recording"
        folder.mkdir()
        imported.write(folder)
        seen, dataset = points_of_target(load(folder), progress=progress)
    without = [one.pose for one in seen if not one.points]
    if without:
        terminal.warn(f"{len(without)} of {len(seen)} images do not show the board: {', '.join(without[:5])}.")
    return replace(imported, dataset=replace(dataset, folder=None))


def _units(texts: Sequence[str]) -> tuple[tuple[str, ...], dict[str, tuple[str, ...]]]:
    """Units of all files, and those of single files by name, typed as `[FILE:]UNIT,...`."""
    of_all: list[str] = []
    of_file: dict[str, tuple[str, ...]] = {}
    for text in texts:
        file, _, names = text.rpartition(":")
        units = tuple(name.strip() for name in names.split(",") if name.strip())
        if file:
            of_file[file] = units
        else:
            of_all += units
    return tuple(of_all), of_file


def _pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Values typed as NAME=VALUE, by name."""
    found: dict[str, str] = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not (name and sign and value):
            raise UsageError(f"{option} {text}: expected NAME=VALUE.")
        if found.setdefault(name, value) != value:
            raise UsageError(f"{option} {name}: both {found[name]} and {value} are given.")
    return found


def _text(imported: "Imported", shown: Mapping[str, Mapping[str, tuple[str, list[str]]]]) -> str:
    """How each column is read, and its first cells."""
    rows = []
    for table, columns in shown.items():
        rows.append([f"{table}:", "read from", "first rows, in SI units"])
        for name, (source, cells) in columns.items():
            rows.append([f"  {name}", source, "  ".join(f"{_short(cell):>10}" for cell in cells)])
    lines = aligned(rows)
    for table in (table for table in imported.read_from if table not in shown):
        lines += [f"{table}: {what} from {source}" for what, source in imported.read_from[table].items()]
    lines += [f"not taken: {what}" for what in imported.left_out]
    return "\n".join(lines)


def _short(cell: str) -> str:
    try:
        value = float(cell)
    except ValueError:
        return cell
    digits = 6 if abs(value) < 1e6 else 10  # times since 1970 differ in their last digits
    return f"{value:.{digits}g}" if repr(value) == cell else cell  # a name, such as 1.10, is no number
