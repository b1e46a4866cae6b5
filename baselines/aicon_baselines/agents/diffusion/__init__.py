"""Diffusion policies of LeRobot: trained on demonstrations by AICON, loaded, and compared on pushT.

`demonstrations` runs episodes, `collection` records them as a dataset, `dataset` reads one, `training` trains on it.
`checkpoint` loads what was saved here or elsewhere, `hub` finds it, and `agent` puts it into a comparison. All but the
first need LeRobot, which is imported on demand.
"""
