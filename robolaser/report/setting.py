"""Common parts of reports: noise, untestable effects, files, and the origin of the data."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from robolaser.diagnosis.cause_words import named, pairs_in_words, place, sentence_case, site_phrase, spoken
from robolaser.diagnosis.pose_scatter import ONE_JOINT
from robolaser.diagnosis.result import DetectionLimit
from robolaser.export.files import missing_reader
from robolaser.report.digits import millimetres, plain
from robolaser.report.document import Column, Section, Table, TableCell, Text

PRINTED_SHARE = 0.05  # of the gap, above which the terminal names a site
SOURCES: Mapping[str, str] = {  # the quantity that each source of noise disturbs; others have their names
    "pixel": "position in the image",
    "target": "target points",
    "board": "corners of the board",
    "point": "measured points",
    "angle": "rotation of tracked bodies",
    "seat": "seat of the ball",
    "joint": "joint readings",
    "probe": "tracker's probe, position",
    "probe_turn": "tracker's probe, rotation",
    "flange": "flange poses, position",
    "flange_turn": "flange poses, rotation",
}


def disturbed(name: str) -> str:
    """The quantity that a source of noise disturbs, in words; one of several sensors in brackets."""
    sensor, _, source = name.rpartition(".")
    words = SOURCES.get(source, source.replace(ONE_JOINT, "readings of ", 1))
    return f"{words} ({sensor})" if sensor else words


def noise_size(sigma: float, unit: str) -> str:
    """A standard deviation with its unit."""
    return plain(sigma, unit, 2) if sigma > 0 else "not known, taken as none"


def noise_table(known: Iterable[tuple[str, float, str, str]]) -> Table:
    """Each source of noise: its name, standard deviation and unit, and their origin."""
    columns = [Column("Source", width=34), Column("Standard deviation", "number"), Column("Known from", "wide")]
    return Table(columns, [(disturbed(name), noise_size(sigma, unit), origin) for name, sigma, unit, origin in known])


def untestable(reasons: Mapping[str, str], title: str = "") -> Table:
    """Why effects could not be tested, each reason once, by effect."""
    effects: dict[str, list[str]] = {}
    for name, reason in reasons.items():
        effects.setdefault(reason, []).append(spoken(name))
    rows = [(sentence_case(", ".join(names)), reason) for reason, names in effects.items()]
    return Table([Column("Effect", "name", 30), Column("Why not", "wide")], rows, title)


def limit_table(limits: Sequence[DetectionLimit], note: str = "") -> Table:
    """Detectable and distinguishable size of each effect at each location, and the error at the tool by the former."""
    titles = ("Effect", "Where", "Detectable from", "Distinguishable from", "At the tool", "Nearest other")
    columns, rows = [Column(title, brief=title.lower()) for title in titles], [_limit(one) for one in limits]
    return Table(columns, rows, note=note, fold=0, printed=len(rows))


def _limit(one: DetectionLimit) -> tuple[TableCell | str, ...]:
    effect, where = one.candidate_effect.effect, place(one.candidate_effect.where)
    never = "never, since what was found imitates it" if one.is_imitated else "never"
    size = never if one.size is None else plain(one.size, one.unit, 2)
    distinguishable = "never" if one.identifiable is None else plain(one.identifiable, one.unit, 2)
    at_tool = TableCell("" if one.at_tool_m is None else millimetres(one.at_tool_m), order=one.at_tool_m)
    nearest = "" if one.rival is None else named(one.rival)
    return TableCell(spoken(effect.name), hint=effect.title), where, size, distinguishable, at_tool, nearest


def site_lines(sites: Iterable[tuple[str, str, float]], verdict: str, most: int) -> list[Text]:
    """Site, coordinate and share of the gap, or of the remaining error; on the terminal only the important ones."""
    what = "of the remaining error" if verdict == "unexplained" else "of the gap"
    return [
        Text(f"{100 * share:.0f} % {what} at {site_phrase(site)}" + f" ({coordinate})" * bool(coordinate),
             "quiet", printed=i < most and share >= PRINTED_SHARE)
        for i, (site, coordinate, share) in enumerate(sites)
    ]  # fmt: skip


def origin(source: str, licence: str) -> str:
    """Origin of the data, for the end of a page."""
    return " ".join([f"Data: {source}."] * bool(source) + [f"Licence of the data: {licence}."] * bool(licence))


def _error(file: Mapping[str, Any]) -> TableCell | str:
    """The error of a file on new poses; without the program that reads it, the extra to install."""
    if file["held_out_mm"] is not None:
        return millimetres(file["held_out_mm"] / 1e3)
    extra = missing_reader(file["file"])
    return TableCell("not known", note=f"needs `pip install 'robolaser[{extra}]'`" if extra else "")


def files_section(files: Sequence[Mapping[str, Any]]) -> Section:
    """The error of each of `files` of a result's JSON on new poses, read by its program."""
    rows: list[tuple[TableCell | str, ...]] = [
        (TableCell(one["file"], link=one["file"]), _error(one), *map(pairs_in_words, (one["contains"], one["lacks"])))
        for one in files
    ]
    columns = [
        Column("File", "name", 24, "file"),
        Column("Error on new poses", brief="error on new poses, base and tool re-fitted"),
        Column("Contains"),
        Column("Lacks", brief="lacks"),
    ]
    note = "Each file was fitted without some poses and tested on these; base and tool are re-fitted to other poses."
    return Section("Files of the corrected arm", [Table(columns, rows, note=note, printed=3)])
