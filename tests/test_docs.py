"""What the docs promise is there, and what is there the docs mention; their code blocks run in `make docs`."""

import ast
import re
import tomllib
from collections.abc import Iterable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

import robolaser.operators
from robolaser.algorithms.registry import ALGORITHMS, POLISH_ONLY
from robolaser.cli import app
from robolaser.data.sensor_format import POSE_UNITS
from robolaser.model.effects import EFFECTS
from robolaser.model.sensors import Stripe
from robolaser.motion.effects import MOTION_EFFECTS
from robolaser.robot.by_name import known_robots

ROOT = Path(__file__).parents[1]
GUESTS = {
    "index.md": ROOT / "README.md",
    "contributing.md": ROOT / "CONTRIBUTING.md",
    "changelog.md": ROOT / "CHANGELOG.md",
}
PAGES = {page.relative_to(ROOT).as_posix(): page for page in (ROOT / "docs").rglob("*.md")}
TEXTS = PAGES | {name: ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")}
SCRIPTS = [script for folder in ("benchmarks", "docs", "examples") for script in (ROOT / folder).rglob("*.py")]
LINK = re.compile(r"\]\((?!https?:)([^)#]*)(#[^)]*)?\)")


@pytest.fixture(params=TEXTS.values(), ids=TEXTS.keys())
def text(request: pytest.FixtureRequest) -> Path:
    path: Path = request.param
    return path


def missing(names: Iterable[str], page: str) -> list[str]:
    said = PAGES[f"docs/{page}"].read_text(encoding="utf-8")
    return [name for name in names if not re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", said)]


def slug(heading: str) -> str:
    return re.sub(r"\s+", "-", re.sub(r"[^\w\s-]", "", heading).strip().lower())


def test_the_first_screen_names_the_two_commands_and_shows_the_result() -> None:
    first_screen = (ROOT / "README.md").read_text(encoding="utf-8").split("\n## ")[0]
    assert "make demo" in first_screen
    assert "make test" in first_screen
    assert (ROOT / re.findall(r"!\[.*\]\((.*)\)", first_screen)[0]).is_file()


def test_every_page_of_the_site_is_there_and_every_page_is_in_the_site() -> None:
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    named = set(re.findall(r"^ +- .*?(\S+\.(?:md|ipynb))$", nav, re.MULTILINE))
    notebooks = {page.relative_to(ROOT / "docs").as_posix() for page in (ROOT / "docs").rglob("*.ipynb")}
    assert named == {page.removeprefix("docs/") for page in PAGES} | notebooks | GUESTS.keys()
    assert all(guest.is_file() for guest in GUESTS.values())


def test_every_link_leads_to_a_file_and_to_a_heading_of_it(text: Path) -> None:
    for file, anchor in LINK.findall(text.read_text(encoding="utf-8")):
        there = text.parent / file if file else text
        assert there.exists(), file
        if anchor:
            headings = re.findall(r"^#+ (.*)$", there.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor[1:] in map(slug, headings), file + anchor


def test_no_text_knows_the_machine_it_was_written_on(text: Path) -> None:
    assert not re.search(r"/(home|Users|work|tmp|root)/|shared/", text.read_text(encoding="utf-8"))


def test_the_layers_shown_are_those_that_the_linter_keeps() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = settings["tool"]["importlinter"]["contracts"][0]["layers"]
    shown = PAGES["docs/explanation/architecture.md"].read_text(encoding="utf-8").split("## Layers")[1].split("```")[1]
    assert shown.removeprefix("text\n").replace("│", "|").splitlines() == layers


def test_every_file_of_the_package_has_its_place_in_the_architecture() -> None:
    tree = PAGES["docs/explanation/architecture.md"].read_text(encoding="utf-8").split("```")[1]
    parts = (ROOT / "robolaser").glob("[!_]*")
    names = [f"{part.name}/" if part.is_dir() else part.name for part in parts if part.suffix in ("", ".py")]
    assert [name for name in names if name not in tree and name != "arrays.py"] == []


def test_every_member_of_a_family_has_its_word_in_the_docs() -> None:
    numbers = [number for effect in EFFECTS for number in effect.units()]
    assert missing([*(effect.name for effect in EFFECTS), *numbers], "reference/effects.md") == []
    assert missing((effect.name for effect in EFFECTS), "reference/gallery.md") == []
    assert missing((effect.name for effect in MOTION_EFFECTS), "reference/gallery.md") == []
    assert missing(robolaser.operators.__all__, "reference/operators.md") == []
    assert missing([*ALGORITHMS, POLISH_ONLY], "reference/operators.md") == []
    assert missing((robot.name for robot in known_robots()), "howto/your-robot.md") == []
    assert missing((f"help: {name}" for name in app if name[0].isalpha()), "reference/commands.md") == []


def test_every_parameter_of_a_scanner_has_its_word_in_the_conventions() -> None:
    names = {**Stripe.format.units, **POSE_UNITS}
    assert missing((name for name in names if name not in "xyz"), "reference/conventions.md") == []


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.relative_to(ROOT).as_posix())
def test_what_a_script_imports_of_the_package_is_there(script: Path) -> None:
    for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("robolaser"):
            module = import_module(node.module or "")
            gone = [name.name for name in node.names if not hasattr(module, name.name)]
            assert not [name for name in gone if find_spec(f"{node.module}.{name}") is None], script
