"""Ablations: our policies without one part each, or with a part as somebody else would have it.

Each module has ``ABLATIONS``: for each name the options of :func:`aicon_torch.make_policy` that
make it, on top of the preset ``"aicon"``; its task names them.
"""
