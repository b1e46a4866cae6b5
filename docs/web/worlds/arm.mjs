import { minus, norm, plus, times } from "../core/plane.mjs";
import { Random } from "../core/random.mjs";
import { readingsOf } from "../core/readings.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

/** Lengths of the links, their radius and that of the ball, m; s, rad/s and rad.
 * @typedef {{ links: number[], thickness: number, ball: number, dt: number, speed: number, stop: number }} Sizes */

const NEAR = 0.02; // m, from where on the tip is at its target

/** An arm of three joints in a plane, a target and a ball. The joints do as they are told. */
export class ArmWorld {
  /** @param {Sizes} sizes @param {number} seed */
  constructor(sizes, seed) {
    this.sizes = sizes;
    this.random = new Random(seed);
    this.touches = 0;
    /** @type {number[]} */
    this.joints = [];
    /** @type {Point} */
    this.target = [0, 0];
    /** @type {Point} */
    this.ball = [0, 0];
    this.draw();
  }

  /** Posture, target and ball of a seed: the ball lies about on the way, but not at either end, and so far out
   * that the first link can pass it; else there may be no way. */
  draw() {
    const between = (/** @type {number} */ low, /** @type {number} */ high) =>
      low + (high - low) * this.random.uniform();
    for (;;) {
      this.joints = [between(-1.5, 1.5), between(-1.5, 1.5), between(-1.5, 1.5)];
      const [distance, angle] = [between(0.45, 0.9), between(-2, 2)];
      this.target = [distance * Math.cos(angle), distance * Math.sin(angle)];
      const tip = this.chain[3];
      const way = minus(this.target, tip);
      this.ball = plus(
        plus(tip, times(between(0.4, 0.6), way)),
        times(between(-0.2, 0.2), [-way[1], way[0]]),
      );
      const isClear =
        this.gap > 0.1 &&
        norm(this.ball) > this.sizes.links[0] + this.sizes.ball + this.sizes.thickness + 0.05 &&
        norm(minus(this.ball, this.target)) > this.sizes.ball + 0.12;
      if (isClear && norm(minus(this.target, tip)) > 0.4) return;
    }
  }

  get dt() {
    return this.sizes.dt;
  }

  /** The base, the two joints after it and the tip. @returns {Point[]} */
  get chain() {
    return chainAt(this.sizes.links, this.joints);
  }

  /** Between the ball and the nearest link, m. */
  get gap() {
    const points = this.chain;
    const gaps = points.slice(1).map((end, i) => distanceTo(points[i], end, this.ball));
    return Math.min(...gaps) - this.sizes.ball - this.sizes.thickness;
  }

  get arrived() {
    return norm(minus(this.target, this.chain[3])) < NEAR;
  }

  get moving() {
    return [...this.joints];
  }

  /** @param {import("../../../examples/web/aicon_policy.mjs").Policy} policy */
  readings(policy) {
    return readingsOf(policy, {
      z_joints: this.joints,
      z_target: [...this.target, 0],
      z_ball: [...this.ball, 0],
    });
  }

  /** One step with velocities of the joints, rad/s. @param {ArrayLike<number>} command */
  step(command) {
    const { dt, stop } = this.sizes;
    this.joints = this.joints.map((q, i) => Math.min(Math.max(q + dt * command[i], -stop), stop));
    if (this.gap < 0) this.touches += 1;
  }

  /** Push every joint a little. */
  kick() {
    this.step([0, 1, 2].map(() => (0.3 / this.dt) * this.random.normal()));
  }

  /** All that changes, as numbers. @returns {number[]} */
  get numbers() {
    return [...this.joints, ...this.target, ...this.ball, this.random.state, this.touches];
  }

  set numbers([q1, q2, q3, targetX, targetY, ballX, ballY, state, touches]) {
    this.joints = [q1, q2, q3];
    this.target = [targetX, targetY];
    this.ball = [ballX, ballY];
    this.random.state = state;
    this.touches = touches;
  }
}

/** Base, joints and tip at some angles. @param {number[]} links @param {number[]} joints @returns {Point[]} */
export function chainAt(links, joints) {
  let angle = 0;
  /** @type {Point[]} */
  const points = [[0, 0]];
  links.forEach((length, i) => {
    angle += joints[i];
    points.push(plus(points[i], [length * Math.cos(angle), length * Math.sin(angle)]));
  });
  return points;
}

/** How the tip moves with joint velocities: J q̇. @param {Point[]} points @param {ArrayLike<number>} speeds
 * @returns {Point} */
export function tipVelocity(points, speeds) {
  const tip = points[3];
  return Array.from(speeds).reduce((sum, speed, i) => {
    const [x, y] = minus(tip, points[i]);
    return plus(sum, times(speed, [-y, x]));
  }, /** @type {Point} */ ([0, 0]));
}

/** From a segment to a place, m. @param {Point} start @param {Point} end @param {Point} place */
function distanceTo(start, end, place) {
  const [along, offset] = [minus(end, start), minus(place, start)];
  const share = (along[0] * offset[0] + along[1] * offset[1]) / (along[0] ** 2 + along[1] ** 2);
  return norm(minus(offset, times(Math.min(Math.max(share, 0), 1), along)));
}
