"""Gradients that keep their order from one meeting to the next: no later one undoes what an earlier one achieves."""

from typing import Any

import pytest
import torch
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Exploration,
    Deterministic,
    Goal,
    Interconnection,
    NullspaceProjection,
    OptionError,
    Policy,
    Sensor,
    WorldModel,
)

SEEDS = range(60)
ACTIONS, SIZE = 4, 3


class Arm:
    """Three linear goals on q = M a and one on a, whose directions and strengths are random."""

    def __init__(self, seed: int) -> None:
        generator = torch.Generator().manual_seed(seed)
        self.matrix = torch.randn(SIZE, ACTIONS, generator=generator, dtype=torch.float64)
        self.matrix *= torch.logspace(1, -1, SIZE, dtype=torch.float64).unsqueeze(-1)  # such as mixed units
        self.slopes = torch.randn(3, SIZE, generator=generator, dtype=torch.float64)
        self.slopes *= torch.rand(3, 1, generator=generator, dtype=torch.float64) * 3
        self.direct = 0.3 * torch.randn(ACTIONS, generator=generator, dtype=torch.float64)

    def policy(self, **options: Any) -> Policy:
        goals = [
            Goal(f"g{i}", Interconnection(lambda q, s=slope: (q * s).sum(-1), ["q"]))
            for i, slope in enumerate(self.slopes)
        ]
        model = WorldModel(
            sensors={"z": Sensor(1, "m")},
            actuators={"a": Actuator(ACTIONS, "m", limit=1e9)},
            estimators=[Deterministic("q", Interconnection(lambda a: a @ self.matrix.mT, ["a"]))],
            goals=[*goals, Goal("direct", Interconnection(lambda a: (a * self.direct).sum(-1), ["a"]))],
            dtype=torch.float64,
        )
        return Policy(model, NullspaceProjection(relative=True, **options), ActionLaw(gain=1.0))

    def raised(self, merge: str) -> bool:
        """Whether the first action raises the cost of the goal that led at q; not asked where the direct one leads."""
        policy = self.policy(merge=merge, exploration=None)
        action, memory = policy.predict({"z": torch.zeros(1)})
        leader = self.slopes[int(memory["q/rank"][0])]
        change = float(leader @ (self.matrix @ action))
        (first,) = (c for c in policy.explain(memory).meetings["a"].candidates if c.rank == 0)
        return change > 1e-9 and not first.trace.startswith("direct")


def test_the_leader_is_never_undone() -> None:
    """With the sum, what is orthogonal at q is not so in the joints; how often that hurts is the coupling's matter."""
    assert not any(Arm(seed).raised("order") for seed in SEEDS)
    assert any(Arm(seed).raised("sum") for seed in SEEDS)


def test_ranked_gradients_arrive_one_by_one() -> None:
    policy = Arm(0).policy(merge="order")
    arrivals = [str(arrival) for arrival in policy.backward_pass.arrivals["a"]]
    assert sorted(arrivals) == ["direct", *(f"g0+g1+g2 → q (rank {rank})" for rank in range(3))]


def test_ranks_keep_their_order_whatever_their_strengths() -> None:
    """What left q last is the strongest in the joints here, and still comes after the others from there."""
    rule = NullspaceProjection(exploration=None)
    gradients = torch.tensor([[0.1, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 5.0], [2.0, 0.0, 0.0]])
    before = torch.tensor([[False] * 4, [True] + [False] * 3, [True, True, False, False], [False] * 4])
    strengths, held = gradients.norm(dim=-1), torch.full((3,), -1)
    assert rule.resolve(gradients, strengths, held)[1].tolist() == [2, 3, 1]
    # The fourth takes what the first would have had; then the way is free for the second, and the third comes last.
    assert rule.resolve(gradients, strengths, held, before)[1].tolist() == [3, 1, 2]


def test_what_was_resolved_together_is_no_conflict() -> None:
    """Two gradients that left q orthogonal and oppose each other in the joints are not explored between."""

    def squeeze(a: Tensor) -> Tensor:
        return torch.stack((a[..., 0] + 0.05 * a[..., 1], -a[..., 0] + 0.05 * a[..., 1]), dim=-1)

    goals = [Goal("left", Interconnection(lambda q: q[..., 0], ["q"]))]
    goals.append(Goal("right", Interconnection(lambda q: 0.9 * q[..., 1], ["q"])))
    goals.append(Goal("rest", Interconnection(lambda a: 1e-3 * a[..., 1], ["a"])))
    model = WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m", limit=1.0)},
        estimators=[Deterministic("q", Interconnection(squeeze, ["a"]))],
        goals=goals,
    )
    rule = NullspaceProjection(relative=True, merge="order", exploration=Exploration(partner="opposing"))
    _, memory = Policy(model, rule, ActionLaw(gain=1.0)).predict({"z": torch.zeros(1)})
    assert not memory["q/exploring"]
    assert not memory["a/exploring"]
    gradients = memory["a/gradients"][1:]  # after that of "rest"
    assert torch.nn.functional.cosine_similarity(gradients[0], gradients[1], dim=0) < -0.9


def test_an_exploring_quantity_sends_its_direction_alone() -> None:
    goals = [Goal("up", Interconnection(lambda q: q[..., 0], ["q"]))]
    goals.append(Goal("down", Interconnection(lambda q: -0.9 * q[..., 0], ["q"])))
    goals.append(Goal("rest", Interconnection(lambda a: 1e-3 * a[..., 1], ["a"])))
    model = WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m", limit=1.0)},
        estimators=[Deterministic("q", Interconnection(lambda a: 1.0 * a, ["a"]))],
        goals=goals,
    )
    policies = [Policy(model, NullspaceProjection(merge=merge), ActionLaw(gain=1.0)) for merge in ("sum", "order")]  # type: ignore[arg-type]
    (one, memory), (other, ranked) = (policy.predict({"z": torch.zeros(1)}) for policy in policies)
    assert memory["q/exploring"] and ranked["q/exploring"]
    torch.testing.assert_close(other / other.norm(), one / one.norm())
    assert (ranked["a/gradients"].norm(dim=-1) > 0).sum() == 2


def test_without_a_later_meeting_the_sum_goes_on() -> None:
    """Where gradients meet once, nothing is inherited, and nothing changes."""
    model = WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(3, "m", limit=1.0)},
        estimators=[Deterministic("q", Interconnection(torch.sin, ["a"]))],
        goals=[Goal(f"g{i}", Interconnection(lambda q, i=i: q[..., i] + q[..., 2], ["q"])) for i in range(2)],
    )
    policies = [Policy(model, NullspaceProjection(merge=merge), ActionLaw(gain=1.0)) for merge in ("sum", "order")]  # type: ignore[arg-type]
    (one, memory), (other, ranked) = (policy.predict({"z": torch.zeros(1)}) for policy in policies)
    assert memory.keys() == ranked.keys()
    torch.testing.assert_close(other, one, rtol=0.0, atol=0.0)


def test_a_wrong_word_is_refused() -> None:
    with pytest.raises(OptionError, match="merge='rank': expected 'sum' or 'order'"):
        NullspaceProjection(merge="rank")  # type: ignore[arg-type]
