"""The tools of others beside ours, for `benchmark.py --peers`: the same work on the same input.

What is not installed is left out, and said. `make install` brings all of them; LeRobot alone comes
with pip install "aicon-torch[lerobot]", the others with "aicon-torch[peers]".
"""

import json
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import cycle, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium as gym
import numpy as np
import torch

import aicon_envs  # noqa: F401  # registers the environments
from aicon_baselines.agents.registry import compiled, factory, import_sb3
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.episodes import run_episodes
from aicon_baselines.evaluation.timing import Step, ratios, replay, spread, take_turns
from aicon_torch import NullspaceProjection, OptionError, make_policy
from aicon_torch.inspection import QuantityTrace
from aicon_torch.resolution import GradientStack

STUDENT = Path(__file__).parent.parent / "baselines" / "checkpoints" / "diffusion_pusht_keypoints"
SEED, RECORDED = 1000, 48
PUSHT = "aicon/PushT-v0", "pusht", "environment_state_agent_pos"

Program = tuple[str, Callable[[], Step]]
"""The name of a program, and what prepares it."""


def compare(rounds: int, steps: int, out: Path | None) -> None:
    """Measure every group, print it, and save peers.json in the folder `out`."""
    results: dict[str, dict[str, list[float]]] = {}
    for title, group in GROUPS.items():
        programs: dict[str, Step] = {}
        for name, prepare in group():
            step = _prepare_if_installed(name, prepare)
            if step is not None:
                programs[name] = step

        if programs:
            results[title] = take_turns(programs, rounds, steps, title)
            print_group(title, results[title])
            if out:
                out.mkdir(parents=True, exist_ok=True)
                (out / "peers.json").write_text(json.dumps(results, indent=2) + "\n")

    if out:
        print(f"\nsaved in {out / 'peers.json'}")


def print_group(title: str, times: Mapping[str, list[float]]) -> None:
    """Print the time of each program, and how many times as long as the first it takes."""
    print(f"\n{title}, one thread, ms: median (5 % to 95 %), and how many times the first")
    first = next(iter(times.values()))
    for name, seconds in times.items():
        print(f"  {name:48} {spread(seconds, 1e3):28} {spread(ratios(seconds, first))}")


def pushing() -> Iterator[Program]:
    """Policies that choose the next action of pushT, on what an episode of AICON observes."""
    observations = _record(*PUSHT)
    batched = _batched(observations)

    yield "AICON", lambda: replay(make_policy("pusht"), observations)
    yield "AICON, compiled", lambda: replay(make_policy("pusht").compile(), observations)
    for sampler, denoising in (("DDIM", 10), ("DDPM", 100)):
        name = f"diffusion policy of LeRobot, {sampler} {denoising}"
        yield name, partial(_student, sampler, denoising, batched)
    yield "PPO of stable-baselines3", lambda: replay(_untrained_agent(), batched)
    yield "MPPI", lambda: replay(_planner("mppi"), batched)
    yield "MPPI with fewer samples", lambda: replay(_planner("mppi_small"), batched)


def gradients() -> Iterator[Program]:
    """Rules from the gradients that arrive at the pusher in an episode of pushT to one."""
    arrivals = _arrivals_at_pusher()
    count = arrivals[0].gradients.shape[-2]

    yield f"nullspace projection of {count} gradients", partial(_projection, arrivals)
    yield "UPGrad of TorchJD", partial(_torchjd, "UPGrad", arrivals)
    yield "PCGrad of TorchJD", partial(_torchjd, "PCGrad", arrivals)


def arm() -> Iterator[Program]:
    """AICON on the arm, with all its goals and no camera, beside one step of inverse kinematics."""
    yield "AICON", partial(_arm_step, compiled=False)
    yield "AICON, compiled", partial(_arm_step, compiled=True)
    yield "one step of mink, limits of joints and speeds", _mink


def _student(sampler: str, steps: int, observations: list[dict[str, Any]]) -> Step:
    """One action of the diffusion policy; it samples four at a time: rounds of a multiple of 4."""
    from aicon_baselines.agents.diffusion.agent import Agent

    return replay(Agent(STUDENT, sampler, steps), observations)


def _planner(name: str) -> Any:
    """The tuned planner, compiled like AICON."""
    return compiled(factory("pusht", name))("deterministic")


def _untrained_agent() -> Any:
    """An agent of stable-baselines3 that has learned nothing, which takes it as long."""
    sb3 = import_sb3()
    config = sb3.TrainingConfig.for_task("pusht", "ppo", steps=8, envs=1, rollout=8, epochs=1)
    with TemporaryDirectory() as folder:
        sb3.train(config, Path(folder))
        return sb3.Agent(Path(folder), "pusht")


def _projection(arrivals: list[QuantityTrace]) -> Step:
    """Resolve the next gradients, without exploration."""
    rule = NullspaceProjection(exploration=None)
    stacks = cycle([_to_stack(arrival) for arrival in arrivals])
    count, size = arrivals[0].gradients.shape[-2:]
    memory = rule.initial(count, size)

    def step() -> None:
        nonlocal memory
        memory = rule(next(stacks), memory)[1]

    return step


def _torchjd(name: str, arrivals: list[QuantityTrace]) -> Step:
    """Aggregate the next gradients with an aggregator of TorchJD."""
    from torchjd import aggregation

    aggregator = getattr(aggregation, name)()
    upcoming = cycle([arrival.gradients for arrival in arrivals])
    return lambda: aggregator(next(upcoming))


def _to_stack(arrival: QuantityTrace) -> GradientStack:
    """What a resolution is given of these gradients, at rest."""
    gradients = arrival.gradients
    nothing = gradients.new_zeros(gradients.shape[:-2])
    return GradientStack(
        gradients=gradients,
        goals=tuple(frozenset(goals) for goals in arrival.goals),
        motion=torch.zeros_like(gradients[..., 0, :]),
        costs=dict.fromkeys(frozenset[str]().union(*arrival.goals), nothing),
        displaced_cost=lambda goal, shift: nothing,
        dt=0.1,
    )


def _arm_step(compiled: bool) -> Step:
    observations = _record("aicon/ArmPush-v0", "arm_push", obs_type="pose", sensing="pose")
    policy = make_policy("arm_push", sensing="pose")
    return replay(policy.compile() if compiled else policy, observations)


def _mink() -> Step:
    """Step toward a pose that is already reached; the work is the same."""
    import mink

    env: Any = gym.make("aicon/ArmPush-v0", obs_type="pose").unwrapped
    env.reset(seed=SEED)
    simulation = env._simulation
    configuration = mink.Configuration(simulation.model, simulation.data.qpos)

    task = mink.FrameTask("tool", "body", position_cost=1.0, orientation_cost=1.0)
    task.set_target(configuration.get_transform_frame_to_world("tool", "body"))
    speeds = {f"panda_joint{index}": 2.0 for index in range(1, 8)}
    limits = [
        mink.ConfigurationLimit(configuration.model),
        mink.VelocityLimit(configuration.model, speeds),
    ]

    def step() -> None:
        configuration.update(configuration.q)
        mink.solve_ik(configuration, [task], 0.01, "daqp", limits=limits)

    return step


def _record(name: str, task: str, obs_type: str, **options: Any) -> list[dict[str, Any]]:
    """What an episode of AICON observes at first."""
    env, policy = gym.make(name, obs_type=obs_type), make_policy(task, **options)
    taken = islice(run_episodes(policy, env, env.reset(seed=SEED)), RECORDED)
    return [step.observation for step in taken]


def _arrivals_at_pusher() -> list[QuantityTrace]:
    """The gradients that arrive at the pusher in this episode."""
    policy, memory, arrivals = make_policy("pusht"), None, []
    for observation in _record(*PUSHT):
        _, memory = policy.predict(observation, memory)
        arrivals.append(policy.trace(memory).quantities["x_pusher"])
    return arrivals


def _batched(observations: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The observations as batches of one."""
    batches = []
    for observation in observations:
        batches.append({name: np.asarray(reading)[None] for name, reading in observation.items()})
    return batches


def _prepare_if_installed(name: str, prepare: Callable[[], Step]) -> Step | None:
    try:
        return prepare()
    except (ModuleNotFoundError, ComparisonError, OptionError, gym.error.Error) as error:
        print(f"without {name}: {error}")
        return None


GROUPS: Mapping[str, Callable[[], Iterator[Program]]] = {
    "one action of pushT": pushing,
    "the gradients that arrive at the pusher": gradients,
    "one step of the arm": arm,
}
