"""Who may look at the scene: its own page, and programs on this machine; no other page that a browser has open.

A page elsewhere can open connections to this machine, and a name of its own can be made to lead here (DNS
rebinding). The first says so in `Origin`, the second in `Host`.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from http import HTTPStatus
from importlib import import_module
from typing import Any

from robolaser.errors import DependencyMissing

LOOPBACK = ("127.0.0.1", "localhost")


def is_own(hosts: Sequence[str], origins: Sequence[str]) -> bool:
    """Whether a request names a loopback address, and comes from the page there or from no page at all.

    Args:
        hosts: Its headers `Host`.
        origins: Its headers `Origin`.
    """
    return len(hosts) == 1 and hosts[0].rpartition(":")[0] in LOOPBACK and list(origins) in ([], [f"http://{hosts[0]}"])


@contextmanager
def only_own_pages() -> Iterator[None]:
    """Let a viser server that is made here refuse all other requests.

    Raises:
        DependencyMissing: This version of viser serves in another way.
    """
    server: Any = import_module("websockets.asyncio.server")  # comes with viser
    serve, guarded = server.serve, []

    def serve_own(*args: Any, process_request: Any, **more: Any) -> Any:
        def checked(connection: Any, request: Any) -> Any:
            if is_own(request.headers.get_all("Host"), request.headers.get_all("Origin")):
                return process_request(connection, request)
            return connection.respond(HTTPStatus.FORBIDDEN, "Only pages of this address may look.\n")

        guarded.append(checked)
        return serve(*args, process_request=checked, **more)

    server.serve = serve_own
    try:
        yield
    finally:
        server.serve = serve
    if not guarded:
        raise DependencyMissing(
            "This version of viser would show the scene to any page in the browser: pip install 'robolaser[view]'"
            " with another one."
        )
