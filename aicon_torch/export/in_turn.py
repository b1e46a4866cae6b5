"""The stages of a control step in C, called in turn for one robot."""

from aicon_torch.control.stages import Stage
from aicon_torch.export.flat_step import FlatStep


def in_turn(flat: FlatStep) -> str:
    """``step(memory, readings, new_memory, new_commands)``, which calls the function of each stage.

    A group that a stage takes and gives is written beside the one that is read, and the two change
    places.
    """
    stages = flat.step.stages
    returned = stages[-1].gives
    passed_on = dict.fromkeys(name for stage in stages[:-1] for name in stage.gives)

    lines = ["static void step(const real *memory, const real *readings,"]
    lines += [f"                 {', '.join(f'real *new_{name}' for name in returned)}) {{"]
    for name in passed_on:
        lines.append(f"  real {name}_room[2][{name.upper()}];")
        lines.append(f"  real *{name} = {name}_room[0], *new_{name} = {name}_room[1];")
    for stage in stages:
        lines += _call(stage, returned)
    return "\n".join([*lines, "}", ""])


def _call(stage: Stage, returned: tuple[str, ...]) -> list[str]:
    """The calls of one stage; what a call gives can be read after it.

    What stays the same from time to time is computed before the first.
    """
    given = [f"new_{name}" for name in stage.gives]
    lines: list[str] = []
    if stage.varying:
        fixed = [name for name in stage.takes if name not in stage.varying]
        lines.append(f"  struct {stage.name}_kept kept;")
        lines.append(f"  {stage.name}_once({', '.join((*fixed, '&kept'))});")
        given = ["&kept", *given]

    arguments = ", ".join((*stage.takes, *given))
    lines += [f"  for (int k = 0; k < {stage.times}; ++k) {{", f"    {stage.name}({arguments});"]
    for name in stage.gives:
        # What is handed on changes places with its predecessor, and is never copied.
        if name not in returned:
            lines.append(f"    real *last_{name} = {name};")
            lines.append(f"    {name} = new_{name}, new_{name} = last_{name};")
    return [*lines, "  }"]
