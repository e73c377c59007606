"""What a departure from the nominal model is: a seam, a place, a few numbers, and how they bend what passes."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, final

from robolaser.arrays import Array
from robolaser.dataset import Dataset, Points, Poses
from robolaser.parameters import Parameter, Parameters, Values
from robolaser.robot import Robot
from robolaser.seams import Bend, Seam


@final
@dataclass(frozen=True)
class Scene:
    """What an effect may look at besides what passes."""

    poses: Poses
    points: Points
    robot: Robot | None
    stripe_axis: str

    @classmethod
    def of(cls, dataset: Dataset) -> "Scene":
        """The scene of a data set."""
        return cls(dataset.poses, dataset.points, dataset.robot, dataset.stripe_axis)


def parameter(*, unit: str, bound: float, typical: float) -> Any:
    """Declare one number of an effect: zero when nominal, within ±bound, `typical` in industry."""
    return field(metadata={"unit": unit, "bound": bound, "typical": typical})


@dataclass(frozen=True)
class Effect(ABC):
    """A departure from the nominal model, at one place, with one value of its numbers for each candidate.

    A subclass declares `name`, `seam`, `title`, `reference` and its parameters, the principal one first, and bends
    what passes. At zero it bends nothing, exactly.

    Attributes:
        where: A joint's name, or one of `camera laser hand_eye target base timing image tool`.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    reference: ClassVar[str]
    seam: ClassVar[Seam]

    where: str

    @classmethod
    @abstractmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Where in this robot and sensor it could sit; empty where it has no meaning."""

    @abstractmethod
    def bend(self, passing: Array, scene: Scene) -> Array:
        """What comes out of the seam; the shape may only grow from 1 to n or m."""

    @classmethod
    def declared(cls) -> tuple[tuple[str, str, float, float], ...]:
        """Its numbers: (name, unit, bound, typical size), the principal one first."""
        return tuple(
            (f.name, f.metadata["unit"], f.metadata["bound"], f.metadata["typical"])
            for f in fields(cls)
            if "unit" in f.metadata
        )


@final
@dataclass(frozen=True)
class Suspect:
    """An effect at a place, its numbers still open."""

    kind: type[Effect]
    where: str

    @property
    def parameters(self) -> Parameters:
        """Its numbers as parameters, named `effect.where.number`, zero when nominal."""
        return Parameters(
            tuple(
                Parameter(f"{self.kind.name}.{self.where}.{name}", unit, 0.0, -bound, bound)
                for name, unit, bound, _ in self.kind.declared()
            )
        )

    def at(self, values: Values) -> Effect:
        """The effect with the numbers of each candidate."""
        numbers = {name: values[f"{self.kind.name}.{self.where}.{name}"] for name, *_ in self.kind.declared()}
        return self.kind(where=self.where, **numbers)


def bend_with(effects: tuple[Effect, ...], scene: Scene) -> Bend:
    """The effects of a model as one function; at a shared seam they act in the order of the list."""

    def bend(seam: Seam, passing: Array) -> Array:
        for effect in effects:
            if effect.seam is seam:
                passing = effect.bend(passing, scene)
        return passing

    return bend
