"""Readings: from what a robot observes to what its estimators are given."""

from aicon_torch.readings.background import BackgroundPerception
from aicon_torch.readings.perception import Perception, SlowPerception

__all__ = ["BackgroundPerception", "Perception", "SlowPerception"]
