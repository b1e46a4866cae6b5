import { Episode } from "../core/episode.mjs";
import { minus, nearestOn, norm, plus } from "../core/plane.mjs";
import { readingsOf } from "../core/readings.mjs";
import { Stage } from "../core/stage.mjs";
import { PointWorld, Runners, tell, whileSeen } from "./screen.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */

const START = /** @type {Point} */ ([-1.6, 0.02]);
const FAR = 1.2; // m, from where the curves begin
const RISE = 0.2; // height of a strength of 1 in them

/** A target behind a wall: where two gradients cancel, and what leads on.
 * @param {import("./screen.mjs").Screen} screen */
export async function startWall({ root, policies, palette }) {
  const stage = new Stage(root.querySelector(".stage"));
  stage.fit([-1.9, -1.3], [1.7, 1.3], false);
  const plot = new Stage(root.querySelector(".plot"));
  plot.fit([0, -0.1 * FAR], [FAR, 0.4 * FAR], false);
  const names = ["wall sum", "wall projection", "wall explore"];
  const colors = [palette.AWAY, palette.ROBOT, palette.EXPLORING];
  const loaded = await Promise.all(names.map((name) => policies.get(name)));

  let target = /** @type {Point} */ ([1.3, 0]);
  let wall = /** @type {Point[]} */ ([
    [0, -0.7],
    [0, 0.8],
  ]);
  const sense = (/** @type {Point} */ place) => ({
    z_target: minus(target, place),
    z_wall: minus(nearestOn(wall, place), place),
  });
  /** @type {Runners<PointWorld>} */
  let runners;
  const restart = () =>
    (runners = new Runners(
      loaded.map((policy) => new Episode(new PointWorld(0.1, START, sense), policy)),
    ));
  root.querySelector("button").addEventListener("click", restart);
  restart();

  // How strong both are in front of the wall, as the policy finds it there.
  const probe = await policies.fresh("wall sum");
  const strengths = Array.from({ length: 49 }, (_, i) => {
    const gap = FAR * (1 - i / 50);
    probe.reset();
    probe.step(readingsOf(probe, { z_target: [gap + 1.3, 0], z_wall: [gap, 0] }));
    return { gap, norms: probe.decided("x").gradients.map(norm) };
  });
  const goals = policies.paths("wall sum", "x").map(([goal]) => goal);
  const scale = 1 / Math.max(...strengths[0].norms);

  /** @type {HTMLCanvasElement | null} */
  let curves = null;
  plot.redraw = () => (curves = null);
  whileSeen(stage, (passed) => {
    const places = runners.after(2 * passed);
    if (!stage.differs([places, target, wall])) return;
    stage.clear(palette.GROUND);
    stage.line(wall, palette.OBSTACLE, 9);
    stage.disc(target, 0.06, palette.TARGET);
    stage.text("target", target, palette.TARGET, [0, -26]);
    runners.episodes.forEach(({ world, policy }, i) => {
      stage.line(world.trail, colors[i], 1.5);
      if (i === 0) drawGradients(places[i], policy);
      stage.disc(places[i], 0.09 - 0.02 * i, colors[i], palette.WHITE); // all can be seen in one place
    });
    stage.hold([
      {
        name: "wall target",
        label: "Target",
        color: palette.TARGET,
        place: target,
        move: (to) => (target = to),
      },
      ...wall.map((place, i) => ({
        name: `end ${i + 1}`,
        label: `End ${i + 1} of the wall`,
        color: palette.PALE,
        place,
        move: (/** @type {Point} */ to) => (wall = wall.map((end, k) => (k === i ? to : end))),
      })),
    ]);

    const [here] = places;
    const gap = norm(minus(nearestOn(wall, here), here));
    curves ??= plot.picture(drawCurves);
    plot.show(curves);
    plot.stroke([FAR - gap, 0], [FAR - gap, 0.38 * FAR], palette.AWAY, 1.5, [4, 4]);
    const { gradients } = runners.episodes[0].policy.decided("x");
    const rest = norm(
      gradients.reduce(
        (sum, gradient) => plus(/** @type {Point} */ (sum), /** @type {Point} */ (gradient)),
        [0, 0],
      ),
    );
    tell(
      root,
      "sum",
      `${gap.toFixed(2)} m from the wall; ${goals.map((goal, i) => `“${goal}” ${(scale * norm(gradients[i])).toFixed(2)}`).join(", ")}; their sum ${(scale * rest).toFixed(2)}.`,
    );
    const arrived = places.map((place) =>
      norm(minus(target, place)) < 0.1
        ? "there"
        : `${norm(minus(target, place)).toFixed(1)} m away`,
    );
    ["sum-place", "projection", "with exploration"].forEach((name, i) => tell(root, name, arrived[i]));
  });

  /** What each goal wants of the robot that adds up. @param {Point} place @param {import("./screen.mjs").Policy} policy */
  function drawGradients(place, policy) {
    for (const [row, gradient] of policy.decided("x").gradients.entries()) {
      const color = goals[row] === "avoid" ? palette.OBSTACLE : palette.TARGET;
      const [x, y] = gradient;
      stage.arrow(place, [-x, -y], 50 * scale * norm(gradient), color, 3);
    }
  }

  /** Both strengths over the distance to the wall. */
  function drawCurves() {
    plot.clear(palette.WHITE);
    plot.stroke([0, 0], [FAR, 0], palette.PALE, 1);
    plot.text("distance to the wall: 1.2 m … 0", [FAR / 2, 0], palette.INK, [0, 16]);
    goals.forEach((goal, row) => {
      const color = goal === "avoid" ? palette.OBSTACLE : palette.TARGET;
      const curve = strengths.map(
        ({ gap: at, norms }) => /** @type {Point} */ ([FAR - at, RISE * scale * norms[row]]),
      );
      plot.line(curve, color, 2.5);
      plot.text(goal, curve[goal === "avoid" ? 40 : 8], color, [goal === "avoid" ? -30 : 0, -12]);
    });
  }
}
