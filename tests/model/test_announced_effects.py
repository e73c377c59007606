"""Effects that other installed packages bring take part like ours; a broken one is named with its package."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from installed import installed

from robolaser.errors import PluginError
from robolaser.model.effects import DECLARED, EFFECTS, GROUP
from robolaser.model.effects.effect import Effect
from robolaser.plugins import announced

WORKING = """
from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, parameter
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class Worn(Effect):
    name: ClassVar[str] = "worn_bearing"
    title: ClassVar[str] = "the flange wobbles"
    reference: ClassVar[str] = "none"
    stage: ClassVar[Stage] = Stage.FLANGE

    site = "base"

    play: Array = parameter(unit="m", bound=0.01, prior_scale=1e-4)

    def apply(self, value, run):
        return value
"""

Install = Callable[..., Path]


def others() -> tuple[type[Effect], ...]:
    """What installed packages announce beside our effects."""
    return tuple(announced(GROUP, Effect, taken=[kind.name for kind in EFFECTS], required=DECLARED).values())


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Put a package with one module and one announcement where Python finds it."""

    def put(code: str, *, package: str = "worn-arms", attribute: str = "Worn") -> Path:
        module = package.replace("-", "_") + "_effects"
        installed(tmp_path, module, code, f"[robolaser.effects]\nworn = {module}:{attribute}\n", package)
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.delitem(sys.modules, module, raising=False)
        return tmp_path

    return put


def test_it_is_listed_among_ours_though_its_module_is_imported_first(install):
    folder = install(WORKING)
    asked = "import worn_arms_effects, robolaser; print([kind.name for kind in robolaser.EFFECTS])"
    environment = os.environ | {"PYTHONPATH": str(folder)}
    said = subprocess.run(
        [sys.executable, "-c", asked], capture_output=True, text=True, check=True, env=environment
    ).stdout
    assert "'worn_bearing'" in said
    assert "'backlash'" in said


def test_a_class_in_a_script_joins_the_library_only_where_it_is_asked_for():
    assert type("Mine", (Effect,), {"name": "mine", "__module__": "__main__"}) not in EFFECTS


@pytest.mark.parametrize(
    ("code", "attribute", "reason"),
    [
        ("import no_such_module", "Worn", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("Worn = 1 / 0", "Worn", "ZeroDivisionError"),
        ("", "Worn", "AttributeError"),
        ("Worn = 3", "Worn", "it is 3, not a subclass of Effect"),
        ("from robolaser.model.effects.effect import Effect as Worn", "Worn", "name, title, reference, stage, apply"),
        (WORKING.replace("    stage:", "    ignored:"), "Worn", "does not define stage"),
    ],
)
def test_a_broken_package_is_named_with_what_went_wrong(install, code, attribute, reason):
    install(code, attribute=attribute)
    with pytest.raises(PluginError) as said:
        others()
    assert "package worn-arms announces worn_arms_effects:Worn" in str(said.value)
    assert reason in str(said.value)


def test_a_name_of_another_package_is_taken(install):
    install(WORKING)
    install(WORKING, package="loose-arms")
    with pytest.raises(PluginError, match=r"worn-arms .* but loose-arms has one of that name"):
        others()


def test_a_broken_package_ends_a_command_with_a_sentence(install):
    folder = install("Worn = 1 / 0")
    ended = subprocess.run(
        [sys.executable, "-c", "import sys, robolaser.cli; sys.exit(robolaser.cli.main())", "list", "effects"],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(folder)},
    )
    assert ended.returncode == 1
    assert "uninstall worn-arms" in ended.stderr
    assert "Traceback" not in ended.stderr
