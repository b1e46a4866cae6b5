"""Running a comparison: every policy on every episode, in parallel, resuming an earlier run."""

from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.evaluation.backends import joblib_backend
from aicon_baselines.evaluation.config import Config
from aicon_baselines.evaluation.errors import ComparisonError, check_counts
from aicon_baselines.evaluation.predictor import Factory
from aicon_baselines.evaluation.progress import progress_bar
from aicon_baselines.evaluation.rollout import Outcome, rollout
from aicon_baselines.evaluation.row import Key, Row, key
from aicon_baselines.evaluation.run_folder import RunFolder, keep
from aicon_baselines.evaluation.sources import note_sources, note_versions
from aicon_baselines.evaluation.task import Episode, Task
from aicon_baselines.extras import naming_extra

with naming_extra():
    from joblib import Parallel, delayed
    from joblib.externals.loky.process_executor import TerminatedWorkerError


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
        policies: What builds each policy for a condition, by the name it gets in the rows; called
            in the worker.
        folder: Where the rows go; this process is its writer.
        jobs: Number of processes.
        backend: "loky" for processes on this machine, "dask" for a cluster.
        scheduler: Address of a running dask scheduler; without one, "dask" starts a cluster on
            this machine.

    Raises:
        ComparisonError: If it cannot run in this way, the folder has rows that lack a measure of
            the task, or a worker was killed.
    """
    check_counts(jobs=jobs)
    config = folder.config
    task = config.apply(task)

    # What is missing, and how many rows are there already.
    known = folder.rows()
    for measure in task.measures:
        if any(measure.key not in row.measures for row in known):
            raise ComparisonError(
                f"{folder.path} holds rows of another version, without {measure.key!r}: choose "
                "another folder"
            )
    finished = {key(row) for row in known}
    note_sources(folder.path, task, policies, has_rows=bool(finished))
    missing = list(_list_jobs(task, config, list(policies), finished))
    total = len(policies) * len(config.conditions) * config.repeats * config.episodes
    done = total - sum(len(job.seeds) for job in missing)

    # Rows are saved as they arrive, in any order, and sorted at the end.
    if missing:
        running = {job.policy: policies[job.policy] for job in missing}
        note_versions(folder.path, running, {row.policy for row in known})
        bar = progress_bar(done, total, folder.count_ended)
        with joblib_backend(backend, jobs, scheduler), bar:
            for rows in _run_all(task, policies, missing, folder):
                folder.append(rows)
    folder.finish()


def _run_all(
    task: Task, policies: Mapping[str, Factory], jobs: list[_Job], folder: RunFolder
) -> Iterator[list[Row]]:
    """Run the jobs in workers and yield the rows of each, in the order in which they end."""
    calls = (delayed(_run)(task, policies[job.policy], job, folder.begin_chunk()) for job in jobs)
    results = Parallel(return_as="generator_unordered")(calls)
    try:
        yield from cast("Iterator[list[Row]]", results)
    except TerminatedWorkerError as error:
        raise ComparisonError(
            "a worker process was killed, perhaps because the memory was full: with fewer --jobs, "
            "the same command goes on from here"
        ) from error


def _list_jobs(
    task: Task, config: Config, policies: list[str], finished: set[Key]
) -> Iterator[_Job]:
    """Split what is missing into jobs, all policies of a chunk next to each other."""
    first, last = (seed // task.chunk_size for seed in (config.seeds[0], config.seeds[-1]))
    chunks, repeats = range(first, last + 1), range(config.repeats)

    for condition, repeat, chunk, policy in product(config.conditions, repeats, chunks, policies):
        seeds = {episode.seed for episode in task.chunk(chunk, repeat)} & set(config.seeds)
        missing = frozenset(
            seed for seed in seeds if (policy, condition, repeat, seed) not in finished
        )
        if missing:
            yield _Job(policy, condition, repeat, chunk, missing)


def _run(task: Task, build: Factory, job: _Job, unfinished: Path) -> list[Row]:
    """Run one job in a worker and return the rows of its seeds; each is kept as it ends."""
    # One thread: the order of additions must not depend on the number of cores.
    torch.set_num_threads(1)

    policy = build(job.condition)
    episodes = task.chunk(job.chunk, job.repeat)
    rows: list[Row] = []

    def on_ended(outcome: Outcome, indices: NDArray[np.intp]) -> None:
        ended = [_to_row(task, job, episodes[index], outcome, index) for index in indices]
        keep(unfinished, ended)
        rows.extend(ended)

    rollout(policy, task, job.condition, episodes, job.seeds, on_ended)
    return rows


def _to_row(task: Task, job: _Job, episode: Episode, outcome: Outcome, index: int) -> Row:
    """Return the row of the episode that was number `index` of the batch."""
    success = bool(outcome.success[index])
    shortest = task.shortest_path_length
    measures = {name: float(values[index]) for name, values in outcome.measures.items()}

    return Row(
        policy=job.policy,
        condition=job.condition,
        repeat=job.repeat,
        seed=episode.seed,
        map=episode.map,
        success=success,
        steps=int(outcome.steps[index]) if success else None,
        collision=bool(outcome.collision[index]),
        path_length=float(outcome.path_length[index]),
        shortest_path_length=shortest(episode) if shortest else None,
        distance=float(outcome.distance[index]),
        measures=measures,
    )
