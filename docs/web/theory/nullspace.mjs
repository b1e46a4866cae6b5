import { cosine, minus, norm, times } from "../core/plane.mjs";
import { readingsOf } from "../core/readings.mjs";
import { Stage } from "../core/stage.mjs";
import { tell, write } from "./screen.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

/** Two gradients that one turns by hand, and what comes of them.
 * @param {import("./screen.mjs").Screen} screen */
export async function startNullspace({ root, policies, palette }) {
  const stage = new Stage(root.querySelector(".stage"));
  stage.fit([-2.4, -1.8], [2.4, 1.8], false);
  const names = ["two sum", "two projection", "two explore"];
  const [sum, projection, explore] = await Promise.all(names.map((name) => policies.get(name)));

  // What each goal wants: minus its gradient.
  let wants = /** @type {[Point, Point]} */ ([
    [1.6, 0.3],
    [-0.7, 1.0],
  ]);
  const result = (/** @type {import("./screen.mjs").Policy} */ policy) => {
    policy.reset();
    const [x, y] = policy.step(
      readingsOf(policy, { z_first: times(-1, wants[0]), z_second: times(-1, wants[1]) }),
    );
    return /** @type {Point} */ ([x, y]);
  };

  function draw() {
    const added = result(sum);
    const projected = result(projection);
    const explored = result(explore);
    const { ranks } = projection.decided("x");
    const { exploring } = explore.decided("x");
    const leader = ranks[0] === 0 ? 0 : 1;
    const along = wants[leader];
    const across = times(3 / (norm(along) || 1), [-along[1], along[0]]);

    const origin = /** @type {Point} */ ([0, 0]);
    const length = (/** @type {Point} */ vector) => norm(vector) * stage.scale;
    stage.clear(palette.GROUND);
    stage.line([across, times(-1, across)], palette.EXPLORING, 1.5, [6, 6]);
    stage.text("nullspace of the leader", times(-0.5, across), palette.EXPLORING);
    stage.line([wants[1 - leader], minus(projected, along)], palette.PALE, 1.5, [3, 4]);
    stage.arrow(origin, added, length(added), palette.CERTAINTY, 9);
    stage.arrow(origin, wants[0], length(wants[0]), palette.TOWARDS, 5);
    stage.arrow(origin, wants[1], length(wants[1]), palette.AWAY, 5);
    stage.arrow(origin, projected, length(projected), palette.RESOLVED, 4);
    if (exploring) stage.arrow(origin, explored, length(explored), palette.EXPLORING, 4);
    stage.text("sum", added, palette.CERTAINTY, [0, 18]);
    stage.text("projection", projected, palette.RESOLVED, [0, -18]);
    stage.text("first", wants[0], palette.TOWARDS, [0, -26]);
    stage.text("second", wants[1], palette.AWAY, [0, -26]);
    stage.hold(
      wants.map((place, i) => ({
        name: `want ${i + 1}`,
        label: `What the ${["first", "second"][i]} goal wants`,
        color: [palette.TOWARDS, palette.AWAY][i],
        place,
        step: 0.1,
        move: (/** @type {Point} */ to) => {
          wants = /** @type {[Point, Point]} */ (wants.map((want, k) => (k === i ? to : want)));
          stage.soon();
        },
      })),
    );

    // What a motion gains of each goal: how far it goes the way that the goal wants.
    const rows = {
      sum: added,
      projection: projected,
      "projection, exploring": exploring ? explored : projected,
    };
    for (const [name, motion] of Object.entries(rows)) {
      wants.forEach(([x, y], i) => {
        const gain = motion[0] * x + motion[1] * y;
        write(root.querySelector(`[data-row="${name}"] td:nth-child(${i + 2})`), gain.toFixed(2));
      });
    }
    tell(
      root,
      "leader",
      `The ${["first", "second"][leader]} leads. Cosine ${cosine(...wants).toFixed(2)}: ${exploring ? "a conflict; it explores." : "no conflict."}`,
    );
  }
  draw();
  stage.redraw = draw;
}
