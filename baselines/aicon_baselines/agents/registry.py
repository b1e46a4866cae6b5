"""The policies that can be compared, by task and name.

A task's policies are the presets of its model (ours, the paper's text and the baselines), the
ablations of the task (ours without one part) and its opponents (what others would do); pushT has
planners, too, which need an extra; agents that were trained come from their folder.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import partial
from importlib import import_module
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, ClassVar

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import Factory, Predictor
from aicon_baselines.evaluation.task import Task
from aicon_baselines.extras import require
from aicon_baselines.named import Later, find, made
from aicon_baselines.tasks.registry import lesson_of, load

PLANNERS = ("mppi", "mppi_small")
"""The planners of pushT, presets of `aicon_baselines.agents.mppi`."""

AGGREGATIONS: Mapping[str, str] = MappingProxyType(
    {
        "pcgrad": "aicon_baselines.resolutions:PCGrad",
        "upgrad": "aicon_baselines.resolutions:UPGrad",
        "cagrad": "aicon_baselines.resolutions:CAGrad",
    }
)
"""Rules for gradients in conflict: in every task, in place of ours and with all else as it is."""


TaskOrName = str | Task
"""A task, or the name that loads it."""


def ablations(task: TaskOrName) -> Mapping[str, Mapping[str, Any]]:
    """Return the ablations of a task: the options that each changes in the preset "aicon"."""
    return {name: made(options) for name, options in _loaded(task).ablations.items()}


def opponents(task: TaskOrName) -> tuple[str, ...]:
    """List the opponents of a task: rules for gradients in conflict, then agents of its own."""
    content = _loaded(task)
    rules = tuple(AGGREGATIONS) if content.model else ()
    return (*rules, *content.agents)


def names(task: TaskOrName) -> tuple[str, ...]:
    """List the policies of a task: the presets of its model, its ablations, then its opponents.

    An unknown task is an error that lists the tasks.
    """
    content = _loaded(task)
    return (*content.presets, *content.ablations, *opponents(content))


def factory(task: TaskOrName, name: str, **options: Any) -> Factory:
    """Return what builds a policy, without building it.

    Args:
        task: The task, or its name; an unknown one is an error that lists the tasks.
        name: Name of the policy; an unknown one is an error that lists the policies of the task.
            Planners of pushT are named as well.
        **options: Options of the policy, by name or dotted path (`**{"law.step": 0.5}`); they
            override those of its name and of the condition.
    """
    content = _loaded(task)
    if name in PLANNERS and content.name == "pusht":
        import_mppi()
        return partial(_build_planner, name, options)
    if name not in names(content):
        valid = ", ".join(names(content))
        raise ComparisonError(
            f"unknown policy {name!r} for task {content.name!r}; valid policies: {valid}"
        )

    # An ablation changes options of ours; a preset is named as it is.
    if name in content.ablations:
        return ModelPolicy(task, "aicon", {**made(content.ablations[name]), **options})
    if name in content.presets:
        return ModelPolicy(task, name, options)

    # A rule for gradients in conflict takes the place of ours, and all else stays. It and an agent
    # are made once here, so that what is not installed is an error before anything runs.
    if name in AGGREGATIONS:
        return ModelPolicy(task, "aicon", {"resolution": find(AGGREGATIONS[name])(), **options})
    named = content.agents[name]
    later = named if isinstance(named, Later) else Later(named)
    agent = PlainAgent(find(later.source), task, {**later.arguments, **options})
    agent.make()
    return agent


def model_of(task: Task) -> str | ModuleType:
    """Return the name of a task's model in the library, or the module of one of its own."""
    from aicon_torch.models.factory import MODELS

    if not task.model:
        raise ComparisonError(
            f"task {task.name!r} has presets and no model: `model=__name__` where its graph is in "
            f"the same file, or one of {', '.join(MODELS)}"
        )
    return task.model if task.model in MODELS else import_module(task.model)


def own_policy(source: str) -> Factory:
    """Return what builds a policy of the user's own.

    It is imported once here, so that what is missing is an error before anything runs.

    Args:
        source: "module:function", the function being a :data:`Factory`: it takes the name of the
            condition and returns a policy with `predict`. The module may lie in this folder.
    """
    _find_own(source)
    return partial(_build_own, source)


@dataclass(frozen=True)
class CompiledPolicy:
    """Builds a policy of the library whose step is compiled, which happens at its first one."""

    build: Any
    is_compiled: ClassVar[bool] = True

    def __call__(self, condition: str) -> Predictor:
        """Build it for a condition."""
        policy: Predictor = self.build(condition).compile()
        return policy


def compiled(build: Factory) -> Factory:
    """Return what builds the same policy of the library with its step compiled.

    Raises:
        ComparisonError: If it is no policy of the library.
    """
    if isinstance(build, PlainAgent):
        name = build.agent.__name__
        raise ComparisonError(f"{name} is no policy of the library and has no step to compile")
    return CompiledPolicy(build)


def can_be_compiled(build: Factory) -> bool:
    """Whether it builds a policy of the library whose step can be compiled.

    A rule of others for gradients in conflict decides robot by robot, which cannot.
    """
    from aicon_baselines.resolutions import Aggregation

    if not isinstance(build, ModelPolicy):
        return False
    return not isinstance(build.options.get("resolution"), Aggregation)


def make(task: TaskOrName, name: str, condition: str | None = None) -> Predictor:
    """Build a policy, for example `make("nav2d", "aicon")`.

    Args:
        task: The task, or its name; an unknown one is an error that lists the tasks.
        name: Name of the policy; an unknown one is an error that lists the policies of the task.
        condition: The task's condition that the policy is for; by default the usual one.
    """
    build = factory(task, name)
    return build(condition or _loaded(task).conditions[0])


def _loaded(task: TaskOrName) -> Task:
    return load(task) if isinstance(task, str) else task


def _find_own(source: str) -> Factory:
    expected = "expected MODULE:FUNCTION, a function of the condition that returns a policy"
    try:
        build: Factory = find(source)
    except (ComparisonError, ImportError) as error:
        raise ComparisonError(f"policy {error}; {expected}") from error

    if not callable(build):
        raise ComparisonError(f"policy {source!r} is a {type(build).__name__}; {expected}")
    return build


def _build_own(source: str, condition: str) -> Predictor:
    return _find_own(source)(condition)


def _build_planner(preset: str, changes: Mapping[str, Any], condition: str) -> Predictor:
    """Build a planner of pushT, with what the task tells a policy about the condition."""
    from aicon_torch.models import pusht, replace_options

    mppi: Any = import_mppi()
    options = replace_options(mppi.PRESETS[preset], changes, "MPPI")
    planner: Predictor = mppi.Agent(
        options, pusht.Options(**load("pusht").policy_options(condition))
    )
    return planner


@dataclass(frozen=True)
class ModelPolicy:
    """Builds a policy of one of the library's models for a condition of its task."""

    task: TaskOrName
    preset: str
    options: Mapping[str, Any] = field(default_factory=dict)
    is_compiled: ClassVar[bool] = False

    def __call__(self, condition: str) -> Predictor:
        """Build it, with what the task tells a policy about the condition."""
        from aicon_torch import make_policy

        task = _loaded(self.task)
        known = task.policy_options(condition)
        return make_policy(model_of(task), preset=self.preset, **{**known, **self.options})


@dataclass(frozen=True)
class PlainAgent:
    """Builds an agent that has nothing of the library.

    What the task tells a policy about the condition, it is told as far as it has such options.
    """

    agent: Any
    task: TaskOrName
    options: Mapping[str, Any] = field(default_factory=dict)

    def make(self, **known: Any) -> Predictor:
        """Build it; an unknown option is an error that lists the valid ones."""
        from aicon_torch.models import replace_options

        options = {**known, **self.options}
        agent: Predictor = replace_options(self.agent(), options, self.agent.__name__)
        return agent

    def __call__(self, condition: str) -> Predictor:
        """Build it for a condition."""
        own = {option.name for option in fields(self.agent)}
        known = _loaded(self.task).policy_options(condition)
        return self.make(**{name: value for name, value in known.items() if name in own})


def saved_agent(
    task: str, folder: Path, sampled: bool = False, trust: bool = False
) -> tuple[str, Factory]:
    """Return the name that a saved agent of stable-baselines3 gets in the rows, and what builds it.

    It is loaded once here, so that what does not fit is an error before anything runs.

    Args:
        task: Name of the task.
        folder: Folder of the agent.
        sampled: Whether it draws its actions, as in training, instead of taking the most likely
            ones.
        trust: Whether code that its files may hold is allowed to run.
    """
    build = partial(_load_agent, folder.resolve(), task, sampled, trust)
    return build().name, build


def diffusion_policy(
    task: str, source: str, sampler: str | None = None, inference_steps: int | None = None
) -> tuple[str, Factory]:
    """Return the name that a saved diffusion policy gets in the rows, and what builds it.

    It is loaded once here, so that what does not fit is an error before anything runs.

    Args:
        task: Name of the task; one with a lesson.
        source: Folder of the policy, or OWNER/REPOSITORY@COMMIT of the Hugging Face hub.
        sampler: "DDPM" or "DDIM"; by default the policy's.
        inference_steps: Number of denoising steps; by default the policy's.
    """
    lesson_of(task)
    from aicon_baselines.agents.diffusion.hub import locate

    build = partial(_load_diffusion, locate(source), sampler, inference_steps, task)
    return build().name, build


def _load_agent(
    folder: Path, task: str, sampled: bool, trust: bool, condition: str | None = None
) -> Any:
    """Load an agent, the same one for every condition."""
    return import_sb3().Agent(folder, task, sampled, trust)


def _load_diffusion(
    folder: Path,
    sampler: str | None,
    inference_steps: int | None,
    task: str,
    condition: str | None = None,
) -> Any:
    """Load a diffusion policy, the same one for every condition."""
    from aicon_baselines.agents.diffusion.agent import Agent

    return Agent(folder, sampler, inference_steps, task=task)


def import_mppi() -> ModuleType:
    """Import `aicon_baselines.agents.mppi`; an error says what to install for it."""
    require("planning by MPPI", "peers", "pytorch_mppi")
    return import_module("aicon_baselines.agents.mppi")


def import_sb3() -> ModuleType:
    """Import `aicon_baselines.agents.sb3`; an error says what to install for it."""
    require("an agent of stable-baselines3", "sb3", "stable_baselines3")
    return import_module("aicon_baselines.agents.sb3")
