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
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import cycle
from pathlib import Path
from threading import Timer
from typing import TYPE_CHECKING, Any, NamedTuple

from aicon_baselines.cli.command_line import Command, run_command

# isort: split

import gymnasium as gym
import numpy as np
import torch

import aicon_envs  # noqa: F401  # registers the environments
from aicon_baselines.agents.registry import compiled, factory, import_sb3
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
PUSHT = "aicon/PushT-v0", "pusht", "environment_state_agent_pos"
SEED = 1000
ARM_STEP = 0.01  # s

RECORDED = 100

Program = tuple[str, Callable[[], Step]]
"""The name of a program, and what prepares it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is measured, and for how long."""
    subjects = parser.add_subparsers(dest="subject", required=True, metavar="SUBJECT")

    subject = subjects.add_parser("arm", help="the arm's loop")
    subject.add_argument("--steps", type=int, default=3000, help="control steps (default: 3000)")
    subject.add_argument("--seed", type=int, default=1000, help="seed of the first episode")
    subject.add_argument("--background", action="store_true", help="do not wait for images")

    subject = subjects.add_parser("peers", help="the tools of others beside ours")
    subject.add_argument("--rounds", type=int, default=60, help="turns (default: 60)")
    subject.add_argument("--steps", type=int, default=20, help="of a turn (default: 20)")

    subject = subjects.add_parser("watch", help="what watching costs")
    subject.add_argument("--tasks", nargs="+", default=["nav2d", "pusht"], metavar="TASK")
    subject.add_argument("--seconds", type=float, default=20.0, help="with the view (default: 20)")
    subject.add_argument("--seed", type=int, default=1004)


def run(arguments: argparse.Namespace) -> None:
    """Measure and print."""
    torch.set_num_threads(1)
    {"arm": arm, "peers": peers, "watch": watch}[arguments.subject](arguments)


def arm(arguments: argparse.Namespace) -> None:
    """Measure the loop and print its parts."""
    results = summarize(_arm_loop(arguments.steps, arguments.seed, arguments.background))
    for name, row in results["parts"].items():
        median, slow = row["median"], row["percentile_99"]
        print(f"{name:30} {median:7.3f} ms, 99th percentile {slow:7.3f} ms")

    factors = results["real_time_factor"]
    processor, clock = factors["processor"], factors["clock"]
    print(f"real-time factor: {processor:.2f} by processor time, {clock:.2f} by the clock")


class Times(NamedTuple):
    """Seconds of each part in each step, and the age of the image that it saw."""

    environment: list[float]
    image: list[float]
    control: list[float]
    predict: list[float]
    clock: list[float]
    again: list[float]
    age: list[float]


class TimedPerception:
    """A perception that is timed, and whose readings are kept."""

    def __init__(self, perception: Any) -> None:
        self._perception = perception
        self.seconds: list[float] = []
        self.readings: list[Any] = []

    def __call__(self, observation: Any, values: Any, starts: Any) -> Any:
        """Read the image, and note how long it took."""
        start = time.process_time()
        readings = self._perception(observation, values, starts)
        self.seconds.append(time.process_time() - start)
        self.readings.append(readings)
        return readings

    def forget(self) -> None:
        """Forget what was noted."""
        self.seconds.clear()
        self.readings.clear()


def _arm_loop(steps: int, seed: int, background: bool) -> Times:
    """Run the loop, the first step, which compiles, left out of the times."""
    options = {**load("arm_push").policy_options("camera"), "camera.background": background}
    policy: Any = make_policy("arm_push", **options)
    perception = TimedPerception(policy.perception)
    policy.perception = perception
    blind = Policy(policy.model, policy.resolution, policy.law)
    policy, blind = policy.compile(), blind.compile()

    env: Any = gym.make("aicon/ArmPush-v0", disable_env_checker=True).unwrapped
    observation, _ = env.reset(seed=seed)
    policy.predict(observation)
    perception.forget()

    times = Times([], perception.seconds, [], [], [], [], [])
    memory: Any = None
    begins: list[bool] = []

    for _ in range(steps):
        begins.append(memory is None)
        clock, start = time.perf_counter(), time.process_time()

        action, memory = policy.predict(observation, memory)
        decided = time.process_time()
        times.predict.append(time.perf_counter() - clock)
        times.control.append(decided - start - perception.seconds[-1])

        observation, _, terminated, _, _ = env.step(action)
        times.environment.append(time.process_time() - decided)
        times.clock.append(time.perf_counter() - clock)
        times.age.append(float(observation["image_age"][0]))

        if terminated:
            seed, memory = seed + 1, None
            observation, _ = env.reset(seed=seed)

    env.close()
    times.again.extend(measure_again(blind, perception.readings, begins))
    return times


def measure_again(policy: Any, readings: list[Any], begins: list[bool]) -> list[float]:
    """Seconds of the same control steps with nothing between them."""
    _, memory = policy.predict(readings[0])  # it compiles
    seconds = []
    for reading, is_first in zip(readings, begins, strict=True):
        before = None if is_first else memory
        start = time.process_time()
        _, memory = policy.predict(reading, before)
        seconds.append(time.process_time() - start)
    return seconds


def summarize(times: Times) -> dict[str, Any]:
    """Medians and 99th percentiles, ms, and simulated by spent time."""
    image, environment = np.array(times.image), np.array(times.environment)
    rendered = np.array(times.age) < ARM_STEP / 2
    # Between images there is nothing to read, which takes next to no time.
    reads_image = image > 10 * np.median(image)

    parts = {
        "predict, by the clock": np.array(times.predict),
        "control step": np.array(times.control),
        "control step on recorded data": np.array(times.again),
        "reading a new image": image[reads_image],
        "environment, without an image": environment[~rendered],
        "environment, with an image": environment[rendered],
    }
    percentiles = {}
    for name, seconds in parts.items():
        median, slow = 1e3 * np.percentile(seconds, (50, 99))
        percentiles[name] = {"median": float(median), "percentile_99": float(slow)}

    simulated = len(times.clock) * ARM_STEP
    processor = sum(times.control) + sum(times.image) + sum(times.environment)
    factors = {"processor": simulated / processor, "clock": simulated / sum(times.clock)}
    return {"parts": percentiles, "real_time_factor": factors}


def peers(arguments: argparse.Namespace) -> None:
    """Measure every group and print it."""
    for title, group in GROUPS.items():
        programs: dict[str, Step] = {}
        for name, prepare in group():
            step = _prepare_if_installed(name, prepare)
            if step is not None:
                programs[name] = step
        if programs:
            times = take_turns(programs, arguments.rounds, arguments.steps, title)
            print_group(title, times)


def print_group(title: str, times: Mapping[str, list[float]]) -> None:
    """Print the time of each program, and how many times as long as the first it takes."""
    print(f"\n{title}, one thread, ms: median (5 % to 95 %), and how many times the first")
    first = next(iter(times.values()))
    for name, seconds in times.items():
        print(f"  {name:48} {spread(seconds, 1e3):28} {spread(ratios(seconds, first))}")


def pushing_programs() -> Iterator[Program]:
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


def gradient_programs() -> Iterator[Program]:
    """Rules from the gradients that arrive at the pusher in an episode of pushT to one."""
    arrivals = _arrivals_at_pusher()
    count = arrivals[0].gradients.shape[-2]

    yield f"nullspace projection of {count} gradients", partial(_projection, arrivals)
    yield "UPGrad of TorchJD", partial(_torchjd, "UPGrad", arrivals)
    yield "PCGrad of TorchJD", partial(_torchjd, "PCGrad", arrivals)


def arm_programs() -> Iterator[Program]:
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
    observation, _ = env.reset(seed=SEED)
    observations, memory = [], None

    for _ in range(RECORDED):
        observations.append(observation)
        action, memory = policy.predict(observation, memory)
        observation, *_ = env.step(action)
    return observations


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

        alone = processor_time_alone(episode, arguments.seed)
        rate, watched = with_view(episode, arguments.seconds, arguments.seed)
        hertz = 1.0 / episode.time_step
        print(
            f"{task}: {rate:.1%} of {hertz:.0f} Hz; processor time of a step {1e3 * alone:.2f} ms "
            f"alone, {1e3 * watched:.2f} ms with the view ({watched / alone:.1f} times)",
            flush=True,
        )


def processor_time_alone(episode: "LiveEpisode", seed: int, steps: int = 200) -> float:
    """Processor time of a step of environment and policy, s."""
    episode.start(seed)
    start = time.process_time()
    for _ in range(steps):
        _go_on(episode, seed)
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


def _go_on(episode: "LiveEpisode", seed: int) -> None:
    """Go on; after the end, from the start."""
    if episode.ended:
        episode.start(seed)
    episode.step()


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
