"""Faults of links: not made as drawn, growing while the motors warm them, or grown already."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun

LEAST_LENGTH_M = 0.05
MOST_OF_PAYLOAD = 0.25  # of the load on a link


@final
@dataclass(frozen=True)
class LinkError(FaultModel):
    """The joint sits elsewhere on the link before it, in some of six directions."""

    effect: ClassVar[str] = "link_geometry"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)

    way: tuple[float, ...]

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Which way; the largest component is one, some are zero."""
        way = rng.uniform(-1.0, 1.0, 6)
        way[rng.permutation(6)[: rng.integers(0, 6)]] = 0.0
        return (tuple((way / np.abs(way).max()).tolist()),)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's numbers."""
        names = ("x", "y", "z", "turn_x", "turn_y", "turn_z")
        return dict(zip(names, (self.size * np.array(self.way)).tolist(), strict=True))

    def links(self, links: Array, run: SyntheticRun) -> Array:
        """Shifted by up to `size` [m] and turned by up to as many radians."""
        links = links.copy()
        column = run.column(self.where)
        way = self.size * np.array(self.way)
        links[:, column, :3, 3] += links[:, column, :3, :3] @ way[:3]
        links[:, column, :3, :3] = links[:, column, :3, :3] @ Rotation.from_rotvec(way[3:]).as_matrix()
        return links


@final
@dataclass(frozen=True)
class LinkGrowth(FaultModel):
    """The link before a joint grows as it warms up, towards an end, with an unknown time constant."""

    effect: ClassVar[str] = "thermal_drift"
    sizes: ClassVar[tuple[float, float]] = (1e-4, 1.2e-3)

    tau: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Time constant, as a share of the run."""
        return (float(np.exp(rng.uniform(np.log(0.1), np.log(1.0)))),)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Joints that a link of some length carries; the link to the first belongs to the base."""
        lengths = np.linalg.norm(run.arm.links[:, :3, 3], axis=1)
        return tuple(joint for joint in run.arm.joints[1:] if lengths[run.column(joint)] > LEAST_LENGTH_M)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's numbers."""
        length = float(np.linalg.norm(run.arm.links[run.column(self.where), :3, 3]))
        return {"growth": self.size / length / float(run.warmed(self.tau).max()), "tau": self.tau}

    def links(self, links: Array, run: SyntheticRun) -> Array:
        """Longer by `size` [m] once warm."""
        links = links.copy()
        along = links[:, run.column(self.where), :3, 3]
        grown = run.warmed(self.tau) / run.warmed(self.tau).max()
        along += self.size * grown[:, None] * along / np.linalg.norm(along, axis=1, keepdims=True)
        return links


@final
@dataclass(frozen=True)
class BentBeam(FaultModel):
    """The link before a joint is a beam, clamped at the joint before, that bends and twists under what it carries.

    Gere, Timoshenko, Mechanics of Materials, ch. 9: the end of a beam of length L and compliance c = L / EI turns by
    c (M + L × F / 2) and shifts by c (M / 2 + L × F / 3) × L under a force F and a moment M there.
    """

    effect: ClassVar[str] = "link_compliance"
    sizes: ClassVar[tuple[float, float]] = (1e-4, 2e-3)

    twists: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How much softer it is in torsion than in bending."""
        return (rng.uniform(1.0, 1.3),)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Links of some length but the first whose load is mostly of the URDF's masses: no other can be named."""
        lengths = np.linalg.norm(run.arm.links[:, :3, 3], axis=1)
        long = [joint for joint in run.arm.joints[1:] if lengths[run.column(joint)] > LEAST_LENGTH_M]
        loads = [[run.arm.link_loads(run.q, kg, joint)[1] for kg in (0.0, run.payload_kg)] for joint in long]
        return tuple(
            joint
            for joint, (masses, whole) in zip(long, loads, strict=True)
            if np.square(whole - masses).sum() < MOST_OF_PAYLOAD**2 * np.square(whole).sum()
        )

    def links(self, links: Array, run: SyntheticRun) -> Array:
        """Turned by up to `size` [rad]."""
        links = links.copy()
        column = run.column(self.where)
        nominal = run.arm.links[column]
        beam = nominal[:3, :3].T @ nominal[:3, 3]
        along = beam / np.linalg.norm(beam)
        force, moment = run.arm.link_loads(run.q, run.payload_kg, self.where)
        arm = np.cross(beam, force)
        turn = moment + arm / 2
        turn += (self.twists - 1.0) * np.outer(turn @ along, along)
        shift = np.cross(moment / 2 + arm / 3, beam)
        compliance = self.size / max(1e-9, float(np.linalg.norm(turn, axis=1).max()))
        R = links[:, column, :3, :3]
        links[:, column, :3, 3] += compliance * np.einsum("nab,nb->na", R, shift)
        links[:, column, :3, :3] = R @ Rotation.from_rotvec(compliance * turn).as_matrix()
        return links


@final
@dataclass(frozen=True)
class GrownArm(FaultModel):
    """The whole arm is warmer than where it was measured: every length from the base to the flange grew alike."""

    effect: ClassVar[str] = "arm_scale"
    sizes: ClassVar[tuple[float, float]] = (1e-4, 1e-3)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "base"

    @property
    def also_right(self) -> tuple[tuple[str, str], ...]:
        """What measures it may be too short: without a known length nobody can tell."""
        return ("tracker_scale", "measuring_system"), ("target_scale", "target")

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        """Farther from the base by the share `size`."""
        grown = T_base_flange.copy()
        grown[:, :3, 3] *= 1.0 + self.size
        return grown
