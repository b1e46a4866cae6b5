"""A look ahead: whether the next place of a sequence is open, before an actuator goes there."""

from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.resolution import Memory

END, HALFWAY, LEADER = range(3)


def initial_look() -> Memory:
    """The first place is the next: what is remembered, without batch dimensions."""
    return {"ahead": torch.tensor(0), "look": torch.tensor(END)}


class LookAhead(NamedTuple):
    """Looks at the next place of the sequence, and passes over it where a gap would be closed.

    One place is looked at in each step, so they take turns with looks at the place that leads of
    those that are known:

    =======  ==========================  ===================================
    turn     what is looked at           next turn
    =======  ==========================  ===================================
    END      the next place              HALFWAY; LEADER if a gap is closed
    HALFWAY  half the way to it          LEADER
    LEADER   the known place that leads  END
    =======  ==========================  ===================================

    Attributes:
        number: Of the next place, ``(*B,)``.
        way: The way to it, ``(*B, n)``.
        turn: What has its turn, ``(*B,)``.
    """

    number: Tensor
    way: Tensor
    turn: Tensor

    @property
    def has_turn(self) -> Tensor:
        """Whether the next place or half the way to it has its turn, ``(*B,)``."""
        return self.turn != LEADER

    @property
    def looked_at(self) -> Tensor:
        """The way to what is looked at if it has its turn, ``(*B, n)``."""
        share = torch.where(self.turn == END, 1.0, 0.5)
        return share.unsqueeze(-1).to(self.way) * self.way

    def after(self, has_looked: Tensor, is_clear: Tensor) -> "LookAhead":
        """What is known after a look at a place, whose turn comes again if another was looked at.

        Args:
            has_looked: Whether what had its turn was looked at, ``(*B,)``.
            is_clear: Whether no gap is closed at what was looked at, ``(*B,)``.
        """
        is_closed = has_looked & self.has_turn & ~is_clear
        following = torch.where(is_closed, LEADER, (self.turn + 1) % 3)
        return self._replace(
            number=self.number + is_closed,
            turn=torch.where(has_looked, following, self.turn),
        )

    def remembered(self, goes: Tensor) -> Memory:
        """What is remembered of it.

        Args:
            goes: Whether the actuator sets out to the next place, ``(*B,)``.
        """
        return {"ahead": self.number + goes, "look": self.turn}
