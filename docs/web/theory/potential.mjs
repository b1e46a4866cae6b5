import { Episode } from "../core/episode.mjs";
import { contains, minus, nearestOn, norm, plus, times } from "../core/plane.mjs";
import { readingsOf } from "../core/readings.mjs";
import { Stage } from "../core/stage.mjs";
import { NavigationWorld } from "../worlds/navigation.mjs";
import { Runners, tell, whileSeen } from "./screen.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

const COLUMNS = 44;
const NEAREST_BELIEF = 0.1; // m; nearer than this the agent does not believe its target
const A_FRAME = 25; // points that are sampled in a frame
const SWEEPS = 120; // of the potential that fits

/** The potential that shifts as the target is triangulated and the projections change: the paper's first figure.
 * @param {import("./screen.mjs").Screen} screen */
export async function startPotential({ root, policies, palette, data }) {
  const policy = await policies.get("potential");
  const probe = await policies.fresh("potential");
  const stage = new Stage(root.querySelector(".stage"));
  const { start, target, obstacles } = data.map;
  const points = [...obstacles.flat(), start, target];
  const low = /** @type {Point} */ (
    [0, 1].map((axis) => Math.min(...points.map((point) => point[axis])) - 0.8)
  );
  const high = /** @type {Point} */ (
    [0, 1].map((axis) => Math.max(...points.map((point) => point[axis])) + 0.8)
  );
  stage.fit(low, high, false);

  const field = new Field(low, high);
  let world = new NavigationWorld(data.map, data.physics, 1);
  let runners = new Runners([new Episode(world, policy)]);
  const restart = () => {
    world = new NavigationWorld(data.map, data.physics, 1);
    runners = new Runners([new Episode(world, policy)]);
  };
  root.querySelector("button").addEventListener("click", restart);
  const isRunning = /** @type {HTMLInputElement} */ (root.querySelector('input[name="runs"]'));

  whileSeen(root, (passed) => {
    const [robot] = runners.after(isRunning.checked && !world.arrived ? 3 * passed : 0);
    const [x, y] = policy.values("p_tar");
    const believed = plus(robot, [x, y]);
    if (runners.episodes[0].steps > 1) field.sample(policy, probe, world, believed);

    stage.clear(palette.GROUND);
    field.draw(stage, palette);
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
    tell(root, '[data-told="spread"]', `${Math.sqrt(xx + yy).toFixed(1)} m`);
    tell(
      root,
      '[data-told="state"]',
      world.arrived
        ? "It has arrived."
        : exploring
          ? "It explores: the potential leads along the wall."
          : "It descends.",
    );
  });
}

/** What the agent would do elsewhere: its own step, from its own memory, at the points of a grid. */
class Field {
  /** @param {Point} low @param {Point} high */
  constructor(low, high) {
    this.low = low;
    this.spacing = (high[0] - low[0]) / COLUMNS;
    this.rows = Math.ceil((high[1] - low[1]) / this.spacing);
    const count = COLUMNS * this.rows;
    this.descents = Array.from({ length: count }, () => /** @type {Point} */ ([0, 0]));
    this.heights = new Float64Array(count);
    this.isFree = new Array(count).fill(true);
    this.next = 0;
    this.picture = document.createElement("canvas");
    [this.picture.width, this.picture.height] = [COLUMNS, this.rows];
  }

  /** The middle of a cell. @param {number} index @returns {Point} */
  place(index) {
    const [column, row] = [index % COLUMNS, Math.floor(index / COLUMNS)];
    return plus(this.low, times(this.spacing, [column + 0.5, row + 0.5]));
  }

  /** Sample some points more; after the last one, fit the potential anew.
   *
   * Covariances, ranks and the exploration that goes on are those of the moment. Two things depend on the
   * place: the target as seen from there, and the true clearance there, which the agent itself cannot know.
   * @param {import("./screen.mjs").Policy} policy @param {import("./screen.mjs").Policy} probe
   * @param {NavigationWorld} world @param {Point} believed */
  sample(policy, probe, world, believed) {
    const nothingRead = readingsOf(probe, {});
    const walls = world.walls;
    for (let k = 0; k < A_FRAME; k += 1, this.next += 1) {
      if (this.next === this.descents.length) return this.#fit();
      const place = this.place(this.next);
      this.isFree[this.next] = !walls.some((wall) => contains(wall, place));
      if (!this.isFree[this.next]) continue;

      const away = walls
        .map((wall) => minus(place, nearestOn(wall, place)))
        .reduce((a, b) => (norm(a) < norm(b) ? a : b));
      const toTarget = minus(believed, place);
      probe.memory.set(policy.memory);
      probe.values("p_tar").set(times(Math.max(NEAREST_BELIEF / norm(toTarget), 1), toTarget));
      probe
        .values("x_obs")
        .set([norm(away) - world.physics.radius, ...times(1 / (norm(away) || 1), away)]);
      probe.values("a").fill(0);
      probe.step(nothingRead);
      const [x, y] = probe.values("a/gradient");
      this.descents[this.next] = [-x / world.dt, -y / world.dt];
    }
  }

  /** Heights whose slopes fit the descents best: each cell in turn, from its neighbours. */
  #fit() {
    this.next = 0;
    const beside = [
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
    ];
    for (let sweep = 0; sweep < SWEEPS; sweep += 1) {
      this.heights.forEach((_, index) => {
        if (!this.isFree[index]) return;
        const [column, row] = [index % COLUMNS, Math.floor(index / COLUMNS)];
        let [sum, count] = [0, 0];
        for (const [right, up] of beside) {
          if (
            column + right < 0 ||
            column + right >= COLUMNS ||
            row + up < 0 ||
            row + up >= this.rows
          )
            continue;
          const other = index + right + COLUMNS * up;
          if (!this.isFree[other]) continue;
          const [here, there] = [this.descents[index], this.descents[other]];
          sum +=
            this.heights[other] +
            (this.spacing / 2) * (right * (here[0] + there[0]) + up * (here[1] + there[1]));
          count += 1;
        }
        if (count) this.heights[index] = sum / count;
      });
    }
    this.#paint();
  }

  #paint() {
    const free = this.heights.filter((_, index) => this.isFree[index]);
    const [least, most] = [Math.min(...free), Math.max(...free)];
    const pen = this.picture.getContext("2d");
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
  }

  /** @param {Stage} stage @param {Record<string, string>} palette */
  draw(stage, palette) {
    const [left, top] = stage.toScreen(plus(this.low, [0, this.rows * this.spacing]));
    const size = this.spacing * stage.scale;
    stage.pen.drawImage(this.picture, left, top, COLUMNS * size, this.rows * size);
    this.descents.forEach((descent, index) => {
      const isShown =
        (index % COLUMNS) % 3 === 1 && Math.floor(index / COLUMNS) % 3 === 1 && this.isFree[index];
      if (isShown) stage.arrow(this.place(index), descent, 14, palette.OUTLINE, 1.2);
    });
  }
}
