"""Compiled loops: nobody waits for them, and they follow what they call."""

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

import robolaser
from robolaser.compiled import kept
from robolaser.compiled.loops import SWITCH, Loops, compile_now, ready

PACKAGE = Path(robolaser.__file__).parent
SOURCES = {
    ".".join(("robolaser", *source.relative_to(PACKAGE).with_suffix("").parts)): source.read_text()
    for source in sorted(PACKAGE.rglob("*_loops.py"))
}
WITH_A_WAY_IN = [module for module, source in SOURCES.items() if "def warm_up" in source]
DOUBLED = """
from {package}.twice_loops import twice
from robolaser.compiled.decorators import compiled

@compiled
def doubled(x):
    return twice(x)
"""
TWICE = """
from robolaser.compiled.decorators import compiled

@compiled
def twice(x):
    return {factor} * x
"""


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for machine code that nobody else has."""
    monkeypatch.setenv(kept.FOLDER, str(tmp_path / "cache"))
    kept.folder.cache_clear()
    yield tmp_path / "cache"
    kept.folder.cache_clear()


def test_small_work_never_asks_for_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is done in two seconds of NumPy starts no other process and loads no numba."""
    monkeypatch.delenv(SWITCH, raising=False)
    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: pytest.fail("a compiler was started"))
    loops = Loops("robolaser.vision.profile_loops", pays_after=1e6)
    assert [loops.after(1e3) for _ in range(100)] == [None] * 100


def test_numpy_goes_on_while_another_process_compiles(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run that first needs loops does not wait for them; a later one has them."""
    monkeypatch.delenv(SWITCH, raising=False)
    module = "robolaser.vision.profile_loops"
    first = Loops(module, pays_after=1.0)
    assert first.after(2.0) is None
    assert first._compiling.poll() is None
    assert not ready(module)
    assert first._compiling.wait() == 0
    assert Loops(module, pays_after=1.0).after(2.0) is importlib.import_module(module)


@pytest.mark.parametrize("switch", ["0"])
def test_nothing_is_compiled_where_nobody_wants_it(switch: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """`ROBOLASER_COMPILE=0` means NumPy, whatever the work."""
    monkeypatch.setenv(SWITCH, switch)
    assert Loops("robolaser.vision.profile_loops", pays_after=0.0).after(1e12) is None


def test_without_a_folder_to_keep_machine_code_numpy_goes_on(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A user's folder that is a file, or full, is no reason to stop."""
    monkeypatch.delenv(SWITCH, raising=False)
    own_cache.write_text("in the way")
    assert Loops("robolaser.vision.profile_loops", pays_after=0.0).after(1.0) is None


def test_who_compiles_already_is_not_disturbed(own_cache: Path) -> None:
    """Two processes that want the same loops compile them once."""
    module = "robolaser.vision.profile_loops"
    (kept.folder() / f"{module}.compiling").touch()
    compile_now(module)
    assert not ready(module)


@pytest.mark.parametrize("module", WITH_A_WAY_IN)
def test_warming_up_compiles_every_way_into_the_loops(module: str) -> None:
    """Each module says how it is called, so that the other process compiles all that a run will call."""
    loops = importlib.import_module(module)
    loops.warm_up()
    declared = {name: found for name, found in vars(loops).items() if hasattr(found, "signatures")}
    entries = [name for name, found in declared.items() if found.__module__ == module and not name.startswith("_")]
    assert entries
    assert all(declared[name].signatures for name in entries), entries


def test_a_loop_notices_a_change_in_what_it_calls(tmp_path: Path) -> None:
    """Machine code made from an older version of a called function in another file is not used."""
    package = tmp_path / "robolaser_like"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "doubled_loops.py").write_text(DOUBLED.format(package=package.name))
    seen = []
    for factor in (2, 3):
        (package / "twice_loops.py").write_text(TWICE.format(factor=factor))
        code = (
            f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
            "from pathlib import Path\n"
            "from robolaser.compiled import kept\n"
            f"kept.PACKAGE = Path({str(package)!r})\n"
            f"from {package.name}.doubled_loops import doubled\n"
            "print(doubled(1.0))"
        )
        run = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, kept.FOLDER: str(tmp_path / "cache")},
        )
        seen.append(float(run.stdout))
    assert seen == [2.0, 3.0]
