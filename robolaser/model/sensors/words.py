"""What reports and errors call what a sensor does."""

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class Words:
    """Phrases of one kind of sensor."""

    closed_form: str = "the measurements"  # what start values of parameters that nobody gives come from
    no_start: str = ""  # a sentence on what would make them superfluous, where they must be given
