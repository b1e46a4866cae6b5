// Points in the plane.

/** @typedef {[number, number]} Point */

/** @param {Point} a @param {Point} b @returns {Point} */
export const plus = (a, b) => [a[0] + b[0], a[1] + b[1]];

/** @param {Point} a @param {Point} b @returns {Point} */
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];

/** @param {number} factor @param {Point} a @returns {Point} */
export const times = (factor, a) => [factor * a[0], factor * a[1]];

/** @param {ArrayLike<number>} a */
export const norm = (a) => Math.hypot(...Array.from(a));

/** The cosine between two vectors of any size; 0 where one of them is zero.
 * @param {number[]} a @param {number[]} b */
export function cosine(a, b) {
  const product = a.reduce((sum, x, i) => sum + x * b[i], 0);
  return product / (norm(a) * norm(b) || Infinity);
}

/** An angle in [−π, π), rad. @param {number} angle */
export const wrap = (angle) => angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));

/** The corners of the box around some points, with a margin. @param {Point[]} points @param {number} margin
 * @returns {{ low: Point, high: Point }} */
export function boundsOf(points, margin) {
  const [xs, ys] = [0, 1].map((axis) => points.map((point) => point[axis]));
  return {
    low: [Math.min(...xs) - margin, Math.min(...ys) - margin],
    high: [Math.max(...xs) + margin, Math.max(...ys) + margin],
  };
}

/** A point of a body where the body is: turned by an angle and shifted.
 * @param {Point} point @param {number[]} pose x, y, angle. @returns {Point} */
export function placed([x, y], [left, top, angle]) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [left + c * x - s * y, top + s * x + c * y];
}

/** The point of a polygon's outline that is nearest to a place.
 * @param {Point[]} corners @param {Point} place @returns {Point} */
export function nearestOn(corners, place) {
  let least = Infinity;
  let nearest = corners[0];
  corners.forEach((start, i) => {
    const along = minus(corners[(i + 1) % corners.length], start);
    const offset = minus(place, start);
    const share = (offset[0] * along[0] + offset[1] * along[1]) / (along[0] ** 2 + along[1] ** 2);
    const point = plus(start, times(Math.min(Math.max(share, 0), 1), along));
    const gap = minus(place, point);
    const squared = gap[0] ** 2 + gap[1] ** 2;
    if (squared < least) [least, nearest] = [squared, point];
  });
  return nearest;
}

/** Whether a place lies within a polygon. @param {Point[]} corners @param {Point} place */
export function contains(corners, [x, y]) {
  let inside = false;
  corners.forEach(([ax, ay], i) => {
    const [bx, by] = corners[(i + 1) % corners.length];
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  });
  return inside;
}
