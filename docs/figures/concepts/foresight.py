"""What foresight does: K gradients, each where the model foresees that the action leads."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import FloatArray, to_array
from aicon_baselines.figures.timeline import simplify
from aicon_torch import ActionLaw, DirectDescent, Foresight
from concepts import drawing
from concepts.world import DT, SPEED, Wall, make_policy, readings

PLACE, TARGET = np.array([0.0, 0.0]), (0.048, 0.026)
FAR_AWAY = Wall((9.0, 9.0), (9.5, 9.0))
STEPS = Foresight().iterations


def draw(path: Path) -> None:
    """Save the picture."""
    one, many, costs = drawing.new_figure(3, height=4.0, below=0.5)
    foreseen = np.array([PLACE, *(DT * action_of(law_after(k)) for k in range(1, STEPS + 1))])
    full = DT * action_of(DirectDescent(smoothing=0.0))

    _draw_step(one, "One gradient: it goes too far")
    drawing.draw_arrow(one, PLACE, full, drawing.RESULT)
    drawing.note(one, "The gradient says where to,\nnot how far.")

    _draw_step(many, f"{STEPS} gradients: it arrives")
    _draw_foreseen(many, foreseen)

    _draw_costs(costs, foreseen, full)
    drawing.save([one, many, costs], path)


def _draw_step(axes: Axes, title: str) -> None:
    """The target, and how far one step can lead."""
    reach = SPEED * DT
    drawing.as_world(axes, None, TARGET, x=(-0.02, 0.112), y=(-0.03, 0.085), title=title)
    angle = np.linspace(-0.5, 1.2, 100)
    circle = reach * np.stack((np.cos(angle), np.sin(angle)))
    axes.plot(*circle, color=palette.PALE, linewidth=1, linestyle=(0, (3, 3)))
    axes.text(0.1, -0.022, "one step\nat most", color=palette.PALE, ha="right", fontsize=9)
    drawing.draw_robot(axes, PLACE)


def _draw_foreseen(axes: Axes, foreseen: FloatArray) -> None:
    """Where the action leads after each inner step, the first ones with their numbers."""
    drawing.draw_arrow(axes, PLACE, foreseen[-1], drawing.RESULT, zorder=4)
    axes.plot(
        *foreseen[1:].T, "o", color="white", markeredgecolor=drawing.RESULT, markersize=6, zorder=8
    )
    for k in range(1, 5):
        offset = (-0.004, 0.006) if k % 2 else (0.003, -0.008)
        x, y = foreseen[k] + offset
        axes.text(x, y, str(k), fontsize=9, zorder=9)
    drawing.note(axes, "Each is taken where the action\nso far would lead.")


def _draw_costs(axes: Axes, foreseen: FloatArray, full: FloatArray) -> None:
    """The distance that is foreseen after each inner step."""
    distances = np.linalg.norm(foreseen - TARGET, axis=1)
    axes.plot(range(STEPS + 1), 100 * distances, "o-", color=drawing.RESULT, markersize=4)
    after_full_speed = 100 * float(np.linalg.norm(full - TARGET))
    axes.axhline(after_full_speed, color=palette.PALE, linestyle=(0, (3, 3)))
    words: dict[str, Any] = {"color": palette.PALE, "ha": "right", "fontsize": 9}
    axes.text(STEPS, after_full_speed + 0.12, "after one step at full speed", **words)
    axes.set_title("Foreseen distance to the target, cm", fontsize=11, loc="left")
    axes.set(xlabel="inner steps", ylim=(0, None), xticks=(0, 5, 10, 15, 20))
    simplify(axes)


def law_after(steps: int) -> Foresight:
    """The law that stops after so many inner steps."""
    return Foresight(iterations=steps, smoothing=0.0)


def action_of(law: ActionLaw) -> FloatArray:
    """The action at :data:`PLACE`, (2,), m/s."""
    action, _ = make_policy(law=law).predict(readings(PLACE, TARGET, FAR_AWAY))
    return to_array(action)
