"""The files of a corrected arm, each with what it delivers on new poses."""

from collections.abc import Mapping, Sequence
from typing import Any

from robolaser.report.digits import millimetres
from robolaser.report.document import Cell, Column, Section, Table

Delivered = Sequence[Mapping[str, Any]]
"""As `files` of calibration.json and diagnosis.json."""

UNLIKE = 1.1
"""Ratio of errors, from which on files are told apart. A judgement."""


def best_file(files: Delivered) -> list[str]:
    """Which file to take, where they deliver unlike."""
    known = sorted((one["held_out_mm"], one["file"]) for one in files if one["held_out_mm"] is not None)
    if len(known) < 2 or known[-1][0] < UNLIKE * known[0][0]:
        return []
    return [f"Use `{known[0][1]}` where you can: it delivers most, {millimetres(known[0][0] / 1e3)} on new poses."]


def files_section(files: Delivered) -> Section:
    """What each file delivers on new poses, read by the program that it is for."""

    def named(pairs: Sequence[Sequence[str]]) -> str:
        return ", ".join(f"{effect.replace('_', ' ')} at {where}" for effect, where in pairs) or "nothing"

    rows: list[tuple[Cell | str, ...]] = [
        (
            Cell(one["file"], link=one["file"]),
            "not known" if one["held_out_mm"] is None else millimetres(one["held_out_mm"] / 1e3),
            named(one["contains"]),
            named(one["lacks"]),
        )
        for one in files
    ]
    columns = [
        Column("File", "name", 24, "file"),
        Column("Error on new poses", brief="error on new poses"),
        Column("Contains"),
        Column("Lacks", brief="lacks"),
    ]
    note = "Each was written without some poses, read back, and held against these; base and tool were fitted anew."
    return Section("Files of the corrected arm", [Table(columns, rows, note=note, printed=3)] if files else [])
