import { minus, norm, times } from "../core/plane.mjs";
import { readingsOf } from "../core/readings.mjs";
import { Stage } from "../core/stage.mjs";
import { slider, tell } from "./screen.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

const DT = 0.1; // s
const MOST = 20;
const NOTHING_NEAR = [9, 9];

/** One step with 1 to 20 gradients: where the model foresees to be after each of them.
 * @param {import("./screen.mjs").Screen} screen */
export async function startForesight({ root, policies, palette }) {
  const stage = new Stage(root.querySelector(".stage"));
  stage.fit([-0.05, -0.065], [0.13, 0.07], false);
  const plot = new Stage(root.querySelector(".plot"));
  plot.fit([-1, -1.3], [MOST + 1, 8], false);
  const counts = Array.from({ length: MOST }, (_, i) => i + 1);
  const many = await Promise.all(counts.map((count) => policies.get(`foresight ${count}`)));
  const one = await policies.get("one gradient");

  let target = /** @type {Point} */ ([0.048, 0.026]);
  const motion = (/** @type {import("./screen.mjs").Policy} */ policy) => {
    policy.reset();
    const [x, y] = policy.step(readingsOf(policy, { z_target: target, z_wall: NOTHING_NEAR }));
    return times(DT, [x, y]);
  };

  let count = 1;
  function draw() {
    const foreseen = [/** @type {Point} */ ([0, 0]), ...many.map(motion)];
    const full = motion(one);
    const distance = (/** @type {Point} */ place) => 100 * norm(minus(target, place)); // cm
    const shown = foreseen.slice(0, count + 1);
    const dots = (/** @type {Point} */ way) => norm(way) * stage.scale;

    stage.clear(palette.GROUND);
    stage.disc([0, 0], 0.1, palette.WALL, palette.OBJECT);
    stage.text("as far as one step can go", [0.0, -0.058], palette.PALE);
    stage.disc(target, 0.003, palette.TARGET);
    stage.arrow([0, 0], full, dots(full), palette.AWAY, 3);
    stage.line(shown, palette.TRAIL, 1.5);
    const end = shown[count];
    stage.arrow([0, 0], end, dots(end), palette.ROBOT, 4);
    shown.slice(1).forEach((place) => stage.disc(place, 0.0012, palette.WHITE, palette.ROBOT));
    stage.disc([0, 0], 0.004, palette.ROBOT, palette.WHITE);
    stage.text("one gradient", full, palette.AWAY, [0, -18]);
    stage.hold([
      {
        name: "near target",
        label: "Target",
        color: palette.TARGET,
        place: target,
        step: 0.004,
        move: (to) => ((target = to), stage.soon()),
      },
    ]);

    plot.clear(palette.WHITE);
    plot.stroke([0, 0], [MOST, 0], palette.PALE, 1);
    plot.stroke([0, distance(full)], [MOST, distance(full)], palette.AWAY, 1.5, [4, 4]);
    plot.text("one gradient, at full speed", [MOST - 5, distance(full)], palette.AWAY, [0, -10]);
    plot.line(
      foreseen.map((place, k) => [k, distance(place)]),
      palette.ROBOT,
      2,
    );
    plot.disc([count, distance(end)], 0.25, palette.ROBOT);
    plot.text("gradients in the step: 0 … 20", [MOST / 2, 0], palette.INK, [0, 18]);
    tell(
      root,
      "left",
      `After ${count} ${count === 1 ? "gradient" : "gradients"} it is ${distance(end).toFixed(2)} cm from the target; with one at full speed ${distance(full).toFixed(2)} cm.`,
    );
  }
  stage.redraw = draw;
  slider(root, "iterations", (value) => {
    count = value;
    stage.soon();
  });
}
