"""Diffusion policies of LeRobot in our comparison."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.agents.diffusion.checkpoint import WEIGHTS, load
from aicon_baselines.agents.diffusion.features import ACTION, KEYPOINTS, PIXELS, STATE
from aicon_baselines.agents.diffusion.hub import locate
from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError

Observation = dict[str, NDArray[Any]]
Memory = dict[str, Tensor]

_READINGS = {STATE: "agent_pos", KEYPOINTS: "environment_state", PIXELS: "pixels"}


class Agent:
    """A saved diffusion policy on pushT.

    It observes the last `n_obs_steps` observations, samples `horizon` actions and executes `n_action_steps` of them
    before it looks again. It is told nothing of the goal: what it pushes to is where its demonstrations ended.

    Rows of a batch are separate robots, each with its own history, queue of actions and random numbers. These are drawn
    from a seed, the first observation of the episode and the number of samples since: an episode goes the same way in
    every batch and every run, up to the last bits of a batched computation.

    The memory holds, for B robots with histories of o observations and queues of a actions:

    | key | shape | content |
    |---|---|---|
    | `observation.*` | (B, o, ...) | normalised observations, the newest last |
    | `action` | (B, a, 2) | the actions sampled last, px |
    | `used` | (B,) | how many of them were executed |
    | `samples` | (B,) | how often the episode has sampled |
    | `key` | (B,) | seed of the episode |
    """

    def __init__(
        self, source: str | Path, sampler: str | None = None, inference_steps: int | None = None, seed: int = 0
    ) -> None:
        """Load a policy.

        Args:
            source: Folder of a policy, or the name of a repository of the Hugging Face hub.
            sampler: "DDPM" or "DDIM"; by default the checkpoint's.
            inference_steps: Number of denoising steps; by default the checkpoint's.
            seed: Seed of the sampler.
        """
        self._folder = locate(str(source))
        self._checkpoint = load(self._folder, sampler, inference_steps)
        self._config: Any = self._checkpoint.policy.config
        self._read = import_lerobot("envs.utils").preprocess_observation
        self._seed = seed

    @property
    def name(self) -> str:
        """What it observes, its sampler and the beginning of a hash, so that no two policies get the same name."""
        digest = hashlib.sha256((self._folder / WEIGHTS).read_bytes()).hexdigest()
        observed = "pixels" if PIXELS in self._config.input_features else "keypoints"
        steps = self._checkpoint.policy.diffusion.num_inference_steps
        return f"diffusion_{observed}_{self._config.noise_scheduler_type.lower()}{steps}_{digest[:4]}"

    @property
    def env_options(self) -> dict[str, Any]:
        """What the environment has to be built with, for a policy that sees pictures."""
        if PIXELS not in self._config.input_features:
            return {}
        _, height, width = self._config.input_features[PIXELS].shape
        return {"obs_type": "pixels_agent_pos", "observation_height": height, "observation_width": width}

    @torch.no_grad()
    def predict(
        self,
        observation: Observation,
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """Choose the next actions (B, 2), px; see `aicon_baselines.Predictor`.

        Args:
            observation: One array (B, ...) per reading.
            state: The memory; see the class.
            episode_start: (B,), true where an episode begins.
            deterministic: Whether the random numbers depend on the episode alone; else they are others in every run.

        Returns:
            The actions, and the memory for the next call.
        """
        readings = self._select(observation)
        before: Memory = state if state is not None else self._forgotten(readings)
        count = len(before["key"])
        begins = state is None or episode_start is None
        start = torch.full((count,), state is None) if begins else torch.from_numpy(np.asarray(episode_start))
        seen = self._checkpoint.preprocess(self._read(readings))
        memory = {name: _push(before[name], seen[name], start) for name in self._config.input_features}
        start &= ~self._repeats(before, memory)
        memory["key"] = before["key"].clone()
        for i in torch.nonzero(start).flatten().tolist():
            memory["key"][i] = self._key([reading[i] for reading in readings.values()], deterministic)
        memory["samples"] = before["samples"].masked_fill(start, 0)
        memory["used"] = before["used"].masked_fill(start, self._config.n_action_steps)
        memory["action"] = before["action"]
        self._refill(memory)
        action = memory["action"][torch.arange(count), memory["used"]]
        memory["used"] = memory["used"] + 1
        return action.numpy(), memory

    def _repeats(self, before: Memory, now: Memory) -> Tensor:
        """Return where an episode has just begun and begins again from the same observation, (B,).

        It would sample the same again, so it keeps what it sampled. That is no rare case: in a comparison, episodes
        that have ended stay in the batch like this.
        """
        same = (before["samples"] == 1) & (before["used"] == 1)
        for name in self._config.input_features:
            same = same & (before[name] == now[name]).flatten(1).all(dim=1)
        before["used"] = torch.where(same, 0, before["used"])
        return same

    def _select(self, observation: Observation) -> Observation:
        """Take the readings that the policy knows; others, such as the goal, it does not see."""
        readings = {}
        for name, feature in self._config.input_features.items():
            reading = observation.get(_READINGS[name])
            expected = feature.shape if name != PIXELS else (*feature.shape[1:], feature.shape[0])
            if reading is None or reading.shape[1:] != tuple(expected):
                offered = {key: value.shape[1:] for key, value in observation.items()}
                raise ComparisonError(
                    f"the policy in {self._folder} observes {_READINGS[name]} {tuple(expected)}, and this condition "
                    f"offers {offered}: choose conditions with the readings that it was trained with"
                )
            if np.isnan(reading).any():
                raise ComparisonError(
                    f"{_READINGS[name]} has missing values, which a diffusion policy cannot do without: choose other "
                    "conditions"
                )
            readings[_READINGS[name]] = np.ascontiguousarray(reading)  # torch takes no negative strides
        return readings

    def _forgotten(self, readings: Observation) -> Memory:
        """Return a memory of no episode."""
        count = len(next(iter(readings.values())))
        config = self._config
        histories = {
            name: torch.zeros(count, config.n_obs_steps, *feature.shape)
            for name, feature in config.input_features.items()
        }
        numbers = {name: torch.zeros(count, dtype=torch.int64) for name in ("used", "samples", "key")}
        return histories | numbers | {ACTION: torch.zeros(count, config.n_action_steps, 2)}

    def _key(self, first: list[NDArray[Any]], deterministic: bool) -> int:
        if not deterministic:
            return int(torch.randint(2**62, ()))
        digest = hashlib.sha256(b"".join(np.ascontiguousarray(reading).tobytes() for reading in first)).digest()
        return int(np.random.SeedSequence([self._seed, *digest]).generate_state(1, np.uint64)[0] >> np.uint64(2))

    def _refill(self, memory: Memory) -> None:
        """Sample actions where all have been executed."""
        rows = torch.nonzero(memory["used"] >= self._config.n_action_steps).flatten()
        if not len(rows):
            return
        seeds = zip(memory["key"][rows].tolist(), memory["samples"][rows].tolist(), strict=True)
        # Not the sum: keys of two episodes may be near each other.
        generators = [_generator(int(np.random.SeedSequence(pair).generate_state(1, np.uint64)[0])) for pair in seeds]
        memory["action"] = memory["action"].index_copy(0, rows, self._sample(memory, rows, generators))
        memory["samples"] = memory["samples"].index_add(0, rows, torch.ones_like(rows))
        memory["used"] = memory["used"].index_fill(0, rows, 0)

    def _sample(self, memory: Memory, rows: Tensor, generators: list[torch.Generator]) -> Tensor:
        """Sample the next actions of these rows, (R, a, 2), px, each with its own random numbers."""
        config, model = self._config, self._checkpoint.policy.diffusion
        batch = {name: memory[name][rows] for name in config.input_features}
        if PIXELS in batch:
            batch["observation.images"] = batch.pop(PIXELS).unsqueeze(2)  # one camera
        noise = torch.stack([torch.randn(config.horizon, 2, generator=generator) for generator in generators])
        condition = model._prepare_global_conditioning(batch)
        actions = model.conditional_sample(len(rows), global_cond=condition, generator=generators, noise=noise)
        first = config.n_obs_steps - 1
        result: Tensor = self._checkpoint.postprocess(actions[:, first : first + config.n_action_steps])
        return result


def _push(history: Tensor, newest: Tensor, start: Tensor) -> Tensor:
    """Append observations (B, ...) to histories (B, o, ...); at a start the first one fills all, as in LeRobot."""
    pushed = torch.cat([history[:, 1:], newest[:, None]], dim=1)
    first = newest[:, None].expand_as(pushed)
    return torch.where(start.view(-1, *[1] * (pushed.ndim - 1)), first, pushed)


def _generator(seed: int) -> torch.Generator:
    return torch.Generator().manual_seed(seed % 2**63)
