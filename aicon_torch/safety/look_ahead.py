"""A look ahead: whether the next place of a sequence is open, before an actuator goes there."""

from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.resolution import Memory

END, HALFWAY = range(2)


def initial_look() -> Memory:
    """The first place is the next: what is remembered, without batch dimensions."""
    return {"ahead": torch.tensor(0), "look": torch.tensor(END)}


class LookAhead(NamedTuple):
    """Looks at the next place of the sequence, and passes over it where a gap would be closed.

    One place is looked at in each step:

    =======  ==================  =========  =================================
    turn     what is looked at   next turn  next turn if a gap is closed
    =======  ==================  =========  =================================
    END      the next place      HALFWAY    END, of the place that follows it
    HALFWAY  half the way to it  END        END, of the place that follows it
    =======  ==================  =========  =================================

    Attributes:
        number: Of the next place, ``(*B,)``.
        way: The way to it, ``(*B, n)``.
        turn: What has its turn, ``(*B,)``.
    """

    number: Tensor
    way: Tensor
    turn: Tensor

    @property
    def looked_at(self) -> Tensor:
        """The way to what is looked at, ``(*B, n)``."""
        share = torch.where(self.turn == END, 1.0, 0.5)
        return share.unsqueeze(-1).to(self.way) * self.way

    def after(self, is_clear: Tensor) -> "LookAhead":
        """What is known after the look.

        Args:
            is_clear: Whether no gap is closed at what was looked at, ``(*B,)``.
        """
        following = torch.where(is_clear, (self.turn + 1) % 2, END)
        return self._replace(number=self.number + ~is_clear, turn=following)

    def remembered(self, goes: Tensor) -> Memory:
        """What is remembered of it.

        Args:
            goes: Whether the actuator sets out to the next place, ``(*B,)``.
        """
        return {"ahead": self.number + goes, "look": self.turn}
