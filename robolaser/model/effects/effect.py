"""What a departure from the nominal model is: a stage, a place, a few numbers, and how they perturb what passes."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.scene import Scene
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Parameter, Parameters, Values

__all__ = ["CandidateEffect", "Effect", "Scene", "parameter", "perturb_with", "shape"]


def parameter(*, unit: str, bound: float, prior_scale: float) -> Any:
    """Declare one number of an effect: zero when nominal, within ±bound, `typical` in industry."""
    return field(metadata={"unit": unit, "bound": bound, "prior_scale": prior_scale})


def shape(*, unit: str, lower: float, upper: float, nominal: float) -> Any:
    """Declare an inner number of an effect, such as a frequency: it means nothing while the others are zero.

    Within [lower, upper] the misfit may have many valleys in it: `Effect.grid` says where to look.
    """
    return field(metadata={"unit": unit, "shape": (lower, upper, nominal)})


@dataclass(frozen=True)
class Effect(ABC):
    """A departure from the nominal model, at one place, with one value of its numbers for each candidate.

    A subclass declares `name`, `stage`, `title`, `reference` and its parameters, the principal one first, and bends
    what passes. With all parameters at zero it bends nothing, exactly, whatever its shapes. What comes out is smooth in
    the parameters, but need not be in the shapes.

    Attributes:
        depends_on_trajectory: Whether it looks at other poses or points than the one that it bends.
        where: A joint's name, or one of `camera laser hand_eye target base timing image tool`.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    reference: ClassVar[str]
    stage: ClassVar[Stage]
    depends_on_trajectory: ClassVar[bool] = False

    where: str

    @classmethod
    @abstractmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Where in this robot and sensor it could sit; empty where something is missing."""

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Why these data cannot test it, as "no joint velocities in the data"; "" where they can."""
        return "" if cls.places(dataset) else "this robot or sensor has no place for it"

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Values of its shapes worth trying for these data, (g, number of shapes).

        So dense that from the best of them the way to the optimum leads downhill.
        """
        return np.array([[nominal for *_, nominal in cls.shapes()]])

    @abstractmethod
    def apply(self, value: Array, scene: Scene) -> Array:
        """What comes out of the stage; the shape may only grow from 1 to n or m."""

    @classmethod
    def declared(cls) -> tuple[tuple[str, str, float, float], ...]:
        """Its numbers: (name, unit, bound, typical size), the principal one first."""
        return tuple(
            (f.name, f.metadata["unit"], f.metadata["bound"], f.metadata["prior_scale"])
            for f in fields(cls)
            if "bound" in f.metadata
        )

    @classmethod
    def shapes(cls) -> tuple[tuple[str, str, float, float, float], ...]:
        """Its inner numbers: (name, unit, lower bound, upper bound, nominal value)."""
        return tuple((f.name, f.metadata["unit"], *f.metadata["shape"]) for f in fields(cls) if "shape" in f.metadata)


@final
@dataclass(frozen=True)
class CandidateEffect:
    """An effect at a place, its numbers still open."""

    kind: type[Effect]
    where: str

    @property
    def parameters(self) -> Parameters:
        """Its numbers as parameters, named `effect.where.number`: those that are zero when nominal, then the shapes."""
        sizes = [Parameter(self.key(name), unit, 0.0, -bound, bound) for name, unit, bound, _ in self.kind.declared()]
        shapes = [
            Parameter(self.key(name), unit, nominal, lower, upper)
            for name, unit, lower, upper, nominal in self.kind.shapes()
        ]
        return Parameters((*sizes, *shapes))

    def key(self, number: str) -> str:
        """The name of one of its numbers among a model's parameters."""
        return f"{self.kind.name}.{self.where}.{number}"

    def at(self, values: Values) -> Effect:
        """The effect with the numbers of each candidate."""
        names = [name for name, *_ in self.kind.declared()] + [name for name, *_ in self.kind.shapes()]
        numbers = {name: values[self.key(name)] for name in names}
        return self.kind(where=self.where, **numbers)


def perturb_with(effects: tuple[Effect, ...], scene: Scene) -> Perturbation:
    """The effects of a model, each at its stage; at a shared stage they act in the order of the list."""
    return Perturbation(tuple((effect.stage, partial(effect.apply, scene=scene)) for effect in effects))
