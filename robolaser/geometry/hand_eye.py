"""Where a sensor sits and what it looks at, from pairs of poses: AX = ZB in closed form, with nothing given."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.geometry.rigid_motion import log_so3, nearest_rotation, pose

ROUNDS = 30
"""Of alternation between the one rotation and the others; each lowers what is left."""
RANK = 1e-9
"""Singular values of the translations' equations below this share of the largest belong to directions that no pose
determines."""


def robot_world_hand_eye(T_base_flange: Array, T_world_tool: Array, tool: Ints) -> tuple[Array, Array]:
    """T_world_base and T_flange_tool with T_world_base T_base_flange T_flange_tool = T_world_tool as nearly as can be.

    A tracker sees bodies on the flange: the world is the tracker's frame, the bodies are the tools. A camera in the
    cell sees a target on the flange: the world is the camera, the target is the tool. A camera on the flange sees a
    target in the cell: the world is the target, the camera is the tool, and what was measured is inverted. AX = XB is
    the same problem with T_world_base eliminated.

    Rotations come first: Σ tr(R_world_toolᵀ R_world_base R_base_flange R_flange_tool) is bilinear in the two that are
    sought. Its relaxation is an eigenvector (Shah 2013, Solving the robot-world/hand-eye calibration problem using the
    Kronecker product), from where the two are improved in turns. The translations are linear, given these.

    Args:
        T_base_flange: Of each measurement, (c or 1, m, 4, 4).
        T_world_tool: As measured, (c or 1, m, 4, 4).
        tool: Number of each measurement's tool, (m,); each occurs.

    Returns:
        T_world_base (c, 4, 4) and T_flange_tool of each tool (c, t, 4, 4). What the poses do not determine, see
        `turns_about_axes`, is arbitrary.
    """
    A, W = T_base_flange[..., :3, :3], T_world_tool[..., :3, :3]
    counts = np.bincount(tool)
    K = np.stack([_mixed(W[:, tool == p], A[:, tool == p]) for p in range(len(counts))], axis=1)
    _, vectors = np.linalg.eigh((K @ np.swapaxes(K, -1, -2) / counts[:, None, None]).sum(axis=1))
    relaxed = vectors[..., -1].reshape(-1, 3, 3)
    Z, _ = nearest_rotation(relaxed * np.sign(np.linalg.det(relaxed))[:, None, None])
    for _ in range(ROUNDS):
        X, _ = nearest_rotation((np.swapaxes(K, -1, -2) @ Z.reshape(-1, 1, 9, 1)).reshape(*K.shape[:2], 3, 3))
        Z, _ = nearest_rotation((K @ X.reshape(*K.shape[:2], 9, 1)).sum(axis=1).reshape(-1, 3, 3))
    shift, tools = _translations(T_base_flange, T_world_tool, tool, Z)
    return pose(Z, shift), pose(X, tools)


def _mixed(W: Array, A: Array) -> Array:
    """Coefficients of Z (rows) and X (columns) in Σ tr(Wᵀ Z A X), entries row by row, (c, 9, 9)."""
    c = max(len(W), len(A))
    W, A = (np.broadcast_to(R, (c, *R.shape[1:])) for R in (W, A))
    mixed: Array = np.einsum("cijn,cikl->cjkln", W, A, optimize=True).reshape(c, 9, 9)
    return mixed


def _translations(T_base_flange: Array, T_world_tool: Array, tool: Ints, Z: Array) -> tuple[Array, Array]:
    """Shift of T_world_base (c, 3) and of each T_flange_tool (c, t, 3), given the rotation Z of the former [m].

    Zᵀ t_world_tool − t_base_flange = R_base_flange t_flange_tool + Zᵀ t_world_base is linear in both.
    """
    c, m, t = len(Z), len(tool), int(tool.max()) + 1
    design = np.zeros((c, m, 3, 3 + 3 * t))
    design[..., :3] = np.eye(3)
    for p in range(t):
        design[:, tool == p, :, 3 + 3 * p : 6 + 3 * p] = T_base_flange[:, tool == p, :3, :3]
    right = T_world_tool[..., :3, 3] @ Z - T_base_flange[..., :3, 3]
    flat = design.reshape(c, 3 * m, -1)
    transposed = np.swapaxes(flat, 1, 2)
    inverse = np.linalg.pinv(transposed @ flat, rcond=RANK**2, hermitian=True)
    found = (inverse @ (transposed @ right.reshape(c, -1, 1)))[..., 0]
    return (Z @ found[:, :3, None])[..., 0], found[:, 3:].reshape(c, t, 3)


def turns_about_axes(R: Array) -> Array:
    """Root mean squares of how far rotations (n, 3, 3) turn from their mean, about three axes, largest first [rad].

    A hand-eye needs two that are not zero: turns about one axis alone leave the place along it open, and no turns at
    all leave all but one rotation open.
    """
    middle, _ = nearest_rotation(R.sum(axis=0))
    turns = log_so3(middle.T @ R)
    largest_first: Array = np.linalg.svd(turns, compute_uv=False) / np.sqrt(len(R))
    return np.pad(largest_first, (0, 3 - len(largest_first)))
