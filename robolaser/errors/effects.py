"""Options that contradict one another."""

from collections.abc import Iterable

from robolaser.errors.base import WrongUsage


class OptionsClash(WrongUsage):
    """Options of which one fixes what the others ask for."""

    def __init__(self, option: str, others: Iterable[str]) -> None:
        super().__init__(f"{option} fixes what {', '.join(others)} would change: leave out one or the other.")
