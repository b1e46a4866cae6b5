"""Agents of stable-baselines3: trained on a task's environment, saved in a folder, and compared like any other policy.

The folder of an agent holds

| file | content |
|---|---|
| `config.json` | `Settings`: what was trained, and for how many steps; `observation`: the shape of each reading |
| `agent.zip` | the agent, as stable-baselines3 saves it |
| `vecnormalize.pkl` | means and variances of the readings and of the reward |
| `replay_buffer.pkl` | SAC only, to go on with training |
| `log_N/` | `progress.csv` from step N on; with the package `tensorboard` installed, its files as well |

An agent of another origin can be compared when it comes with these files. Both `agent.zip` and `vecnormalize.pkl` can
run any code when they are loaded: load only what you trust.

What is learned is documented where it is decided: `ShapedPush` (reward of pushT; navigation has the environment's
own), `RelativeTarget` (actions of pushT), `Readings` (observations).
"""

import hashlib
import json
import pickle
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any, cast
from zipfile import BadZipFile

import gymnasium as gym
import numpy as np
import stable_baselines3
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure as configure_logger
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecFrameStack, VecNormalize
from tqdm import tqdm

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_baselines.errors import ComparisonError
from aicon_baselines.tasks import load

Observation = dict[str, NDArray[Any]]

ALGORITHMS = ("ppo", "sac")
"""What `train` trains; `Agent` also loads A2C, DDPG and TD3."""

_LOADABLE = (*ALGORITHMS, "a2c", "ddpg", "td3")
_CONFIG, _AGENT, _STATISTICS, _REPLAY = "config.json", "agent.zip", "vecnormalize.pkl", "replay_buffer.pkl"
_WORLD = 512.0  # px, side of the world of pushT
_IDS = {"nav2d": "aicon/Nav2D-v0", "pusht": "aicon/PushT-v0"}
# Where the tasks differ. An episode of 1000 steps takes 50 s: many traps can be left in that, and most are met in it.
_DEFAULTS: dict[str, dict[str, Any]] = {
    "nav2d": {"horizon": 1000, "stack": 8, "reach": None, "discount": 0.995},
    "pusht": {"horizon": 300, "stack": 1, "reach": 100.0, "approach": 0.2, "discount": 0.99},
}


@dataclass(frozen=True)
class Settings:
    """What an agent was trained for.

    Attributes:
        task: Name of the task.
        algorithm: "ppo" or "sac".
        steps: Steps of all environments together.
        seed: Seed of the network, and of the environments: environment i starts with seed + i. Not below 1000, where
            the seeds are that results are reported on.
        envs: Number of environments.
        rollout: Steps of each environment between two updates of PPO.
        horizon: Steps after which a training episode is cut.
        stack: Number of successive observations that the agent sees at once, zeros before the first one.
        reach: See `RelativeTarget`, px; None where the agent's actions are the environment's.
        approach: See `ShapedPush`; without meaning in navigation.
        discount: Discount factor of the return.
        normalized: Whether the readings were normalised, with statistics in `vecnormalize.pkl`.
    """

    task: str
    algorithm: str
    steps: int
    seed: int = 10_000
    envs: int = 8
    rollout: int = 512
    horizon: int = 1000
    stack: int = 1
    reach: float | None = None
    approach: float = 0.0
    discount: float = 0.99
    normalized: bool = True

    def __post_init__(self) -> None:
        """Reject what cannot be trained or loaded."""
        if self.task not in _IDS:
            raise ComparisonError(f"unknown task {self.task!r}; valid tasks: {', '.join(_IDS)}")
        if self.algorithm not in _LOADABLE:
            raise ComparisonError(f"unknown algorithm {self.algorithm!r}; valid algorithms: {', '.join(_LOADABLE)}")
        for name in ("steps", "envs", "rollout", "horizon", "stack"):
            if getattr(self, name) < 1:
                raise ComparisonError(f"{name} must be 1 or more, not {getattr(self, name)}")
        if self.seed < 1000:
            raise ComparisonError(f"the seed must be 1000 or more, not {self.seed}: results are reported on the others")


def settings(task: str, algorithm: str, steps: int, **options: Any) -> Settings:
    """Describe a training, with the task's defaults for what is None or not given."""
    load(task)
    if algorithm not in ALGORITHMS:
        raise ComparisonError(f"unknown algorithm {algorithm!r}; valid algorithms: {', '.join(ALGORITHMS)}")
    given = {name: value for name, value in options.items() if value is not None}
    return Settings(task, algorithm, steps, **_DEFAULTS[task] | given)


# --- environments


class ShapedPush(gym.Wrapper[Any, Any, Any, Any]):
    """PushT with a reward that is not the same everywhere far from the goal; for training only.

    r = (Φ' - Φ) / 100 px + 5 [success], with Φ = -e - w d before and Φ' after the step; e is the pose error
    `info["pose_error"]` and d the distance of the pusher to the nearest keypoint, both px. Undiscounted, an episode
    gives Φ at its end minus Φ at its start, / 100 px, + 5 if it ends in success, whatever lies between (A. Ng, D.
    Harada, S. Russell, ICML 1999). The environment's own reward, the coverage, is 0 until the object overlaps its goal,
    and pays for staying just below success.
    """

    def __init__(self, env: gym.Env[Any, Any], approach: float) -> None:
        """Wrap an environment that observes keypoints; `approach` is w."""
        super().__init__(env)
        self._approach = approach

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._potential = self._evaluate(observation, info)
        return observation, info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, _, terminated, truncated, info = self.env.step(action)
        before, self._potential = self._potential, self._evaluate(observation, info)
        reward = (self._potential - before) / 100.0 + 5.0 * info["is_success"]
        return observation, reward, terminated, truncated, info

    def _evaluate(self, observation: Observation, info: dict[str, Any]) -> float:
        keypoints = observation["environment_state"].reshape(-1, 2)
        gap = np.linalg.norm(keypoints - observation["agent_pos"], axis=-1).min()
        return float(-info["pose_error"] - self._approach * gap)


class RelativeTarget(gym.Wrapper[Any, Any, Any, Any]):
    """PushT whose action a in [-1, 1]² puts the controller's target at p + reach a, p the pusher's position, px.

    The environment's own action is the target itself, clipped to the world: what a random agent does with it is to
    shuttle through the middle, and how it has to push depends on where it is.
    """

    def __init__(self, env: gym.Env[Any, Any], reach: float) -> None:
        """Wrap the environment; `reach` in px."""
        super().__init__(env)
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self._reach = reach

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        self._observation, info = self.env.reset(seed=seed, options=options)
        return self._observation, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        result = self.env.step(to_target(action, self._observation, self._reach))
        self._observation = result[0]
        return result


def to_target(action: NDArray[Any], observation: Observation, reach: float | None) -> NDArray[np.float32]:
    """Return the environment's action (*B, 2): `action` itself, or what `RelativeTarget` says if there is a reach."""
    if reach is not None:
        action = np.clip(observation["agent_pos"] + reach * action, 0.0, _WORLD)
    return np.asarray(action, np.float32)


def make_training_env(config: Settings, seed: int) -> VecEnv:
    """Build the environments that an agent is trained in; `seed` is that of the first one."""
    envs = DummyVecEnv([lambda: _make_single(config)] * config.envs)
    envs.seed(seed)
    return envs


def _make_single(config: Settings) -> Monitor[Any, Any]:
    env = gym.make(_IDS[config.task], max_episode_steps=config.horizon, disable_env_checker=True)
    if config.task == "pusht":
        env = ShapedPush(env, config.approach)
    if config.reach is not None:
        env = RelativeTarget(env, config.reach)
    return Monitor(env)


class Readings(BaseFeaturesExtractor):
    """All readings side by side; of a bearing φ its direction (sin φ, cos φ), which does not jump at ±π."""

    def __init__(self, observation_space: spaces.Dict) -> None:
        """Count the features of these observations."""
        sizes = {name: int(np.prod(box.shape or ())) for name, box in observation_space.spaces.items()}
        super().__init__(observation_space, sum((2 if is_bearing(name) else 1) * n for name, n in sizes.items()))

    def forward(self, observations: dict[str, torch.Tensor]) -> torch.Tensor:
        """Return the features (B, n)."""
        features = []
        for name, reading in observations.items():
            features += [reading.sin(), reading.cos()] if is_bearing(name) else [reading]
        return torch.cat(features, dim=-1)


def is_bearing(name: str) -> bool:
    """Return whether a reading is an angle, which is not normalised; see `Readings`."""
    return name.endswith("bearing")


# --- training


def train(
    config: Settings, folder: Path, checkpoint: int = 50_000, report: Callable[[str], None] = lambda line: None
) -> Settings:
    """Train an agent, or go on with the one in the folder, and save it every `checkpoint` steps and at the end.

    What is learned after a stop differs from what would have been learned without one: episodes begin anew, with other
    seeds, and SAC and PPO draw other numbers.

    Args:
        config: What to train. An agent in the folder must have the same settings, except for the steps.
        folder: Folder of the agent.
        checkpoint: Steps between two saves.
        report: Called with a line of text after each save.

    Returns:
        The settings with the number of steps taken, at least those asked for.
    """
    if checkpoint < 1:
        raise ComparisonError(f"checkpoint must be 1 or more, not {checkpoint}")
    model, statistics = _resume(config, folder) if (folder / _CONFIG).exists() else _begin(config)
    missing = config.steps - model.num_timesteps
    if missing > 0:
        formats = ["csv", "tensorboard"] if find_spec("tensorboard") else ["csv"]
        model.set_logger(configure_logger(str(folder / f"log_{model.num_timesteps}"), formats))
        saving = _Saving(config, folder, statistics, checkpoint, report)
        model.learn(missing, callback=saving, reset_num_timesteps=model.num_timesteps == 0)
        _save(config, folder, model, statistics)
        model.logger.close()
    statistics.close()
    return replace(config, steps=model.num_timesteps)


def _begin(config: Settings) -> tuple[BaseAlgorithm, VecNormalize]:
    envs = make_training_env(config, config.seed)
    names = cast("spaces.Dict", envs.observation_space).spaces
    statistics = VecNormalize(
        envs, gamma=config.discount, norm_obs_keys=[name for name in names if not is_bearing(name)]
    )
    network: dict[str, Any] = {
        "features_extractor_class": Readings,
        "net_arch": [256, 256],
        "activation_fn": torch.nn.ReLU,
    }
    common: dict[str, Any] = {"gamma": config.discount, "seed": config.seed, "device": "cpu"}
    stacked = _stacked(statistics, config)
    if config.algorithm == "ppo":
        network["log_std_init"] = -0.5  # σ = 0.6 of a half range; 1 would often be clipped
        return stable_baselines3.PPO(
            "MultiInputPolicy",
            stacked,
            n_steps=config.rollout,
            batch_size=min(256, config.rollout * config.envs),
            n_epochs=5,
            policy_kwargs=network,
            **common,
        ), statistics
    return stable_baselines3.SAC(
        "MultiInputPolicy",
        stacked,
        buffer_size=min(300_000, config.steps),
        learning_starts=min(5000, config.steps // 4),
        gradient_steps=max(1, config.envs // 2),  # an update for every two steps
        policy_kwargs=network,
        **common,
    ), statistics


def _resume(config: Settings, folder: Path) -> tuple[BaseAlgorithm, VecNormalize]:
    there, _ = read_settings(folder)
    _check_files(folder, there)
    differing = [
        f"{field.name} is {getattr(there, field.name)} there and {getattr(config, field.name)} here"
        for field in fields(config)
        if field.name != "steps" and getattr(there, field.name) != getattr(config, field.name)
    ]
    if differing:
        raise ComparisonError(f"{folder} holds another agent: {'; '.join(differing)}. Choose another folder.")
    model = load_algorithm(folder, there)
    # Other episodes than those since the start; the steps so far, because they are more than the environments.
    statistics = VecNormalize.load(
        str(folder / _STATISTICS), make_training_env(config, config.seed + model.num_timesteps)
    )
    model.set_env(_stacked(statistics, config))
    if isinstance(model, OffPolicyAlgorithm) and (folder / _REPLAY).exists():
        model.load_replay_buffer(str(folder / _REPLAY))
    return model, statistics


def _stacked(statistics: VecNormalize, config: Settings) -> VecEnv:
    return VecFrameStack(statistics, config.stack) if config.stack > 1 else statistics


class _Saving(BaseCallback):
    """Saves every so many steps and shows a bar, on a terminal only."""

    def __init__(
        self,
        config: Settings,
        folder: Path,
        statistics: VecNormalize,
        interval: int,
        report: Callable[[str], None],
    ) -> None:
        super().__init__()
        self._config, self._folder, self._statistics = config, folder, statistics
        self._interval, self._report = interval, report

    def _on_training_start(self) -> None:
        steps = self.model.num_timesteps
        self._bar = tqdm(initial=steps, total=self._config.steps, unit=" steps", smoothing=0.05, disable=None)
        self._saved = steps

    def _on_step(self) -> bool:
        self._bar.update(self.model.num_timesteps - self._bar.n if not self._bar.disable else 0)
        if self.num_timesteps - self._saved >= self._interval:
            self._saved = self.num_timesteps
            _save(self._config, self._folder, self.model, self._statistics)
            self._bar.clear()
            self._report(f"{self.num_timesteps:,} steps: {self._recent()}")
        return True

    def _on_training_end(self) -> None:
        self._bar.close()

    def _recent(self) -> str:
        """Tell how the last 100 training episodes went."""
        rewards = [episode["r"] for episode in self.model.ep_info_buffer or ()]
        successes = list(self.model.ep_success_buffer or ())
        if not rewards or not successes:
            return "no episode has ended yet"
        return f"success {100.0 * np.mean(successes):.0f} %, reward {np.mean(rewards):.2f} (with exploration)"


def _save(config: Settings, folder: Path, model: BaseAlgorithm, statistics: VecNormalize) -> None:
    """Write the agent, each file at once, so that a kill leaves whole ones; `config.json` comes last."""
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder / _AGENT, model.save)
    _write(folder / _STATISTICS, statistics.save)
    if isinstance(model, OffPolicyAlgorithm):
        _write(folder / _REPLAY, model.save_replay_buffer)
    readings = cast("spaces.Dict", statistics.venv.observation_space).spaces
    content = asdict(replace(config, steps=model.num_timesteps))
    content["observation"] = {name: list(box.shape or ()) for name, box in readings.items()}
    _write(folder / _CONFIG, lambda path: Path(path).write_text(json.dumps(content, indent=2) + "\n"))


def _write(path: Path, write: Callable[[str], Any]) -> None:
    temporary = path.with_name(f"new_{path.name}")  # the ending stays: stable-baselines3 appends it otherwise
    write(str(temporary))
    temporary.replace(path)


# --- loading


class Agent:
    """A saved agent with the `predict` of a policy, which expects and gives what the environment does.

    Readings are normalised and stacked as in training. One that is missing (NaN) keeps its last value. Its `state` is
    the last readings and the stack.
    """

    def __init__(self, folder: Path, task: str) -> None:
        """Load the agent of a folder; an error says what is missing there, or that it is for another task."""
        self._folder = folder
        self.settings, self._shapes = read_settings(folder)
        if self.settings.task != task:
            raise ComparisonError(
                f"the agent in {folder} was trained for {self.settings.task!r}, not {task!r}. Compare it with --task "
                f"{self.settings.task}, or train another: {_training_command(task, self.settings.algorithm)}"
            )
        _check_files(folder, self.settings)
        self._model = load_algorithm(folder, self.settings)
        self._statistics = _load_statistics(folder) if self.settings.normalized else None

    @property
    def name(self) -> str:
        """Algorithm, steps and the beginning of a hash, so that rows of two agents never get the same name."""
        files = [self._folder / _AGENT, *([self._folder / _STATISTICS] if self.settings.normalized else [])]
        digest = hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()
        return f"{self.settings.algorithm}_{self.settings.steps}_{digest[:4]}"

    def predict(
        self,
        observation: Observation,
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """Choose the next actions (B, m); see `aicon_baselines.Predictor`."""
        readings = self._select(observation)
        count = len(next(iter(readings.values())))
        start = np.ones(count, np.bool_) if state is None or episode_start is None else episode_start
        last, stacks = state if state is not None else self._empty(count)
        readings = {name: _fill(reading, last[name], start) for name, reading in readings.items()}
        stacks = {name: _push(reading, stacks[name], start) for name, reading in self._normalize(readings).items()}
        action, _ = self._model.predict(stacks, deterministic=deterministic)
        return to_target(action, readings, self.settings.reach), (readings, stacks)

    def _select(self, observation: Observation) -> Observation:
        """Take the readings that the agent knows; others, such as the goal, it does not see."""
        for name, shape in self._shapes.items():
            if name not in observation or observation[name].shape[1:] != shape:
                offered = {key: value.shape[1:] for key, value in observation.items()}
                raise ComparisonError(
                    f"the agent in {self._folder} observes {self._shapes}, and this condition offers {offered}: choose "
                    "conditions with the readings that it was trained with"
                )
        return {name: observation[name] for name in self._shapes}

    def _empty(self, count: int) -> tuple[Observation, Observation]:
        sizes = {name: int(np.prod(shape)) for name, shape in self._shapes.items()}
        last = {name: np.zeros((count, size)) for name, size in sizes.items()}
        stacks = {name: np.zeros((count, size * self.settings.stack), np.float32) for name, size in sizes.items()}
        return last, stacks

    def _normalize(self, readings: Observation) -> Observation:
        return cast("Observation", self._statistics.normalize_obs(readings)) if self._statistics else readings


def _fill(reading: NDArray[Any], last: NDArray[Any], start: NDArray[np.bool_]) -> NDArray[Any]:
    """Put the last reading, or 0 at the start of an episode, where a number is missing; (B, n)."""
    return np.where(np.isnan(reading), np.where(start[:, None], 0.0, last), reading)


def _push(reading: NDArray[Any], stack: NDArray[Any], start: NDArray[np.bool_]) -> NDArray[Any]:
    """Append a reading (B, n) to a stack (B, k n) and drop the oldest, as `VecFrameStack` does."""
    kept = np.where(start[:, None], 0.0, stack[:, reading.shape[1] :])
    return np.concatenate([kept, reading], axis=-1).astype(np.float32)


def read_settings(folder: Path) -> tuple[Settings, dict[str, tuple[int, ...]]]:
    """Read `config.json`: the settings, and the shape of each reading."""
    path = folder / _CONFIG
    if not path.exists():
        raise ComparisonError(f"{folder} has no {_CONFIG}; save an agent there: {_training_command('TASK', 'ppo')}")
    try:
        content = json.loads(path.read_text())
        shapes = {name: tuple(shape) for name, shape in content.pop("observation").items()}
        return Settings(**content), shapes
    except ComparisonError as error:
        raise ComparisonError(f"{path}: {error}") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        expected = ", ".join(field.name for field in fields(Settings))
        raise ComparisonError(
            f"{path} does not describe an agent ({error}); expected: {expected}, observation"
        ) from error


def load_algorithm(folder: Path, config: Settings) -> BaseAlgorithm:
    """Load `agent.zip`, on the CPU."""
    kind: type[BaseAlgorithm] = getattr(stable_baselines3, config.algorithm.upper())
    try:
        return kind.load(str(folder / _AGENT), device="cpu")
    except (ValueError, TypeError, KeyError, AttributeError, RuntimeError, AssertionError, BadZipFile) as error:
        raise ComparisonError(
            f"{folder / _AGENT} is not an agent of {config.algorithm.upper()} ({error}); save one again in another "
            f"folder: {_training_command(config.task, config.algorithm)}"
        ) from error


def _load_statistics(folder: Path) -> VecNormalize:
    path = folder / _STATISTICS
    try:
        with path.open("rb") as file:
            statistics = pickle.load(file)
        if isinstance(statistics, VecNormalize):
            return statistics
        reason = type(statistics).__name__
    except (pickle.UnpicklingError, EOFError, AttributeError, ImportError, IndexError, ValueError, KeyError) as error:
        reason = str(error)
    raise ComparisonError(f"{path} holds no VecNormalize ({reason}); copy it from where the agent was trained")


def _check_files(folder: Path, config: Settings) -> None:
    needed = [_AGENT, *([_STATISTICS] if config.normalized else [])]
    missing = [name for name in needed if not (folder / name).exists()]
    if missing:
        raise ComparisonError(
            f"{folder} has no {' and no '.join(missing)}; copy the whole folder from where the agent was trained, or "
            f"train one in another: {_training_command(config.task, config.algorithm)}"
        )


def _training_command(task: str, algorithm: str) -> str:
    return f"python scripts/train_sb3.py --task {task} --algorithm {algorithm} --out FOLDER"
