"""Searches that cannot begin, go on or end."""

from collections.abc import Iterable
from pathlib import Path

from robolaser.errors.base import RobolaserError, WrongUsage, near


class AlgorithmUnknown(WrongUsage):
    """No algorithm of that name."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        super().__init__(f"No algorithm '{name}'.{near(name, known)} One of your own is package.module:attribute.")


class RequestUnreadable(WrongUsage):
    """A text that asks for no algorithm that could be looked for."""

    def __init__(self, text: str, reason: str) -> None:
        super().__init__(
            f"'{text}' asks for no algorithm: {reason}. Expected NAME or package.module:attribute,"
            " and :key=value after it for each setting, as in rcga:b=2:pop_size=50."
        )


class SettingUnknown(WrongUsage):
    """An algorithm has no setting of that name."""

    def __init__(self, algorithm: str, setting: str, known: Iterable[str]) -> None:
        super().__init__(f"{algorithm} has no setting '{setting}'.{near(setting, known)}")


class SettingSenseless(WrongUsage):
    """A setting of an algorithm has a value without meaning."""

    def __init__(self, algorithm: str, setting: str, value: object, expected: str) -> None:
        super().__init__(f"{algorithm}: {setting} is {value!r}, expected {expected}.")


class SettingsRefused(WrongUsage):
    """An algorithm cannot be made with the settings that it was given."""

    def __init__(self, text: str, error: BaseException) -> None:
        said = str(error) if isinstance(error, RobolaserError) else f"{type(error).__name__}: {error}"
        super().__init__(f"{text} cannot be made. {said.rstrip('.')}. Give it other settings.")


class NotImportable(WrongUsage):
    """A module that was asked for is not there, or fails when it is imported."""

    def __init__(self, text: str, module: str, error: BaseException) -> None:
        super().__init__(
            f"{text}: module {module} cannot be imported ({type(error).__name__}: {error})."
            " It has to lie in the current directory or be installed. Settings are written :key=value."
        )


class AttributeLacking(WrongUsage):
    """A module has nothing of that name."""

    def __init__(self, text: str, module: str, attribute: str, known: Iterable[str]) -> None:
        super().__init__(f"{text}: {module} has no '{attribute}'.{near(attribute, known)}")


class NotAnAlgorithm(WrongUsage):
    """What was imported cannot search."""

    def __init__(self, text: str, found: object, expected: str) -> None:
        super().__init__(f"{text} is {found!r:.80} and cannot search. Expected {expected}.")


class NothingAsked(RobolaserError):
    """An algorithm goes on and on without a candidate."""

    def __init__(self, rounds: int) -> None:
        super().__init__(f"It went through {rounds} rounds without asking what a candidate costs.")


class OperatorSetting(RobolaserError):
    """An operator or algorithm was given a setting that has no meaning."""

    def __init__(self, where: str, setting: str, value: object, expected: str) -> None:
        super().__init__(f"{where}: {setting} is {value!r}, expected {expected}.")


class ProgressUnknown(RobolaserError):
    """An operator that depends on time runs where nobody tells the time."""

    def __init__(self, operator: str) -> None:
        super().__init__(
            f"{operator} does not know how far the run has come: its algorithm does not pass itself on to"
            f" its operators (MOEAD and differential evolution do not). Tell it: {operator}(progress=...), a share"
            " of the run from 0 to 1 or a function without arguments that returns it."
        )


class BoundsMissing(RobolaserError):
    """Variables without finite bounds where an operator measures its steps by them."""

    def __init__(self, operator: str, variables: Iterable[int]) -> None:
        super().__init__(
            f"{operator} measures its steps by the distance to the bounds, but the problem gives variables"
            f" {', '.join(map(str, variables))} no finite ones. Give the problem finite xl and xu."
        )


class ManyObjectives(RobolaserError):
    """A search for one objective met a problem with several."""

    def __init__(self, where: str, objectives: int) -> None:
        super().__init__(
            f"{where} minimises one objective, but the problem has {objectives}."
            " Take NSGA2 or another multi-objective algorithm; robolaser's operators work in it."
        )


class CheckpointUnreadable(RobolaserError):
    """A file that is no checkpoint, or a damaged one."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path} is not a whole checkpoint: {reason}. Delete it to start the run anew.")


class CheckpointForeign(RobolaserError):
    """A checkpoint of another run than the one to be resumed."""

    def __init__(self, path: Path, what: str, found: object, expected: object) -> None:
        super().__init__(
            f"{path} belongs to another run: {what} is {found}, here it is {expected}."
            " Resume with what the run was started with, or delete the checkpoint to start anew."
        )


class CheckpointImpossible(RobolaserError):
    """A run of which no checkpoint can be taken."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"No checkpoint can be taken: {reason}.")


class ResidualsShape(RobolaserError):
    """A residual function that does not return one row for each candidate."""

    def __init__(self, candidates: int, shape: tuple[int, ...]) -> None:
        super().__init__(
            f"The residuals of {candidates} candidates have shape {shape}, expected ({candidates}, k):"
            " one row of k residuals for each candidate, the same k in every call."
        )
