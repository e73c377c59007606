"""Cells that cannot be emulated."""

from collections.abc import Iterable
from pathlib import Path

from robolaser.errors.base import RobolaserError, WrongUsage, near


class FaultUnknown(WrongUsage):
    """A fault that the emulator does not have."""

    def __init__(self, kind: str, known: Iterable[str]) -> None:
        super().__init__(f"--fault {kind}: there is no such fault.{near(kind, known)}")


class FaultSenseless(WrongUsage):
    """A fault that cannot be understood."""

    def __init__(self, text: str, reason: str) -> None:
        super().__init__(f"--fault {text}: {reason}. For example: lost:0.1, impact:3@12, silent@>5s, late:2.5@7-9.")


class ControllerUnknown(RobolaserError):
    """A language that no emulated controller speaks."""

    def __init__(self, kind: str, known: Iterable[str]) -> None:
        super().__init__(f"cell.toml, [arm] kind: no emulated controller speaks '{kind}'.{near(kind, known)}")


class AxisMissing(RobolaserError):
    """A fault of an axis that the arm does not have."""

    def __init__(self, kind: str, axis: int, axes: int) -> None:
        super().__init__(f"--fault {kind}:{axis}: the arm has axes 1 to {axes}.")


class CameraPortTaken(RobolaserError):
    """A port at which no camera can be served."""

    def __init__(self, port: int, reason: str) -> None:
        super().__init__(
            f"The camera cannot be served at port {port}: {reason}."
            " Choose another --camera-port, or leave it out for any that is free."
        )


class EmulatorSilent(RobolaserError):
    """The emulator's process did not come up."""

    def __init__(self, folder: Path, said: str) -> None:
        super().__init__(f"The emulator of {folder} did not start. It said: {said.strip() or 'nothing'}")


class WorldKeyUnknown(RobolaserError):
    """A key that no world has."""

    def __init__(self, file: str, section: str, key: str, known: Iterable[str]) -> None:
        where = f"[{section}] " if section else ""
        super().__init__(f"{file}, {where}{key}: there is no such key.{near(key, known)}")


class DepartureUnknown(RobolaserError):
    """An effect that an emulated world cannot have."""

    def __init__(self, file: str, name: str, known: Iterable[str]) -> None:
        super().__init__(f"{file}, [[effect]] name: an emulated world cannot have '{name}'.{near(name, known)}")


class DepartureNowhere(RobolaserError):
    """An effect at a place that cannot have it."""

    def __init__(self, file: str, name: str, where: str, known: Iterable[str]) -> None:
        super().__init__(f"{file}, [[effect]] where: {name} cannot sit at '{where}'.{near(where, known)}")


class NoScannerToEmulate(RobolaserError):
    """A world for a cell without arm or camera."""

    def __init__(self, file: str) -> None:
        super().__init__(
            f"{file} is a world that a camera on an arm looks at, but dataset.toml has no [robot], or its sensor is no"
            " stripe scanner with an [image]. Emulate this cell without --world."
        )


class BoardNotDrawn(RobolaserError):
    """A world with a board whose pattern nobody says."""

    def __init__(self, file: str) -> None:
        super().__init__(
            f"{file} has a [board], but dataset.toml has none, so its corners and squares are not known: add [board]"
            " with columns, rows and square_m there."
        )
