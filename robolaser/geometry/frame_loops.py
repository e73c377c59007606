"""Rigid motions in compiled loops: a frame is a tuple, its upper three rows one after the other."""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled.decorators import compiled

Frame = tuple[float, float, float, float, float, float, float, float, float, float, float, float]


@compiled
def frame(T: Array) -> Any:
    """The tuple of a matrix, (3 or 4, 4)."""
    return (
        T[0, 0], T[0, 1], T[0, 2], T[0, 3],
        T[1, 0], T[1, 1], T[1, 2], T[1, 3],
        T[2, 0], T[2, 1], T[2, 2], T[2, 3],
    )  # fmt: skip


@compiled
def times(a: Frame, b: Frame) -> Any:
    """T_a_c = T_a_b T_b_c."""
    a_0, a_1, a_2, a_3, a_4, a_5, a_6, a_7, a_8, a_9, a_10, a_11 = a
    b_0, b_1, b_2, b_3, b_4, b_5, b_6, b_7, b_8, b_9, b_10, b_11 = b
    return (
        a_0 * b_0 + a_1 * b_4 + a_2 * b_8,
        a_0 * b_1 + a_1 * b_5 + a_2 * b_9,
        a_0 * b_2 + a_1 * b_6 + a_2 * b_10,
        a_0 * b_3 + a_1 * b_7 + a_2 * b_11 + a_3,
        a_4 * b_0 + a_5 * b_4 + a_6 * b_8,
        a_4 * b_1 + a_5 * b_5 + a_6 * b_9,
        a_4 * b_2 + a_5 * b_6 + a_6 * b_10,
        a_4 * b_3 + a_5 * b_7 + a_6 * b_11 + a_7,
        a_8 * b_0 + a_9 * b_4 + a_10 * b_8,
        a_8 * b_1 + a_9 * b_5 + a_10 * b_9,
        a_8 * b_2 + a_9 * b_6 + a_10 * b_10,
        a_8 * b_3 + a_9 * b_7 + a_10 * b_11 + a_11,
    )


@compiled
def turned_xyz(w: float, phi: float, psi: float) -> Any:
    """R_x(w) R_y(φ) R_z(ψ)."""
    s_w, s_p, s_q = np.sin(w), np.sin(phi), np.sin(psi)
    c_w, c_p, c_q = np.cos(w), np.cos(phi), np.cos(psi)
    return (
        c_p * c_q, -c_p * s_q, s_p, 0.0,
        s_w * s_p * c_q + c_w * s_q, -s_w * s_p * s_q + c_w * c_q, -s_w * c_p, 0.0,
        -c_w * s_p * c_q + s_w * s_q, c_w * s_p * s_q + s_w * c_q, c_w * c_p, 0.0,
    )  # fmt: skip


@compiled
def turned_zyz(w: float, phi: float, psi: float) -> Any:
    """R_z(w) R_y(φ) R_z(ψ)."""
    s_w, s_p, s_q = np.sin(w), np.sin(phi), np.sin(psi)
    c_w, c_p, c_q = np.cos(w), np.cos(phi), np.cos(psi)
    return (
        c_w * c_p * c_q - s_w * s_q, -c_w * c_p * s_q - s_w * c_q, c_w * s_p, 0.0,
        s_w * c_p * c_q + c_w * s_q, -s_w * c_p * s_q + c_w * c_q, s_w * s_p, 0.0,
        -s_p * c_q, s_p * s_q, c_p, 0.0,
    )  # fmt: skip
