import { contains, minus, nearestOn, norm, plus, times, wrap } from "../core/plane.mjs";
import { Random } from "../core/random.mjs";
import { readingsOf } from "../core/readings.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

/** A map of the project's.
 * @typedef {{ name: string, obstacles: Point[][], start: Point, target: Point }} NavigationMap */

/** Of the agent and its sensors, as in aicon_envs.nav2d: m, s and rad.
 * @typedef {{ bearing_noise: number, range_noise: number, actuation_noise: number, dt: number,
 *   radius: number, max_range: number, max_speed: number, arrival: number }} Physics */

const LEAST_GAP = 0.02; // m between the agent and a wall that is dragged to it

/** A disc among walls, which sees the direction of its target and feels how near a wall is. */
export class NavigationWorld {
  /** @param {NavigationMap} map @param {Physics} physics @param {number} seed Of all noise. */
  constructor(map, physics, seed) {
    this.map = map;
    this.physics = physics;
    this.random = new Random(seed);
    /** @type {Point} */
    this.robot = map.start;
    /** @type {Point} */
    this.target = map.target;
    /** @type {Point[]} */
    this.shifts = map.obstacles.map(() => [0, 0]);
    this.hits = 0;
  }

  get dt() {
    return this.physics.dt;
  }

  /** Corners of every wall, m. @returns {Point[][]} */
  get walls() {
    return this.map.obstacles.map((corners, i) =>
      corners.map((corner) => plus(corner, this.shifts[i])),
    );
  }

  get arrived() {
    return norm(minus(this.target, this.robot)) < this.physics.arrival;
  }

  /** What moves from step to step. */
  get moving() {
    return [...this.robot];
  }

  /** Distance to the nearest wall minus the radius, m. @param {Point} place */
  clearance(place) {
    const gaps = this.walls.map((wall) => norm(minus(nearestOn(wall, place), place)));
    return Math.min(...gaps, this.physics.max_range) - this.physics.radius;
  }

  /** @param {import("../../../examples/web/aicon_policy.mjs").Policy} policy */
  readings(policy) {
    const { bearing_noise, range_noise, max_range } = this.physics;
    const [x, y] = minus(this.target, this.robot);
    const bearing = wrap(Math.atan2(y, x) + bearing_noise * this.random.normal());
    const range = this.clearance(this.robot) + range_noise * this.random.normal();
    return readingsOf(policy, {
      z_tar: [bearing],
      z_obs: [Math.min(Math.max(range, 0), max_range)],
    });
  }

  /** One step with a velocity, m/s. A wall stops the agent.
   * @param {ArrayLike<number>} command */
  step(command) {
    const [vx, vy] = Array.from(command);
    if (vx === 0 && vy === 0) return;
    const { actuation_noise, dt, max_speed } = this.physics;
    const factor = max_speed / Math.max(Math.hypot(vx, vy), max_speed);
    const noisy = (/** @type {number} */ v) => factor * v + actuation_noise * this.random.normal();
    const next = plus(this.robot, [dt * noisy(vx), dt * noisy(vy)]);
    if (this.clearance(next) > 0) this.robot = next;
    else this.hits += 1;
  }

  /** Put the target elsewhere; nothing happens where there is a wall. @param {Point} place */
  moveTarget(place) {
    if (!this.walls.some((wall) => contains(wall, place))) this.target = place;
  }

  /** Shift a wall by so much, as far as the agent leaves room. @param {number} index @param {Point} by */
  moveWall(index, by) {
    const before = this.shifts[index];
    this.shifts[index] = plus(before, by);
    const isOn = contains(this.walls[index], this.robot) || this.clearance(this.robot) < LEAST_GAP;
    if (isOn) this.shifts[index] = before;
  }

  /** Throw the agent somewhere nearby. */
  kick() {
    for (let attempt = 0; attempt < 50; attempt += 1) {
      const next = plus(this.robot, times(0.3, [this.random.normal(), this.random.normal()]));
      const isFree = !this.walls.some((wall) => contains(wall, next));
      if (isFree && this.clearance(next) > LEAST_GAP) {
        this.robot = next;
        return;
      }
    }
  }

  /** All that changes, as numbers. @returns {number[]} */
  get numbers() {
    return [...this.robot, ...this.target, this.random.state, this.hits, ...this.shifts.flat()];
  }

  set numbers([x, y, targetX, targetY, state, hits, ...shifts]) {
    this.robot = [x, y];
    this.target = [targetX, targetY];
    this.random.state = state;
    this.hits = hits;
    this.shifts = this.shifts.map((_, i) => [shifts[2 * i], shifts[2 * i + 1]]);
  }
}
