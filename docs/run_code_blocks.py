"""Runs every code block of the docs as a reader would, from the top of each page to its end.

Each page has a scratch folder that holds a copy of examples/.

- ```console: each line after "$ " is run by the shell; the lines below it are its output.
- ```python: the blocks of one page share their names; a ```text block right below one is what it prints.

Shown output must come, in order. A line "..." stands for any lines, " ..." at a line's end for its rest. Numbers must
agree to the digits shown, save for one unit of the last decimal.

A comment <!-- not run: WHY --> above a block skips it; <!-- fails --> says that its last command exits with 1.

    docs/run_code_blocks.py [--update] [PAGE ...]

With --update the shown output of blocks without "..." is replaced by what came.
"""

import argparse
import contextlib
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")))
WIDTH, HELP_WIDTH = "160", "100"  # columns of the terminal
TIMEOUT_S = 300

FENCE = re.compile(
    r"^(?:<!-- (?P<mark>[^\n]*?) -->\n)?```(?P<language>\w+)\n(?P<body>.*?)^```$(?:\n\n?```text\n(?P<shown>.*?)^```$)?",
    re.MULTILINE | re.DOTALL,
)
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.(\d+))?")


class Mismatch(Exception):
    """A block did something else than the page shows."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, what a comment above says, its text, and where it stands in the page."""

    language: str
    mark: str
    body: str
    shown: str | None
    line: int
    body_at: tuple[int, int]
    shown_at: tuple[int, int]

    @property
    def runs(self) -> bool:
        return self.language in ("python", "console") and not self.mark.startswith("not run: ")


def blocks(text: str) -> Iterator[Block]:
    for found in FENCE.finditer(text):
        yield Block(
            language=found["language"],
            mark=found["mark"] or "",
            body=found["body"],
            shown=found["shown"],
            line=text.count("\n", 0, found.start("body")) + 1,
            body_at=found.span("body"),
            shown_at=found.span("shown"),
        )


def commands(body: str) -> Iterator[tuple[str, str]]:
    """Each command with the output shown below it."""
    for part in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
        command, _, shown = part.partition("\n")
        while command.endswith("\\"):
            more, _, shown = shown.partition("\n")
            command += "\n" + more
        yield command, shown


def same(shown: str, came: str) -> bool:
    """Whether two lines agree, save for spaces, lines of boxes and the last digit of numbers."""
    shown, came = (" ".join(re.sub("─+", "─", line).split()) for line in (shown, came))
    if shown.endswith(" ..."):
        shown = shown.removesuffix(" ...")
        came = " ".join(came.split()[: len(shown.split())])
    if NUMBER.sub("#", shown) != NUMBER.sub("#", came):
        return False
    pairs = zip(NUMBER.finditer(shown), NUMBER.finditer(came), strict=True)
    return all(_close(a, b) for a, b in pairs)


def _close(a: re.Match[str], b: re.Match[str]) -> bool:
    """Whether two numbers agree: whole ones exactly, others within one unit of the last decimal that both have."""
    digits = min(len(a[1] or ""), len(b[1] or ""))
    return round(abs(float(a[0]) - float(b[0])), digits) <= (10.0**-digits if digits else 0)


def compare(shown: str, came: str) -> None:
    """Every shown line must come, in order."""
    left = [line for line in came.splitlines() if line.strip()]
    gap = False
    for line in filter(str.strip, shown.splitlines()):
        if line.strip() == "...":
            gap = True
            continue
        while gap and left and not same(line, left[0]):
            left.pop(0)
        if not left or not same(line, left.pop(0)):
            raise Mismatch(f"the page shows:\n  {line}\nbut the output was:\n{came}")
        gap = False
    if shown.strip() and left and not gap:
        raise Mismatch(f"the output goes on after what the page shows:\n{came}")


def run_shell(command: str, folder: Path, *, expected: int) -> str:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    width = HELP_WIDTH if "--help" in command else WIDTH
    done = subprocess.run(
        command, shell=True, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL, timeout=TIMEOUT_S, check=False, env=os.environ | {"PATH": path, "COLUMNS": width},
    )  # fmt: skip
    if done.returncode != expected:
        raise Mismatch(f"`{command}` exits with {done.returncode}, expected {expected}:\n{done.stdout}")
    return done.stdout


def run_console(block: Block, folder: Path, *, update: bool) -> str:
    """Run the commands; gives the block's text with the output that came."""
    text = ""
    steps = list(commands(block.body))
    for i, (command, shown) in enumerate(steps):
        fails = block.mark == "fails" and i == len(steps) - 1
        came = run_shell(command, folder, expected=1 if fails else 0)
        keep = "..." in shown.split("\n") or not shown.strip()
        if not (update and not keep):
            compare(shown, came)
        tail = "\n" if i < len(steps) - 1 and shown.endswith("\n\n") else ""
        text += f"$ {command}\n" + (shown if keep else tidy(came) + tail)
    return text


def run_python(block: Block, names: dict[str, Any], page: Path, *, update: bool) -> str | None:
    """Run the block; gives what it printed."""
    out = io.StringIO()
    source = "\n" * (block.line - 1) + block.body
    with contextlib.redirect_stdout(out):
        exec(compile(source, str(page), "exec"), names)
    if block.shown is not None and not update:
        compare(block.shown, out.getvalue())
    return tidy(out.getvalue())


def tidy(text: str) -> str:
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines())


def run_page(page: Path, *, update: bool) -> int:
    """Run a page's blocks; gives how many."""
    text, fresh, done = page.read_text(encoding="utf-8"), [], 0
    names: dict[str, Any] = {"__name__": "__main__"}
    home = Path.cwd()
    with tempfile.TemporaryDirectory() as scratch:
        shutil.copytree(ROOT / "examples", Path(scratch) / "examples")
        os.chdir(scratch)
        try:
            for block in blocks(text):
                if not block.runs:
                    continue
                try:
                    if block.language == "console":
                        fresh.append((block.body_at, run_console(block, Path(scratch), update=update)))
                    else:
                        printed = run_python(block, names, page, update=update)
                        if block.shown is not None and printed is not None and "..." not in block.shown.split("\n"):
                            fresh.append((block.shown_at, printed))
                except Mismatch as wrong:
                    raise SystemExit(f"{page.relative_to(ROOT)}, line {block.line}: {wrong}") from None
                except Exception:
                    traceback.print_exc()
                    raise SystemExit(f"{page.relative_to(ROOT)}, line {block.line}: the block does not run.") from None
                done += 1
        finally:
            os.chdir(home)
    if update:
        for (start, end), new in reversed(fresh):
            text = text[:start] + new + text[end:]
        page.write_text(text, encoding="utf-8")
    return done


def main() -> None:
    parser = argparse.ArgumentParser(description="Run every code block of the docs.")
    parser.add_argument("pages", metavar="PAGE", nargs="*", type=Path, help="default: all")
    parser.add_argument("--update", action="store_true", help="replace the shown output by what comes")
    args = parser.parse_args()
    for page in [page.resolve() for page in args.pages] or PAGES:
        began = time.monotonic()
        count = run_page(page, update=args.update)
        print(f"{page.relative_to(ROOT)}: {count} blocks, {time.monotonic() - began:.1f} s", flush=True)


if __name__ == "__main__":
    main()
