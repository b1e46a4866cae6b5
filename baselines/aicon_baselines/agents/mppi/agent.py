"""Model-predictive path integral control of pushT as a policy of our comparison."""

from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from pytorch_mppi import MPPI_Batched
from torch import Tensor

from aicon_baselines.agents.mppi.cost import Cost
from aicon_baselines.agents.mppi.options import Options
from aicon_baselines.agents.mppi.prediction import STATE_SIZE, Prediction
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import starting_rows
from aicon_torch.models import pusht
from aicon_torch.models.pusht import PIXEL
from aicon_torch.models.pusht.benchmark import WORKSPACE


class Memory(NamedTuple):
    """What the planner keeps of B robots.

    Attributes:
        plan: (B, H, 2), the planned mean velocities, m/s.
        pusher: (B, 2), where the pusher was, m.
        velocity: (B, 2), its velocity there, m/s.
        pose: (B, 3), where the object was, m and rad.
        begun: (B,), whether the episode has only begun.
        random_state: State of the random numbers, the same for all robots.
    """

    plan: Tensor
    pusher: Tensor
    velocity: Tensor
    pose: Tensor
    begun: Tensor
    random_state: Tensor


class Agent:
    """MPPI on pushT with AICON's contact model, on the same readings.

    In each step it draws sequences of velocities around the last plan, predicts what each does
    (:class:`Prediction`), and averages them, weighted by their costs (:class:`Cost`). The first
    velocity of the average is what the servo is to give the pusher. Sampling and weighting are
    those of pytorch-mppi (Williams et al. 2017, algorithm 2).

    All robots of a batch draw the same numbers, from a seed: an episode goes the same way in every
    batch and every run, up to the last bits of a batched computation.

    Args:
        options: Those of the planner.
        model: Those of AICON's model, which say what is pushed, where to, and how fast.
        seed: Seed of the samples.

    Raises:
        ComparisonError: Where the goal moves or readings are late.
    """

    def __init__(
        self, options: Options | None = None, model: pusht.Options | None = None, seed: int = 0
    ) -> None:
        self._options = options or Options()
        self._model = model or pusht.Options()
        self._seed = seed
        if self._model.observe_goal or self._model.delay:
            raise ComparisonError(
                "MPPI plans to a fixed goal from readings without delay: choose other conditions"
            )

        self._prediction = Prediction(self._model)
        frame = torch.tensor(tuple(self._model.goal_pose), dtype=self._model.dtype)
        goal = self._prediction.body.pose_of_frame(frame)
        self._cost = Cost(self._prediction.dynamics, goal, self._options)
        self._planner = self._make_planner(self._prediction, self._cost)

    def compile(self) -> "Agent":
        """Return the same policy with compiled prediction and cost, many times faster."""
        compiled = Agent(self._options, self._model, self._seed)
        prediction, cost = torch.compile(compiled._prediction), torch.compile(compiled._cost)
        compiled._planner = compiled._make_planner(prediction, cost)
        return compiled

    @torch.inference_mode()
    def predict(
        self,
        observation: dict[str, Any],
        state: Memory | None = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float64], Memory]:
        """Choose the next position targets (B, 2), px; see `aicon_baselines.evaluation.Predictor`.

        Args:
            observation: ``environment_state`` (B, 2K) and ``agent_pos`` (B, 2), px.
            state: What the previous call returned second.
            episode_start: (B,), true where an episode begins.
            deterministic: Makes no difference: the samples are those of the seed.

        Raises:
            ComparisonError: Where a reading is missing.
        """
        keypoints = self._metres(observation, "environment_state")
        pusher = self._metres(observation, "agent_pos")
        pose = self._prediction.body.registration(keypoints.reshape(len(keypoints), -1, 2))

        # 1. Forget what was before an episode.
        initial = self._initial(pusher, pose)
        previous = initial if state is None else state
        starts = torch.from_numpy(starting_rows(len(pusher), state, episode_start))
        begins = starts & ~_repeats(previous, initial)
        memory = _restart(previous, initial, begins)

        # 2. Plan, from where the pusher is and how fast it is.
        velocity = self._velocity(memory, pusher)
        states = torch.cat((pose, pusher, velocity), dim=-1)
        plan, random_state = self._plan(states, memory, rows=begins | ~starts)

        # 3. The target that yields the first velocity.
        offset = self._prediction.servo.target_offset(plan[:, 0], velocity, self._model.dt)
        target = (pusher + offset).clamp(*WORKSPACE)
        memory = Memory(plan, pusher, velocity, pose, starts, random_state)
        return (target / PIXEL).numpy(), memory

    def _metres(self, observation: dict[str, Any], name: str) -> Tensor:
        """A reading in metres, (B, n)."""
        reading = PIXEL * torch.as_tensor(observation[name], dtype=self._model.dtype)
        if not reading.isfinite().all():
            raise ComparisonError(
                f"{name} has missing values, or infinite ones, of which MPPI knows nothing: choose "
                "other conditions"
            )
        return reading

    def _initial(self, pusher: Tensor, pose: Tensor) -> Memory:
        """The memory of robots at rest (B, 2) without a plan."""
        count = len(pusher)
        return Memory(
            plan=pusher.new_zeros(count, self._options.horizon, 2),
            pusher=pusher,
            velocity=torch.zeros_like(pusher),
            pose=pose,
            begun=torch.zeros(count, dtype=torch.bool),
            random_state=torch.Generator().manual_seed(self._seed).get_state(),
        )

    def _velocity(self, memory: Memory, pusher: Tensor) -> Tensor:
        """The pusher's velocity (B, 2), m/s, as the servo leaves it after its last motion."""
        dt = self._model.dt
        mean = (pusher - memory.pusher) / dt
        return self._prediction.servo.final_velocity(memory.velocity, mean, dt)

    def _plan(self, states: Tensor, memory: Memory, rows: Tensor) -> tuple[Tensor, Tensor]:
        """The new plans (B, H, 2) in these rows (B,), and the state of the random numbers then."""
        plan = memory.plan.clone()
        if not rows.any():
            return plan, memory.random_state

        # The planner shifts the last plans by a step, and remembers nothing else.
        planner = self._planner
        planner.N, planner.U = int(rows.sum()), plan[rows]

        # It draws from torch's global random numbers, which are others' as well.
        with torch.random.fork_rng(devices=()):
            torch.set_rng_state(memory.random_state)
            planner.command(states[rows])
            plan[rows] = planner.U
            return plan, torch.get_rng_state()

    def _make_planner(self, prediction: Any, cost: Any) -> MPPI_Batched:
        """The planner, of one robot at first."""
        options, dtype = self._options, self._model.dtype
        limit = torch.full((2,), self._model.max_speed, dtype=dtype)
        with torch.random.fork_rng(devices=()):
            return MPPI_Batched(
                prediction,
                cost,
                nx=STATE_SIZE,
                noise_sigma=options.noise**2 * torch.eye(2, dtype=dtype),
                num_envs=1,
                num_samples=options.samples,
                horizon=options.horizon,
                lambda_=options.temperature,
                u_min=-limit,
                u_max=limit,
            )


def _restart(memory: Memory, initial: Memory, begins: Tensor) -> Memory:
    """The memory where no episode begins, (B,), and the initial one where one does."""
    rows = begins[:, None]
    return memory._replace(
        plan=torch.where(rows[:, None], initial.plan, memory.plan),
        pusher=torch.where(rows, initial.pusher, memory.pusher),
        velocity=torch.where(rows, initial.velocity, memory.velocity),
    )


def _repeats(memory: Memory, initial: Memory) -> Tensor:
    """Where an episode had just begun, and what is seen is what was seen then, (B,).

    It would plan the same again. That is no rare case: in a comparison, episodes that have ended
    stay in the batch like this.
    """
    same_pusher = (memory.pusher == initial.pusher).all(-1)
    same_pose = (memory.pose == initial.pose).all(-1)
    return memory.begun & same_pusher & same_pose
