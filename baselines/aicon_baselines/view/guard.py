"""Who may talk to the page: whoever opened it, and no other page in the same browser.

Any page in a browser can send requests to a server on the same machine. Two headers that a page
cannot forge tell them apart. `Origin` is the page that a request comes from: it has to be this one.
`Host` is the name by which the server was found: a page that has its own name resolve to this
machine (DNS rebinding) arrives with that name.
"""

import http
import ipaddress
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any
from urllib.parse import urlsplit

import websockets.asyncio.server
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

__all__ = ["Guard"]

_HERE = ("localhost", "127.0.0.1", "::1")
_EVERYWHERE = ("0.0.0.0", "::", "")
_STARTING = threading.Lock()

Answer = Callable[..., Response | None]
"""Answers a request; None lets a websocket open."""


class Guard:
    """Refuses requests of foreign pages, by their headers `Host` and `Origin`.

    Allowed are the names of this machine for itself, the address that is listened at, and names
    given by the user. A server that listens everywhere may be called by any numeric address, since
    no page can give itself such a name.

    Args:
        host: Address that is listened at.
        names: Other names by which the page may be called.
    """

    def __init__(self, host: str, names: Sequence[str] = ()) -> None:
        self._names = {name.lower() for name in (*_HERE, host, *names)} - set(_EVERYWHERE)
        self._by_any_address = host in _EVERYWHERE

    def allow(self, name: str) -> None:
        """Let the page be called by another name, too."""
        self._names.add(name.lower())

    def objection(self, headers: Headers) -> str | None:
        """What is wrong with a request, in a sentence; None where nothing is."""
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        if len(hosts) != 1 or len(origins) > 1:
            return "a request names one host, and one origin at most"

        name = _name_of(hosts[0])
        if not self._knows(name):
            return f"this page is not called {name!r}; if it is yours: --allow-host {name}"

        # A page's own requests come from where it was fetched; programs that are no browser name
        # no origin.
        own = (f"http://{hosts[0]}".lower(), f"https://{hosts[0]}".lower())
        if origins and origins[0].lower() not in own:
            return f"{origins[0]!r} is another page, and has no business here"
        return None

    @contextmanager
    def on_duty(self) -> Iterator[None]:
        """Guard the server that viser starts meanwhile.

        viser offers no way to look at its requests, so the function that it starts its server with
        is exchanged for the moment.

        Raises:
            RuntimeError: If it was not called: this viser starts its server in another way, which
                would be without a guard.
        """
        serve = websockets.asyncio.server.serve
        guarded = []

        def serve_guarded(
            *arguments: Any, process_request: Answer, **options: Any
        ) -> websockets.asyncio.server.serve:
            guarded.append(True)
            answer = partial(self._answer, process_request)
            return serve(*arguments, process_request=answer, **options)

        with _STARTING:
            websockets.asyncio.server.serve = serve_guarded  # type: ignore[assignment,misc]
            try:
                yield
            finally:
                websockets.asyncio.server.serve = serve  # type: ignore[misc]
        if not guarded:
            raise RuntimeError("this version of viser cannot be guarded; 1.1 can")

    def _answer(self, usual: Answer, connection: Any, request: Request) -> Response | None:
        """Refuse, or answer as usual; no other page may put this one into a frame."""
        objection = self.objection(request.headers)
        if objection is not None:
            text = Headers({"Content-Type": "text/plain; charset=utf-8"})
            body = f"Refused: {objection}\n".encode()
            return Response(http.HTTPStatus.FORBIDDEN, "Forbidden", text, body)

        response = usual(connection, request)
        if response is not None:
            response.headers["Content-Security-Policy"] = "frame-ancestors 'self'"
        return response

    def _knows(self, name: str) -> bool:
        """Whether the page may be called by a name."""
        return name in self._names or (self._by_any_address and _is_address(name))


def _name_of(host: str) -> str:
    """The name in a header `Host`, without its port; empty where it has none."""
    if "@" in host:  # a user's name, which no browser sends
        return ""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:  # brackets that do not close
        return ""


def _is_address(name: str) -> bool:
    """Whether a name is a numeric address, IPv4 or IPv6."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
