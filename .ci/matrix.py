"""Tests a built wheel in fresh environments: each Python, with the newest and with the lowest declared versions.

    .ci/matrix.py [--python 3.12]... [--versions newest|lowest]... [-- PYTEST ARGUMENTS]

All files are written to build/matrix. An interpreter that is not installed is reported and skipped. With the newest
versions, deprecation warnings are errors, so that they are noticed early.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "matrix"
PYTHONS = ("3.11", "3.12", "3.13")
VERSIONS = ("newest", "lowest")
EXTRAS = ("robots", "compare", "dask", "view", "trials", "mujoco", "ros")
UV = [sys.executable, "-m", "uv", "--quiet"]
PYTEST = ["-n", "2", "--dist", "loadfile", "--durations", "25", "-p", "no:cacheprovider"]
STRICT = ["-W", "error"]


def interpreter(version: str) -> Path | None:
    """An interpreter of that version: on the path, or pyenv's."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    named = shutil.which(f"python{version}")
    for candidate in [*([Path(named)] if named else []), *sorted(pyenv.glob(f"{version}.*/bin/python"))]:
        ask = [candidate, "-c", "import sys; print('%d.%d' % sys.version_info[:2])"]
        answer = subprocess.run(ask, capture_output=True, text=True, check=False)
        if answer.stdout.strip() == version:
            return candidate
    return None


def built_wheel() -> Path:
    """Build the package's wheel."""
    folder = BUILD / "wheel"
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([*UV, "build", "--wheel", "--out-dir", folder, ROOT], check=True)
    return next(folder.glob("*.whl"))


def without_sources(folder: Path) -> None:
    """Copy the repository without the package, so that only the wheel can be imported."""
    files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, files.split("\0")):
        if not name.startswith("robolaser/") and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)


def installed(python: Path, wheel: Path, folder: Path, versions: str) -> Path:
    """Create a fresh environment with the wheel; returns its interpreter."""
    subprocess.run([*UV, "venv", "--clear", "--python", python, folder / "env"], check=True)
    own = folder / "env" / "bin" / "python"
    constraints = folder / "lowest.txt"
    bounds: list[str | Path] = []
    if versions == "lowest":
        extras = [word for extra in EXTRAS for word in ("--extra", extra)]
        lowest = ["--resolution", "lowest-direct", "--python", own, "--output-file", constraints]
        subprocess.run([*UV, "pip", "compile", *extras, *lowest, ROOT / "pyproject.toml"], check=True)
        bounds = ["--constraints", constraints]
    package = f"{wheel}[{','.join(EXTRAS)}]"
    wanted = ["--python", own, package, "--requirement", ROOT / "requirements-test.txt", *bounds]
    subprocess.run([*UV, "pip", "install", *wanted], check=True)
    return own


def main() -> int:
    """Run all combinations; returns the number of failures."""
    parser = argparse.ArgumentParser(description="Test a built wheel in fresh environments.")
    parser.add_argument("--python", action="append", choices=PYTHONS, help="default: all")
    parser.add_argument("--versions", action="append", choices=VERSIONS, help="default: both")
    parser.add_argument("pytest", nargs="*", help="arguments of pytest; default: all tests")
    args = parser.parse_args()
    wheel = built_wheel()
    rows: list[str] = []
    failed = 0
    for version in args.python or PYTHONS:
        python = interpreter(version)
        if python is None:
            rows.append(f"{version:8} not installed")
            continue
        for versions in args.versions or VERSIONS:
            began = time.monotonic()
            folder = BUILD / f"{version}-{versions}"
            shutil.rmtree(folder, ignore_errors=True)
            without_sources(folder / "repository")
            own = installed(python, wheel, folder, versions)
            strict = STRICT if versions == "newest" else []
            command = [own.parent / "pytest", *PYTEST, *strict, *args.pytest]
            environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
            code = subprocess.run(command, cwd=folder / "repository", env=environment, check=False).returncode
            failed += code != 0
            outcome = "passed" if code == 0 else f"failed ({code})"
            rows.append(f"{version:8} {versions:8} {outcome:12} {time.monotonic() - began:6.0f} s")
    print("\n".join(["", *rows]))
    return failed


if __name__ == "__main__":
    sys.exit(main())
