"""Measure what the documents say of speed, beyond `aicon bench`; the processor's time counts.

Example: python scripts/benchmark.py arm --steps 3000
         python scripts/benchmark.py peers --rounds 20
         python scripts/benchmark.py watch --tasks nav2d pusht arm_push reach

arm: the arm's loop at 100 Hz with an image every fifth step: physics and rendering, image, control
step, and the real-time factor. The control step is timed in the loop, where physics and rendering
have emptied the processor's caches, and again on what was recorded.

peers: the tools of others beside ours, the same work on the same input, in turns. What is not
installed is left out, and said.

watch: the rate that a control loop keeps with the live view, and what the view costs.
"""

import argparse
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import cycle
from pathlib import Path
from threading import Timer
from typing import TYPE_CHECKING, Any

from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command

# isort: split

import gymnasium as gym
import numpy as np
import torch

import aicon_envs  # noqa: F401  # registers the environments
from aicon_baselines.agents.registry import compiled, factory, import_sb3
from aicon_baselines.cli.bench import observations_of_one, record_observations
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.timing import Step, ratios, replay, spread, take_turns
from aicon_baselines.tasks import load
from aicon_torch import NullspaceProjection, OptionError, Policy, make_policy
from aicon_torch.inspection import QuantityTrace
from aicon_torch.resolution import GradientStack

if TYPE_CHECKING:
    from aicon_baselines.view import LiveEpisode

REPOSITORY = Path(__file__).resolve().parents[1]
STUDENT = REPOSITORY / "baselines" / "checkpoints" / "diffusion_pusht_keypoints"
PUSHT, ARM = ("pusht", "deterministic"), ("arm_push", "true_pose")
RECORDED = 100
ARM_STEP = 0.01  # s

Program = tuple[str, Callable[[], Step]]
"""The name of a program, and what prepares it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is measured, and for how long."""
    subjects = parser.add_subparsers(dest="subject", required=True, metavar="SUBJECT")

    subject = subjects.add_parser("arm", help="the arm's loop")
    add_option(subject, "--steps", 3000, "control steps", type=at_least(1))
    add_option(subject, "--seed", 1000, "seed of the first episode", type=at_least(0))
    subject.add_argument("--background", action="store_true", help="do not wait for images")

    subject = subjects.add_parser("peers", help="the tools of others beside ours")
    add_option(subject, "--rounds", 60, "turns", type=at_least(1))
    add_option(subject, "--steps", 20, "of a turn", type=at_least(1))

    subject = subjects.add_parser("watch", help="what watching costs")
    subject.add_argument("--tasks", nargs="+", default=["nav2d", "pusht"], metavar="TASK")
    add_option(subject, "--seconds", 20.0, "with the view")
    add_option(subject, "--seed", 1004, "seed of the first episode", type=at_least(0))


def run(arguments: argparse.Namespace) -> None:
    """Measure and print."""
    torch.set_num_threads(1)
    {"arm": arm, "peers": peers, "watch": watch}[arguments.subject](arguments)


def arm(arguments: argparse.Namespace) -> None:
    """Measure the loop and print its parts."""
    times = arm_times(arguments.steps, arguments.seed, arguments.background)
    image, environment = times["image"], times["environment"]
    rendered = times["age"] < ARM_STEP / 2
    # Between images there is nothing to read, which takes next to no time.
    reads_image = image > 10 * np.median(image)

    parts = {
        "predict, by the clock": times["predict"],
        "control step": times["control"],
        "control step on recorded data": times["again"],
        "reading a new image": image[reads_image],
        "environment, without an image": environment[~rendered],
        "environment, with an image": environment[rendered],
    }
    for name, seconds in parts.items():
        median, slow = 1e3 * np.percentile(seconds, (50, 99))
        print(f"{name:30} {median:7.3f} ms, 99th percentile {slow:7.3f} ms")

    simulated = len(image) * ARM_STEP
    processor = simulated / (times["control"].sum() + image.sum() + environment.sum())
    clock = simulated / times["clock"].sum()
    print(f"real-time factor: {processor:.2f} by processor time, {clock:.2f} by the clock")


def arm_times(steps: int, seed: int, background: bool) -> dict[str, Any]:
    """Seconds of each part in each step, and the age of the image that it saw, (steps,) each.

    The first step, which compiles, is left out.
    """
    options = {**load("arm_push").policy_options("camera"), "camera.background": background}
    policy: Any = make_policy("arm_push", **options)
    blind: Any = Policy(policy.model, policy.resolution, policy.law).compile()
    see, readings = policy.perception, []
    times: dict[str, list[float]] = defaultdict(list)

    def timed_perception(*seen: Any) -> Any:
        start = time.process_time()
        readings.append(see(*seen))
        times["image"].append(time.process_time() - start)
        return readings[-1]

    policy.perception = timed_perception
    policy = policy.compile()
    env: Any = gym.make("aicon/ArmPush-v0", disable_env_checker=True).unwrapped
    observation, _ = env.reset(seed=seed)
    policy.predict(observation)
    readings.clear()
    times.clear()

    memory: Any = None
    begins: list[bool] = []
    for _ in range(steps):
        begins.append(memory is None)
        clock, start = time.perf_counter(), time.process_time()
        action, memory = policy.predict(observation, memory)
        decided = time.process_time()
        times["predict"].append(time.perf_counter() - clock)
        times["control"].append(decided - start - times["image"][-1])

        observation, _, terminated, _, _ = env.step(action)
        times["environment"].append(time.process_time() - decided)
        times["clock"].append(time.perf_counter() - clock)
        times["age"].append(float(observation["image_age"][0]))

        if terminated:
            seed, memory = seed + 1, None
            observation, _ = env.reset(seed=seed)
    env.close()

    # The same control steps with nothing between them.
    blind.predict(readings[0])  # it compiles
    for reading, begin in zip(readings, begins, strict=True):
        before = None if begin else memory
        start = time.process_time()
        _, memory = blind.predict(reading, before)
        times["again"].append(time.process_time() - start)
    return {name: np.array(seconds) for name, seconds in times.items()}


def peers(arguments: argparse.Namespace) -> None:
    """Measure every group and print the time of each program beside the first."""
    for title, group in GROUPS.items():
        programs: dict[str, Step] = {}
        for name, prepare in group():
            try:
                programs[name] = prepare()
            except (ModuleNotFoundError, ComparisonError, OptionError, gym.error.Error) as error:
                print(f"without {name}: {error}")
        if not programs:
            continue

        times = take_turns(programs, arguments.rounds, arguments.steps, title)
        print(f"\n{title}, one thread, ms: median (5 % to 95 %), and how many times the first")
        first = next(iter(times.values()))
        for name, seconds in times.items():
            print(f"  {name:48} {spread(seconds, 1e3):28} {spread(ratios(seconds, first))}")


def pushing_programs() -> Iterator[Program]:
    """Policies that choose the next action of pushT, on what an episode of AICON observes."""
    batches = record_observations(*PUSHT, RECORDED)
    observations = observations_of_one(*PUSHT, RECORDED)

    yield "AICON", lambda: replay(make_policy("pusht"), observations)
    yield "AICON, compiled", lambda: replay(make_policy("pusht").compile(), observations)
    for sampler, denoising in (("DDIM", 10), ("DDPM", 100)):
        name = f"diffusion policy of LeRobot, {sampler} {denoising}"
        yield name, partial(_student, sampler, denoising, batches)
    yield "PPO of stable-baselines3", lambda: replay(_untrained_agent(), batches)
    for name, planner in (("MPPI", "mppi"), ("MPPI with fewer samples", "mppi_small")):
        yield name, partial(_planner, planner, batches)


def gradient_programs() -> Iterator[Program]:
    """Rules from the gradients that arrive at the pusher in an episode of pushT to one."""
    policy, memory, arrivals = make_policy("pusht"), None, []
    for observation in observations_of_one(*PUSHT, RECORDED):
        _, memory = policy.predict(observation, memory)
        arrivals.append(policy.trace(memory).quantities["x_pusher"])
    count = arrivals[0].gradients.shape[-2]

    yield f"nullspace projection of {count} gradients", partial(_projection, arrivals)
    yield "UPGrad of TorchJD", partial(_torchjd, "UPGrad", arrivals)
    yield "PCGrad of TorchJD", partial(_torchjd, "PCGrad", arrivals)


def arm_programs() -> Iterator[Program]:
    """AICON on the arm, with all its goals and no camera, beside one step of inverse kinematics."""
    observations = observations_of_one(*ARM, RECORDED)

    yield "AICON", lambda: replay(make_policy("arm_push", sensing="pose"), observations)
    fast = make_policy("arm_push", sensing="pose").compile()
    yield "AICON, compiled", lambda: replay(fast, observations)
    yield "one step of mink, limits of joints and speeds", _mink


def _student(sampler: str, steps: int, observations: list[dict[str, Any]]) -> Step:
    """One action of the diffusion policy; it samples four at a time: rounds of a multiple of 4."""
    from aicon_baselines.agents.diffusion.agent import Agent

    return replay(Agent(STUDENT, sampler, steps), observations)


def _planner(name: str, observations: list[dict[str, Any]]) -> Step:
    """The tuned planner, compiled like AICON."""
    return replay(compiled(factory("pusht", name))("deterministic"), observations)


def _untrained_agent() -> Any:
    """An agent of stable-baselines3 that has learned nothing, which takes it as long."""
    sb3 = import_sb3()
    config = sb3.TrainingConfig.for_task("pusht", "ppo", steps=8, envs=1, rollout=8, epochs=1)
    with tempfile.TemporaryDirectory() as folder:
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


def _mink() -> Step:
    """Step toward a pose that is already reached; the work is the same."""
    import mink

    env: Any = gym.make("aicon/ArmPush-v0", obs_type="pose").unwrapped
    env.reset(seed=1000)
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


GROUPS: Mapping[str, Callable[[], Iterator[Program]]] = {
    "one action of pushT": pushing_programs,
    "the gradients that arrive at the pusher": gradient_programs,
    "one step of the arm": arm_programs,
}


def watch(arguments: argparse.Namespace) -> None:
    """Measure task by task; a page that is open meanwhile counts."""
    from aicon_baselines.view import open_episode

    for task in arguments.tasks:
        # Where the usual condition renders images, they would be all that is measured.
        condition = load(task).timed_condition or None
        episode = open_episode(task, condition=condition, seed=arguments.seed)
        episode.compile()
        while not episode.compiled:
            time.sleep(0.1)

        alone = processor_time_alone(episode)
        rate, watched = with_view(episode, arguments.seconds, arguments.seed)
        hertz = 1.0 / episode.time_step
        print(
            f"{task}: {rate:.1%} of {hertz:.0f} Hz; processor time of a step {1e3 * alone:.2f} ms "
            f"alone, {1e3 * watched:.2f} ms with the view ({watched / alone:.1f} times)",
            flush=True,
        )


def processor_time_alone(episode: "LiveEpisode", steps: int = 200) -> float:
    """Processor time of a step of environment and policy, s; after the end, from the start."""
    seed = episode.seed
    start = time.process_time()
    for _ in range(steps):
        if episode.ended:
            episode.start(seed)
        episode.step()
    return (time.process_time() - start) / steps


def with_view(episode: "LiveEpisode", seconds: float, seed: int) -> tuple[float, float]:
    """The share of the control rate that is kept with the view, and a step's processor time, s."""
    from aicon_baselines.view import LiveView, serve

    episode.start(seed)
    view = LiveView(episode, serve("127.0.0.1", 0), compiles=False, loops=True)
    print(f"http://localhost:{view.port}", flush=True)

    timer = Timer(seconds, view.stop)
    timer.start()
    begun, worked = time.monotonic(), time.process_time()
    view.run()
    passed, used = time.monotonic() - begun, time.process_time() - worked
    view.close()
    return view.taken * episode.time_step / passed, used / view.taken


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
