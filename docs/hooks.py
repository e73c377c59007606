"""Pages that live elsewhere in the repository: README.md as the front page, CONTRIBUTING.md, CHANGELOG.md, READMEs."""

import contextlib
import io
import os
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

from robolaser.cli import main
from robolaser.model.effects import EFFECTS
from robolaser.motion.effect import Number
from robolaser.motion.effects import MOTION_EFFECTS

ROOT = Path(__file__).parents[1]
GUESTS = {"index.md": "README.md", "contributing.md": "CONTRIBUTING.md", "changelog.md": "CHANGELOG.md"}
HELP = re.compile(r"<!-- help: ([\w ]+) -->")
BENCHMARKS = "<!-- the READMEs of the benchmarks come here -->"
MOVING = "<!-- the effects on moving arms come here -->"


def on_files(files: Files, config: Any) -> Files:
    """Take the guests in, their links to pages turned the way they lead from here."""
    for page, source in GUESTS.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, page, content=_from_here(text)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Turn links to the guests; put in what commands, effects and benchmarks say of themselves."""
    for name, source in GUESTS.items():
        markdown = re.sub(rf"\]\(\.\./((?:\.\./)*){source}", rf"](\1{name}", markdown)
    markdown = HELP.sub(lambda marked: _help(marked[1]), markdown)
    if MOVING in markdown:
        markdown = _with_sources(markdown).replace(MOVING, _moving())
    if BENCHMARKS not in markdown:
        return markdown
    return markdown.replace(BENCHMARKS, "\n\n".join(map(_below, sorted((ROOT / "benchmarks").glob("*/README.md")))))


def _help(command: str) -> str:
    """What a command prints with --help, as a block that is as wide as a page."""
    os.environ["COLUMNS"] = "80"
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        main([*command.split(), "--help"])
    return f"```text\n{printed.getvalue()}```"


def _with_sources(text: str) -> str:
    """Remedy and source of each effect at the end of its section."""
    for effect in EFFECTS:
        words = f"Remedy: {effect.remedy.replace('{where}', 'the joint')}\n\nSource: {effect.reference}."
        section = re.compile(rf"^### {effect.name}\n.*?(?=^##)", re.MULTILINE | re.DOTALL)
        text = section.sub(lambda found, words=words: f"{found[0]}{words}\n\n", text)
    return text


def _moving() -> str:
    """The effects on moving arms: parameters and alternatives; usual sizes, remedies and sources."""
    lines = ["| effect | class | parameters | what | alternatives |", "|---" * 5 + "|"]
    for effect in MOTION_EFFECTS:
        numbers, rivals = ", ".join(map(_number, effect.numbers)), ", ".join(f"`{rival}`" for rival in effect.rivals)
        lines.append(f"| `{effect.name}` ({effect.rows}) | `{effect.cause}` | {numbers} | {effect.clause} | {rivals} |")
    lines += ["", "Usual sizes are those of the first parameter; fits and first steps are relative to them.", ""]
    lines += ["| effect | usual size | remedy | source |", "|---" * 4 + "|"]
    for effect in MOTION_EFFECTS:
        size = f"{effect.numbers[0].usual:g} {effect.numbers[0].unit}"
        if not effect.form:
            lines.append(f"| `{effect.name}` ({effect.rows}) | {size} | {effect.remedy} | {effect.reference} |")
    return "\n".join(lines)


def _number(number: Number) -> str:
    """A parameter and its unit."""
    return f"`{number.name}` [{number.unit}]" if number.unit else f"`{number.name}`"


def _from_here(text: str) -> str:
    """Links to docs/ and to guests as they lead from the site's root; links to other files become their text."""
    text = re.sub(r"\]\(docs/", "](", text)
    for page, source in GUESTS.items():
        text = text.replace(f"]({source}", f"]({page}")
    return re.sub(r"(?<!!)\[([^\]]+)\]\((?:LICENSE|examples/[^)]*)\)", r"\1", text)


def _below(file: Path) -> str:
    """Headings one level down, the folder's name in the first; links to files that the site lacks become their text."""
    text = re.sub(r"\A# (.*)", rf"# \1 (`{file.parent.name}`)", file.read_text(encoding="utf-8"))
    text = re.sub(r"^(#+ )", r"#\1", text, flags=re.MULTILINE).replace("](../../docs/pictures/", "](../pictures/")
    return re.sub(r"!?\[([^\]]+)\]\((?!https?:|\.\./pictures/)[^)]+\)", r"\1", text)
