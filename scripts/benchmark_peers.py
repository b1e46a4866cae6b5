"""The tools of others beside ours, for `benchmark.py --peers`: each group does the same work on the same input.

What is not installed is left out, and said. LeRobot has an environment of its own (`make lerobot-env`); the others
install anywhere: pip install "aicon-torch[peers]".
"""

import json
from collections.abc import Callable, Iterator
from functools import partial
from itertools import cycle
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import gymnasium as gym
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

import aicon_envs  # noqa: F401  # registers the environments
from aicon_baselines.agents.registry import import_sb3
from aicon_baselines.evaluation import ComparisonError
from aicon_torch import NullspaceProjection, OptionError, make_policy
from aicon_torch.parts.contact import norm
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.contact_limits import pose_error
from aicon_torch.parts.pose import PoseMotion
from aicon_torch.parts.rigid_object import Outline
from aicon_torch.parts.servo import Servo
from aicon_torch.resolution import GradientStack
from timing import Step, spread, take_turns

STUDENT = Path(__file__).parent.parent / "baselines" / "checkpoints" / "diffusion_pusht_keypoints"
SEED, RECORDED = 1000, 48
DT = 0.1  # s, a control step of pushT
PUSHT = "aicon/PushT-v0", "pusht", "environment_state_agent_pos"


def compare(rounds: int, steps: int, out: Path | None) -> None:
    """Measure every group, print it, and save peers.json in the folder `out`."""
    results: dict[str, dict[str, list[float]]] = {}
    for title, group in GROUPS.items():
        programs = {name: step for name, make in group() if (step := _installed(name, make))}
        if not programs:
            continue
        results[title] = take_turns(programs, rounds, steps, title)
        print(
            f"\n{title}, one thread, ms: median (5 % to 95 %), and how many times as long as the first"
        )
        first = next(iter(results[title].values()))
        for name, times in results[title].items():
            ratios = [a / b for a, b in zip(times, first, strict=True)]
            print(f"  {name:48} {spread(times, 1e3):28} {spread(ratios)}")
        if out:
            out.mkdir(parents=True, exist_ok=True)
            (out / "peers.json").write_text(json.dumps(results, indent=2) + "\n")
    if out:
        print(f"\nsaved in {out / 'peers.json'}")


def pushing() -> Iterator[tuple[str, Callable[[], Step]]]:
    """Policies that choose the next action of pushT from what they observe in an episode of AICON."""
    observations = _record(*PUSHT)
    yield "AICON", lambda: _play(make_policy("pusht"), observations)
    yield "AICON, compiled", lambda: _play(make_policy("pusht").compile(), observations)
    for sampler, denoising in (("DDIM", 10), ("DDPM", 100)):
        name = f"diffusion policy of LeRobot, {sampler} {denoising}"
        yield name, partial(_student, sampler, denoising, observations)
    yield "PPO of stable-baselines3", lambda: _play(_agent(), _batched(observations))
    yield "MPPI, 256 samples of 16 steps", lambda: _play(Mppi(), observations)


def gradients() -> Iterator[tuple[str, Callable[[], Step]]]:
    """Rules from the gradients that meet in an episode of pushT to one."""
    meetings = _meetings()
    ours = NullspaceProjection(exploration=None)
    count, size = meetings[0].gradients.shape[-2:]

    def projection() -> Step:
        turns, memory = cycle(meetings), ours.initial(count, size)

        def step() -> None:
            nonlocal memory
            memory = ours(next(turns), memory)[1]

        return step

    def torchjd(name: str) -> Step:
        from torchjd import aggregation

        aggregator, turns = (
            getattr(aggregation, name)(),
            cycle([meeting.gradients for meeting in meetings]),
        )
        return lambda: aggregator(next(turns))

    yield f"nullspace projection of {count} gradients", projection
    yield "UPGrad of TorchJD", lambda: torchjd("UPGrad")
    yield "PCGrad of TorchJD", lambda: torchjd("PCGrad")


def arm() -> Iterator[tuple[str, Callable[[], Step]]]:
    """AICON on the arm, with all its goals and no camera, beside one step of inverse kinematics for the same Panda."""

    def ours(compiled: bool) -> Step:
        observations = _record("aicon/PandaPush-v0", "panda_push", obs_type="pose", sensing="pose")
        policy = make_policy("panda_push", sensing="pose")
        return _play(policy.compile() if compiled else policy, observations)

    def mink() -> Step:
        import mink

        env = gym.make("aicon/PandaPush-v0", obs_type="pose").unwrapped
        env.reset(seed=SEED)
        configuration = mink.Configuration(env._simulation.model, env._simulation.data.qpos)  # type: ignore[attr-defined]
        task = mink.FrameTask("tool", "body", position_cost=1.0, orientation_cost=1.0)
        task.set_target(configuration.get_transform_frame_to_world("tool", "body"))
        joints = {f"panda_joint{index}": 2.0 for index in range(1, 8)}
        limits = [
            mink.ConfigurationLimit(configuration.model),
            mink.VelocityLimit(configuration.model, joints),
        ]

        def step() -> None:
            configuration.update(configuration.q)
            mink.solve_ik(configuration, [task], 0.01, "daqp", limits=limits)

        return step

    yield "AICON", lambda: ours(compiled=False)
    yield "AICON, compiled", lambda: ours(compiled=True)
    yield "one step of mink, limits of joints and speeds", mink


class Mppi:
    """Model-predictive path integral control (pytorch-mppi) with AICON's contact model, on the same readings.

    It samples velocities, predicts the object with `PoseMotion`, and weighs samples by pose error and distance.
    """

    def __init__(self, samples: int = 256, horizon: int = 16, seed: int = 0) -> None:
        from pytorch_mppi import MPPI

        torch.manual_seed(seed)
        self._outline, self._servo = Outline.of(), Servo.of()
        self._motion = PoseMotion(ContactDynamics(self._outline, self._outline.gyration))
        self._goal = self._outline.center_at(
            torch.tensor([256.0, 256.0, np.pi / 4], dtype=torch.float64)
        )
        speed = torch.full((2,), 400.0, dtype=torch.float64)
        self._mppi = MPPI(
            self._dynamics,
            self._cost,
            nx=5,
            noise_sigma=torch.eye(2, dtype=torch.float64) * 300.0**2,
            num_samples=samples,
            horizon=horizon,
            lambda_=5.0,
            u_min=-speed,
            u_max=speed,
        )

    def predict(
        self, observation: dict[str, Any], last: Tensor | None = None
    ) -> tuple[NDArray[np.float64], Tensor]:
        """The next position target (2,), px, and where the pusher is."""
        keypoints = torch.as_tensor(observation["environment_state"], dtype=torch.float64).reshape(
            -1, 2
        )
        pusher = torch.as_tensor(observation["agent_pos"], dtype=torch.float64)
        velocity = (pusher - last) / DT if last is not None else torch.zeros_like(pusher)
        action = self._mppi.command(torch.cat((self._outline.pose(keypoints), pusher)))
        return self._servo.target(action, pusher, velocity, DT).numpy(), pusher

    def _dynamics(self, state: Tensor, action: Tensor) -> Tensor:
        pusher = state[..., 3:] + DT * action
        return torch.cat((self._motion(state[..., :3], pusher, action, DT), pusher), dim=-1)

    def _cost(self, state: Tensor, action: Tensor) -> Tensor:
        away = (norm(state[..., 3:] - state[..., :2]) - 60.0).clamp(min=0.0)
        return norm(pose_error(state[..., :3], self._goal, self._outline.gyration)) + 0.1 * away


def _record(name: str, task: str, obs_type: str, **options: Any) -> list[dict[str, Any]]:
    """What an episode of AICON observes at first."""
    env, policy = gym.make(name, obs_type=obs_type), make_policy(task, **options)
    observation, _ = env.reset(seed=SEED)
    observations, memory = [], None
    for _ in range(RECORDED):
        observations.append(observation)
        action, memory = policy.predict(observation, memory)
        observation, *_ = env.step(action)
    return observations


def _meetings() -> list[GradientStack]:
    """The meetings at the pusher in this episode."""
    policy = make_policy("pusht")
    step = _play(policy, _record(*PUSHT))
    with patch.object(policy.resolution, "forward", wraps=policy.resolution.forward) as forward:
        for _ in range(RECORDED):
            step()
    seen: list[GradientStack] = [call.args[0] for call in forward.call_args_list]
    largest = max(meeting.gradients.shape[-2] for meeting in seen)
    return [meeting for meeting in seen if meeting.gradients.shape[-2] == largest]


def _play(policy: Any, observations: list[dict[str, Any]]) -> Step:
    """One step of a policy on the next of these observations, again and again."""
    turns, memory = cycle(observations), None

    def step() -> None:
        nonlocal memory
        _, memory = policy.predict(next(turns), memory)

    return step


def _student(sampler: str, steps: int, observations: list[dict[str, Any]]) -> Step:
    """One action of the diffusion policy; it samples four at a time, so a round takes a multiple of four."""
    from aicon_baselines.agents.diffusion.agent import Agent

    return _play(Agent(STUDENT, sampler, steps), _batched(observations))


def _agent() -> Any:
    """An agent of stable-baselines3 that has learned nothing yet, which takes it as long as what it will have."""
    sb3 = import_sb3()
    with TemporaryDirectory() as folder:
        sb3.train(sb3.settings("pusht", "ppo", steps=8, envs=1, rollout=8, epochs=1), Path(folder))
        return sb3.Agent(Path(folder), "pusht")


def _batched(observations: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [
        {name: reading[None] for name, reading in observation.items()}
        for observation in observations
    ]


def _installed(name: str, make: Callable[[], Step]) -> Step | None:
    try:
        return make()
    except (ModuleNotFoundError, ComparisonError, OptionError, gym.error.Error) as error:
        print(f"without {name}: {error}")
        return None


GROUPS = {
    "one action of pushT": pushing,
    "the gradients that meet in pushT": gradients,
    "one step of the arm": arm,
}
