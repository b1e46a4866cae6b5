"""The order in which estimators run: each after those that it reads."""

from collections.abc import Sequence

from aicon_torch.errors import GraphError
from aicon_torch.estimation import Estimator


def in_order(estimators: Sequence[Estimator]) -> list[Estimator]:
    """Each estimator after those it reads; in a cycle, after all but those it was reached from.

    Raises:
        GraphError: If estimators without memory define each other in a circle, where no value is
            there to begin with.
    """
    owners = {name: estimator for estimator in estimators for name in estimator.outputs}
    ordered: list[Estimator] = []

    def visit(estimator: Estimator, trail: tuple[Estimator, ...]) -> None:
        # It waits for itself: a cycle, in which somebody has to remember a value of the last step.
        if estimator in trail:
            _check_circle((*trail[trail.index(estimator) :], estimator))
            return
        if estimator in ordered:
            return

        # Depth first: all that it reads comes before it.
        for name in estimator.inputs:
            owner = owners.get(name, estimator)
            if owner is not estimator:
                visit(owner, (*trail, estimator))
        if estimator not in ordered:  # a cycle may have put it there meanwhile
            ordered.append(estimator)

    for estimator in estimators:
        visit(estimator, ())
    return ordered


def _check_circle(circle: tuple[Estimator, ...]) -> None:
    """A circle needs a member that remembers its last value."""
    if not any(member.recursive for member in circle):
        cycle = " → ".join(member.outputs[0] for member in circle)
        raise GraphError(
            f"Functions define each other in a circle: {cycle}. Make one an EKF or a KalmanFilter."
        )
