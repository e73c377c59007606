"""From pixels to residuals in one loop: rays, laser plane, hand-eye and arm. Lee et al. 2004, eqs. 1-18."""

from typing import Any

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.compiled.decorators import compiled
from robolaser.geometry.frame_loops import frame, times, turned_xyz, turned_zyz

TILE = 256  # rows whose residuals are worked out before they are written


@compiled
def costs(
    first: int, last: int, own: Array, bracket: Array, zyz: bool, along_u: bool, image: Array, known: Array, J: Array
) -> None:
    """J of eq. 18 for an arm that stands the same for all candidates.

    Args:
        first: First candidate.
        last: The one after the last.
        own: The paper's fourteen in its order, (c, 14).
        bracket: Nominal turn of the camera on the flange, (3, 3).
        zyz: Whether the first of the three angles turns about z rather than x.
        along_u: Whether the stripe runs along image u.
        image: Pixels along the camera's x and y, (2, 1, m) [px].
        known: Target points in the flange frame, (3, 1, m) [m].
        J: Takes the sums, (c,) [m²]; infinite at the model's poles.
    """
    rows = np.uintp(0), np.uintp(image.shape[2])
    for i in range(first, last):
        lens, f, plane, mount = _parts(own, i, bracket, zyz, along_u)
        total = _squares(0, rows, image, known, lens, _light(plane, f), _focal(mount, f))
        J[i] = total if np.isfinite(total) else np.inf


@compiled
def unpacked(own: Array, bracket: Array, zyz: bool, along_u: bool) -> Any:
    """What `residuals` needs of the paper's fourteen, so that effects can perturb it.

    Args:
        own: As for `costs`, and so are the others.
        bracket: Likewise.
        zyz: Likewise.
        along_u: Likewise.

    Returns:
        Camera (c, 6): origins of the camera's x and y in the image [px], their pitches [m/px], k [1/m²] and f [m];
        sheet (c, 1, 4) as n · P = d; T_flange_camera (c, 1, 4, 4).
    """
    c = len(own)
    camera, sheet, mount = np.empty((c, 6)), np.empty((c, 1, 4)), np.zeros((c, 1, 4, 4))
    for i in range(c):
        lens, f, plane, T = _parts(own, i, bracket, zyz, along_u)
        for j in range(5):
            camera[i, j] = lens[j]
        camera[i, 5] = f
        for j in range(4):
            sheet[i, 0, j] = plane[j]
        for j in range(12):
            mount[i, 0, j // 4, j % 4] = T[j]
        mount[i, 0, 3, 3] = 1.0
    return camera, sheet, mount


@compiled
def _parts(own, i, bracket, zyz, along_u):  # type: ignore[no-untyped-def]
    """Camera, focal length, laser plane and mount of one candidate."""
    f, s_u, s_v, u_0, v_0, k = own[i, 0], own[i, 1], own[i, 2], own[i, 3], own[i, 4], own[i, 5]
    lens = (v_0, u_0, s_v, -s_u, k) if along_u else (u_0, v_0, s_u, s_v, k)
    cos = np.cos(own[i, 7])
    plane = (cos, 0.0, np.sin(own[i, 7]), own[i, 6] * cos)
    angles = own[i, 8], own[i, 9], own[i, 10]
    turn = turned_zyz(*angles) if zyz else turned_xyz(*angles)
    b_x, b_y, b_z = bracket
    held = (b_x[0], b_x[1], b_x[2], own[i, 11], b_y[0], b_y[1], b_y[2], own[i, 12], b_z[0], b_z[1], b_z[2], own[i, 13])
    return lens, f, plane, times(held, turn)


@compiled
def residuals(
    first: int,
    last: int,
    top: int,
    bottom: int,
    camera: Array,
    sheet: Array,
    mount: Array,
    flange: Array,
    runs: Ints,
    image: Array,
    known: Array,
    E: Array,
    J: Array,
) -> None:
    """Known points less predicted ones, and the sum of their squares.

    Axes of length one count for every candidate, pose or row.

    Args:
        first: First candidate.
        last: The one after the last.
        top: First row.
        bottom: The one after the last.
        camera: As `unpacked` gives it, (c, 6).
        sheet: (c, 1 or m, 4).
        mount: T_flange_camera, (c, 1 or n, 4, 4).
        flange: T_base_flange, (c or 1, 1 or n, 4, 4).
        runs: Pose, first row and the one after the last, of rows that follow one another in one pose, (r, 3).
        image: Pixels along the camera's x and y, (2, c or 1, m) [px].
        known: Target points in the base frame, (3, c or 1, m) [m].
        E: Takes the residuals, (c, m, 3) [m]; or empty.
        J: Takes the sums over these rows, (c,) [m²]; infinite at the model's poles.
    """
    store, tile = len(E) > 0, np.empty((3, TILE))
    for i in range(first, last):
        x_0, y_0, s_x, s_y, k, f = camera[i]
        lens = (x_0, y_0, s_x, s_y, k)
        total = 0.0
        for run in range(len(runs)):
            start, stop = max(runs[run, 1], top), min(runs[run, 2], bottom)
            if start >= stop:
                continue
            rows = np.uintp(start), np.uintp(stop)  # signed, an index might count from the end: no vector code
            pose = runs[run, 0]
            T = frame(flange[i if len(flange) > 1 else 0, pose if flange.shape[1] > 1 else 0])
            a = _focal(times(T, frame(mount[i, pose if mount.shape[1] > 1 else 0])), f)
            if sheet.shape[1] > 1:
                total += _on_own_planes(i, rows, image, known, lens, f, sheet, a, E)
            elif store:
                total += _errors(i, rows, image, known, lens, _light(sheet[i, 0], f), a, E, tile)
            else:
                total += _squares(i, rows, image, known, lens, _light(sheet[i, 0], f), a)
        J[i] = total if np.isfinite(total) else np.inf


@compiled
def _focal(a, f):  # type: ignore[no-untyped-def]
    """T_base_camera for rays (x, y, 1), whose z stands for f."""
    r_xx, r_xy, r_xz, t_x, r_yx, r_yy, r_yz, t_y, r_zx, r_zy, r_zz, t_z = a
    return r_xx, r_xy, r_xz * f, t_x, r_yx, r_yy, r_yz * f, t_y, r_zx, r_zy, r_zz * f, t_z


@compiled
def _light(plane, f):  # type: ignore[no-untyped-def]
    """The laser plane for rays (x, y, 1)."""
    return plane[0], plane[1], plane[2] * f, plane[3]


@compiled
def _error(i, r, image, known, lens, light, a):  # type: ignore[no-untyped-def]
    x_0, y_0, s_x, s_y, k = lens
    n_x, n_y, n_f, d = light
    r_xx, r_xy, r_xf, t_x, r_yx, r_yy, r_yf, t_y, r_zx, r_zy, r_zf, t_z = a
    at, to = i if image.shape[1] > 1 else 0, i if known.shape[1] > 1 else 0
    x, y = (image[0, at, r] - x_0) * s_x, (image[1, at, r] - y_0) * s_y
    grown = 1.0 + k * (x * x + y * y)
    x, y = x * grown, y * grown
    rho = d / (n_x * x + n_y * y + n_f)
    return (
        known[0, to, r] - t_x - rho * (r_xx * x + r_xy * y + r_xf),
        known[1, to, r] - t_y - rho * (r_yx * x + r_yy * y + r_yf),
        known[2, to, r] - t_z - rho * (r_zx * x + r_zy * y + r_zf),
    )


@compiled
def _squares(i, rows, image, known, lens, light, a):  # type: ignore[no-untyped-def]
    J = 0.0
    for r in range(rows[0], rows[1]):
        x, y, z = _error(i, r, image, known, lens, light, a)
        J += x * x + y * y + z * z
    return J


@compiled
def _errors(i, rows, image, known, lens, light, a, E, tile):  # type: ignore[no-untyped-def]
    """Residuals into E by way of a tile whose axes lie apart: vector code cannot write every third number."""
    J = 0.0
    for start in range(rows[0], rows[1], np.uintp(TILE)):
        size = min(np.uintp(TILE), rows[1] - start)
        for r in range(size):
            x, y, z = _error(i, start + r, image, known, lens, light, a)
            J += x * x + y * y + z * z
            tile[0, r], tile[1, r], tile[2, r] = x, y, z
        for r in range(size):
            E[i, start + r, 0], E[i, start + r, 1], E[i, start + r, 2] = tile[0, r], tile[1, r], tile[2, r]
    return J


@compiled
def _on_own_planes(i, rows, image, known, lens, f, sheet, a, E):  # type: ignore[no-untyped-def]
    J = 0.0
    for r in range(rows[0], rows[1]):
        x, y, z = _error(i, r, image, known, lens, _light(sheet[i, r], f), a)
        J += x * x + y * y + z * z
        if len(E) > 0:
            E[i, r, 0], E[i, r, 1], E[i, r, 2] = x, y, z
    return J


def warm_up() -> None:
    """Compile all that is called from outside."""
    zyz, along_u = False, True
    own, bracket, image, known = np.ones((1, 14)), np.eye(3), np.ones((2, 1, 1)), np.ones((3, 1, 1))
    J, frames, runs = np.empty(1), np.zeros((1, 1, 4, 4)), np.array([[0, 0, 1]])
    costs(0, 1, own, bracket, zyz, along_u, image, known, J)
    camera, sheet, mount = unpacked(own, bracket, zyz, along_u)
    residuals(0, 1, 0, 1, camera, sheet, mount, frames, runs, image, known, np.empty((1, 1, 3)), J)
