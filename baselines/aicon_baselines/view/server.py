"""viser, the server of the page; without it, an error says what to install."""

import logging
import socket
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from urllib.parse import urlsplit

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.extras import naming_extra

with naming_extra():
    import viser

    from aicon_baselines.view.guard import Guard

__all__ = ["PageServer", "serve", "viser"]

_LOGGER = logging.getLogger(__name__)


class PageServer(viser.ViserServer):
    """The server of a page, which other pages cannot talk to and no message makes public.

    Args:
        host: Address to listen at.
        port: Port of the page; where it is taken, the next free one.
        names: Names by which the page may be called, besides `localhost` and the address.
    """

    def __init__(self, host: str, port: int, names: Sequence[str] = ()) -> None:
        self._guard = Guard(host, names)
        with self._guard.on_duty():
            super().__init__(host, port, label="aicon", verbose=False)
        self.gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")

    @contextmanager
    def waiting(self, note: str) -> Iterator[None]:
        """Show a note on the page while what it will show is made."""
        shown = self.gui.add_markdown(f"*{note}*")
        try:
            yield
        finally:
            shown.remove()

    def request_share_url(self, verbose: bool = True) -> None:
        """Refuse: every message of a page could ask for a public address."""
        _LOGGER.warning("A page asked for a public address; refused, since --share was not given.")

    def share(self) -> str:
        """Make the page public through viser's server, `share.viser.studio`.

        Returns:
            The public address. Who knows it, sees the page and steers the policy.

        Raises:
            ComparisonError: If that server does not answer.
        """
        address = super().request_share_url(verbose=False)
        name = urlsplit(address or "").hostname
        if address is None or name is None:
            raise ComparisonError("there is no public address: share.viser.studio does not answer")

        self._guard.allow(name)
        return address


def serve(host: str, port: int, names: Sequence[str] = ()) -> PageServer:
    """Start a server.

    Args:
        host: Address to listen at.
        port: Port of the page; where it is taken, the next free one.
        names: Names by which the page may be called, besides `localhost` and the address.

    Raises:
        ComparisonError: If it cannot listen there.
    """
    # viser tries one port after the other, also where the address is to blame.
    try:
        socket.create_server((host, 0)).close()
    except OSError as error:
        raise ComparisonError(f"cannot listen at {host!r}: {error.strerror or error}") from error

    import rich  # with which viser says where the page is, as who starts it does anyway

    rich.get_console().quiet = True
    return PageServer(host, port, names)
