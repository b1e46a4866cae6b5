import { Box, Circle, Polygon, Vec2, World } from "planck";
import { contains, placed } from "../core/plane.mjs";
import { Random } from "../core/random.mjs";
import { readingsOf } from "../core/readings.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */
/** @typedef {[number, number, number]} Pose x, y and angle, px and rad. */

/** The benchmark's sizes, px, the pusher's controller, and the T.
 * @typedef {{ size: number, radius: number, stiffness: number, damping: number, sub_step: number,
 *   sub_steps: number, goal: Pose, keypoints: Point[], border: number[], parts: Point[][] }} Table */

const METRE = 100; // px of a metre of the engine, which wants things of about that size
const WALLS = [7, 504]; // px, their inner faces
const ENOUGH = 0.95; // share of the goal that is to be covered
const SHIFT = 30; // px, of a kick
const TURN = 0.5; // rad

const BRAKING = 100; // m/s² of the engine: friction with the table, 1 g where the table is half a metre wide
const ROUGH = 0.2; // friction of the sides, the engine's own; the benchmark has none
const HEAVY = 20; // density of the disc; that of the T is 1

/** A driven disc and a T on a table, in the physics engine planck. */
export class PushingWorld {
  /** @param {Table} table @param {number} seed
   * @param {{ pusher: Point, pose: Pose }} [start] By default drawn as in the benchmark. */
  constructor(table, seed, start) {
    this.table = table;
    this.random = new Random(seed);
    const { pusher, pose } = start ?? this.#draw();
    /** @type {Pose} */
    this.goal = table.goal;
    this.#build();
    this.#place(pusher, [0, 0], pose);
    this.start = { pusher, pose };
  }

  get dt() {
    return this.table.sub_step * this.table.sub_steps;
  }

  /** @returns {Point} */
  get pusher() {
    const { x, y } = this.disc.getPosition();
    return [x * METRE, y * METRE];
  }

  /** @returns {Pose} */
  get pose() {
    const { x, y } = this.tee.getPosition();
    return [x * METRE, y * METRE, this.tee.getAngle()];
  }

  /** Corners of the T, in the order of the observation. @returns {Point[]} */
  get corners() {
    return this.table.keypoints.map((corner) => placed(corner, this.pose));
  }

  /** Share of the goal that the T covers. */
  get coverage() {
    const at = (/** @type {Pose} */ pose) =>
      this.table.parts.map((part) => part.map((corner) => placed(corner, pose)));
    const goal = at(this.goal);
    const covered = at(this.pose).flatMap((part) =>
      goal.map((other) => area(clipped(part, other))),
    );
    const whole = this.table.parts.map(area);
    return sum(covered) / sum(whole);
  }

  get arrived() {
    return this.coverage > ENOUGH;
  }

  get moving() {
    return [...this.pusher, ...this.pose];
  }

  /** @param {import("../../../examples/web/aicon_policy.mjs").Policy} policy */
  readings(policy) {
    return readingsOf(policy, {
      z_pusher: this.pusher,
      z_keypoints: this.corners.flat(),
      z_target: this.goal,
    });
  }

  /** One step, in which a controller drives the disc to a place, px: v ← v + (k_p (place − p) − k_v v) dt.
   * @param {ArrayLike<number>} command */
  step(command) {
    const { size, stiffness, damping, sub_step, sub_steps } = this.table;
    const [x, y] = Array.from(command, (value) => Math.min(Math.max(value, 0), size) / METRE);
    for (let k = 0; k < sub_steps; k += 1) {
      const [place, velocity] = [this.disc.getPosition(), this.disc.getLinearVelocity()];
      this.disc.setLinearVelocity(
        new Vec2(
          velocity.x + (stiffness * (x - place.x) - damping * velocity.x) * sub_step,
          velocity.y + (stiffness * (y - place.y) - damping * velocity.y) * sub_step,
        ),
      );
      this.#rub(sub_step);
      this.engine.step(sub_step, 8, 4);
    }
  }

  /** @param {Pose} goal */
  moveGoal(goal) {
    this.goal = this.#within(goal);
  }

  /** @param {Pose} pose */
  moveObject(pose) {
    this.#place(this.pusher, this.velocity, this.#within(pose));
  }

  /** Shift and turn the T, but not onto the disc. */
  kick() {
    const [x, y, angle] = this.pose;
    for (let attempt = 0; attempt < 50; attempt += 1) {
      const [right, down, turn] = [0, 1, 2].map(() => 2 * this.random.uniform() - 1);
      const pose = this.#within([x + SHIFT * right, y + SHIFT * down, angle + TURN * turn]);
      const isOn = this.table.parts.some((part) =>
        contains(
          part.map((corner) => placed(corner, pose)),
          this.pusher,
        ),
      );
      if (!isOn) return this.#place(this.pusher, this.velocity, pose);
    }
  }

  /** Velocity of the disc, px/s. @returns {Point} */
  get velocity() {
    const { x, y } = this.disc.getLinearVelocity();
    return [x * METRE, y * METRE];
  }

  /** All that changes, as numbers. @returns {number[]} */
  get numbers() {
    const { x, y } = this.tee.getLinearVelocity();
    return [
      ...this.pusher,
      ...this.velocity,
      ...this.pose,
      x,
      y,
      this.tee.getAngularVelocity(),
      ...this.goal,
      this.random.state,
    ];
  }

  set numbers([px, py, vx, vy, x, y, angle, slideX, slideY, turn, goalX, goalY, goalAngle, state]) {
    this.#place([px, py], [vx, vy], [x, y, angle]);
    this.tee.setLinearVelocity(new Vec2(slideX, slideY));
    this.tee.setAngularVelocity(turn);
    this.goal = [goalX, goalY, goalAngle];
    this.random.state = state;
  }

  /** Dry friction with the table, which a turn feels at the radius of gyration. (The linear part of planck
   * 1.5's FrictionJoint does nothing: it subtracts an impulse from itself.) @param {number} time s */
  #rub(time) {
    const { x, y } = this.tee.getLinearVelocity();
    const turn = this.tee.getAngularVelocity();
    const speed = Math.hypot(x, y, this.gyration * turn);
    const left = Math.max(1 - (BRAKING * time) / (speed || 1), 0);
    this.tee.setLinearVelocity(new Vec2(left * x, left * y));
    this.tee.setAngularVelocity(left * turn);
  }

  #build() {
    const { radius, parts } = this.table;
    const scaled = (/** @type {Point} */ [x, y]) => new Vec2(x / METRE, y / METRE);
    this.engine = new World({ gravity: new Vec2(0, 0), allowSleep: false });

    // Walls as thick as the table, since the disc may press the T hard against them.
    const ground = this.engine.createBody();
    const [middle, half] = [(WALLS[0] + WALLS[1]) / 2, (WALLS[1] - WALLS[0]) / 2];
    for (const [x, y] of /** @type {Point[]} */ ([
      [-1, 0],
      [1, 0],
      [0, -1],
      [0, 1],
    ])) {
      const place = scaled([middle + 4 * half * x, middle + 4 * half * y]);
      const shape = new Box((3 * half) / METRE, (3 * half) / METRE, place);
      ground.createFixture({ shape, friction: 0, filterGroupIndex: -1 });
    }
    // The disc is driven by its velocity, and passes over the walls, as in the benchmark.
    this.disc = this.engine.createBody({ type: "dynamic", fixedRotation: true });
    const round = { shape: new Circle(radius / METRE), friction: ROUGH, filterGroupIndex: -1 };
    this.disc.createFixture({ ...round, density: HEAVY });
    this.tee = this.engine.createBody({ type: "dynamic", bullet: true });
    for (const part of parts) {
      this.tee.createFixture({ shape: new Polygon(part.map(scaled)), density: 1, friction: ROUGH });
    }
    const center = this.tee.getLocalCenter();
    this.gyration = Math.sqrt(
      this.tee.getInertia() / this.tee.getMass() - Vec2.dot(center, center),
    );
  }

  /** @param {Point} pusher @param {Point} velocity @param {Pose} pose */
  #place([px, py], [vx, vy], [x, y, angle]) {
    this.disc.setTransform(new Vec2(px / METRE, py / METRE), 0);
    this.disc.setLinearVelocity(new Vec2(vx / METRE, vy / METRE));
    this.tee.setTransform(new Vec2(x / METRE, y / METRE), angle);
    this.tee.setLinearVelocity(Vec2.zero());
    this.tee.setAngularVelocity(0);
  }

  /** A start as gym-pusht draws it. @returns {{ pusher: Point, pose: Pose }} */
  #draw() {
    const between = (/** @type {number} */ low, /** @type {number} */ high) =>
      low + Math.floor((high - low) * this.random.uniform());
    return {
      pusher: [between(50, 450), between(50, 450)],
      pose: [between(100, 400), between(100, 400), Math.PI * (2 * this.random.uniform() - 1)],
    };
  }

  /** A pose shifted until the T lies between the walls. @param {Pose} pose @returns {Pose} */
  #within([x, y, angle]) {
    const [low, high] = WALLS;
    const corners = this.table.keypoints.map((corner) => placed(corner, [x, y, angle]));
    const shift = (/** @type {number} */ axis) => {
      const along = corners.map((corner) => corner[axis]);
      return Math.max(low - Math.min(...along), 0) + Math.min(high - Math.max(...along), 0);
    };
    return [x + shift(0), y + shift(1), angle];
  }
}

/** @param {number[]} values */
const sum = (values) => values.reduce((total, value) => total + value, 0);

/** Area of a polygon with positive orientation. @param {Point[]} corners */
function area(corners) {
  return sum(
    corners.map(([x, y], i) => {
      const [nextX, nextY] = corners[(i + 1) % corners.length];
      return (x * nextY - nextX * y) / 2;
    }),
  );
}

/** The part of a convex polygon that lies in another one: cut along each of its sides in turn.
 * @param {Point[]} corners @param {Point[]} other @returns {Point[]} */
function clipped(corners, other) {
  return other.reduce((left, start, i) => {
    const end = other[(i + 1) % other.length];
    const inside = (/** @type {Point} */ [x, y]) =>
      (end[0] - start[0]) * (y - start[1]) - (end[1] - start[1]) * (x - start[0]);
    return left.flatMap((corner, j) => {
      const next = left[(j + 1) % left.length];
      const [here, there] = [inside(corner), inside(next)];
      const kept = here >= 0 ? [corner] : [];
      if (here >= 0 === there >= 0) return kept;
      const share = here / (here - there);
      return [
        ...kept,
        [corner[0] + share * (next[0] - corner[0]), corner[1] + share * (next[1] - corner[1])],
      ];
    });
  }, corners);
}
