"""Packages as pip leaves them: a module where Python finds it, beside what it announces."""

from pathlib import Path


def installed(folder: Path, module: str, code: str, announced: str, package: str = "") -> None:
    """`announced` is the text of `entry_points.txt`; the package has the module's name if it has no other."""
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    (folder / f"{module}.py").write_text(code, "utf-8")
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package or module}\nVersion: 1.0\n", "utf-8")
    (info / "entry_points.txt").write_text(announced, "utf-8")
