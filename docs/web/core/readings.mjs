/** The readings of a policy in their order: NaN for what is not told, and ages as they usually are.
 * @param {import("../../../examples/web/aicon_policy.mjs").Policy} policy
 * @param {Record<string, ArrayLike<number>>} told By the names of `policy.metadata.readings`. */
export function readingsOf(policy, told) {
  const { readings, sensors } = policy.metadata;
  const ages = new Map(sensors.map(({ name, age }) => [`${name}.age`, age]));
  return readings.flatMap(({ name, shape }) => {
    const size = shape.reduce((product, length) => product * length, 1);
    return Array.from(told[name] ?? new Array(size).fill(ages.get(name) ?? NaN));
  });
}
