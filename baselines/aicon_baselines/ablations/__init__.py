"""Ablations: our policies without one part each, or with one part as somebody else would have it.

Each module has ``ABLATIONS``: options of :func:`aicon_torch.make_policy` by name of the ablation, on
top of the preset ``"aicon"``.
"""
