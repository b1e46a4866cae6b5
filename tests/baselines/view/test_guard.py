"""The page obeys those who opened it, and no other page in their browser."""

import http.client
import logging
from collections.abc import Iterator

import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")

import msgspec
import viser
from _browser import wait_until
from websockets.datastructures import Headers
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.view import PageServer, serve
from aicon_baselines.view.guard import Guard

VERSION = f"viser-v{viser.__version__}"


@pytest.fixture(scope="module")
def server() -> Iterator[PageServer]:
    """A page that listens to this machine, and may be called `robot.local`, too."""
    server = serve("127.0.0.1", 0, ["robot.local"])
    yield server
    server.stop()


def status_of(server: PageServer, **headers: str) -> int:
    """The status of a request for the page."""
    port = server.get_port()
    connection = http.client.HTTPConnection("127.0.0.1", port)
    filled = {name: value.format(port=port) for name, value in headers.items()}
    connection.request("GET", "/", headers=filled)
    status = connection.getresponse().status
    connection.close()
    return status


@pytest.mark.parametrize("name", ["localhost", "127.0.0.1", "LOCALHOST", "[::1]", "robot.local"])
def test_the_page_is_there_by_its_own_names(server: PageServer, name: str) -> None:
    assert status_of(server, Host=f"{name}:{{port}}") == 200


@pytest.mark.parametrize("host", ["rebound.example:{port}", "192.168.1.5", "localhost.example", ""])
def test_a_foreign_host_is_refused(server: PageServer, host: str) -> None:
    assert status_of(server, Host=host) == 403


def test_a_foreign_host_is_told_what_would_help(server: PageServer) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", server.get_port())
    connection.request("GET", "/", headers={"Host": "lab.example"})
    assert "if it is yours: --allow-host lab.example" in connection.getresponse().read().decode()
    connection.close()


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "http://localhost:3000", "https://127.0.0.1", "null", ""]
)
def test_another_page_cannot_open_a_websocket(server: PageServer, origin: str) -> None:
    address = f"ws://127.0.0.1:{server.get_port()}"
    with pytest.raises(InvalidStatus, match="403"):
        connect(address, origin=Origin(origin), subprotocols=[VERSION])  # type: ignore[list-item]


def test_its_own_page_can(server: PageServer) -> None:
    own = f"127.0.0.1:{server.get_port()}"
    origin = Origin(f"http://{own}")
    with connect(f"ws://{own}", origin=origin, subprotocols=[VERSION]) as page:  # type: ignore[list-item]
        assert page.recv(timeout=60)


def test_no_other_page_may_frame_it(server: PageServer) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", server.get_port())
    connection.request("GET", "/")
    headers = connection.getresponse().headers
    assert headers["Content-Security-Policy"] == "frame-ancestors 'self'"
    connection.close()


def test_no_message_makes_it_public(
    server: PageServer, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    opened: list[object] = []

    class Tunnel:
        def __init__(self, *address: object) -> None:
            opened.append(address)

    monkeypatch.setattr("viser._viser.ViserTunnel", Tunnel)
    own = f"127.0.0.1:{server.get_port()}"
    with (
        caplog.at_level(logging.WARNING),
        connect(f"ws://{own}", subprotocols=[VERSION]) as page,  # type: ignore[list-item]
    ):
        page.send(msgspec.msgpack.encode({"type": "ShareUrlRequest"}))
        wait_until(lambda: bool(opened) or "public address; refused" in caplog.text)
    assert not opened


def test_asked_for_it_becomes_public_by_that_name(
    server: PageServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    public = "https://some-words.share.viser.studio"
    monkeypatch.setattr(viser.ViserServer, "request_share_url", lambda *_, **__: public)
    assert status_of(server, Host="some-words.share.viser.studio") == 403
    assert server.share() == public
    assert status_of(server, Host="some-words.share.viser.studio", Origin=public) == 200


def test_a_server_that_does_not_answer_is_named(
    server: PageServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viser.ViserServer, "request_share_url", lambda *_, **__: None)
    with pytest.raises(ComparisonError, match=r"share\.viser\.studio does not answer"):
        server.share()


def test_who_listens_everywhere_answers_to_any_number_but_no_unknown_name() -> None:
    guard = Guard("0.0.0.0")
    assert guard.objection(Headers(Host="192.168.1.5:8080")) is None
    assert guard.objection(Headers(Host="[fe80::1]:8080")) is None
    assert guard.objection(Headers(Host="rebound.example")) is not None


@pytest.mark.parametrize("host", ["[::1", "0.0.0.0", ":8080", "evil@localhost"])
def test_what_is_no_name_is_refused(host: str) -> None:
    assert Guard("127.0.0.1").objection(Headers(Host=host)) is not None


def test_two_hosts_are_one_too_many() -> None:
    headers = Headers([("Host", "localhost"), ("Host", "evil.example")])
    assert Guard("127.0.0.1").objection(headers) is not None


def test_a_viser_that_starts_otherwise_is_not_left_alone() -> None:
    with pytest.raises(RuntimeError, match="cannot be guarded"), Guard("127.0.0.1").on_duty():
        pass
