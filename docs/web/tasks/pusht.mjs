import { asItIs, drawDecision, felt } from "../core/decision.mjs";
import { norm, placed, wrap } from "../core/plane.mjs";
import { TaskPage, pageData } from "../core/task_page.mjs";
import { PushingWorld } from "../worlds/pushing.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */
/** @typedef {import("../worlds/pushing.mjs").Pose} Pose */

const { policies, palette, table } = pageData();
const LEVER = 95; // px from the origin of the T to where it is turned
const FASTEST = 800; // px/s

/** @param {Pose} pose @returns {Point[]} */
const outline = (pose) =>
  table.border.map((/** @type {number} */ i) => placed(table.keypoints[i], pose));

/** The side that a path comes through, such as 3 of "x_contact[3]". @param {string[]} path */
const sideOf = (path) => Number(/\[(\d+)\]/.exec(path.join(" "))?.[1] ?? 0);

/** @type {import("../core/task_page.mjs").Task<PushingWorld>} */
const task = {
  seed: 3,
  speed: 1,
  legend: {
    disc: palette.ROBOT,
    "T, and where it shall lie": palette.GOAL,
    "where it believes the T": palette.BELIEF,
    "touch a side (the dot)": palette.TOWARDS,
    "leave a side": palette.AWAY,
    "its motion": palette.RESOLVED,
    "its motion, exploring": palette.EXPLORING,
  },

  makeWorld: (seed) => new PushingWorld(table, seed),

  frame: () => ({ low: [0, 0], high: [table.size, table.size], isDown: true }),

  draw(stage, world, at, policy, meeting) {
    const disc = /** @type {Point} */ ([at[0], at[1]]);
    stage.clear(palette.GROUND);
    stage.box([7, 7], [504, 504], { edge: palette.OUTLINE, width: 3 });
    stage.polygon(outline(world.goal), { fill: palette.GOAL });
    stage.polygon(outline([at[2], at[3], at[4]]), { fill: palette.OBJECT, edge: palette.OUTLINE });

    const keypoints = Array.from(policy.values("x_keypoints"), (value) => value / table.pixel);
    if (world.dt && keypoints.some((value) => value !== 0)) {
      const corners = table.border.map((/** @type {number} */ i) => [
        keypoints[2 * i],
        keypoints[2 * i + 1],
      ]);
      stage.polygon(corners, { edge: palette.BELIEF, width: 2, dash: [5, 4] });
    }

    stage.disc(disc, table.radius, palette.ROBOT, palette.WHITE);
    if (world.arrived) return;
    const contacts = Array.from(policy.values("x_contact"), (value) => value / table.pixel);
    for (const { color, label } of felt(meeting.wants)) {
      const side = Number(label.match(/\d+/)) - 1;
      stage.disc([contacts[2 * side], contacts[2 * side + 1]], 4, color);
    }
    const velocity = policy.values("a");
    const share = norm(velocity) / (FASTEST * table.pixel);
    drawDecision(stage, palette, disc, meeting, asItIs, { velocity, share });
  },

  handles(world, at) {
    const object = /** @type {Pose} */ ([at[2], at[3], at[4]]);
    /** @param {string} name @param {string} label @param {Pose} pose @param {string} color
     * @param {[Point, Point]} grips Where it is held to be moved and to be turned, in its frame.
     * @param {(pose: Pose) => void} set */
    const both = (name, label, pose, color, [hold, turn], set) => [
      {
        name,
        label,
        color,
        place: placed(hold, pose),
        step: 8,
        move: (/** @type {Point} */ [x, y]) => {
          const [left, top] = placed(hold, pose);
          set([pose[0] + x - left, pose[1] + y - top, pose[2]]);
        },
      },
      {
        name: `turn ${name}`,
        label: `Turn the ${label}`,
        color,
        place: placed(turn, pose),
        step: 8,
        move: (/** @type {Point} */ [x, y]) =>
          set([
            pose[0],
            pose[1],
            Math.atan2(y - pose[1], x - pose[0]) - Math.atan2(turn[1], turn[0]),
          ]),
      },
    ];
    const held = /** @type {[Point, Point]} */ ([[-42, 15], [42, 15]]);
    const ends = /** @type {[Point, Point]} */ ([[0, 30], [0, LEVER]]);
    return [
      ...both("goal", "goal", world.goal, "#2e7d1e", held, (pose) => world.moveGoal(pose)),
      ...both("object", "T", object, palette.OUTLINE, ends, (pose) => world.moveObject(pose)),
    ];
  },

  look(path, gradient, policy) {
    const side = sideOf(path);
    const [contacts, pusher] = [policy.values("x_contact"), policy.values("x_pusher")];
    const touches =
      [0, 1].reduce((sum, i) => sum - gradient[i] * (contacts[2 * side + i] - pusher[i]), 0) > 0;
    return touches
      ? { label: `touch side ${side + 1}`, color: palette.TOWARDS }
      : { label: `leave side ${side + 1}`, color: palette.AWAY };
  },

  told: (world) =>
    world.arrived
      ? "The T lies in its goal. Drag either elsewhere."
      : `${Math.round(10 * world.coverage) * 10} % of the goal covered, ${Math.round((Math.abs(wrap(world.pose[2] - world.goal[2])) * 18) / Math.PI) * 10}° off.`,
};

void new TaskPage(task, policies).start();
