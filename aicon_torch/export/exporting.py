"""Export: the control step of a policy as a shared library that needs neither torch nor Python."""

import hashlib
import json
import math
import os
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from aicon_torch.control.memory import OUTLASTS_EPISODES
from aicon_torch.control.stages import Named, run
from aicon_torch.control.step import ControlStep
from aicon_torch.errors import OptionError
from aicon_torch.export.codegen import cached_library, compile_library, in_c, prelude
from aicon_torch.export.codegen.targets import WEB, find_target
from aicon_torch.export.flat_step import FlatStep
from aicon_torch.export.in_turn import in_turn
from aicon_torch.export.library import FORMAT, Library
from aicon_torch.files import check_folder, write_whole
from aicon_torch.graph import WorldModel
from aicon_torch.readings.validation import BEGINS

# The test that a library brings along: its steps, how many readings are drawn for it at most, and
# how many nearby ones, at which share of their size, tell what hangs on rounding. So do memories
# that differ by a unit in the last place, where little is left of large numbers.
_TEST_STEPS = 3
_TEST_SEEDS = 10
_NUDGES = 16
_NUDGE = 1e-6
_UNITS = 1.0

_STACK = 6 * 2**20
"""Bytes of its arrays up to which a step runs on a stack of 8 MiB, with room for the rest of it."""


def export(
    step: ControlStep,
    path: str | Path,
    description: Mapping[str, str],
    perceives: bool,
    target: str | None,
) -> None:
    """Write the control step of a policy to a file.

    Args:
        step: The step.
        path: A file that ends in ``.so``, for a library compiled for this kind of machine, in
            ``.wasm``, for a module that runs in web pages, or in ``.c``, for its source; with a
            target as libraries do there.
        description: What is to be known of it, such as its task.
        perceives: Whether a perception stands before it, which is not exported.
        target: The machine that the library is for, a name in
            ``aicon_torch.export.codegen.targets.TARGETS``; None for this kind of machine.

    Raises:
        OptionError: If the file's name ends otherwise, it cannot be written there, or there is no
            such target or no C compiler.
        GraphError: If an operation cannot be translated to C.
    """
    if not isinstance(path, str | os.PathLike):
        raise OptionError(f"path={path!r}: expected the name of a file.")
    path = Path(path)

    # A web page is the one target that the name of a file tells.
    if target is None and path.suffix == find_target(WEB).suffix:
        target = WEB
    _check_suffix(path, target)
    check_folder(path)
    source = library_source(step, description, perceives)
    if path.suffix == ".c":
        write_whole(path, source.encode())
    else:
        compile_library(source, path, target)


def _check_suffix(path: Path, target: str | None) -> None:
    """Check that a name ends as what shall be written to it."""
    if target is not None:
        suffix = find_target(target).suffix
        if path.suffix != suffix:
            raise OptionError(
                f"{str(path)!r}: expected a name that ends in {suffix}, as libraries for {target} "
                "do."
            )
    elif path.suffix not in (".so", ".c"):
        raise OptionError(
            f"{str(path)!r}: expected a name that ends in .so (a library for this kind of machine; "
            "another one is named by target=...), in .wasm (a module that runs in web pages) or in "
            ".c (its source, to be compiled elsewhere)."
        )


def compiled_library(step: ControlStep, perceives: bool) -> Library:
    """The control step of a policy as a library, loaded: see :func:`export` for what may fail."""
    return Library(cached_library(library_source(step, {}, perceives)), "The compiled step")


def library_source(step: ControlStep, description: Mapping[str, str], perceives: bool) -> str:
    """The source of an exported policy, in C; see :func:`export`."""
    if step.model.like.device.type != "cpu":
        raise OptionError(f"A policy on {step.model.like.device}: expected one on the CPU.")
    flat = FlatStep(step)
    _check_stack(flat)

    # Every function of the step.
    examples = flat.examples()
    functions = [prelude(step.model.like.dtype)]
    for stage in flat.stages:
        outputs = [f"new_{name}" for name in stage.gives]
        function = flat.function_of(stage)
        functions.append(in_c(stage.name, function, stage.takes, outputs, examples, stage.varying))

    # What the library says of itself, and what calls these functions.
    metadata = _metadata(flat, description, perceives)
    metadata["parameters"] = parameters_of(flat.model)

    # Of all that is computed, and of nothing that is said about it.
    metadata["fingerprint"] = hashlib.sha256("".join(functions).encode()).hexdigest()
    return "\n".join(
        [_HEADING, *functions, _constants(flat, metadata), in_turn(flat), _step(flat), _test(flat)]
    )


def _check_stack(flat: FlatStep) -> None:
    """Check that the arrays of a step, which allocates nothing, have room on the stack."""
    # Three memories: the test's, the one that begins an episode, and the one after the step.
    sizes = {name: layout.size for name, layout in flat.layouts.items()}
    count = 3 * sizes["memory"] + 2 * (sizes["values"] + sizes["descent"])
    needed = count * flat.model.like.element_size()
    if needed > _STACK:
        raise OptionError(
            f"The step needs {needed / 2**20:.0f} MiB of stack, and threads have 8: expected fewer "
            "readings. A perception reads pictures before the step (perception=...)."
        )


def parameters_of(model: WorldModel) -> str:
    """A number for the parameters of a model as they are; empty where it has none."""
    digest, parameters = hashlib.sha256(), list(model.parameters())
    for parameter in parameters:
        digest.update(parameter.detach().double().numpy(force=True).tobytes())
    return digest.hexdigest() if parameters else ""


def _metadata(flat: FlatStep, description: Mapping[str, str], perceives: bool) -> dict[str, Any]:
    """What the library says of itself."""
    model = flat.model
    sensors: list[dict[str, Any]] = []
    fields = ("size", "unit", "key", "optional", "range", "scale", "age", "age_key")
    for name, sensor in model.sensors.items():
        facts = {"name": name, **{field: getattr(sensor, field) for field in fields}}
        if sensor.range is not None:  # JSON knows no infinity
            facts["range"] = [end if math.isfinite(end) else None for end in sensor.range]
        sensors.append(facts)

    actuators: list[dict[str, Any]] = []
    for name, actuator in model.actuators.items():
        facts = {"size": actuator.size, "unit": actuator.unit, "key": actuator.key}
        actuators.append({"name": name, **facts})

    # A perception makes readings of images and the like, never of the time.
    perceived = [name for name in model.sensors if perceives and name != model.clock]
    return {
        "format": FORMAT,
        "aicon_torch": _own_version(),
        "description": dict(description),
        "dtype": str(model.like.dtype).removeprefix("torch."),
        "dt": model.dt,
        "iterations": flat.step.law.iterations,
        "sensors": sensors,
        "readings": flat.layouts["readings"].to_json(),
        "perceived": perceived,
        "actuators": actuators,
        "goals": list(model.goals),
        "memory": flat.layouts["memory"].to_json(),
        "commands": flat.layouts["commands"].to_json(),
    }


def _own_version() -> str:
    """The version that is installed."""
    try:
        return version("aicon-torch")
    except PackageNotFoundError:  # it runs out of its source
        return "not installed"


def _test(flat: FlatStep) -> str:
    """A test of the library: some readings, and what comes of them."""
    memory_size = flat.layouts["memory"].size

    # Readings whose commands hang on rounding would test nothing, and others are drawn: several
    # at once, as a step of many robots takes hardly longer than one of one.
    for seeds in ([0], range(1, _TEST_SEEDS)):
        drawn = [_test_readings(flat, seed) for seed in seeds]
        outcomes, is_settled = _outcomes(flat, torch.stack(drawn))
        settled_commands = is_settled[:, memory_size:].sum(-1)
        best = int(settled_commands.argmax())
        if is_settled[best, memory_size:].all():
            break

    return _TEST.format(
        steps=_TEST_STEPS,
        readings=_initializer(drawn[best]),
        outcome=_initializer(outcomes[best]),
        settled=_initializer(is_settled[best].int()),
    )


def _outcomes(flat: FlatStep, readings: Tensor) -> tuple[Tensor, Tensor]:
    """What comes of readings ``(D, steps, n)``, and which of it does not hang on rounding.

    What hangs on rounding tells nothing: of two gradients of one length, either may come first. It
    differs much where the readings differ by little, or the memories by a unit in the last place.

    Returns:
        The memory and the commands after the steps, ``(D, m)``, and which of them are settled.
    """
    # In the rows of each draw: the readings, others nearby, and the readings again.
    generator, shape = torch.Generator("cpu").manual_seed(0), (_NUDGES, *readings.shape[1:])
    noise = torch.randn(shape, generator=generator, dtype=torch.float32, device="cpu").to(readings)
    as_drawn = readings.unsqueeze(1)
    nearby = as_drawn * (1.0 + _NUDGE * noise)
    rows = torch.cat((as_drawn, nearby, as_drawn.expand_as(nearby)), dim=1)

    # On the way, memories of the latter are rounded otherwise.
    units = torch.zeros(rows.shape[:2])
    units[:, 1 + _NUDGES :] = _UNITS
    found = _after(flat, rows.flatten(0, 1), units.flatten()).view(*rows.shape[:2], -1)

    # Half of what the test allows.
    is_single = flat.step.model.like.dtype == torch.float32
    outcome = found[:, :1]
    is_settled = _are_close(found[:, 1 : 1 + _NUDGES], outcome, 1e-4)
    is_settled &= _are_close(found[:, 1 + _NUDGES :], outcome, 5e-5 if is_single else 5e-10)
    return outcome.squeeze(1), is_settled


def _are_close(found: Tensor, outcome: Tensor, tolerance: float) -> Tensor:
    """Which numbers are those of an outcome ``(D, 1, m)`` in all rows ``(D, R, m)``, ``(D, m)``."""
    close = torch.isclose(found, outcome, rtol=tolerance, atol=tolerance, equal_nan=True)
    return close.all(dim=1)


def _test_readings(flat: FlatStep, seed: int) -> Tensor:
    """Readings of a few steps, ``(steps, n)``; the second time there are none of optional ones."""
    layout, generator = flat.layouts["readings"], torch.Generator("cpu").manual_seed(seed)
    size = (_TEST_STEPS, layout.size)
    noise = torch.rand(size, generator=generator, dtype=torch.float32, device="cpu")

    # Away from zero, where signs and ranks hang on rounding.
    readings = 0.1 + noise
    for name, sensor in flat.model.sensors.items():
        entry = layout.entries[name]
        if sensor.optional:
            readings[1, entry.start : entry.stop] = torch.nan
    return readings.to(flat.model.like.dtype)


def _after(flat: FlatStep, readings: Tensor, units: Tensor) -> Tensor:
    """The memory and the commands after first steps with readings ``(B, steps, n)``, ``(B, m)``.

    Args:
        flat: The step.
        readings: The readings.
        units: By how many units in the last place the memory of a row differs on the way, ``(B,)``.
    """
    first, *others = (flat.unpack("readings", step) for step in readings.unbind(dim=1))
    (memory,) = flat.step.start(first)
    groups: dict[str, Named] = {"memory": memory}
    for step in (first, *others):
        restarted = _rounded(flat.step.restarted(dict(groups["memory"]), step), units)
        groups = run(flat.step.stages, {"memory": restarted, "readings": step})
    return torch.cat([flat.pack(name, groups[name]) for name in ("memory", "commands")], dim=-1)


def _rounded(memory: Named, units: Tensor) -> Named:
    """A memory ``(B, …)`` whose real numbers are other ones by rounding, by units ``(B,)``."""
    generator, rounded = torch.Generator("cpu").manual_seed(0), dict(memory)
    for key, value in memory.items():
        if value.is_floating_point():
            noise = torch.randn(value.shape, generator=generator, dtype=value.dtype, device="cpu")
            share = torch.finfo(value.dtype).eps * units.to(value)
            rounded[key] = value * (1.0 + share.view(-1, *[1] * (value.ndim - 1)) * noise)
    return rounded


def _constants(flat: FlatStep, metadata: Mapping[str, Any]) -> str:
    """Sizes, the memory before the first episode, and the metadata."""
    sizes = {"FORMAT": FORMAT, "BEGINS": flat.layouts["memory"].entries[BEGINS].start}
    for group, layout in flat.layouts.items():
        sizes[group.upper()] = layout.size
    lines = [f"#define {name} {size}" for name, size in sizes.items()]
    lines.append(f"static const real blank[MEMORY] = {_initializer(flat.blank())};")

    text = json.dumps(metadata)

    # C joins literals that follow each other, so no line has to be endless.
    pieces = [text[place : place + 90] for place in range(0, len(text), 90)]
    lines += ["EXPORTED const char aicon_metadata[] ="]
    lines += [f"    {json.dumps(piece)}" for piece in pieces]
    return "\n".join(lines) + ";\n"


def _initializer(values: Tensor) -> str:
    """A tensor as the initial value of an array, row by row."""
    if values.dim() > 1:
        return "{" + ", ".join(map(_initializer, values)) + "}"

    # Python's nan and inf have other names in C.
    numbers = ["NAN" if value != value else repr(value) for value in values.tolist()]
    return "{" + ", ".join(numbers).replace("inf", "INFINITY") + "}"


def _step(flat: FlatStep) -> str:
    """Steps of some robots, and where their episodes begin."""
    kept: list[str] = []
    for key in OUTLASTS_EPISODES:
        entry = flat.layouts["memory"].entries[key]
        size = f"{entry.stop - entry.start} * sizeof(real)"
        kept.append(f"      memcpy(fresh + {entry.start}, before + {entry.start}, {size});")
    return _STEP.replace("      KEPT", "\n".join(kept))


_HEADING = """\
/* The control step of a policy, exported by aicon-torch.

   cc -O2 -std=gnu11 -shared -fPIC -ffp-contract=off -fno-math-errno -o policy.so policy.c -lm

   It allocates nothing and keeps nothing: the memory is the caller's. */
#include <string.h>
#define EXPORTED __attribute__((visibility("default")))
#pragma GCC diagnostic ignored "-Wunused-function" /* not every step needs each of its functions */
"""

_STEP = """\
/* Format, bytes of a real number, and how many of them there are in the readings, the memory and
   the commands of one robot. */
EXPORTED const int aicon_sizes[5] = {FORMAT, sizeof(real), READINGS, MEMORY, COMMANDS};

/* The memory before the first episode. */
EXPORTED void aicon_blank(void *memory) { memcpy(memory, blank, sizeof blank); }

/* One step of each of some robots. Where starts is set, or the memory says so, an episode begins:
   the memory starts anew, but for what outlasts it. Next may be memory. */
EXPORTED void aicon_step(long rows, const unsigned char *starts, const void *readings,
                         const void *memory, void *next, void *commands) {
  for (long row = 0; row < rows; ++row) {
    const real *seen = (const real *)readings + row * READINGS;
    const real *before = (const real *)memory + row * MEMORY;
    real fresh[MEMORY], after[MEMORY];

    if ((starts && starts[row]) || before[BEGINS] != 0) {
      start(seen, fresh);
      KEPT
      before = fresh;
    }
    step(before, seen, after, (real *)commands + row * COMMANDS);
    memcpy((real *)next + row * MEMORY, after, sizeof after);
  }
}

/* Whether an episode has yet to begin after a step, as a reading that it begins with has not come:
   the commands of that step are not to be sent. */
EXPORTED int aicon_begins(const void *memory) { return ((const real *)memory)[BEGINS] != 0; }
"""

_TEST = """\
/* Whether it computes here what it did when it was exported, but for what hangs on rounding. */
static int is_near(const real *found, const real *recorded, const char *settled, int count) {{
  const real tolerance = sizeof(real) == 4 ? 1e-4 : 1e-9;
  for (int i = 0; i < count; ++i) {{
    if (!settled[i] || (found[i] != found[i] && recorded[i] != recorded[i])) continue;
    if (!(magnitude(found[i] - recorded[i]) <= tolerance * (1 + magnitude(recorded[i]))))
      return 0;
  }}
  return 1;
}}

EXPORTED int aicon_test(void) {{
  static const real readings[{steps}][READINGS] = {readings};
  static const real recorded[MEMORY + COMMANDS] = {outcome};
  static const char settled[MEMORY + COMMANDS] = {settled};
  real outcome[MEMORY + COMMANDS];

  aicon_blank(outcome);
  for (int k = 0; k < {steps}; ++k) {{
    const unsigned char starts = k == 0;
    aicon_step(1, &starts, readings[k], outcome, outcome, outcome + MEMORY);
  }}
  return is_near(outcome, recorded, settled, MEMORY + COMMANDS);
}}
"""
