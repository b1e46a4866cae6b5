import { cosine, norm } from "./plane.mjs";

/** A gradient that meets others, and what it wants.
 * @typedef {{ label: string, color: string, gradient: number[], strength: number, rank: number,
 *   toLeader: number }} Want */

/** What met in the last step: every gradient that is not zero, the leader, and what opposes it.
 * @typedef {{ wants: Want[], leader: Want | null, against: Want | null, exploring: boolean }} Meeting */

const OPPOSED = -0.6; // θ_enter: below it, two gradients are in conflict

/** @param {import("../../../examples/web/aicon_policy.mjs").Policy} policy
 * @param {string[][]} paths Of the gradients, row by row.
 * @param {(path: string[], gradient: number[]) => { label: string, color: string }} look
 * @returns {Meeting} */
export function meetingOf(policy, paths, look) {
  const { gradients, ranks, exploring } = policy.decided(policy.meetings[0]);
  const wants = gradients
    .map((gradient, row) => ({
      ...look(paths[row], gradient),
      gradient,
      strength: norm(gradient),
      rank: ranks[row],
      toLeader: 0,
    }))
    .filter(({ strength }) => strength > 1e-9);

  // Where nothing is ranked, the strongest is what the others are compared with.
  wants.sort((a, b) => b.strength - a.strength);
  const leader = wants.find(({ rank }) => rank === 0) ?? wants[0] ?? null;
  for (const want of wants)
    want.toLeader = want === leader ? 1 : cosine(leader.gradient, want.gradient);
  const against = wants.find(
    ({ toLeader, strength }) => toLeader < OPPOSED && 3 * strength > leader.strength,
  );
  return { wants, leader, against: against ?? null, exploring };
}
