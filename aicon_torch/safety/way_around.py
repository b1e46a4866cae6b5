"""The way around what holds up a proposal: exploration in the nullspace of the constraints."""

import math

import torch
from torch import Tensor

from aicon_torch.resolution import Memory
from aicon_torch.safety import SafeAction
from aicon_torch.safety.places import spread
from aicon_torch.vectors import reject, unit, wrap_angle

# Shares, and times in the dampers' time constant T: a faster robot needs no new number.
HELD = 0.1  # share of the proposal that is carried out, below which it is held up
MEMORY = 2.0  # time constant of that share
ASKING = 0.05  # share of the actuator's limit below which a proposal asks for nothing
LEAN = 0.5  # by how much it leans against the constraint on its way along it
GAIN = 1 / 3  # how much farther it must have come, as a share of the way on which it brakes
ASIDE = 0.1  # by how much the side of a sequence counts beside that of the proposal
TURNS = 2.0  # times all around in the plane of the way, after which another is tried
CONTACT = 1e-3  # share of what is tried that the constraints must take away to be felt


def initial_way(size: int) -> Memory:
    """FREE, and all was carried out: what is remembered, without batch dimensions.

    Args:
        size: Number n of components of the actuator.
    """
    return {
        "escaping": torch.tensor(False),
        "normal": torch.zeros(size),
        "tangent": torch.zeros(size),
        "angle": torch.tensor(0.0),
        "turned": torch.tensor(0.0),
        "kept": torch.tensor(1.0),
        "gained": torch.tensor(0.0),
        "escapes": torch.tensor(0),
    }


class Around:
    """Detects that a proposal w is held up, and moves along the constraints until it is not.

    FREE, the nominal action is tried, and the share of it that the constraints leave, (a·w)/‖w‖²,
    is averaged. Where next to nothing is left, it is AROUND: it explores in the nullspace of the
    constraints. They push along their force f = Σ μᵢcᵢ, whose direction n at the beginning, and the
    tangent t to it that is nearest to w, span the plane of the way. There,

        a = ‖w‖ (Jn − λn)/‖Jn − λn‖,   J = t nᵀ − n tᵀ,

    leans against the constraint and moves along it, always to the same side; where nothing pushes
    any more, n turns on until something does, around a corner. All in the same bounds.

    It is over once w is open (w·n ≥ 0), and the actuator has come farther along w than where it was
    held up, ∫ a·w/‖w‖ dt > G: of a proposal that leads to a target it is nearer to that then, so
    that it does not come back to the same place, as with the Bug algorithms (Lumelsky and Stepanov
    1987). Or where nothing is proposed any more. Or where n has turned by 4π, so that no way leads
    out in this plane: then another one is tried.

    Args:
        limits: Of the actuator, ``(n,)``.
        dt: The time step, s.
        time: The dampers' time constant, s.
    """

    def __init__(self, limits: Tensor, dt: float, time: float) -> None:
        self.speed, self.dt, self.time = float(limits.median()), dt, time
        self.rate = min(1.0, dt / (MEMORY * time))

    def aim(self, nominal: Tensor, memory: Memory) -> Tensor:
        """What it tries, ``(*B, n)``: the nominal action, or as fast as that along the constraint.

        Args:
            nominal: What is proposed, ``(*B, n)``.
            memory: What was remembered.
        """
        normal, tangent = _turned(memory)
        speed = torch.linalg.vector_norm(nominal, dim=-1, keepdim=True)
        along = speed * unit(tangent - LEAN * normal)
        return torch.where(memory["escaping"].unsqueeze(-1), along, nominal)

    def judge(self, nominal: Tensor, tried: Tensor, safe: SafeAction, memory: Memory) -> Memory:
        """Whether to go around from the next step on, and which way.

        Args:
            nominal: What is proposed, ``(*B, n)``.
            tried: What was tried.
            safe: What the constraints made of that.
            memory: What was remembered.
        """
        is_around = memory["escaping"]
        asked = torch.linalg.vector_norm(nominal, dim=-1)
        is_asking = asked > ASKING * self.speed

        # 1. What share of the proposal is carried out, and how far it has come along it.
        progress = (safe.action * unit(nominal)).sum(-1)
        share = torch.where(is_asking, progress / asked.clamp(min=ASKING * self.speed), 1.0)
        kept = torch.lerp(memory["kept"], share, self.rate)
        gained = memory["gained"] + progress * self.dt

        # 2. Where the constraint is now, in the plane of the way, and how far that has turned.
        push = torch.linalg.vector_norm(safe.force, dim=-1)
        effort = torch.linalg.vector_norm(tried, dim=-1)
        is_felt = push > CONTACT * effort
        angle = torch.where(is_around, self._angle(safe.force, is_felt, asked, memory), 0.0)
        turned = memory["turned"] + wrap_angle(angle - memory["angle"])

        # 3. From FREE to AROUND: a constraint is felt, and next to nothing was carried out.
        begins = ~is_around & is_felt & is_asking & (kept < HELD)

        # 4. Back to FREE: past what held it up, all around, or nothing is asked for any more.
        normal, _ = _turned({**memory, "angle": angle})
        is_open = (nominal * normal).sum(-1) >= 0.0
        has_passed = is_open & (gained > GAIN * self.speed * self.time)
        is_enclosed = turned.abs() > TURNS * 2.0 * math.pi
        ends = is_around & (has_passed | is_enclosed | ~is_asking)

        # 5. The plane of a new way. Where the proposal favours no side, a sequence names one.
        first_normal = unit(safe.force)
        sideways = unit(nominal) + ASIDE * spread(memory["escapes"], nominal)
        is_new = begins.unsqueeze(-1)
        return {
            "escaping": (is_around | begins) & ~ends,
            "normal": torch.where(is_new, first_normal, memory["normal"]),
            "tangent": torch.where(is_new, unit(reject(sideways, first_normal)), memory["tangent"]),
            "angle": angle,
            "turned": torch.where(is_around, turned, 0.0),
            "kept": torch.where(begins | is_around, 1.0, kept),
            "gained": torch.where(begins, 0.0, gained),
            "escapes": memory["escapes"] + begins,
        }

    def _angle(self, force: Tensor, is_felt: Tensor, asked: Tensor, memory: Memory) -> Tensor:
        """The angle ``(*B,)`` of the constraint's normal, rad; it turns on where none is felt.

        Args:
            force: That of the constraints, ``(*B, n)``.
            is_felt: Whether they push, ``(*B,)``.
            asked: ‖w‖, ``(*B,)``.
            memory: What was remembered.
        """
        along_normal = (force * memory["normal"]).sum(-1)
        along_tangent = (force * memory["tangent"]).sum(-1)
        onwards = memory["angle"] + asked / self.speed * self.dt / self.time
        return torch.where(is_felt, torch.atan2(along_tangent, along_normal), onwards)


def _turned(memory: Memory) -> tuple[Tensor, Tensor]:
    """The constraint's normal n and the tangent Jn in the plane of the way, ``(*B, n)`` both."""
    angle = memory["angle"].unsqueeze(-1)
    cosine, sine = torch.cos(angle), torch.sin(angle)
    normal, tangent = memory["normal"], memory["tangent"]
    return cosine * normal + sine * tangent, cosine * tangent - sine * normal
