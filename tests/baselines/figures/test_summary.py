"""The summary says how the episode ended, what each panel shows, and where the files are."""

from pathlib import Path

from aicon_baselines.figures import FigureSummary

FILES = (Path("folder", "rollout.png"), Path("folder", "rollout.json"))


def test_summary_with_panels() -> None:
    panels = [
        {"panel": "a", "time_s": 0.4, "title": "First contact"},
        {"panel": "b", "time_s": 12.35, "title": "Out of time"},
    ]
    summary = FigureSummary("arrival after 4.4 s", {"panels": panels}, FILES)
    assert str(summary).splitlines() == [
        "arrival after 4.4 s",
        "  (a)   0.40 s  First contact",
        "  (b)  12.35 s  Out of time",
        "saved in folder: rollout.png, rollout.json",
    ]


def test_summary_without_panels() -> None:
    summary = FigureSummary("success after 20.2 s", {"seed": 1}, FILES[:1])
    assert str(summary).splitlines() == ["success after 20.2 s", "saved in folder: rollout.png"]
