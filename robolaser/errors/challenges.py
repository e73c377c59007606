"""Blind trials that cannot be made or scored."""

from collections.abc import Iterable
from pathlib import Path

from robolaser.errors.base import RobolaserError, WrongUsage, near


class KindUnknown(WrongUsage):
    """No such kind of world."""

    def __init__(self, kind: str, known: Iterable[str]) -> None:
        super().__init__(f"No kind of world '{kind}'.{near(kind, known)}")


class NotAChallenge(RobolaserError):
    """The folder holds no sealed truth."""

    def __init__(self, folder: Path) -> None:
        super().__init__(
            f"{folder} has no truth.sealed that can be read, so it is no blind trial. "
            "Make one with `robolaser challenge new`."
        )


class SealBroken(RobolaserError):
    """A data set's hash is not that of the truth."""

    def __init__(self, seal: Path, *, there: bool) -> None:
        wrong = "does not match the truth in truth.sealed" if there else "is not there"
        super().__init__(
            f"{seal} {wrong}: one of the two was changed after the trial was made. "
            "Its score would mean nothing; make the trial anew."
        )


class DiagnosisUnreadable(RobolaserError):
    """A file that should hold a diagnosis does not."""

    def __init__(self, path: Path, why: str) -> None:
        super().__init__(
            f"{path} is no diagnosis of the format robolaser-diagnosis/1: {why}. "
            "Delete it to have the data set diagnosed anew."
        )


class NotToImitate(RobolaserError):
    """A data set whose cell a blind trial cannot be built around."""

    def __init__(self, name: str, lacking: str) -> None:
        super().__init__(
            f"A blind trial cannot be made like '{name}': {lacking}. It needs the points of a stripe scanner, "
            "a robot with joint angles, and a placed target."
        )
