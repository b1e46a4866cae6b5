"""The picture of a graph, with what comes along its edges."""

import re
from itertools import pairwise

import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")

from aicon_baselines.view import open_episode
from aicon_baselines.view.graph_picture import GraphPicture, edge_shares


def test_edges_are_as_wide_as_their_gradients_are_strong() -> None:
    trace = open_episode("nav2d", seed=1006).trace
    (meeting,) = (met for met in trace.quantities.values() if len(met.paths) > 1)
    edges: set[tuple[str, str]] = set()
    for path in meeting.paths:
        edges.update(pairwise(path))

    shares, led = edge_shares(trace, edges)
    strengths = meeting.magnitudes[0]
    for path, strength in zip(meeting.paths, strengths, strict=True):
        assert shares[path[0], path[1]] == pytest.approx(float(strength / strengths.max()))

    dominant = meeting.paths[int(meeting.dominant[0])]
    assert (dominant[0], dominant[1]) in led


def test_every_quantity_on_a_path_is_in_the_picture() -> None:
    episode = open_episode("nav2d", seed=1006)
    model = episode.policy.model
    picture = GraphPicture(model, dict.fromkeys(model.goals, (0, 0, 0))).draw(episode.trace)
    named = set(re.findall(r">([\w]+)</text>", picture))
    for path in model.paths():
        assert named.issuperset((path.goal, *path.quantities, path.actuator))
    assert picture.count("<line") == sum(len(edges) for edges in model.edges.values())


def test_a_goal_that_is_switched_off_leaves_its_edges_pale() -> None:
    episode = open_episode("nav2d", seed=1006)
    episode.weigh("avoid", 0.0)
    shares, led = edge_shares(episode.trace, {("avoid", "x_obs"), ("reach", "p_tar")})
    assert shares["avoid", "x_obs"] == 0.0
    assert led == {("reach", "p_tar")} or led == set()
