"""Effects that cannot be, and simulations that cannot be made."""

from collections.abc import Iterable

from robolaser.errors.base import RobolaserError, WrongUsage, near


class EffectUnknown(WrongUsage):
    """No effect of that name."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        super().__init__(f"No effect '{name}'.{near(name, known)}")


class PlaceUnknown(RobolaserError):
    """An effect has no meaning at that place."""

    def __init__(self, effect: str, where: str, known: Iterable[str]) -> None:
        super().__init__(f"{effect} cannot sit at '{where}'.{near(where, known)}")


class EffectSenseless(RobolaserError):
    """An effect that this data set's robot or sensor cannot have."""

    def __init__(self, effect: str, reason: str) -> None:
        super().__init__(f"{effect} has no meaning for these data: {reason}.")


class TargetOutOfSight(RobolaserError):
    """An arm that cannot look at a target often enough."""

    def __init__(self, robot: str, wanted: int, tried: int, down: int, seeing: int, level: float) -> None:
        super().__init__(
            f"{robot}: {wanted} poses that see the target were asked for, {seeing} found. Of {tried} random postures"
            f" within the joint limits, {down} look down; the others of these miss the level z = {level:.3g} m of the"
            " base frame or show the stripe outside the image. Ask for fewer poses, or for another level of the"
            " target or turn of the camera on the flange (bracket_quat)."
        )


class BentOutOfSight(RobolaserError):
    """Effects so large that the target leaves the image."""

    def __init__(self, robot: str, wanted: int, tried: int, good: int) -> None:
        super().__init__(
            f"{robot}: {wanted} poses were asked for, but of {tried} planned ones only {good} still do their job with"
            " the effects in place. Take smaller effects, or ask for fewer poses."
        )


class NothingReached(RobolaserError):
    """A place that an arm cannot reach from enough sides."""

    def __init__(self, robot: str, place: Iterable[float], wanted: int, tried: int, found: int) -> None:
        at = ", ".join(f"{part:.3f}" for part in place)
        super().__init__(
            f"{robot}: from {tried} starts within the joint limits, {found} postures reach the socket at ({at}) m,"
            f" but {wanted} were asked for. Ask for fewer poses, or take another seed."
        )


class EffectSizeUnclear(WrongUsage):
    """An effect to be simulated without a size that can be read."""

    def __init__(self, text: str) -> None:
        super().__init__(
            f"'{text}' does not say an effect and its size: expected NAME[:WHERE]=SIZE in SI units, such as"
            " joint_offset:joint_2=0.002."
        )


class EffectTooLarge(RobolaserError):
    """An effect to be simulated far beyond what it is in the world."""

    def __init__(self, effect: str, number: str, size: float, bound: float, unit: str) -> None:
        hint = " Are these degrees?" if unit == "rad" else " Are these millimetres?" if unit == "m" else ""
        super().__init__(f"{effect}: {number} is {size:g} {unit}, but its bounds are ±{bound:g} {unit}.{hint}")


class ShapeOutside(RobolaserError):
    """An inner number of an effect to be simulated that it cannot have."""

    def __init__(self, effect: str, number: str, value: float, lower: float, upper: float, unit: str) -> None:
        of = f" {unit}" if unit else ""
        super().__init__(f"{effect}: {number} is {value:g}{of}, but it lies between {lower:g} and {upper:g}{of}.")


class EffectBendsNothing(WrongUsage):
    """A finding that no model can take in."""

    def __init__(self, name: str) -> None:
        super().__init__(f"{name} cannot be added to a model: they are found, left out and listed by a diagnosis.")


class DemandSenseless(RobolaserError):
    """Something that a simulated cell cannot have."""

    def __init__(self, what: str, value: object, expected: str) -> None:
        super().__init__(f"A cell cannot be simulated with {what} {value!r}: expected {expected}.")
