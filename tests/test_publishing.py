"""What is published: wheel and source distribution, their version, licences, citation and recipe."""

import os
import re
import subprocess
import sys
import tomllib
import zipfile
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[1]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT_NAME = re.compile(r"[\w-]+")
CONDA_FORGE = {"pin": "pinocchio", "opencv-python-headless": "py-opencv"}  # the names that differ
FORMS = sorted(set((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml")) - {ROOT / ".github/ISSUE_TEMPLATE/config.yml"})
of_a_source_tree = pytest.mark.skipif(not (ROOT / "robolaser").is_dir(), reason="only the wheel is here")


def run(*command: str | Path, folder: Path, **environment: str) -> str:
    known = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=folder, env=known | environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def hatch(*words: str | Path, folder: Path) -> str:
    return run(sys.executable, "-m", "hatchling", *words, folder=folder)


def git(*words: str | Path, folder: Path) -> str:
    return run("git", "-c", "user.name=A", "-c", "user.email=a@example.org", *words, folder=folder)


def names_in(wheel: Path) -> set[str]:
    return {re.sub(r"^robolaser-[^/]*\.dist-info", "dist-info", name) for name in zipfile.ZipFile(wheel).namelist()}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The wheel and, made from the source distribution alone, another."""
    folder = tmp_path_factory.mktemp("built")
    hatch("build", "--directory", folder, folder=ROOT)
    run("tar", "xzf", next(folder.glob("*.tar.gz")), folder=folder)
    hatch("build", "--target", "wheel", "--directory", folder / "again", folder=next(folder.glob("robolaser-*/")))
    return next(folder.glob("*.whl")), next((folder / "again").glob("*.whl"))


@of_a_source_tree
def test_the_source_distribution_makes_the_same_wheel(built):
    wheel, again = built
    assert wheel.name == again.name
    assert names_in(wheel) == names_in(again)


@of_a_source_tree
def test_an_installed_wheel_calibrates_and_writes_pages_far_from_the_sources(built, tmp_path):
    site = tmp_path / "site"
    quietly = ["--quiet", "--no-deps", "--no-index", "--no-compile", "--target", site]
    run(sys.executable, "-m", "pip", "--disable-pip-version-check", "install", *quietly, built[0], folder=tmp_path)
    for words in ("simulate --robot scorbot_er7 --poses 8 --output cell", "calibrate cell --output result"):
        run(sys.executable, "-m", "robolaser", *words.split(), folder=tmp_path, PYTHONPATH=str(site))
    assert "vega" in (tmp_path / "result" / "report.html").read_text(encoding="utf-8")
    where = run(
        sys.executable, "-c", "import robolaser; print(robolaser.__file__)", folder=tmp_path, PYTHONPATH=str(site)
    )
    assert Path(where.strip()).is_relative_to(site)


@of_a_source_tree
def test_the_licence_of_every_script_that_pages_carry_is_in_the_wheel(built):
    notice = (ROOT / "NOTICE").read_text(encoding="utf-8")
    of_others = [path.name for path in (ROOT / "robolaser/report/assets").glob("vega*.js")]
    assert len(of_others) == 2
    assert [name for name in of_others if name not in notice] == []
    licences = [path.relative_to(ROOT) for path in (ROOT / "robolaser/report/assets").glob("*.LICENSE.txt")]
    assert {"dist-info/licenses/NOTICE", *(f"dist-info/licenses/{path}" for path in licences)} <= names_in(built[0])


def test_the_licence_of_every_example_of_others_is_in_the_notice():
    notice = (ROOT / "NOTICE").read_text(encoding="utf-8")
    pages = (ROOT / "examples").glob("*/README.md")
    of_others = [page.parent.name for page in pages if "**Licence:**" in page.read_text(encoding="utf-8")]
    assert of_others
    assert [name for name in of_others if f"examples/{name}" not in notice] == []


@pytest.mark.parametrize(
    ("history", "version"),
    [
        ([], r"0\.0\.0"),
        (["init"], r"0\.0\.1\.dev1\+g\w+"),
        (["init", "tag v1.2.3"], r"1\.2\.3"),
        (["init", "tag v1.2.3", "commit --quiet --allow-empty --message more"], r"1\.2\.4\.dev1\+g\w+"),
    ],
    ids=["no repository", "no tag", "a tag", "after a tag"],
)
def test_the_version_comes_from_the_tags(history, version, tmp_path):
    for name in ("pyproject.toml", "README.md", "LICENSE", "NOTICE"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    for step in history:
        git(*step.split(), folder=tmp_path)
        if step == "init":
            git("add", ".", folder=tmp_path)
            git("commit", "--quiet", "--message", "first", folder=tmp_path)
    assert re.fullmatch(version, hatch("version", folder=tmp_path).strip())


def test_the_newest_version_of_the_changelog_is_the_unreleased_one_and_the_others_are_in_order():
    headings = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert headings[0] == "[Unreleased]"
    released = [re.fullmatch(r"\[(\d+)\.(\d+)\.(\d+)\] - (\d{4}-\d\d-\d\d)", heading) for heading in headings[1:]]
    assert all(released)
    of = [(*map(int, one.groups()[:3]), one[4]) for one in released if one]
    assert all(newer > older for newer, older in pairwise(of))


def test_the_conda_recipe_asks_for_what_the_package_asks_for():
    recipe = yaml.safe_load((ROOT / "conda.recipe/recipe.yaml").read_text(encoding="utf-8"))
    wanted = {f"python {PROJECT['project']['requires-python']}"}
    for stated in PROJECT["project"]["dependencies"]:
        name = PROJECT_NAME.match(stated)[0]
        wanted.add(f"{CONDA_FORGE.get(name, name)} {stated.removeprefix(name)}")
    assert set(recipe["requirements"]["run"]) == wanted
    built_with = {re.sub(r"(?=>=)", " ", stated) for stated in PROJECT["build-system"]["requires"]}
    assert built_with <= set(recipe["requirements"]["host"])
    assert recipe["about"]["license"] == PROJECT["project"]["license"]
    assert recipe["about"]["license_file"] == PROJECT["project"]["license-files"]


def test_the_citation_names_the_software_its_licence_and_the_paper():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= citation.keys()
    assert citation["license"] == "MIT"
    assert [one["year"] for one in citation["references"]] == [2004]


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.stem)
def test_every_issue_form_asks_for_something(form):
    asked = yaml.safe_load(form.read_text(encoding="utf-8"))
    assert asked["name"]
    assert asked["description"]
    fields = [one for one in asked["body"] if one["type"] != "markdown"]
    assert {one["type"] for one in fields} <= {"textarea", "input", "dropdown", "checkboxes"}
    assert len({one["id"] for one in fields}) == len(fields)
    assert all(one["attributes"]["label"] for one in fields)
    assert any(one.get("validations", {}).get("required") for one in fields)
