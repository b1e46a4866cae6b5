"""Tells Gymnasium the names of the environments; none of them is imported before it is made."""

from gymnasium.envs.registration import register

register(
    id="aicon/Nav2D-v0",
    entry_point="aicon_envs.nav2d.environment:Nav2DEnv",
    vector_entry_point="aicon_envs.nav2d.vector:Nav2DVectorEnv",
    max_episode_steps=12_000,
)

register(
    id="aicon/PushT-v0",
    entry_point="aicon_envs.pusht.environment:PushTEnv",
    max_episode_steps=300,
)

for name in ("ArmPush", "PandaPush"):  # the second is the name that it had before
    register(
        id=f"aicon/{name}-v0",
        entry_point="aicon_envs.arm_push.environment:ArmPushEnv",
        max_episode_steps=18_000,
    )

register(
    id="aicon/Reach-v0",
    entry_point="aicon_envs.reach.environment:ReachEnv",
    max_episode_steps=1_000,
)
