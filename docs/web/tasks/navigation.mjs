import { asItIs, drawDecision } from "../core/decision.mjs";
import { boundsOf, minus, norm, plus, times } from "../core/plane.mjs";
import { TaskPage, pageData } from "../core/task_page.mjs";
import { NavigationWorld } from "../worlds/navigation.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

const { policies, palette, maps, physics } = pageData();
const MARGIN = 0.9; // m of ground around what there is

/** @type {Record<string, { label: string, color: string }>} By what a path comes through. */
const LOOKS = {
  p_tar: { label: "reach the target", color: palette.TOWARDS },
  P_tar: { label: "know it better", color: palette.CERTAINTY },
  x_obs: { label: "avoid the wall", color: palette.AWAY },
};

/** @type {import("../core/task_page.mjs").Task<NavigationWorld>} */
const task = {
  seed: 1,
  speed: 4,
  legend: {
    robot: palette.ROBOT,
    target: palette.TARGET,
    "where it believes the target (2σ)": palette.BELIEF,
    "its motion": palette.RESOLVED,
    "its motion, exploring": palette.EXPLORING,
  },

  makeWorld: (seed) => new NavigationWorld(maps[seed % maps.length], physics, seed),

  frame: ({ map }) => ({
    ...boundsOf([...map.obstacles.flat(), map.start, map.target], MARGIN),
    isDown: false,
  }),

  draw(stage, world, at, policy, meeting) {
    const robot = /** @type {Point} */ ([at[0], at[1]]);
    stage.clear(palette.GROUND);
    for (const wall of world.walls) stage.polygon(wall, { fill: palette.OBSTACLE });
    stage.disc(world.target, physics.arrival, palette.TARGET);
    stage.text("target", world.target, palette.TARGET, [0, -24]);

    // It believes the target relative to itself.
    const [x, y] = policy.values("p_tar");
    const believed = plus(robot, [x, y]);
    stage.spread(believed, policy.values("P_tar"), palette.BELIEF);
    stage.disc(believed, 0.06, palette.BELIEF);

    // The wall as it feels it: so far, against the slope of its distance.
    const [distance, ...slope] = policy.values("x_obs");
    const felt = plus(
      robot,
      times(-(Math.max(distance, 0) + physics.radius) / (norm(slope) || 1), [slope[0], slope[1]]),
    );
    if (distance < 3) stage.line([robot, felt], palette.AWAY, 1.5, [4, 4]);

    stage.disc(robot, physics.radius, palette.ROBOT, palette.WHITE);
    if (world.arrived) return;
    const velocity = policy.values("a");
    const share = norm(velocity) / physics.max_speed;
    drawDecision(stage, palette, robot, meeting, asItIs, { velocity, share });
  },

  handles: (world) => [
    {
      name: "target",
      label: "Target",
      color: palette.TARGET,
      place: world.target,
      move: (to) => world.moveTarget(to),
    },
    ...world.map.obstacles.map((corners, i) => {
      const place = plus(middle(corners), world.shifts[i]);
      return {
        name: `wall ${i + 1}`,
        label: `Wall ${i + 1}`,
        color: palette.PALE,
        place,
        move: (/** @type {Point} */ to) => world.moveWall(i, minus(to, place)),
      };
    }),
  ],

  look: (path) => LOOKS[path[1]] ?? { label: path.join(" → "), color: palette.PALE },

  told: (world) =>
    world.arrived
      ? "It has arrived. Drag the target elsewhere."
      : `${Math.round(norm(minus(world.target, world.robot)))} m to the target.` +
        (world.hits ? ` Stopped by a wall ${world.hits} times.` : ""),
};

/** A place on a wall by which it is held: the middle of its longest side.
 * @param {Point[]} corners @returns {Point} */
function middle(corners) {
  const sides = corners.map(
    (corner, i) => /** @type {[Point, Point]} */ ([corner, corners[(i + 1) % corners.length]]),
  );
  const length = (/** @type {[Point, Point]} */ [a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);
  const [a, b] = sides.reduce((best, side) => (length(side) > length(best) ? side : best));
  return times(0.5, plus(a, b));
}

void new TaskPage(task, policies).start();
