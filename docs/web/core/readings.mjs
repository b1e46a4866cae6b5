/** The readings of a policy in their order; NaN for what is not told.
 * @param {import("../../../examples/web/aicon_policy.mjs").Policy} policy
 * @param {Record<string, ArrayLike<number>>} told By the names of `policy.metadata.readings`. */
export function readingsOf(policy, told) {
  const readings = [];
  for (const { name, shape } of policy.metadata.readings) {
    const size = shape.reduce((product, length) => product * length, 1);
    readings.push(...Array.from(told[name] ?? new Array(size).fill(NaN)));
  }
  return readings;
}
