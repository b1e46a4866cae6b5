"""Agents of stable-baselines3: trained on a task's environment, saved in a folder, and compared like any other policy.

| file | content |
|---|---|
| `settings.py` | what is trained |
| `shaping.py` | the reward of pushT in training; navigation has the environment's own |
| `from_pusher.py` | actions of pushT, and keypoints from where the pusher is |
| `last_action.py` | an agent sees its last action |
| `environments.py` | the environments that an agent is trained in, and everything that it observes |
| `readings.py` | how readings enter the network |
| `networks.py` | networks and hyperparameters |
| `training.py` | training and going on with it |
| `files.py` | the folder of an agent |
| `agent.py` | a saved agent as a policy |

Example:
    >>> from pathlib import Path
    >>> from aicon_baselines import sb3
    >>> config = sb3.settings("pusht", "ppo", steps=1_000_000)
    >>> sb3.train(config, Path("runs/ppo_pusht"))  # doctest: +SKIP
    >>> agent = sb3.Agent(Path("runs/ppo_pusht"), "pusht")  # doctest: +SKIP
"""

from aicon_baselines.agents.sb3.agent import Agent
from aicon_baselines.agents.sb3.settings import ALGORITHMS, Settings, settings
from aicon_baselines.agents.sb3.training import train

__all__ = ["ALGORITHMS", "Agent", "Settings", "settings", "train"]
