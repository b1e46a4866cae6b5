"""Baselines beside AICON, and what compares them: the same episodes for every policy.

`aicon_baselines.evaluation` runs and sums up, `aicon_baselines.tasks` says what is to be done,
`aicon_baselines.agents` builds the policies, and the command `aicon` (`aicon_baselines.cli`) puts
them together.
"""
