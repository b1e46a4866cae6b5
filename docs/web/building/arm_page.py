"""What the page about an arm holds."""

from typing import Any

from building import arm
from building.packing import pack
from building.variants import variants


def data() -> dict[str, Any]:
    """Its policies, and the sizes of the arm."""
    policies = {name: pack(policy) for name, policy in variants(arm)}
    return {"policies": policies, "arm": arm.sizes()}
