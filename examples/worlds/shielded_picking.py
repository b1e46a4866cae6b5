"""Other people's scripts behind a shield: they pick and place, and a board is in their way.

The worlds and their scripts are those of so101_pick_place.py and ogbench_cubes.py; the scripts know
nothing of the board, and the shield nothing of what they do. With their packages, as `make worlds`
puts them into .venv-worlds:

    export PYTHONPATH=.venv-worlds:examples/worlds
    python scripts/shield.py shielded_picking:so101 --episodes 50 --horizon 300
    python scripts/shield.py shielded_picking:cube --episodes 50 --horizon 400
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray
from ogbench_cubes import HAND as ROBOTIQ
from ogbench_cubes import Cubes, Oracle
from so101_pick_place import HAND as JAW
from so101_pick_place import PickPlace, Script
from torch import Tensor

from aicon_baselines.agents.shields.clamped import Clamped, shortened
from aicon_baselines.agents.shields.world import World, guards, seeded
from aicon_baselines.evaluation.predictor import Predictor
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_torch import Actuator, Affine, Goal, Sensor, Shield, WorldModel
from aicon_torch.dampers import VelocityDampers
from aicon_torch.models.picking import Hand
from aicon_torch.models.picking.graph import LAG, TIP_NOISE, position, read_first
from aicon_torch.parts import norm

HALF_WIDTH = 0.06  # m, of the board, besides its round edge
EDGE = 0.02  # m, the radius of that edge, which the tip must not enter
MARGIN = 0.03  # m, kept from it: the arm does not follow exactly
BRAKING = 0.05  # m, the way on which the tip brakes
FREE = EDGE + 0.06  # m, from it to block and goal, at least


class Blocked(gymnasium.Wrapper[Any, Any, Any, Any]):
    """A world in which a board stands halfway between the block and its goal, across the way.

    Its middle on the table, the direction across it and its height are in the observation,
    `z_board` (5,), m; `info["collision"]` says whether the tip is inside. An action is tip and jaw
    in one array.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], height: float, is_blocked: bool) -> None:
        super().__init__(env)
        seen, acts = env.observation_space, env.action_space
        assert isinstance(seen, Dict) and isinstance(acts, Dict)
        self.observation_space = Dict({**seen.spaces, "z_board": Box(-np.inf, np.inf, (5,))})
        self._turns = sum(acts["tip"].shape or ())
        self.action_space = Box(-1.0, 1.0, (self._turns + 1,))
        self._height, self._is_blocked = height, is_blocked

    def reset(self, **arguments: Any) -> Any:
        """Begin, anew until the board leaves block and goal free."""
        while True:
            observation, info = self.env.reset(**arguments)
            begin, end = observation["z_block"][:2], observation["z_goal"][:2]
            length = np.linalg.norm(end - begin)
            if length > 2 * FREE:
                break
            arguments = {}  # drawn anew from the same generator
        middle = (begin + end) / 2 if self._is_blocked else np.full(2, 100.0)
        across = (end - begin) / length
        self._board = np.concatenate([middle, across, [self._height]])
        return observation | {"z_board": self._board}, info

    def step(self, action: Any) -> Any:
        """Move."""
        divided = {"tip": action[: self._turns], "jaw": action[self._turns :]}
        observation, reward, ends, cut, info = self.env.step(divided)
        tip = observation["z_tip"][:3]
        inside = float(gap(torch.tensor(tip), torch.tensor(self._board))) < 0
        info = info | {"collision": inside, "position": tip}
        return observation | {"z_board": self._board}, reward, ends, cut, info


def gap(tip: Tensor, board: Tensor) -> Tensor:
    """How far a tip ``(*B, 3)`` is from a board ``(*B, 5)``, ``(*B,)``, m."""
    beside, across, height = tip[..., :2] - board[..., :2], board[..., 2:4], board[..., 4]
    along = torch.stack((-across[..., 1], across[..., 0]), -1)
    off_plane = (beside * across).sum(-1)
    off_middle = (beside * along).sum(-1)
    outside = (off_plane, off_middle.abs() - HALF_WIDTH, tip[..., 2] - height)
    beyond = [outside[0], *(length.clamp(min=0.0) for length in outside[1:])]
    return norm(torch.stack(beyond, -1)) - EDGE


@dataclass(frozen=True)
class InOneArray:
    """A script whose actions are tip and jaw in one array (B, n + 1)."""

    script: Any

    def predict(self, *arguments: Any, **named: Any) -> tuple[NDArray[Any], Any]:
        """What the script does."""
        action, state = self.script.predict(*arguments, **named)
        return np.concatenate([action["tip"], action["jaw"]], -1), state


class OfTheTip:
    """A policy of which the motion of the tip is guarded, and hand and jaw turn as they are told.

    Args:
        policy: Whose actions begin with the motion of the tip, (B, 3).
        guard: A guard around :class:`Wanted`.
    """

    def __init__(self, policy: Predictor, guard: Predictor) -> None:
        self._policy, self._guard = policy, guard

    def predict(
        self,
        observation: Mapping[str, Any],
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[Any], Any]:
        """The guarded action (B, n)."""
        of_policy, of_guard = (None, None) if state is None else state
        action, of_policy = self._policy.predict(
            observation, of_policy, episode_start, deterministic
        )
        tip = np.asarray(observation["z_tip"])[..., :3]
        seen = {**observation, "z_tip": tip, "wanted": action[..., :3]}
        moved, of_guard = self._guard.predict(seen, of_guard, episode_start)
        return np.concatenate([moved, action[..., 3:]], -1), (of_policy, of_guard)


@dataclass(frozen=True)
class Wanted:
    """A policy that proposes what the observation says is wanted of the tip."""

    def predict(self, observation: Mapping[str, Any], *_: Any, **__: Any) -> tuple[Any, Any]:
        """The motion of the tip (B, 3), in shares of the largest."""
        return observation["wanted"], None


def shielded(hand: Hand, policy: Predictor, goes_around: bool = True) -> Predictor:
    """A policy whose tip does not enter the board, compiled."""
    farthest = hand.steps[:3]

    def meant(proposal: Tensor) -> Tensor:
        return proposal * proposal.new_tensor(farthest) / hand.time_step

    shield = Shield(Wanted(), model(hand), nominal=meant, goes_around=goes_around)
    return OfTheTip(policy, shield.compile())


def model(hand: Hand) -> WorldModel:
    """The tip, and a board that it sees."""
    farthest = hand.steps[:3]

    def command(tip: Tensor) -> Tensor:
        return tip * hand.time_step / tip.new_tensor(farthest)

    def inside(x_tip: Tensor, z_board: Tensor) -> Tensor:
        return MARGIN - gap(x_tip, z_board)

    velocity = Actuator(
        3,
        "m/s",
        limit=tuple(step / hand.time_step for step in farthest),
        command=command,
        command_range=(-1.0, 1.0),
        dampers=VelocityDampers(braking=BRAKING),
    )
    tip = position(
        "x_tip",
        Affine(x_tip=1.0, tip="dt"),
        LAG**2,
        Affine(x_tip=1.0, z_tip=-1.0),
        read_first("z_tip", 3),
        size=3,
        noise=TIP_NOISE**2,
    )
    return WorldModel(
        sensors={"z_tip": Sensor(3, "m"), "z_board": Sensor(5, "m")},
        actuators={"tip": velocity},
        estimators=[tip],
        goals=[Goal("board", inside, safety=True)],
        dt=hand.time_step,
    )


def clamped(hand: Hand, policy: Predictor) -> Predictor:
    """A policy whose tip is slowed to what is left of its way to the board, wherever it goes."""

    def slowed(action: NDArray[Any], observation: Mapping[str, Any]) -> NDArray[Any]:
        tip, board = (torch.tensor(observation[name]) for name in ("z_tip", "z_board"))
        left = (gap(tip, board) - MARGIN).clamp(min=0.0).numpy()
        return shortened(action, left[..., None] / max(hand.steps[:3]))

    return OfTheTip(policy, Clamped(Wanted(), slowed))


def _world(
    make: Callable[[], Any],
    script: Any,
    hand: Hand,
    horizon: int,
    height: float,
    is_blocked: bool,
) -> World:
    def make_env(count: int) -> Any:
        return side_by_side(lambda: Blocked(make(), height, is_blocked), count, horizon)

    return World(
        proposers={"script": lambda: InOneArray(script())},
        guards=guards(partial(clamped, hand), partial(shielded, hand)),
        start=seeded(make_env),
        time_step=hand.time_step,
        still=(round(3.0 / hand.time_step), 0.02),
        at_once=25,
    )


def so101(is_blocked: bool = True) -> World:
    """SO-101, and the script of its package."""
    return _world(PickPlace, Script, JAW, 300, 0.12, is_blocked)


def cube(is_blocked: bool = True) -> World:
    """OGBench's cube-single, across the table, and its oracle."""
    return _world(partial(Cubes, 1, 1), Oracle, ROBOTIQ, 400, 0.3, is_blocked)


so101_free, cube_free = partial(so101, False), partial(cube, False)
