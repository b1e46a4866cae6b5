import { Episode } from "../core/episode.mjs";
import { boundsOf, contains, minus, nearestOn, norm, plus, times } from "../core/plane.mjs";
import { readingsOf } from "../core/readings.mjs";
import { Stage } from "../core/stage.mjs";
import { NavigationWorld } from "../worlds/navigation.mjs";
import { Runners, tell, whileSeen } from "./screen.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

const COLUMNS = 44;
const NEAREST_BELIEF = 0.1; // m; nearer than this the agent does not believe its target
const WORKING = 1.0; // ms of a frame for the potential
const SWEEPS = 120; // of the potential that fits

/** The potential that shifts as the target is triangulated and the projections change: the paper's first figure.
 * @param {import("./screen.mjs").Screen} screen */
export async function startPotential({ root, policies, palette, data }) {
  const policy = await policies.get("potential");
  const probe = await policies.fresh("potential");
  const stage = new Stage(root.querySelector(".stage"));
  const { start, target, obstacles } = data.map;
  const { low, high } = boundsOf([...obstacles.flat(), start, target], 0.8);
  stage.fit(low, high, false);

  /** @type {NavigationWorld} */
  let world;
  /** @type {Runners<NavigationWorld>} */
  let runners;
  const restart = () => {
    world = new NavigationWorld(data.map, data.physics, 1);
    runners = new Runners([new Episode(world, policy)]);
  };
  restart();
  root.querySelector("button").addEventListener("click", restart);
  const isRunning = /** @type {HTMLInputElement} */ (root.querySelector('input[name="runs"]'));

  // What the agent would do elsewhere: its own step, from its own memory. Covariances, ranks and the exploration
  // that goes on are those of the moment. Two things depend on the place: the target as seen from there, and the
  // true clearance there, which the agent itself cannot know.
  const nothingRead = readingsOf(probe, {});
  let believed = start;
  /** @param {Point} place @returns {Point | null} */
  const descentAt = (place) => {
    const { walls, physics } = world;
    if (walls.some((wall) => contains(wall, place))) return null;
    const away = walls
      .map((wall) => minus(place, nearestOn(wall, place)))
      .reduce((a, b) => (norm(a) < norm(b) ? a : b));
    const toTarget = minus(believed, place);
    const [gap, slope] = [norm(away) - physics.radius, times(1 / (norm(away) || 1), away)];
    probe.memory.set(policy.memory);
    probe.values("p_tar").set(times(Math.max(NEAREST_BELIEF / norm(toTarget), 1), toTarget));
    probe.values("x_obs").set([gap, ...slope]);
    probe.values("a").fill(0);
    probe.step(nothingRead);
    const [x, y] = probe.values("a/gradient");
    return [-x / world.dt, -y / world.dt];
  };
  const field = new Field(low, high, descentAt, stage, palette);

  whileSeen(stage, (passed) => {
    const [robot] = runners.after(isRunning.checked && !world.arrived ? 3 * passed : 0);
    const [x, y] = policy.values("p_tar");
    believed = plus(robot, [x, y]);
    if (runners.episodes[0].steps > 1) field.workFor(WORKING);
    if (!stage.differs([robot, believed, world.target, field.count])) return;

    stage.clear(palette.GROUND);
    if (field.picture) stage.show(field.picture);
    for (const wall of world.walls) stage.polygon(wall, { fill: palette.OBSTACLE });
    stage.disc(world.target, 0.1, palette.TARGET);
    stage.spread(believed, policy.values("P_tar"), palette.BELIEF);
    stage.disc(believed, 0.05, palette.BELIEF);
    stage.disc(robot, data.physics.radius, palette.ROBOT, palette.WHITE);
    stage.hold([
      {
        name: "hidden target",
        label: "Target",
        color: palette.TARGET,
        place: world.target,
        move: (to) => world.moveTarget(to),
      },
    ]);

    const { exploring } = policy.decided("x_rob");
    const [xx, , , yy] = policy.values("P_tar");
    tell(root, "spread", `${Math.sqrt(xx + yy).toFixed(1)} m`);
    tell(
      root,
      "state",
      world.arrived
        ? "It has arrived."
        : exploring
          ? "It explores: the potential leads along the wall."
          : "It descends.",
    );
  });
}

/** The potential that fits descents at the points of a grid, worked out bit by bit, again and again. */
class Field {
  /** @param {Point} low @param {Point} high @param {(place: Point) => Point | null} descentAt Null within a wall.
   * @param {Stage} stage @param {Record<string, string>} palette */
  constructor(low, high, descentAt, stage, palette) {
    this.low = low;
    this.spacing = (high[0] - low[0]) / COLUMNS;
    this.rows = Math.ceil((high[1] - low[1]) / this.spacing);
    this.places = Array.from({ length: COLUMNS * this.rows }, (_, index) =>
      plus(low, times(this.spacing, [(index % COLUMNS) + 0.5, Math.floor(index / COLUMNS) + 0.5])),
    );
    this.heights = new Float64Array(this.places.length);
    /** @type {(Point | null)[]} */
    this.descents = [];
    /** @type {HTMLCanvasElement | null} */
    this.picture = null;
    this.count = 0; // of pictures
    this.work = this.#forever(descentAt, stage, palette);
  }

  /** Go on for so long, ms. @param {number} time */
  workFor(time) {
    const end = performance.now() + time;
    do this.work.next();
    while (performance.now() < end);
  }

  /** Sample every point, fit, paint, and begin anew.
   * @param {(place: Point) => Point | null} descentAt @param {Stage} stage @param {Record<string, string>} palette
   * @returns {Generator<void, never, void>} */
  *#forever(descentAt, stage, palette) {
    for (;;) {
      for (const [index, place] of this.places.entries()) {
        this.descents[index] = descentAt(place);
        yield;
      }
      const cells = this.#cells();
      for (let sweep = 0; sweep < SWEEPS; sweep += 1) {
        for (const { index, others, rise } of cells) {
          let sum = 0;
          for (const other of others) sum += this.heights[other];
          this.heights[index] = sum / others.length + rise;
        }
        yield;
      }
      const shades = this.#shades();
      yield;
      this.picture = stage.picture(() => this.#draw(shades, stage, palette));
      this.count += 1;
      yield;
    }
  }

  /** The free cells with the free ones beside them, and how much higher they lie than these on average. */
  #cells() {
    const { descents, spacing } = this;
    return descents.flatMap((here, index) => {
      if (!here) return [];
      const column = index % COLUMNS;
      const beside = [column + 1 < COLUMNS && [1, 0], column > 0 && [-1, 0], [0, 1], [0, -1]]
        .filter((way) => way && descents[index + way[0] + COLUMNS * way[1]])
        .map((way) => /** @type {number[]} */ (way));
      const others = beside.map(([right, up]) => index + right + COLUMNS * up);
      const rises = beside.map(([right, up], k) => {
        const there = descents[others[k]];
        return (spacing / 2) * (right * (here[0] + there[0]) + up * (here[1] + there[1]));
      });
      const rise = rises.reduce((a, b) => a + b, 0) / rises.length;
      return others.length ? [{ index, others, rise }] : [];
    });
  }

  /** The heights as a small picture, a dot a cell, in thirteen shades. */
  #shades() {
    const free = this.heights.filter((_, index) => this.descents[index]);
    const [least, most] = [Math.min(...free), Math.max(...free)];
    const shades = document.createElement("canvas");
    [shades.width, shades.height] = [COLUMNS, this.rows];
    const pen = shades.getContext("2d");
    const image = pen.createImageData(COLUMNS, this.rows);
    this.heights.forEach((height, index) => {
      const share = Math.round((12 * (height - least)) / (most - least || 1)) / 12;
      const [column, row] = [index % COLUMNS, this.rows - 1 - Math.floor(index / COLUMNS)];
      image.data.set(
        [235 - 70 * share, 243 - 95 * share, 250 - 50 * share, 255],
        4 * (column + COLUMNS * row),
      );
    });
    pen.putImageData(image, 0, 0);
    return shades;
  }

  /** @param {HTMLCanvasElement} shades @param {Stage} stage @param {Record<string, string>} palette */
  #draw(shades, stage, palette) {
    const [left, top] = stage.toScreen(plus(this.low, [0, this.rows * this.spacing]));
    const size = this.spacing * stage.scale;
    stage.pen.drawImage(shades, left, top, COLUMNS * size, this.rows * size);
    this.descents.forEach((descent, index) => {
      const isShown = (index % COLUMNS) % 3 === 1 && Math.floor(index / COLUMNS) % 3 === 1;
      if (isShown && descent) stage.arrow(this.places[index], descent, 14, palette.OUTLINE, 1.2);
    });
  }
}
