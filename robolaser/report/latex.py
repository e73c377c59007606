"""The tables of a document in LaTeX, for a paper (booktabs)."""

import re

from robolaser.report.document import Document, Table

RAISED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
LOWERED = str.maketrans(RAISED, "-0123456789")
SPECIAL = {  # characters that LaTeX would take for commands, or a font may lack
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "∞": r"$\infty$", "–": "--",
    "×": r"\texttimes{}", "<": r"\textless{}", ">": r"\textgreater{}", **{sign: f"\\{sign}" for sign in "&%$#_{}"},
}  # fmt: skip


def latex_tables(document: Document) -> str:
    """The tables of a document, as on its page, each with its section's heading; matrices need their colours."""
    blocks = ((section.title, block) for section in document.shown for block in section.blocks)
    tables = ((heading, block) for heading, block in blocks if isinstance(block, Table) and block.kind != "matrix")
    return "\n".join(latex(heading, table) for heading, table in tables)


def latex(heading: str, table: Table) -> str:
    """A table, its title and note below a heading; lines in small type are in brackets, but for those on names."""
    caption = ". ".join(one.removesuffix(".") for one in (heading, table.title, table.note) if one)
    rows = [
        [" ".join([cell.text, *(f"({line})" for line in cell.below if i)]).strip() for i, cell in enumerate(row)]
        for row in table.cells
    ]
    head, *body = (f"{' & '.join(map(_escaped, line))} \\\\" for line in ([one.title for one in table.columns], *rows))
    return "\n".join(
        [
            r"\begin{table}", r"\centering", f"\\caption{{{_escaped(caption)}.}}",
            f"\\begin{{tabular}}{{l{'r' * (len(table.columns) - 1)}}}", r"\toprule", head, r"\midrule", *body,
            r"\bottomrule", r"\end{tabular}", r"\end{table}", "",
        ]
    )  # fmt: skip


def _escaped(text: str) -> str:
    return "".join(
        f"\\textsuperscript{{{part.translate(LOWERED)}}}" if i % 2 else "".join(SPECIAL.get(one, one) for one in part)
        for i, part in enumerate(re.split(f"([{RAISED}]+)", text))
    )
