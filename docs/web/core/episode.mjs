import { carryOver } from "./policies.mjs";

/** @typedef {import("../../../examples/web/aicon_policy.mjs").Policy} Policy */

/** What steps, and is sensed.
 * @typedef {{ dt: number, moving: number[], arrived: boolean, readings(policy: Policy): number[],
 *   step(command: ArrayLike<number>): void }} World */

/** A policy in a world.
 * @template {World} W */
export class Episode {
  /** @param {W} world @param {Policy} policy */
  constructor(world, policy) {
    this.world = world;
    this.policy = policy;
    this.steps = 0;
    this.before = world.moving;
    /** @type {number[]} */
    this.read = [];
    policy.reset();
  }

  /** Sense, decide, move; once it has arrived, rest. */
  step() {
    this.before = this.world.moving;
    if (this.world.arrived) return;
    this.read = this.world.readings(this.policy);
    const command = this.policy.step(this.read);
    this.world.step(command);
    this.steps += 1;
  }

  /** What moves, a share of a step after the last but one. @param {number} share */
  at(share) {
    const after = this.world.moving;
    return after.map((value, i) => this.before[i] + share * (value - this.before[i]));
  }

  /** Go on with another policy. @param {Policy} policy */
  change(policy) {
    if (policy === this.policy) return;
    if (this.read.length > 0) carryOver(this.policy, policy, this.read);
    this.policy = policy;
  }
}
