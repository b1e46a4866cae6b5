"""Running a comparison: every policy on every episode, in parallel, going on where an earlier run stopped."""

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple, cast

import torch
from joblib import Parallel, delayed

from aicon_baselines.evaluation.backends import joblib_backend
from aicon_baselines.evaluation.config import Config
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.agents.registry import Factory
from aicon_baselines.evaluation.progress import ProgressBar, report
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.evaluation.row import Key, Row, key
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.task import Task


class _Job(NamedTuple):
    """One policy on one chunk; `seeds` are those without a row yet."""

    policy: str
    condition: str
    repeat: int
    chunk: int
    seeds: frozenset[int]


def compare(
    task: Task,
    policies: Mapping[str, Factory],
    folder: RunFolder,
    jobs: int = 1,
    backend: str = "loky",
    scheduler: str | None = None,
) -> None:
    """Fill the folder with the rows of these policies; episodes that have a row are not run again.

    Args:
        task: The task; maps and horizon are those of the folder's configuration.
        policies: What builds each policy for a condition, by the name it gets in the rows; called in the worker.
        folder: Where the rows go.
        jobs: Number of processes.
        backend: "loky" for processes on this machine, "dask" for a cluster.
        scheduler: Address of a running dask scheduler; without one, "dask" starts a cluster on this machine.
    """
    if jobs < 1:
        raise ComparisonError(f"jobs must be 1 or more, not {jobs}")
    config = folder.config
    task = config.apply(task)
    todo = list(_jobs(task, config, list(policies), {key(row) for row in folder.rows()}))
    total = len(policies) * len(config.conditions) * config.repeats * config.episodes
    done = total - sum(len(job.seeds) for job in todo)
    if todo:
        with joblib_backend(backend, jobs, scheduler), ProgressBar(done, total) as bar:
            calls = (delayed(_run)(task, policies[job.policy], job, bar.path) for job in todo)
            results = cast("Iterator[list[Row]]", Parallel(return_as="generator_unordered")(calls))
            for rows in results:
                folder.append(rows)
                bar.received(len(rows))
    folder.sort()


def _jobs(task: Task, config: Config, policies: list[str], there: set[Key]) -> Iterator[_Job]:
    """Split what is missing into jobs, all policies of a chunk next to each other."""
    chunks = range(config.seeds[0] // task.chunk_size, config.seeds[-1] // task.chunk_size + 1)
    for condition, repeat, chunk, policy in product(config.conditions, range(config.repeats), chunks, policies):
        seeds = (episode.seed for episode in task.chunk(chunk, repeat) if episode.seed in config.seeds)
        missing = frozenset(seed for seed in seeds if (policy, condition, repeat, seed) not in there)
        if missing:
            yield _Job(policy, condition, repeat, chunk, missing)


def _run(task: Task, build: Factory, job: _Job, progress: Path) -> list[Row]:
    """Run one job in a worker, on one thread: the order of additions must not depend on the number of cores."""
    torch.set_num_threads(1)
    episodes = task.chunk(job.chunk, job.repeat)
    outcome = rollout(build(job.condition), task, job.condition, episodes, job.seeds, partial(report, progress))
    return [
        Row(
            policy=job.policy,
            condition=job.condition,
            repeat=job.repeat,
            seed=episode.seed,
            map=episode.map,
            success=bool(outcome.success[i]),
            steps=int(outcome.steps[i]) if outcome.success[i] else None,
            collision=bool(outcome.collision[i]),
            path_length=float(outcome.path_length[i]),
            shortest_path_length=task.shortest_path_length(episode) if task.shortest_path_length else None,
            distance=float(outcome.distance[i]),
            measures={name: float(values[i]) for name, values in outcome.measures.items()},
        )
        for i, episode in enumerate(episodes)
        if episode.seed in job.seeds
    ]
