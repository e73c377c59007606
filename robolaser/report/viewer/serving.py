"""The scene in a browser: sliders for the joints and the poses, a switch between the models."""

import io
import socket
import threading
from collections.abc import Callable, Iterable
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import rms
from robolaser.errors import RobolaserError
from robolaser.plugins import extra
from robolaser.report.digits import millimetres
from robolaser.report.viewer.scene import SceneNode, ShownCell, fixed_shapes, moving_shapes
from robolaser.robot.collision_bodies import arm_length

if TYPE_CHECKING:
    from viser import ViserServer

HOST = "127.0.0.1"  # only this machine has access
WIDEST = 360.0  # degrees to either side, for joints without limits
FROM = np.array([0.5, -1.0, 0.45])  # in sizes of the scene
SMALLEST_M = 1e-6  # shown; smaller lengths are "below" it
LIGHT, MIDDLE = (232, 234, 237), (205, 209, 214)
STEP = 0.1  # of a slider [° or mm]


@final
class ViewerApp:
    """The scene in the browser with its panel of controls.

    The last of several models is shown first. `collisions` gives those at joint values (j,), in words, and the shapes
    to show there. Without a port, it is served at a free one.

    Raises:
        DependencyMissing: viser is not installed.
        RobolaserError: The port is taken or not allowed.
    """

    def __init__(
        self,
        models: tuple[ShownCell, ...],
        cloud: SceneNode | None = None,
        port: int | None = None,
        collisions: Callable[[Array], tuple[str, tuple[SceneNode, ...]]] | None = None,
    ) -> None:
        self._server = _server(port)
        self._lock = threading.RLock()  # callbacks from browsers run on many threads
        self._models = {model.name: model for model in models}
        self._current = models[-1]
        self._arm_m = arm_length(self._current.dataset.robot)
        self._handles: dict[str, Any] = {}
        self._hears_sliders = True  # false while the program moves them
        self._pose: int | None = 0
        self._collisions = collisions
        further = {"target": len(self._current.target), "points": len(self._current.points), "cloud": cloud is not None,
                   "bodies": collisions is not None}  # fmt: skip
        self._groups = ("robot", *self._current.groups, *(name for name, there in further.items() if there))
        with self._lock:
            self._build_panel()
            if cloud is not None:
                self._put(cloud)
            self._show_fixed()
            self._show_moving()
            self._place_camera()

    @property
    def url(self) -> str:
        """Its address."""
        return f"http://{HOST}:{self._server.get_port()}"

    def wait(self) -> None:
        """Serve until the process is interrupted."""
        self._server.sleep_forever()

    def stop(self) -> None:
        """Stop serving, without a message on standard output."""
        with redirect_stdout(io.StringIO()):
            self._server.stop()

    def _build_panel(self) -> None:
        gui, dataset = self._server.gui, self._current.dataset
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.set_panel_label(dataset.name[:60])
        self._model = gui.add_dropdown("Model", tuple(self._models), initial_value=self._current.name)
        self._model.on_update(self._locked(self._switch_model))
        gui.add_markdown(_rms_note(self._models.values()))
        last = len(dataset.poses) - 1
        self._number = gui.add_slider("Row of poses.csv", 0, max(last, 1), 1, 0, disabled=last == 0)
        self._number.on_update(self._locked(self._go_to_pose))
        self._name: Any = gui.add_text("Pose", dataset.poses.names[0], disabled=True)
        self._sliders: list[Any] = []
        if dataset.robot is not None:
            with gui.add_folder("Joints"):
                self._sliders = [self._slider(i) for i in range(len(dataset.robot.joints))]
        if self._collisions is not None:
            self._hits: Any = gui.add_text("Here", "", disabled=True)
        with gui.add_folder("Show"):
            self._shown = {group: gui.add_checkbox(group, initial_value=True) for group in self._groups}
        for box in self._shown.values():
            box.on_update(self._locked(self._apply_visibility))

    def _locked(self, act: Callable[[], None]) -> Callable[[Any], None]:
        """A callback for a change in the browser; callbacks run one at a time, each with the newest values."""

        def locked(_: Any) -> None:
            with self._lock:
                act()

        return locked

    def _slider(self, joint: int) -> Any:
        robot, q = self._current.dataset.arm
        unit, factor = self._unit(joint)
        own, widest = factor * q[:, joint], WIDEST if unit == "°" else np.inf
        low = np.floor(min(max(factor * robot.lower[joint], -widest), own.min()))
        high = np.ceil(max(min(factor * robot.upper[joint], widest), own.max()))
        name = f"{robot.joints[joint]} [{unit}]"
        slider = self._server.gui.add_slider(name, float(low), float(high), STEP, round(float(own[0]), 1))
        slider.on_update(self._locked(self._follow_sliders))
        return slider

    def _unit(self, joint: int) -> tuple[str, float]:
        robot, _ = self._current.dataset.arm
        return ("mm", 1e3) if robot.prismatic[joint] else ("°", 180.0 / np.pi)

    def _switch_model(self) -> None:
        self._current = self._models[self._model.value]
        self._show_fixed()
        self._show_moving()

    def _go_to_pose(self) -> None:
        self._pose = min(int(self._number.value), len(self._current.dataset.poses) - 1)
        self._name.value = self._current.dataset.poses.names[self._pose]
        self._hears_sliders = False
        try:
            for joint, slider in enumerate(self._sliders):
                _, q = self._current.dataset.arm
                slider.value = round(float(self._unit(joint)[1] * q[self._pose, joint]), 1)
        finally:
            self._hears_sliders = True
        self._show_moving()

    def _follow_sliders(self) -> None:
        """Show the cell at the joint angles of the sliders."""
        if self._hears_sliders:
            self._pose = None
            self._name.value = ""
            self._show_moving()

    def _show_moving(self) -> None:
        model = self._current
        frames = model.at(self._q()) if self._pose is None else model.at_pose(self._pose)
        self._show(("robot", "sensor", "light"), moving_shapes(model, frames))
        if self._collisions is not None:
            q = self._q() if self._pose is None else model.dataset.arm[1][self._pose]
            self._hits.value, shapes = self._collisions(q)
            self._show(("bodies",), shapes)

    def _show_fixed(self) -> None:
        self._show(("target", "points"), fixed_shapes(self._current, tuple(self._models.values())))

    def _q(self) -> Array:
        return np.array([slider.value / self._unit(joint)[1] for joint, slider in enumerate(self._sliders)])

    def _show(self, groups: tuple[str, ...], shapes: tuple[SceneNode, ...]) -> None:
        """Replace the shapes of some groups."""
        gone = {name for name in self._handles if name.split("/")[0] in groups} - {shape.name for shape in shapes}
        with self._server.atomic():
            for name in gone:
                self._handles.pop(name).remove()
            for shape in shapes:
                self._put(shape)

    def _put(self, shape: SceneNode) -> None:
        self._handles[shape.name] = shape.draw(self._server.scene)
        self._handles[shape.name].visible = self._shown[shape.name.split("/")[0]].value

    def _apply_visibility(self) -> None:
        for name, handle in self._handles.items():
            handle.visible = self._shown[name.split("/")[0]].value

    def _place_camera(self) -> None:
        """Move the camera beside the cell, with arm and target in view."""
        scene, camera = self._server.scene, self._server.initial_camera
        scene.set_up_direction("+z")
        arm_m, model = self._arm_m, self._current
        ground: dict[str, Any] = {"cell_size": 0.1, "section_size": 0.5, "cell_color": LIGHT, "section_color": MIDDLE}
        scene.add_grid("ground", 3.0, 3.0, **ground, fade_distance=4 * arm_m + 2.0)
        seen = [model.at_pose(0).flange[:3, 3], *model.target[:: max(1, len(model.target) // 100)]]
        if model.dataset.robot is not None:
            seen.append(np.zeros(3))
        low, high = np.min(seen, axis=0), np.max(seen, axis=0)
        middle = (low + high) / 2
        camera.look_at = tuple(middle)
        camera.position = tuple(middle + max(float(np.linalg.norm(high - low)), arm_m) * FROM)


def _rms_note(models: Iterable[ShownCell]) -> str:
    """Distances of the measured points from the target, by each model."""
    parts = []
    for model in models:
        if not model.groups and not len(model.points):
            return (
                f"Only the arm is drawn: a {model.dataset.format.title} has neither camera nor light. Name a"
                " calibration to see its points."
            )
        apart = model.points - model.target if len(model.target) else np.empty((0, 3))
        apart = apart[np.isfinite(apart).all(axis=1)]
        if len(apart):
            size = rms(apart)
            text = millimetres(size) if size > SMALLEST_M else f"below {millimetres(SMALLEST_M)}"
            parts.append(f"{model.name}: **{text}**")
    return f"Points from the target, root mean square: {'; '.join(parts)}" if parts else "No points were measured."


def _server(port: int | None) -> "ViserServer":
    viser = extra("viser", "viser is not installed, which shows the scene: pip install 'robolaser[view]'.")
    if port is not None:
        try:
            with socket.socket() as trial:
                trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                trial.bind((HOST, port))
        except OSError as error:
            reason = error.strerror or error
            raise RobolaserError(f"Cannot serve at port {port}: {reason}. Choose another --port.") from None
    make: Callable[..., ViserServer] = viser.ViserServer
    with redirect_stdout(io.StringIO()):  # its welcome message
        return make(host=HOST, port=8080 if port is None else port, verbose=False)
