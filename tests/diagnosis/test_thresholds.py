"""Every number that decides what a diagnosis says stands in one place, and what it does was measured."""

import ast
from pathlib import Path

import robolaser
from robolaser.diagnosis import thresholds

MEASURED = Path(__file__).parents[2] / "benchmarks" / "thresholds" / "README.md"
FILES = sorted((Path(robolaser.__file__).parent / "diagnosis").glob("*.py"))


def test_of_every_threshold_it_was_measured_what_half_and_twice_of_it_change() -> None:
    text = MEASURED.read_text()
    assert not [name for name in vars(thresholds) if name.isupper() and f"`{name}`" not in text]


def test_what_other_numbers_there_are_is_said() -> None:
    text = MEASURED.read_text()
    others = [f"{file.stem}.{name}" for file in FILES if file.stem != "thresholds" for name in numbers(file)]
    assert not [name for name in others if f"`{name}`" not in text]


def numbers(file: Path) -> list[str]:
    """Names that a file gives to numbers."""
    found = []
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            inside = [each for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
            if any(isinstance(each.value, int | float) for each in inside):
                found += [each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]
    return found
