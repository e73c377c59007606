"""Only its own page and programs on this machine may look at the scene."""

import http.client

import pytest

viser = pytest.importorskip("viser")

from robolaser.report.viewer.same_origin import is_own, only_own_pages  # noqa: E402


@pytest.fixture(scope="module")
def port():
    with only_own_pages():
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server.get_port()
    server.stop()


def status(port, host, origin, *, upgrade):
    """What a request is answered with; 101 where a WebSocket is opened."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    connection.putrequest("GET", "/", skip_host=True)
    more = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"} if upgrade else {}
    more |= {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="} if upgrade else {}
    for name, value in {"Host": host, "Origin": origin, **more}.items():
        if value:
            connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse().status
    connection.close()
    return answer


@pytest.mark.parametrize("upgrade", [False, True])
@pytest.mark.parametrize(
    ("host", "origin", "own"),
    [
        ("127.0.0.1:{port}", "", True),
        ("localhost:{port}", "http://localhost:{port}", True),
        ("evil.example", "", False),
        ("evil.example:{port}", "http://evil.example:{port}", False),
        ("127.0.0.1:{port}", "http://evil.example", False),
        ("127.0.0.1:{port}", "http://127.0.0.1:1", False),
        ("127.0.0.1:{port}", "null", False),
    ],
)
def test_other_pages_and_other_names_are_refused(port, host, origin, own, upgrade):
    answer = status(port, host.format(port=port), origin.format(port=port), upgrade=upgrade)
    assert answer == ((101 if upgrade else 200) if own else 403)


def test_two_hosts_are_none():
    assert not is_own(["127.0.0.1:80", "evil.example"], [])
    assert not is_own([], [])
