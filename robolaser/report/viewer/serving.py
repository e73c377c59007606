"""The scene in a browser: sliders for the joints and the poses, a switch between the models."""

import io
import socket
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING, Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import DependencyMissing, RobolaserError
from robolaser.report.viewer.drawing import drawn
from robolaser.report.viewer.model import Belief
from robolaser.report.viewer.scene import arm_length, cell, measured
from robolaser.report.viewer.shapes import Dots, Shape

if TYPE_CHECKING:
    from viser import ViserServer

HOST = "127.0.0.1"  # nobody else on the network needs to see the cell
WIDEST = 360.0  # degrees to either side, for joints without limits
FROM = np.array([0.5, -1.0, 0.45])  # in sizes of what there is to see
SMALLEST_M = 1e-6  # that is told
LIGHT, MIDDLE = (232, 234, 237), (205, 209, 214)
STEPS = {"°": 0.1, "mm": 0.1}


@final
class ViewerApp:
    """What is shown, and what can be done with it.

    Args:
        beliefs: The models to switch between; the last is shown first.
        cloud: A cloud to show with them.
        port: Where to serve; a free one when absent.

    Raises:
        DependencyMissing: viser is not installed.
        RobolaserError: Nobody can listen there.
    """

    def __init__(self, beliefs: tuple[Belief, ...], cloud: Dots | None = None, port: int | None = None) -> None:
        self._server = _served(port)
        self._turn_by_turn = threading.RLock()  # browsers are heard on many threads
        self._beliefs = {belief.name: belief for belief in beliefs}
        self._belief = beliefs[-1]
        self._arm_m = arm_length(self._belief.dataset)
        self._handles: dict[str, Any] = {}
        self._telling = True  # whether changes of sliders come from the user
        self._pose: int | None = 0
        self._groups = _groups(self._belief, has_cloud=cloud is not None)
        with self._turn_by_turn:
            self._declare()
            if cloud is not None:
                self._put(cloud)
            self._stay()
            self._move()
            self._look()

    @property
    def url(self) -> str:
        """Where it is to be seen."""
        return f"http://{HOST}:{self._server.get_port()}"

    def wait(self) -> None:
        """Serve until the process is interrupted."""
        self._server.sleep_forever()

    def stop(self) -> None:
        """Serve no longer."""
        self._server.stop()

    def _declare(self) -> None:
        gui, dataset = self._server.gui, self._belief.dataset
        gui.configure_theme(show_logo=False, show_share_button=False, control_layout="collapsible")
        gui.set_panel_label(dataset.name[:60])
        self._model = gui.add_dropdown("Model", tuple(self._beliefs), initial_value=self._belief.name)
        self._model.on_update(self._heard(self._switch))
        self._told = gui.add_markdown(_told(self._beliefs.values()))
        last = len(dataset.poses) - 1
        self._number = gui.add_slider("Row of poses.csv", 0, max(last, 1), 1, 0, disabled=last == 0)
        self._number.on_update(self._heard(self._choose))
        self._name: Any = gui.add_text("Pose", dataset.poses.names[0], disabled=True)
        self._sliders: list[Any] = []
        if dataset.robot is not None:
            with gui.add_folder("Joints"):
                self._sliders = [self._slider(i) for i in range(len(dataset.robot.joints))]
        with gui.add_folder("Show"):
            self._shown = {group: gui.add_checkbox(group, initial_value=True) for group in self._groups}
        for box in self._shown.values():
            box.on_update(self._heard(self._reveal))

    def _heard(self, act: Callable[[], None]) -> Callable[[Any], None]:
        """What a change in the browser calls: one after the other, each by what the sliders say when it is its turn."""

        def locked(_: Any) -> None:
            with self._turn_by_turn:
                act()

        return locked

    def _slider(self, joint: int) -> Any:
        robot, poses = self._belief.dataset.robot, self._belief.dataset.poses
        assert robot is not None  # whose joint it is
        assert poses.q is not None
        unit, factor = self._unit(joint)
        own = factor * poses.q[:, joint]
        low, high = (
            float(np.clip(factor * end, -WIDEST, WIDEST) if unit == "°" else factor * end)
            for end in (robot.lower[joint], robot.upper[joint])
        )
        low, high = (np.floor(min(low, own.min())), np.ceil(max(high, own.max())))
        slider = self._server.gui.add_slider(
            f"{robot.joints[joint]} [{unit}]", float(low), float(high), STEPS[unit], round(float(own[0]), 1)
        )
        slider.on_update(self._heard(self._turn))
        return slider

    def _unit(self, joint: int) -> tuple[str, float]:
        robot = self._belief.dataset.robot
        assert robot is not None  # as above
        return ("mm", 1e3) if robot.prismatic[joint] else ("°", 180.0 / np.pi)

    def _switch(self) -> None:
        self._belief = self._beliefs[self._model.value]
        self._stay()
        self._move()

    def _choose(self) -> None:
        """Go to a pose of the data set."""
        self._pose = min(int(self._number.value), len(self._belief.dataset.poses) - 1)
        q = self._belief.dataset.poses.q
        self._name.value = self._belief.dataset.poses.names[self._pose]
        with self._quietly():
            for joint, slider in enumerate(self._sliders):
                assert q is not None  # there are sliders, so there are joints
                slider.value = round(float(self._unit(joint)[1] * q[self._pose, joint]), 1)
        self._move()

    def _turn(self) -> None:
        """Go where the sliders are."""
        if self._telling:
            self._pose = None
            self._name.value = ""
            self._move()

    @contextmanager
    def _quietly(self) -> Iterator[None]:
        self._telling = False
        try:
            yield
        finally:
            self._telling = True

    def _move(self) -> None:
        belief = self._belief
        posture = belief.at(self._q()) if self._pose is None else belief.at_pose(self._pose)
        self._show(("robot", "scanner", "light"), cell(belief, posture, self._arm_m))

    def _stay(self) -> None:
        self._show(("target", "points"), measured(self._belief, tuple(self._beliefs.values())))

    def _q(self) -> Array:
        return np.array([slider.value / self._unit(joint)[1] for joint, slider in enumerate(self._sliders)])

    def _show(self, groups: tuple[str, ...], shapes: tuple[Shape, ...]) -> None:
        """Put the shapes of some groups in the place of those that are there."""
        gone = {name for name in self._handles if name.split("/")[0] in groups} - {shape.name for shape in shapes}
        with self._server.atomic():
            for name in gone:
                self._handles.pop(name).remove()
            for shape in shapes:
                self._put(shape)

    def _put(self, shape: Shape) -> None:
        self._handles[shape.name] = drawn(self._server.scene, shape)
        self._handles[shape.name].visible = self._shown[shape.name.split("/")[0]].value

    def _reveal(self) -> None:
        for name, handle in self._handles.items():
            handle.visible = self._shown[name.split("/")[0]].value

    def _look(self) -> None:
        """From beside, so that arm and target are in view."""
        scene, camera = self._server.scene, self._server.initial_camera
        scene.set_up_direction("+z")
        arm_m, belief = self._arm_m, self._belief
        ground: dict[str, Any] = {"cell_size": 0.1, "section_size": 0.5, "cell_color": LIGHT, "section_color": MIDDLE}
        scene.add_grid("ground", 3.0, 3.0, **ground, fade_distance=4 * arm_m + 2.0)
        seen = [belief.at_pose(0).flange[:3, 3], *belief.target[:: max(1, len(belief.target) // 100)]]
        if belief.dataset.robot is not None:
            seen.append(np.zeros(3))
        low, high = np.min(seen, axis=0), np.max(seen, axis=0)
        middle = (low + high) / 2
        camera.look_at = tuple(middle)
        camera.position = tuple(middle + max(float(np.linalg.norm(high - low)), arm_m) * FROM)


def _groups(belief: Belief, *, has_cloud: bool) -> tuple[str, ...]:
    """What can be shown and hidden."""
    scanner = () if belief.sight is None else ("scanner", "light")
    known = ("target",) * bool(len(belief.target))
    return ("robot", *scanner, *known, *("points",) * bool(len(belief.points)), *("cloud",) * has_cloud)


def _told(beliefs: Iterable[Belief]) -> str:
    """How far the measured points lie from the target, by each model."""
    told = []
    for belief in beliefs:
        if belief.sight is None:
            return f"Only the arm is drawn: a sensor of kind {belief.dataset.kind} has neither camera nor light."
        apart = np.linalg.norm(belief.points - belief.target, axis=-1) if len(belief.target) else np.empty(0)
        apart = apart[np.isfinite(apart)]
        if len(apart):
            told.append(f"{belief.name}: **{_millimetres(float(np.sqrt(np.mean(apart**2))))}**")
    return f"Points from the target, root mean square: {'; '.join(told)}" if told else "No points were measured."


def _millimetres(length_m: float) -> str:
    return f"{1e3 * length_m:.3g} mm" if length_m > SMALLEST_M else f"below {1e3 * SMALLEST_M:g} mm"


def _served(port: int | None) -> "ViserServer":
    try:
        import viser  # noqa: PLC0415 - an extra
    except ImportError:
        raise DependencyMissing(
            "viser is not installed, which shows the scene: pip install 'robolaser[view]'."
        ) from None
    if port is not None:
        try:
            with socket.socket() as trial:
                trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                trial.bind((HOST, port))
        except OSError as error:
            reason = error.strerror or str(error)
            raise RobolaserError(f"Cannot serve at port {port}: {reason}. Choose another --port.") from None
    make: Callable[..., ViserServer] = viser.ViserServer
    with redirect_stdout(io.StringIO()):  # its own greeting
        return make(host=HOST, port=8080 if port is None else port, verbose=False)
