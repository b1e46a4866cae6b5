// A moment of a page as the part of its address after "#".

/** @typedef {{ seed: number, variant: string, world?: number[], memory?: number[] }} Moment */

/** @param {Moment} moment */
export function toHash({ seed, variant, world, memory }) {
  const words = new URLSearchParams({ seed: String(seed), variant });
  if (world) words.set("world", fromNumbers(world));
  if (memory) words.set("memory", fromNumbers(memory));
  return `#${words}`;
}

/** @param {string} hash @returns {Partial<Moment>} */
export function fromHash(hash) {
  const words = new URLSearchParams(hash.replace(/^#/, ""));
  /** @type {Partial<Moment>} */
  const moment = {};
  const seed = Number(words.get("seed") ?? NaN);
  if (Number.isInteger(seed) && seed >= 0) moment.seed = seed;
  if (words.has("variant")) moment.variant = words.get("variant");
  if (words.has("world")) moment.world = toNumbers(words.get("world"));
  if (words.has("memory")) moment.memory = toNumbers(words.get("memory"));
  return moment;
}

/** Numbers, bit by bit, in letters that an address may have. @param {number[]} numbers */
function fromNumbers(numbers) {
  const bytes = new Uint8Array(Float64Array.from(numbers).buffer);
  const text = btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  return text.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** @param {string} text */
function toNumbers(text) {
  const letters = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  return Array.from(new Float64Array(bytes.buffer));
}
