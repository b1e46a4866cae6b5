"""What the descriptions of robots say, read in float64."""

from aicon_torch.parts.descriptions.link_tree import JointDescription, LinkTree
from aicon_torch.parts.descriptions.mjcf import read_mjcf
from aicon_torch.parts.descriptions.urdf import origin_of, parse_xml, read_urdf

__all__ = ["JointDescription", "LinkTree", "origin_of", "parse_xml", "read_mjcf", "read_urdf"]
