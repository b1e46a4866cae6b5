import { drawDecision } from "../core/decision.mjs";
import { minus, norm } from "../core/plane.mjs";
import { TaskPage, pageData } from "../core/task_page.mjs";
import { ArmWorld, chainAt, tipVelocity } from "../worlds/arm.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

const { policies, palette, arm } = pageData();
const REACH = 1.12; // m, of what is shown

/** @type {Record<string, { label: string, color: string }>} By goal. */
const LOOKS = {
  reach: { label: "reach the target", color: palette.TOWARDS },
  "keep off": { label: "keep off the ball", color: palette.AWAY },
  stops: { label: "keep off the stops", color: palette.CERTAINTY },
};

/** @type {import("../core/task_page.mjs").Task<ArmWorld>} */
const task = {
  seed: 11,
  speed: 1,
  legend: {
    arm: palette.ROBOT,
    target: palette.TARGET,
    ball: palette.OBSTACLE,
    "its motion": palette.RESOLVED,
    "its motion, exploring": palette.EXPLORING,
  },

  makeWorld: (seed) => new ArmWorld(arm, seed),

  frame: () => ({ low: [-REACH, -REACH], high: [REACH, REACH], isDown: false }),

  draw(stage, world, at, policy, meeting) {
    const points = chainAt(arm.links, at);
    const tip = points[3];
    stage.clear(palette.GROUND);
    stage.disc(world.ball, arm.ball, palette.OBSTACLE);
    stage.disc(world.target, 0.035, palette.TARGET);
    stage.line(points, palette.BODY, 2 * arm.thickness * stage.scale);
    stage.line(points, palette.ROBOT, 3);
    for (const point of points.slice(0, 3)) stage.disc(point, 0.03, palette.ROBOT, palette.WHITE);
    stage.disc(tip, 0.018, palette.ROBOT, palette.WHITE);
    stage.text("target", world.target, palette.TARGET, [0, -26]);

    if (world.arrived) return;
    // A gradient of the joints has no direction in the plane: drawn is where it takes the tip.
    const ofTip = (/** @type {ArrayLike<number>} */ velocity) => tipVelocity(points, velocity);
    const velocity = policy.values("a");
    const share = norm(ofTip(velocity)) / arm.speed;
    drawDecision(stage, palette, tip, meeting, ofTip, { velocity, share });
  },

  handles: (world) => [
    {
      name: "target",
      label: "Target",
      color: palette.TARGET,
      place: world.target,
      move: (to) => void (world.target = within(to)),
    },
    {
      name: "ball",
      label: "Ball",
      color: palette.PALE,
      place: world.ball,
      move: (to) => void (world.ball = within(to)),
    },
  ],

  look: ([goal]) => LOOKS[goal] ?? { label: goal, color: palette.PALE },

  told: (world) =>
    (world.arrived
      ? "The tip is at its target. Drag it elsewhere."
      : `${Math.round(10 * norm(minus(world.target, world.chain[3]))) * 10} cm to the target.`) +
    (world.gap < 0 ? " A link is in the ball." : ""),
};

/** A place within what is shown. @param {Point} place @returns {Point} */
function within([x, y]) {
  return [Math.min(Math.max(x, -REACH), REACH), Math.min(Math.max(y, -REACH), REACH)];
}

void new TaskPage(task, policies).start();
