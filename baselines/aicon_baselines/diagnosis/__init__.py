"""Why an episode failed: what is seen in its trace, in words and in one picture."""

from aicon_baselines.diagnosis.diagnose import Diagnosis, diagnose
from aicon_baselines.diagnosis.finding import Finding
from aicon_baselines.diagnosis.history import History
from aicon_baselines.evaluation.recording import Recording

__all__ = ["Diagnosis", "Finding", "History", "Recording", "diagnose"]
