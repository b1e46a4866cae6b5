"""Agents of stable-baselines3: trained on a task, saved, and compared like any other policy.

| file | content |
|---|---|
| `training_config.py` | what is trained |
| `wrappers.py` | pushT's reward in training and its frame, and the last action, which agents see |
| `environments.py` | the environments of the training, and everything that an agent observes |
| `algorithms.py` | networks and hyperparameters, and how readings enter |
| `training.py` | training, and going on with it |
| `agent_folder.py` | the folder of an agent |
| `weights.py` | loading its network, without running code |
| `statistics.py` | what normalises its readings, as a file |
| `replay_file.py` | what SAC has seen, as a file |
| `agent.py` | a saved agent as a policy |

Example:
    >>> from pathlib import Path
    >>> from aicon_baselines.agents import sb3
    >>> config = sb3.TrainingConfig.for_task("pusht", "ppo", steps=1_000_000)
    >>> sb3.train(config, Path("runs/ppo_pusht"))  # doctest: +SKIP
    >>> agent = sb3.Agent(Path("runs/ppo_pusht"), "pusht")  # doctest: +SKIP
"""

from aicon_baselines.agents.sb3.agent import Agent
from aicon_baselines.agents.sb3.training import train
from aicon_baselines.agents.sb3.training_config import ALGORITHMS, TrainingConfig

__all__ = ["ALGORITHMS", "Agent", "TrainingConfig", "train"]
