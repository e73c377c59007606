"""The camera: a server that draws what it sees, picture after picture, for whoever connects."""

import socket
import socketserver
import threading
import time
from collections.abc import Iterable
from contextlib import suppress
from typing import final

import cv2
import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.world.world import EmulatedWorld

FRAMES_A_S = 15.0
BUFFER_BYTES = 65536
"""What waits at most in the system for a slow client: a fraction of a frame."""


@final
class CameraServer:
    """A camera in a world. A client's next frame is drawn when the last one is on its way: a slow one misses some."""

    def __init__(self, world: EmulatedWorld, rng: np.random.Generator) -> None:
        self._world, self._rng, self._lit = world, rng, False
        self._drawing = threading.Lock()
        self._broken: Exception | None = None
        self._ended = False
        frames_to = self._send_frames

        class Client(socketserver.BaseRequestHandler):
            def handle(self) -> None:
                frames_to(self.request)

        self._server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), Client)
        self._server.daemon_threads = True
        self.address = f"tcp://127.0.0.1:{self._server.server_address[1]}"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True)
        self._thread.start()

    def follow(self, path: Iterable[Array], *, lit: bool) -> None:
        """Say where the encoders went, (j,) each [rad], and whether the laser is on at the end of it.

        Raises:
            Exception: Whatever broke while it drew.
        """
        if self._broken is not None:
            raise self._broken
        for motor in path:
            self._world.follow(motor)
        self._lit = lit

    def close(self) -> None:
        """Stop, and let go of everyone."""
        self._ended = True
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def _send_frames(self, client: socket.socket) -> None:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        with suppress(OSError):  # the client left
            while not self._ended:
                began = time.monotonic()
                try:
                    frame = self._drawn()
                except Exception as error:  # the one who tells of the arm must hear of it
                    self._broken = error
                    return
                client.sendall(frame)
                time.sleep(max(0.0, began + 1 / FRAMES_A_S - time.monotonic()))

    def _drawn(self) -> bytes:
        with self._drawing:
            image = self._world.photograph(self._rng, lit=self._lit)
        return cv2.imencode(".pgm", image)[1].tobytes()
