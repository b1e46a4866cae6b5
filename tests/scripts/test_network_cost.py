"""A network in pushT's graph computes the same in C."""

import pytest

pytest.importorskip("pymunk")

from aicon_baselines.cli.bench import observations_of_one
from aicon_torch.export.codegen import has_compiler
from network_cost import largest_difference, with_network, with_picture


@pytest.mark.slow
@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_a_network_of_thirty_thousand_weights_takes_the_same_steps_in_c() -> None:
    observations = observations_of_one("pusht", "deterministic", 20)
    policy = with_network()
    assert 0 < largest_difference(policy, policy.compile(), observations) <= 1e-9


@pytest.mark.slow
@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_a_network_that_reads_pictures_in_the_graph_takes_the_same_steps_in_c() -> None:
    seen = observations_of_one("pusht", "pixels_48", 20)
    observations = [{**each, "pixels": each["pixels"].reshape(-1)} for each in seen]
    policy = with_picture()
    assert 0 < largest_difference(policy, policy.compile(), observations) <= 1e-9
