import { Episode } from "../core/episode.mjs";
import { plus, times } from "../core/plane.mjs";
import { readingsOf } from "../core/readings.mjs";

/** @typedef {import("../core/plane.mjs").Point} Point */
/** @typedef {import("../../../examples/web/aicon_policy.mjs").Policy} Policy */

/** What a screen gets: its part of the page, the page's policies, and everything else that it holds.
 * @typedef {{ root: HTMLElement, policies: import("../core/policies.mjs").Policies,
 *   palette: Record<string, string>, data: any }} Screen */

const SEEN = 0.1; // share of a stage

/** Call something for every frame in which a stage is seen, with the time since the last, s.
 * @param {import("../core/stage.mjs").Stage} stage @param {(passed: number) => void} frame */
export function whileSeen(stage, frame) {
  let isSeen = false;
  let last = 0;
  const next = (/** @type {number} */ now) => {
    if (!isSeen) return;
    frame(Math.min((now - last) / 1000, 0.1));
    last = now;
    requestAnimationFrame(next);
  };
  new IntersectionObserver(([entry]) => {
    const wasSeen = isSeen;
    isSeen = entry.intersectionRatio >= SEEN;
    if (isSeen && !wasSeen) requestAnimationFrame((now) => ((last = now), next(now)));
  }, { threshold: SEEN }).observe(stage.element);
}

/** A slider, and what shows its number. @param {HTMLElement} root @param {string} name
 * @param {(value: number) => void} [does] */
export function slider(root, name, does = () => {}) {
  const input = /** @type {HTMLInputElement} */ (root.querySelector(`input[name="${name}"]`));
  const output = /** @type {HTMLOutputElement} */ (root.querySelector(`output[name="${name}"]`));
  const show = () => {
    output.textContent = input.value;
    does(input.valueAsNumber);
  };
  input.addEventListener("input", show);
  show();
  return {
    get value() {
      return input.valueAsNumber;
    },
  };
}

/** @type {Map<Element, string>} */
const untold = new Map();
const TELL_EVERY = 120; // ms; nobody reads faster

/** Write words into the part of a screen that has a name, soon. @param {HTMLElement} root
 * @param {string} name @param {string} words */
export function tell(root, name, words) {
  write(root.querySelector(`[data-told="${name}"]`), words);
}

/** Write words into a part of a screen, soon. @param {Element} part @param {string} words */
export function write(part, words) {
  if (untold.size === 0) setTimeout(tellAll, TELL_EVERY);
  untold.set(part, words);
}

function tellAll() {
  for (const [part, words] of untold) if (part.textContent !== words) part.textContent = words;
  untold.clear();
}

/** A point that moves as it is told. */
export class PointWorld {
  /** @param {number} dt @param {Point} place
   * @param {(place: Point) => Record<string, ArrayLike<number>>} sense What is read where it is. */
  constructor(dt, place, sense) {
    this.dt = dt;
    this.place = place;
    this.sense = sense;
    this.arrived = false;
    this.trail = [place];
  }

  get moving() {
    return [...this.place];
  }

  /** @param {Policy} policy */
  readings(policy) {
    return readingsOf(policy, this.sense(this.place));
  }

  /** @param {ArrayLike<number>} command */
  step(command) {
    this.place = plus(this.place, times(this.dt, [command[0], command[1]]));
    this.trail = [...this.trail.slice(-400), this.place];
  }
}

/** Episodes side by side, which keep step with the time.
 * @template {import("../core/episode.mjs").World} W */
export class Runners {
  /** @param {Episode<W>[]} episodes All with the same time step. */
  constructor(episodes) {
    this.episodes = episodes;
    this.debt = 0;
  }

  /** Let some time pass, and say where each is now. @param {number} passed s @returns {Point[]} */
  after(passed) {
    const { dt } = this.episodes[0].world;
    this.debt += passed;
    for (; this.debt >= dt; this.debt -= dt) for (const episode of this.episodes) episode.step();
    return this.episodes.map((episode) => /** @type {Point} */ (episode.at(this.debt / dt)));
  }
}
