"""The camera: a server that sends what it sees, picture after picture, to whoever connects."""

import socket
import socketserver
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import cv2
import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.world.world import EmulatedWorld

FRAMES_A_S = 15.0
BUFFER_BYTES = 65536
"""What waits at most in the system for a slow client: a fraction of a frame."""


@final
@dataclass(frozen=True)
class Snapshot:
    """Where the arm went, and whether the laser was on at the end of it."""

    path: Sequence[Array]  # joint angles that the encoders saw, one after the other, (j,) each [rad]
    lit: bool


@final
class CameraServer:
    """A camera in a world. One thread draws, one for each client sends; a client that is slow misses frames."""

    def __init__(self, world: EmulatedWorld, begin: Snapshot, rng: np.random.Generator) -> None:
        self._world, self._rng = world, rng
        self._snapshots: deque[Snapshot] = deque([begin])
        self._frame, self._count = b"", 0
        self._fresh = threading.Condition()
        self._watched = 0
        self._ended = False
        self._broken: Exception | None = None
        self._draw(begin)
        self._server = _server(self._send_frames)
        self.address = f"tcp://127.0.0.1:{self._server.server_address[1]}"
        self._threads = [
            threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True),
            threading.Thread(target=self._watch, daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def tell(self, snapshot: Snapshot) -> None:
        """Say how the arm went on.

        Raises:
            Exception: Whatever broke while it drew.
        """
        if self._broken is not None:
            raise self._broken
        if not self._ended:
            self._snapshots.append(snapshot)

    def close(self) -> None:
        """Stop, and let go of everyone."""
        self._end()
        self._server.shutdown()
        for thread in self._threads:
            thread.join()
        self._server.server_close()

    def _send_frames(self, client: socket.socket) -> None:
        with self._fresh:
            sent = self._count
            self._watched += 1
        try:
            while not self._ended:
                with self._fresh:
                    while self._count == sent and not self._ended:
                        self._fresh.wait()
                    frame, sent = self._frame, self._count
                client.sendall(frame)
        except OSError:
            return
        finally:
            with self._fresh:
                self._watched -= 1

    def _watch(self) -> None:
        try:
            self._go_on()
        except Exception as error:  # the one who tells of the arm must hear of it
            self._broken = error
            self._end()

    def _end(self) -> None:
        with self._fresh:
            self._ended = True
            self._fresh.notify_all()

    def _go_on(self) -> None:
        snapshot = self._snapshots[-1]
        while not self._ended:
            began = time.monotonic()
            while self._snapshots:
                snapshot = self._snapshots.popleft()
                for motor in snapshot.path:
                    self._world.follow(motor)
            if self._watched:
                self._draw(snapshot)
            time.sleep(max(0.0, began + 1 / FRAMES_A_S - time.monotonic()))

    def _draw(self, snapshot: Snapshot) -> None:
        for motor in snapshot.path[-1:]:
            self._world.follow(motor)
        image = self._world.photograph(self._rng, lit=snapshot.lit)
        frame = cv2.imencode(".pgm", image)[1].tobytes()
        with self._fresh:
            self._frame, self._count = frame, self._count + 1
            self._fresh.notify_all()


def _server(frames_to: Callable[[socket.socket], None]) -> socketserver.ThreadingTCPServer:
    class Client(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            self.request.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
            frames_to(self.request)

    server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), Client)
    server.daemon_threads = True
    return server
