import { Episode } from "../core/episode.mjs";
import { norm } from "../core/plane.mjs";
import { Stage } from "../core/stage.mjs";
import { PointWorld, Runners, slider, tell, whileSeen } from "./screen.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

const DEPTH = -1.1; // m, where what pulls is
const SIDES = [-1, 1]; // m, where both points are: left the sum, right the projection

/** N pulls press a point on a floor: a sum lets it through, projection does not.
 * @param {import("./screen.mjs").Screen} screen */
export async function startFloor({ root, policies, palette, data }) {
  const stage = new Stage(root.querySelector(".stage"));
  stage.fit([-2, -1.35], [2, 1.05], false);
  const [sum, projection] = await Promise.all(
    ["floor sum", "floor projection"].map((name) => policies.get(name)),
  );

  const floorRow = policies.paths("floor sum", "x").findIndex(([goal]) => goal === "floor");
  const count = slider(root, "count");
  const slope = slider(root, "slope");
  const pullsOf = (/** @type {number} */ side) =>
    Array.from(
      { length: data.floor.pulls },
      (_, i) =>
        /** @type {Point} */ ([
          side + 0.7 * (count.value === 1 ? 0 : i / (count.value - 1) - 0.5),
          DEPTH,
        ]),
    );

  /** @param {number} side @param {import("./screen.mjs").Policy} policy */
  const begin = (side, policy) =>
    new Episode(
      new PointWorld(0.02, [side, 0.8], (place) => ({
        z: place,
        z_slope: [slope.value],
        ...Object.fromEntries(
          pullsOf(side).map(([x, y], i) => [`z_pull_${i}`, [x - place[0], y - place[1]]]),
        ),
      })),
      policy,
    );
  /** @type {Runners<PointWorld>} */
  let runners;
  const restart = () =>
    (runners = new Runners([begin(SIDES[0], sum), begin(SIDES[1], projection)]));
  root.querySelector("button").addEventListener("click", restart);
  restart();

  whileSeen(stage, (passed) => {
    // Any number of pulls is switched on, in the memory.
    for (const { policy } of runners.episodes) {
      policy
        .values("goals/active")
        .forEach((_, i, active) => (active[i] = i <= count.value ? 1 : 0));
    }
    const places = runners.after(passed);
    if (!stage.differs([places, count.value, slope.value])) return;
    stage.clear(palette.GROUND);
    stage.box([-2, 0], [2, data.floor.margin], { fill: "#f6dccb" });
    stage.box([-2, -2], [2, 0], { fill: palette.OBJECT });
    stage.text("from here on the floor is felt", [0, data.floor.margin], palette.INK, [0, -12]);

    ["sum", "projection"].forEach((name, i) => {
      const place = places[i];
      for (const pull of pullsOf(SIDES[i]).slice(0, count.value)) {
        stage.line([place, pull], palette.TRAIL, 1);
        stage.disc(pull, 0.04, palette.TARGET);
      }
      stage.disc(place, 0.08, palette.ROBOT, palette.WHITE);
      runners.episodes[i].policy.decided("x").gradients.forEach((gradient, row) => {
        const [color, width] = row === floorRow ? [palette.AWAY, 5] : [palette.TOWARDS, 2];
        stage.arrow(
          place,
          [-gradient[0], -gradient[1]],
          15 * Math.min(norm(gradient), 5),
          color,
          width,
        );
      });
      stage.text(name, place, palette.INK, [0, -26]);
      const height = runners.episodes[i].world.moving[1];
      tell(root, name, `${height.toFixed(2)} m${height < -0.02 ? ", sunk" : ""}`);
    });

    // What the policies say of the pulls: how far each points down.
    const down = runners.episodes[1].policy
      .decided("x")
      .gradients.filter((gradient, row) => row !== floorRow && norm(gradient) > 0)
      .map((gradient) => gradient[1]);
    const together = down.reduce((total, value) => total + value, 0);
    tell(
      root,
      "bounds",
      `The pulls together press with ${together.toFixed(1)}, the strongest with ${Math.max(...down, 0).toFixed(1)}; the floor holds with ${slope.value}.`,
    );
  });
}
