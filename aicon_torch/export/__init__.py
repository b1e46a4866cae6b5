"""Export: the same step elsewhere, in C or by TorchInductor, in this process or as a file."""

from aicon_torch.export.exported_policy import ExportedPolicy, load_exported

__all__ = ["ExportedPolicy", "load_exported"]
