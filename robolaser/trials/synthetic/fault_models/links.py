"""Faults of links: wrong geometry, thermal growth during the run, bending under load, or earlier growth."""

from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.trials.synthetic.fault_model import FaultModel, SyntheticRun, log_uniform, uniform

LEAST_LENGTH_M = 0.05
LEAST_WARM_M = 0.2  # metal and plastics grow by less than half a per cent
MOST_OF_PAYLOAD = 0.25  # of the load on a link


def joints_on_long_links(run: SyntheticRun, least_m: float = LEAST_LENGTH_M) -> tuple[str, ...]:
    """Joints that a link of some length carries; the link to the first belongs to the base."""
    lengths = np.linalg.norm(run.arm.links[:, :3, 3], axis=1)
    return tuple(joint for joint in run.joints[1:] if lengths[run.column(joint)] > least_m)


def joints_on_bending_links(run: SyntheticRun) -> tuple[str, ...]:
    """Joints on long links whose load is mostly by the URDF's masses: no other can be named."""
    found = []
    for joint in joints_on_long_links(run):
        masses, whole = (run.arm.link_loads(run.q, kg, joint)[1] for kg in (0.0, run.payload_kg))
        if np.square(whole - masses).sum() < MOST_OF_PAYLOAD**2 * np.square(whole).sum():
            found.append(joint)
    return tuple(found)


def beam(run: SyntheticRun, joint: str) -> Array:
    """Vector from the previous joint to this one, in the frame of this one before it turns, (3,) [m]."""
    T = run.arm.links[run.column(joint)]
    return np.asarray(T[:3, :3].T @ T[:3, 3])


def _some_way(where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[float, ...]:
    """A shift and a turn vector; the largest component is one, some are zero."""
    way = rng.uniform(-1.0, 1.0, 6)
    way[rng.permutation(6)[: rng.integers(0, 6)]] = 0.0
    return tuple((way / np.abs(way).max()).tolist())


@final
class LinkError(FaultModel, effect="link_geometry", sizes=(3e-4, 4e-3)):
    """The joint is displaced on the link before it, in some of six directions."""

    way: Annotated[tuple[float, ...], _some_way]

    def values(self, run: SyntheticRun) -> dict[str, float]:
        names = ("x", "y", "z", "turn_x", "turn_y", "turn_z")
        return dict(zip(names, (self.size * np.array(self.way)).tolist(), strict=True))

    def links(self, links: Array, run: SyntheticRun) -> Array:
        """Shifted by up to `size` [m] and turned by up to as many radians."""
        links, column, way = links.copy(), run.column(self.where), self.size * np.array(self.way)
        links[:, column] = links[:, column] @ pose(exp_so3(way[3:]), way[:3])
        return links


@final
class LinkGrowth(
    FaultModel, effect="thermal_drift", sizes=(1e-4, 6e-4), places=lambda run: joints_on_long_links(run, LEAST_WARM_M)
):
    """The link before a joint grows as it warms up, towards an end, with an unknown time constant."""

    tau: Annotated[float, log_uniform(0.1, 1.0)]  # as a share of the run

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """For each metre and degree of warmth."""
        length = float(np.linalg.norm(beam(run, self.where)))
        return {"growth": self.size / length / float(run.warmed(self.tau).max()), "tau": self.tau}

    def links(self, links: Array, run: SyntheticRun) -> Array:
        """Longer by `size` [m] once warm."""
        links = links.copy()
        along = links[:, run.column(self.where), :3, 3]
        grown = run.warmed(self.tau) / run.warmed(self.tau).max()
        along += self.size * grown[:, None] * along / np.linalg.norm(along, axis=1, keepdims=True)
        return links


@final
class BentBeam(FaultModel, effect="link_compliance", sizes=(1e-4, 2e-3), places=joints_on_bending_links):
    """The link before a joint is a beam, clamped at the joint before, that bends and twists under its load.

    Gere, Timoshenko, Mechanics of Materials, ch. 9: the end of a beam of length L and compliance c = L / EI turns by
    c (M + L × F / 2) and shifts by c (M / 2 + L × F / 3) × L under a force F and a moment M there.
    """

    twists: Annotated[float, uniform(1.0, 1.3)]  # compliance in torsion over that in bending

    def links(self, links: Array, run: SyntheticRun) -> Array:
        """Turned by up to `size` [rad]."""
        links, column, L = links.copy(), run.column(self.where), beam(run, self.where)
        along = L / np.linalg.norm(L)
        force, moment = run.arm.link_loads(run.q, run.payload_kg, self.where)
        arm = np.cross(L, force)
        turn = moment + arm / 2
        turn += (self.twists - 1.0) * np.outer(turn @ along, along)
        shift = np.cross(moment / 2 + arm / 3, L)
        compliance = self.size / max(1e-9, float(np.linalg.norm(turn, axis=1).max()))
        links[:, column] = links[:, column] @ pose(exp_so3(compliance * turn), compliance * shift)
        return links


@final
class GrownArm(
    FaultModel,
    effect="arm_scale",
    sizes=(1e-4, 1e-3),
    signed=True,
    location="base",
    also=(("tracker_scale", "measuring_system"), ("target_scale", "target")),
):
    """The whole arm is warmer than when it was measured: every length from base to flange grew by the share `size`.

    Without a known length, this is indistinguishable from a short scale of the sensor.
    """

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        grown = T_base_flange.copy()
        grown[:, :3, 3] *= 1.0 + self.size
        return grown
