"""The extras of the wheel: which optional modules belong to which, and what to say without them."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec

from aicon_baselines.evaluation.errors import ComparisonError

EXTRAS: Mapping[str, tuple[str, ...]] = {
    "compare": ("imageio", "joblib", "matplotlib", "tqdm"),
    "pusht": ("pymunk", "pygame"),
    "panda": ("mujoco",),  # and example-robot-data, which is files without a module
    "robots": ("pytorch_kinematics", "trimesh", "collada", "mujoco"),
    "reach": ("mujoco", "trimesh"),  # and example-robot-data, as for the arm
    "view": ("viser",),
    "upstream": ("gym_pusht",),
    "sb3": ("stable_baselines3",),
    "lerobot": ("lerobot", "diffusers"),
    "peers": ("torchjd", "quadprog", "clarabel", "pytorch_mppi", "mink"),
    "kinematics": ("pink", "placo", "daqp"),  # pink brings pinocchio
    "cluster": ("distributed",),
    "compiler": ("ziglang",),
}
"""The modules that each extra brings."""


def missing_modules(extra: str) -> tuple[str, ...]:
    """Name those modules of an extra that are not installed."""
    return tuple(module for module in EXTRAS[extra] if find_spec(module) is None)


def require(user: str, extra: str, *modules: str) -> None:
    """Refuse to go on without modules.

    Args:
        user: What needs them, such as "the dask backend".
        extra: The extra that brings them.
        *modules: Their names.

    Raises:
        ComparisonError: If one is not installed; it says how to install it.
    """
    missing = [module for module in modules if find_spec(module) is None]
    if missing:
        raise ComparisonError(f"{user} needs {' and '.join(missing)}: {pip_command(extra)}")


def extra_of(module: str | None) -> str | None:
    """Name the extra that brings a module, such as "matplotlib.figure"; None if no extra does."""
    root = (module or "").partition(".")[0]
    for extra, modules in EXTRAS.items():
        if root in modules:
            return extra
    return None


def missing_extra(error: ModuleNotFoundError) -> ModuleNotFoundError:
    """Return the error to raise where a module could not be imported: it says what to install."""
    extra = extra_of(error.name)
    remedy = f"; this needs: {pip_command(extra)}" if extra else ""
    return ModuleNotFoundError(f"{error}{remedy}", name=error.name)


@contextmanager
def naming_extra() -> Iterator[None]:
    """Say what to install where a module cannot be imported meanwhile."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise missing_extra(error) from error


def pip_command(extra: str) -> str:
    """Return the command that installs an extra."""
    return f"pip install 'aicon-torch[{extra}]'"
