/** @typedef {import("./plane.mjs").Point} Point */

const [SHORTEST, LONGEST] = [16, 80]; // dots, of a gradient: of none, and of the strongest
const FULL_SPEED = 90; // dots, of the motion
const FAINT = 0.02; // share of the strongest, below which a gradient is not drawn

/** Draw what a step decided: where each gradient leads, and the thin arrow of the motion that came of them.
 * @param {import("./stage.mjs").Stage} stage @param {Record<string, string>} palette
 * @param {Point} place Where the arrows begin.
 * @param {import("./meeting.mjs").Meeting} meeting
 * @param {(velocity: ArrayLike<number>) => Point} inPlane What a velocity of the quantity is in the plane.
 * @param {{ velocity: ArrayLike<number>, share: number }} motion With its share of the greatest speed. */
export function drawDecision(stage, palette, place, { wants, exploring }, inPlane, motion) {
  for (const { gradient, strength, color } of felt(wants)) {
    const way = inPlane(gradient.map((value) => -value));
    const share = strength / wants[0].strength;
    stage.arrow(place, way, SHORTEST + (LONGEST - SHORTEST) * share, color, 5);
  }
  const color = exploring ? palette.EXPLORING : palette.RESOLVED;
  stage.arrow(place, inPlane(motion.velocity), FULL_SPEED * motion.share, color, 2);
}

/** The gradients that are strong enough to be drawn. @param {import("./meeting.mjs").Want[]} wants */
export const felt = (wants) => wants.filter(({ strength }) => strength > FAINT * wants[0].strength);

/** A velocity of the plane itself. @param {ArrayLike<number>} velocity @returns {Point} */
export const asItIs = (velocity) => [velocity[0], velocity[1]];
