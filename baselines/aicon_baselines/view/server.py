"""viser, the server of the page; without it, an error says what to install."""

from aicon_baselines.extras import missing_extra

try:
    import viser
except ModuleNotFoundError as error:
    raise missing_extra(error) from error

__all__ = ["viser"]
