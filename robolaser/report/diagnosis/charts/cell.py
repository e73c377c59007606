"""The cell drawn in a typical pose, the guilty places marked."""

from collections.abc import Mapping
from contextlib import suppress

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from robolaser.arrays import Array
from robolaser.diagnosis.result import Diagnosis
from robolaser.report.canvas import FITTED, GRID, HELD_OUT, INK, MUTED, PAPER, Picture, picture
from robolaser.report.diagnosis.pictures.posture import Posture

ELEVATION = np.radians(18.0)
"""How far from above the cell is looked at."""
FAN_LINES = 40
NEAR = 0.06
"""Distance, relative to the arm's size, below which joints share a label."""
LEAST_SHARE = 0.1
"""Share from which on a place is guilty."""


def cell(diagnosis: Diagnosis) -> Picture:
    """Arm, sensor and target as seen from the side on which the arm spreads."""
    posture = Posture.of(diagnosis)
    guilty = accused(diagnosis)
    view = _view(posture)

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        ax.set_aspect("equal", adjustable="datalim")
        ax.axis("off")
        _target(ax, posture.points @ view, "target" in guilty)
        if len(posture.light):
            _light(ax, posture.light @ view, "laser" in guilty)
        _arm(ax, posture, view, guilty)
        _marks(ax, posture, view, guilty)
        ax.margins(0.12)

    marked = ", ".join(f"{site} ({said})" if said else site for site, said in guilty.items())
    what = (
        f"Marked: {marked}."
        if marked
        else "No place is marked: what is left is noise."
        if diagnosis.verdict == "no_gap"
        else "No place is marked: the gap lies at none of them alone."
    )
    whose = "share of what is left" if diagnosis.verdict == "unexplained" else "share of the gap"
    said = f" In brackets: {whose} that lies there." if any(guilty.values()) else ""
    return picture(
        "Where the gap lies",
        f"The cell in pose {posture.name}, one in the middle of those measured. {what}{said}",
        f"A line drawing of the cell. {what}",
        paint,
    )


def accused(diagnosis: Diagnosis) -> Mapping[str, str]:
    """The guilty places, each with its share where it has one: those of effects found, and those where a gap lies."""
    shares: dict[str, float] = {}
    for lies in diagnosis.where:
        shares[lies.site] = shares.get(lies.site, 0.0) + lies.share
    found = [finding.candidate_effect.where for finding in diagnosis.findings]
    places = [*found, *(site for site, share in shares.items() if share >= LEAST_SHARE and not found)]
    if diagnosis.verdict == "unexplained":
        places += [site for site, share in shares.items() if share >= LEAST_SHARE]
    return {site: f"{100 * min(1.0, shares[site]):.0f} %" if site in shares else "" for site in dict.fromkeys(places)}


def _view(posture: Posture) -> Array:
    """From the base frame to the plane of the drawing, (3, 2): the arm spreads to the right, up is up."""
    seen = np.concatenate([posture.line, posture.camera[None], posture.points])
    flat = seen[:, :2] - seen[:, :2].mean(axis=0)
    across = np.linalg.svd(flat, full_matrices=False)[2][0] if np.ptp(flat) > 0 else np.array([1.0, 0.0])
    across = across * np.sign(across @ (posture.camera[:2] - posture.line[0, :2]) or 1.0)
    right = np.array([across[0], across[1], 0.0])
    away = np.array([-across[1], across[0], 0.0])
    up = np.array([0.0, 0.0, np.cos(ELEVATION)]) + np.sin(ELEVATION) * away
    return np.column_stack([right, up])


def _arm(ax: Axes, posture: Posture, view: Array, guilty: Mapping[str, str]) -> None:
    line = np.concatenate([posture.line, posture.camera[None]]) @ view
    base = line[0]
    size = np.ptp(line, axis=0).max() or 1.0
    ax.plot(base[0] + size * np.array([-0.09, 0.09]), [base[1]] * 2, color=_colour("base", guilty), linewidth=3.5)
    if posture.joints:
        ax.plot(*line[:-1].T, color=MUTED, linewidth=5, alpha=0.45, solid_capstyle="round", solid_joinstyle="round")
    hand = "hand_eye" if posture.is_scanner else "tool"
    ax.plot(*line[-2:].T, color=_colour(hand, guilty), linewidth=2.2)
    for name, place in zip(posture.joints, posture.line[1:-1] @ view, strict=False):
        if name not in guilty:
            ax.plot(*place, "o", ms=6.5, mfc=PAPER, mec=MUTED, mew=1.4, zorder=4)
    if posture.is_scanner and "camera" not in guilty:
        ax.plot(*line[-1], "s", ms=7, mfc=PAPER, mec=INK, mew=1.4, zorder=4)


def _light(ax: Axes, light: Array, is_guilty: object) -> None:
    """The sheet as a fan from the projector, (1 + k, 2)."""
    colour = HELD_OUT if is_guilty else FITTED
    ends = light[1:][np.argsort(light[1:, 0])]
    for end in ends[np.linspace(0, len(ends) - 1, min(FAN_LINES, len(ends))).round().astype(int)]:
        ax.plot(*np.stack([light[0], end]).T, color=colour, linewidth=0.5, alpha=0.5)
    ax.plot(*ends.T, color=colour, linewidth=1.6)
    ax.plot(*light[0], "D", ms=5, mfc=PAPER, mec=colour, mew=1.4, zorder=4)


def _target(ax: Axes, points: Array, is_guilty: object) -> None:
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415 - only here

    colour = HELD_OUT if is_guilty else MUTED
    with suppress(QhullError, ValueError):  # a few points on a line have no outline
        ax.add_patch(Polygon(points[ConvexHull(points).vertices], fc=GRID, ec=colour, alpha=0.5, lw=1.0, zorder=0))
    ax.plot(*points.T, "o", ms=1.5, mew=0, color=colour, alpha=0.6, zorder=1)


def _marks(ax: Axes, posture: Posture, view: Array, guilty: Mapping[str, str]) -> None:
    """A dot and a name at each guilty place; those that are nowhere in space are named in a corner."""
    places = {name: posture.line[1 + i] for i, name in enumerate(posture.joints)}
    places |= {"base": posture.line[0], "camera": posture.camera, "target": posture.points.mean(axis=0)}
    places["hand_eye" if posture.is_scanner else "tool"] = (posture.line[-1] + posture.camera) / 2
    if len(posture.light):
        places["laser"] = posture.light[0]
    here = [site for site in guilty if site in places]
    for site in here:
        at = places[site] @ view
        if site != "target":
            ax.plot(*at, "o", ms=11, color=HELD_OUT, zorder=5)
        beside = (11, 5) if site in posture.joints else (11, -15)
        ax.annotate(
            _label(site, guilty), at, beside, textcoords="offset points", color=HELD_OUT, weight="bold", zorder=6
        )
    elsewhere = [_label(site, guilty) for site in guilty if site not in places]
    if elsewhere:
        ax.annotate("\n".join(elsewhere), (0, 1), xycoords="axes fraction", va="top", color=HELD_OUT, weight="bold")
    for label, at in _innocent(posture, view, guilty):
        ax.annotate(
            label, tuple(at), (-9, 0), textcoords="offset points", ha="right", va="center", color=MUTED, fontsize=8
        )


def _innocent(posture: Posture, view: Array, guilty: Mapping[str, str]) -> list[tuple[str, Array]]:
    """Names of joints that are not guilty, those at one place in one label."""
    near = NEAR * float(np.ptp(posture.line @ view, axis=0).max())
    labels: list[tuple[str, Array]] = []
    for name, at in zip(posture.joints, posture.line[1:] @ view, strict=False):
        if name in guilty:
            continue
        if labels and np.linalg.norm(at - labels[-1][1]) < near:
            labels[-1] = (f"{labels[-1][0]}, {name}", labels[-1][1])
        else:
            labels.append((name, at))
    return labels


def _label(site: str, guilty: Mapping[str, str]) -> str:
    return f"{site} {guilty[site]}".rstrip()


def _colour(site: str, guilty: Mapping[str, str]) -> str:
    return HELD_OUT if site in guilty else INK
