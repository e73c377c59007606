"""Comparisons that cannot begin or go on, and contestants that break the rules."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from robolaser.errors.base import RobolaserError, WrongUsage, near


class CandidateNotANumber(RobolaserError):
    """A contestant asked for the cost of NaN."""

    def __init__(self, variable: str) -> None:
        super().__init__(f"It asked what a candidate costs whose {variable} is not a number.")


class CandidateShape(RobolaserError):
    """A contestant asked for the cost of something that is no array of candidates."""

    def __init__(self, shape: tuple[int, ...], dimension: int) -> None:
        super().__init__(
            f"It asked for costs with an array of shape {shape}, expected (candidates, {dimension}): a row each."
        )


class ProblemUnknown(WrongUsage):
    """Neither a folder nor a name of a problem."""

    def __init__(self, text: str) -> None:
        super().__init__(
            f"No folder '{text}', and no problem of that name. A problem is the folder of a data set; `paper`, the"
            " simulated experiment of Lee et al. 2004; `reduced:` before either, what its closed form leaves to be"
            " searched; or `pymoo:` and a test function, as in pymoo:rastrigin."
        )


class TestFunctionUnknown(WrongUsage):
    """pymoo has none of that name whose lowest cost is known."""

    __test__ = False  # its name misleads pytest

    def __init__(self, text: str, known: Iterable[str]) -> None:
        super().__init__(
            f"No test function '{text}'.{near(text, known)} A number of variables may follow: pymoo:rastrigin-14."
        )


class DimensionSenseless(WrongUsage):
    """A test function was asked for with a senseless number of variables."""

    def __init__(self, text: str, dimension: str) -> None:
        super().__init__(f"{text}: '{dimension}' variables, expected a whole number from 2: pymoo:rastrigin-14.")


class NoClosedForm(WrongUsage):
    """The reduction of a test function was asked for."""

    def __init__(self, text: str) -> None:
        super().__init__(f"{text}: test functions have no closed form, only calibrations have. Leave out `reduced:`.")


class ProblemTwice(WrongUsage):
    """Two problems of the same name."""

    def __init__(self, name: str, first: str, second: str) -> None:
        super().__init__(
            f"{first} and {second} are both called '{name}', and results go by names."
            " Give one of them another `name` in its dataset.toml, or leave it out."
        )


class NothingToSearch(RobolaserError):
    """A reduced problem without variables."""

    def __init__(self, text: str) -> None:
        super().__init__(
            f"{text}: every parameter follows from the data in closed form, nothing is left to be searched."
            " Only stripe scanners have a reduced problem worth comparing on."
        )


class ComparisonForeign(RobolaserError):
    """Runs in a folder that do not compare with those to come."""

    def __init__(self, path: Path, what: str, found: object, expected: object) -> None:
        super().__init__(
            f"{path} holds runs on other terms: {what} is {found} there, here it is {expected}, and such runs do not"
            " compare. Go on with the same, take another folder, or begin anew with --force."
        )


class RecordUnreadable(RobolaserError):
    """A file that is no record of runs, or a damaged one."""

    def __init__(self, path: Path, line: int, reason: str) -> None:
        super().__init__(
            f"{path}, line {line}, is no record of a comparison ({reason})."
            " Take another folder, begin anew with --force, or"
            " delete that line to go on without it."
        )


class DaskMissing(RobolaserError):
    """A Dask cluster is asked for, and Dask is not installed."""

    def __init__(self) -> None:
        super().__init__("Dask's `distributed` is not installed here; `pip install 'robolaser[dask]'` brings it.")


class SchedulerUnreachable(RobolaserError):
    """Where a Dask scheduler should be, there is none."""

    def __init__(self, address: str, why: str) -> None:
        super().__init__(
            f"No Dask scheduler could be reached at '{address}': {why.rstrip('.')}. Expected is the address that"
            " `dask scheduler` prints, such as tcp://host:8786, from a machine that may reach it."
        )


class ClusterDiffers(RobolaserError):
    """Scheduler or workers have other versions, so that runs would fail or come out otherwise."""

    def __init__(
        self, address: str, ours: Mapping[str, str | None], theirs: Mapping[str, Mapping[str, str | None]]
    ) -> None:
        has: dict[str, list[str]] = {}
        for who, versions in theirs.items():
            for package, version in versions.items():
                if version != ours[package]:
                    what = f"{package} {ours[package] or 'missing'} here, {version or 'missing'} on"
                    has.setdefault(what, []).append(who)
        told = [f"{what} {who[0]}" + (f" and {len(who) - 1} more" if who[1:] else "") for what, who in has.items()]
        super().__init__(
            f"The Dask cluster at {address} has other versions than we, and the same runs would not come out the same:"
            f" {'; '.join(told)}. Install the same everywhere."
        )


class ClusterLost(RobolaserError):
    """The scheduler went away in the middle of a comparison."""

    def __init__(self, address: str) -> None:
        super().__init__(f"The Dask scheduler at {address} does not answer any more.")
