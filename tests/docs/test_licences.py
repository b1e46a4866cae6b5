"""Whatever is shipped says under which licence."""

import tomllib

from _documents import ROOT


def test_every_distribution_brings_its_licence() -> None:
    plugins = (ROOT / "baselines").glob("lerobot_*")
    for path in (ROOT, *plugins):
        project = tomllib.loads((path / "pyproject.toml").read_text())["project"]
        assert (project["license"], project["license-files"]) == ("MIT", ["LICENSE"])
        assert (path / "LICENSE").read_text() == (ROOT / "LICENSE").read_text()


def test_every_checkpoint_says_its_licence() -> None:
    for folder in (ROOT / "baselines" / "checkpoints").iterdir():
        assert "\n## Licence\n" in (folder / "README.md").read_text()


def test_nothing_but_code_numbers_and_pictures_of_ours_is_shipped() -> None:
    """A new kind of file, such as a mesh or a map of others, needs a thought about its licence."""
    kinds = {".py", ".md", ".typed", ".toml", ".json", ".safetensors", ".csv", ".png", ""}
    kinds |= {".cpp", ".hpp", ".txt"}  # examples/cpp
    kinds |= {".mjs", ".mts"}  # examples/web
    kinds |= {".webp"}  # the films of the gallery
    kinds |= {".css", ".html"}  # the site's, and its pages to play with
    kinds |= {".zip"}  # agents of stable-baselines3 that were trained here
    kinds |= {".pt"}  # weights of a network that was trained here
    for folder in ("aicon_torch", "envs", "baselines", "examples", "docs"):
        for path in (ROOT / folder).rglob("*"):
            parts = path.relative_to(ROOT).parts
            if path.is_file() and not {"__pycache__", "_build"} & set(parts):
                assert path.suffix in kinds, path
