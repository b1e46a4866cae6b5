import { Policy } from "../../../examples/web/aicon_policy.mjs";

/** What a page holds of a policy: the module, by gzip, in base64; and the paths whose gradients meet.
 * @typedef {{ wasm: string, paths: Record<string, string[][]> }} Packed */

/** The policies that a page holds, each unpacked when it is first asked for. */
export class Policies {
  /** @param {Record<string, Packed>} packed */
  constructor(packed) {
    this.packed = packed;
    /** @type {Map<string, Promise<Policy>>} */
    this.loaded = new Map();
  }

  /** @param {string} name */
  get(name) {
    if (!this.loaded.has(name)) this.loaded.set(name, this.#load(name));
    return this.loaded.get(name);
  }

  /** One more of the same, with a memory of its own. @param {string} name */
  fresh(name) {
    return this.#load(name);
  }

  /** The paths of the gradients that meet at a quantity. @param {string} name @param {string} meeting */
  paths(name, meeting) {
    return this.packed[name].paths[meeting];
  }

  /** @param {string} name */
  async #load(name) {
    const policy = await Policy.load(await unpacked(this.packed[name].wasm));
    policy.reset();
    return policy;
  }
}

/** @param {string} text */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** Let a policy go on with what another one believes, in the middle of an episode.
 *
 * Estimates, covariances and actions are taken over. What is remembered where gradients meet
 * belongs to the rule, and begins anew.
 * @param {Policy} from @param {Policy} to @param {number[]} readings The last ones. */
export function carryOver(from, to, readings) {
  to.reset();
  to.step(readings);
  const own = new Set([...from.meetings, ...to.meetings].map((meeting) => `${meeting}/`));
  const known = new Map(from.metadata.memory.map(({ name, shape }) => [name, String(shape)]));
  for (const { name, shape } of to.metadata.memory) {
    const isOwn = [...own].some((prefix) => name.startsWith(prefix));
    if (!isOwn && known.get(name) === String(shape)) to.values(name).set(from.values(name));
  }
}
