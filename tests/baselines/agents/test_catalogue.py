"""The names that `aicon list` prints are those of the policies that there are."""

import pytest

from aicon_baselines import agents, tasks
from aicon_baselines.agents.catalogue import CATALOGUE
from aicon_torch import presets


@pytest.mark.parametrize("task", tasks.names())
def test_the_catalogue_names_the_policies_of_a_task(task: str) -> None:
    names = CATALOGUE[task]
    assert names.presets == presets(task)
    assert names.ablations == tuple(agents.ablations(task))
    assert names.opponents == agents.opponents(task)


def test_the_catalogue_has_every_task_and_no_other() -> None:
    assert tuple(CATALOGUE) == tasks.names()
