"""viser, the server of the page; without it, an error says what to install."""

import socket

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.extras import missing_extra

try:
    import rich
    import viser
except ModuleNotFoundError as error:
    raise missing_extra(error) from error

__all__ = ["serve", "viser"]


def serve(host: str, port: int) -> viser.ViserServer:
    """Start a server.

    Args:
        host: Address to listen at.
        port: Port of the page; where it is taken, the next free one.

    Raises:
        ComparisonError: If it cannot listen there.
    """
    # viser tries one port after the other, also where the address is to blame.
    try:
        socket.create_server((host, 0)).close()
    except OSError as error:
        raise ComparisonError(f"cannot listen at {host!r}: {error.strerror or error}") from error

    rich.get_console().quiet = True  # who starts it says where the page is
    return viser.ViserServer(host, port, label="aicon", verbose=False)
