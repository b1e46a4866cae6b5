"""A trained policy as a small folder to pass on."""

import csv
import json
import shutil
from pathlib import Path

from aicon_baselines.agents.diffusion.checkpoint import CONFIG, WEIGHTS, load, read_weights
from aicon_baselines.agents.diffusion.training import LOSS, POLICY
from aicon_baselines.files import read_json

_LOSS_CURVE = "loss.png"


def export(
    training: Path, folder: Path, sampler: str | None = None, inference_steps: int | None = None
) -> None:
    """Copy the policy of a training with its weights in half precision.

    LeRobot loads them as float32. The loss comes along, as `loss.csv` and as a picture.

    Args:
        training: Folder of the training.
        folder: Folder of the copy; other files in it are left alone.
        sampler: "DDPM" or "DDIM"; by default the training's.
        inference_steps: Number of denoising steps; by default the training's.

    Raises:
        ComparisonError: Where the policy cannot be loaded.
    """
    from safetensors.torch import save_file

    source = training / POLICY
    load(source, sampler, inference_steps)  # a policy that cannot be loaded is not passed on
    folder.mkdir(parents=True, exist_ok=True)

    # 1. The processors, as they are.
    for file in source.iterdir():
        if file.name not in (CONFIG, WEIGHTS):
            shutil.copyfile(file, folder / file.name)

    # 2. The configuration, with another sampler.
    config = read_json(source / CONFIG)
    if sampler is not None:
        config["noise_scheduler_type"] = sampler
    if inference_steps is not None:
        config["num_inference_steps"] = inference_steps
    (folder / CONFIG).write_text(json.dumps(config, indent=4) + "\n")

    # 3. The weights, in half precision.
    weights = {name: value.half() for name, value in read_weights(source).items()}
    save_file(weights, folder / WEIGHTS, {"format": "pt"})

    # 4. The loss.
    shutil.copyfile(training / LOSS, folder / LOSS)
    _draw_loss_curve(folder / LOSS, folder / _LOSS_CURVE)


def _draw_loss_curve(loss: Path, picture: Path) -> None:
    """Draw the second column of a CSV file over its first."""
    from matplotlib.figure import Figure

    with loss.open(newline="") as file:
        lines = list(csv.DictReader(file))
    steps = [int(line["step"]) for line in lines]
    losses = [float(line["loss"]) for line in lines]

    figure = Figure(figsize=(5.0, 2.6), dpi=100, layout="constrained")
    axes = figure.add_subplot(xlabel="gradient step", ylabel="loss", yscale="log")
    axes.plot(steps, losses, linewidth=1.0)
    axes.grid(which="both", alpha=0.3)
    figure.savefig(picture)
