"""Every public name has its place in the reference, and an example that runs."""

import ast
import doctest
import re
from collections.abc import Iterator
from pathlib import Path

import griffe
import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "docs" / "reference" / "api").glob("*.md"))
PUBLIC = ("", "operators", "algorithms", "problems", "simulation", "diagnosis", "scan")
EXAMPLES_BEGIN = "examples of this page begin with"


@pytest.fixture(scope="module")
def package() -> griffe.Module:
    import robolaser  # noqa: PLC0415 - the installed one, where the tests run beside a wheel

    return griffe.load("robolaser", search_paths=[Path(robolaser.__file__).parents[1]], resolve_aliases=True)


def target(package: griffe.Module, name: str) -> griffe.Object:
    """What a name of the package stands for; of a function in a module of its name, the function."""
    found = package[name.removeprefix("robolaser.")]
    found = found.final_target if found.is_alias else found
    return found[name.rpartition(".")[2]] if found.is_module and name.count(".") == 2 else found


def shown(page: Path) -> list[str]:
    return re.findall(r"^::: (\S+)$", page.read_text(encoding="utf-8"), re.MULTILINE)


def public(package: griffe.Module) -> Iterator[griffe.Object]:
    for folder in PUBLIC:
        module = package[folder] if folder else package
        for name in module.exports:
            yield target(package, ".".join(filter(None, ("robolaser", folder, str(name)))))


def test_every_public_name_is_in_the_reference(package):
    there = {target(package, name).path for page in PAGES for name in shown(page)}
    assert {one.path for one in public(package)} - there == set()


def test_every_public_name_has_an_example(package):
    assert [one.path for one in public(package) if one.docstring is None or ">>>" not in one.docstring.value] == []


def test_every_argument_and_result_of_what_is_public_has_a_type(package):
    def untyped(one: griffe.Object) -> Iterator[str]:
        if isinstance(one, griffe.Function):
            missing = [
                each.name for each in one.parameters if each.annotation is None and each.name not in ("self", "cls")
            ]
            yield from (f"{one.path}({name})" for name in missing)
            if one.returns is None:
                yield one.path
        elif isinstance(one, griffe.Class):
            for name, member in one.members.items():
                if not name.startswith("_") and not member.is_alias:
                    yield from untyped(member)

    assert [name for one in public(package) for name in untyped(one)] == []


@pytest.mark.parametrize(
    "page", [page for page in PAGES if EXAMPLES_BEGIN in page.read_text("utf-8")], ids=lambda p: p.stem
)
def test_the_examples_of_a_page_run(page, package, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    beginning = page.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    given: dict[str, object] = {}
    exec(compile(ast.parse(beginning), str(page), "exec"), given)
    runner, parser = doctest.DocTestRunner(), doctest.DocTestParser()
    for name in shown(page):
        one = target(package, name)
        if one.docstring is not None:
            text = one.docstring.value
            runner.run(parser.get_doctest(text, dict(given), one.path, str(one.filepath), one.lineno))
    outcome = runner.summarize(verbose=False)
    assert outcome.attempted > 10
    assert outcome.failed == 0
