"""What happens, in words: the headline of the panel, its numbers, and the legend."""

import html
from collections.abc import Mapping

from aicon_baselines.palette import EXPLORING, GOAL, OUTLINE, RESOLVED, TARGET
from aicon_baselines.view.scene import Scene


def status(scene: Scene, note: str) -> str:
    """What happens, as a headline and a line of numbers.

    Args:
        scene: The world.
        note: What else there is to say.
    """
    episode = scene.episode
    numbers = [f"{episode.time:.1f} s", scene.progress()]
    numbers.append(f"cosine {float(episode.meeting.cosine[0]):+.2f}")
    numbers.append("compiled" if episode.compiled else "")
    shown = " · ".join(words for words in numbers if words)

    lines = [
        f'<div style="padding:0.4em 1em"><div style="font-weight:700;font-size:1.15em;'
        f'color:{_color(scene)}">{html.escape(scene.headline())}</div>',
        f"<div>{html.escape(shown)}</div>",
    ]
    if note:
        lines.append(f'<div style="color:{TARGET}">{html.escape(note)}</div>')
    return "".join([*lines, "</div>"])


def legend(title: str, meanings: Mapping[str, str]) -> str:
    """What the world is, and each colour with its meaning."""
    rows = [
        f'<div style="padding:0.2em 1em 0.6em;font-size:0.88em;line-height:1.45">'
        f'<p style="margin:0 0 0.5em">{html.escape(title)}</p>'
    ]
    for meaning, color in meanings.items():
        swatch = (
            f'<span style="display:inline-block;width:0.9em;height:0.9em;border-radius:3px;'
            f'margin-right:0.5em;vertical-align:-0.1em;background:{color}"></span>'
        )
        rows.append(f"<div>{swatch}{html.escape(meaning)}</div>")
    return "".join([*rows, "</div>"])


def _color(scene: Scene) -> str:
    """The colour of the headline."""
    if scene.episode.succeeded:
        return GOAL
    if scene.episode.ended:
        return OUTLINE
    return EXPLORING if bool(scene.episode.meeting.exploring[0]) else RESOLVED
