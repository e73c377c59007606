"""One document says the same on a page, on a terminal and in a notebook."""

from page_claims import HOSTILE, Reader

from robolaser.report.console import printed
from robolaser.report.document import Column, Document, Figure, Figures, Notes, Section, Table, TableCell, Text
from robolaser.report.page import fragment, render


def made(word="thing"):
    rows = [
        (TableCell(f"{word} {i}", below=["meaning"]), TableCell(f"{i} mm", order=i), TableCell(note="beware"))
        for i in range(9)
    ]
    columns = [Column("Name", "name", brief="name"), Column("Size", "number", brief="size"), Column("Remark")]
    return Document(
        word,
        "tested",
        "with care",
        "It is well.",
        "Use `tool`.",
        [Figures([Figure("noise", "noise alone", "-1 mm", "how to read it", 50.0)])],
        [
            Section("Doubt", [Notes([f"note of {word}"], "steps", printed=1), Text("aside", "quiet")]),
            Section("Evidence", [Table(columns, rows, printed=4)]),
            Section("Nothing", []),
        ],
        prints_lead=True,
    )


def test_each_way_of_showing_has_answer_figures_notes_and_the_tables_that_matter():
    shown = [" ".join("".join(Reader(way(made())).texts).split()) for way in (render, fragment)]
    for text in (*shown, " ".join(printed(made()).replace("`", "").split())):
        for part in (
            "thing",
            "with care",
            "It is well.",
            "Use tool.",
            "noise alone",
            "how to read it",
            "note of thing",
        ):
            assert part in text
        assert "thing 3" in text


def test_a_terminal_has_the_first_rows_and_says_how_many_are_left():
    text = printed(made())
    assert "thing 3" in text
    assert "thing 4" not in text
    assert "and 5 more" in text
    assert "beware" not in text


def test_a_section_without_blocks_is_left_out():
    assert "Nothing" not in render(made())


def test_hostile_names_stay_text_wherever_they_are_shown():
    for way in (render, fragment):
        read = Reader(way(made(HOSTILE)))
        assert not any("alert(" in program for program in read.programs)
        assert "<script>alert" in "".join(read.texts)
    assert "\x07" not in printed(made(HOSTILE))
