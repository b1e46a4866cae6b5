"""A trained policy as a small folder to pass on."""

import csv
import json
import shutil
from pathlib import Path

from aicon_baselines.agents.diffusion.checkpoint import CONFIG, WEIGHTS, load, read_weights

_LOSS, _PICTURE = "loss.csv", "loss.png"


def export(training: Path, folder: Path, sampler: str | None = None, inference_steps: int | None = None) -> None:
    """Copy the policy of a training with its weights in half precision, which LeRobot loads as float32.

    The loss comes along, as `loss.csv` and as a picture.

    Args:
        training: Folder of the training.
        folder: Folder of the copy; other files in it are left alone.
        sampler: "DDPM" or "DDIM"; by default the training's.
        inference_steps: Number of denoising steps; by default the training's.
    """
    from safetensors.torch import save_file

    source = training / "policy"
    load(source, sampler, inference_steps)  # a policy that cannot be loaded is not passed on
    folder.mkdir(parents=True, exist_ok=True)
    for file in source.iterdir():
        if file.name not in (CONFIG, WEIGHTS):
            shutil.copyfile(file, folder / file.name)
    content = json.loads((source / CONFIG).read_text())
    changes = {"noise_scheduler_type": sampler, "num_inference_steps": inference_steps}
    content |= {name: value for name, value in changes.items() if value is not None}
    (folder / CONFIG).write_text(json.dumps(content, indent=4) + "\n")
    weights = {name: value.half() for name, value in read_weights(source).items()}
    save_file(weights, folder / WEIGHTS, {"format": "pt"})
    shutil.copyfile(training / _LOSS, folder / _LOSS)
    _draw(folder / _LOSS, folder / _PICTURE)


def _draw(loss: Path, picture: Path) -> None:
    from matplotlib.figure import Figure

    with loss.open(newline="") as file:
        lines = list(csv.DictReader(file))
    figure = Figure(figsize=(5.0, 2.6), dpi=100, layout="constrained")
    axes = figure.add_subplot(xlabel="gradient step", ylabel="loss", yscale="log")
    axes.plot([int(line["step"]) for line in lines], [float(line["loss"]) for line in lines], linewidth=1.0)
    axes.grid(which="both", alpha=0.3)
    figure.savefig(picture)
