import { Episode } from "./episode.mjs";
import { meetingOf } from "./meeting.mjs";
import { fromHash, toHash } from "./moment.mjs";
import { Policies } from "./policies.mjs";
import { Stage } from "./stage.mjs";

/** @typedef {import("./plane.mjs").Point} Point */
/** @typedef {import("./meeting.mjs").Meeting} Meeting */
/** @typedef {import("../../../examples/web/aicon_policy.mjs").Policy} Policy */

/** What can be pushed, and be brought back by all its numbers.
 * @typedef {import("./episode.mjs").World & { numbers: number[], kick(): void }} World */

/** What a page knows of its task.
 * @template {World} W
 * @typedef {{ seed: number, speed: number, legend: Record<string, string>,
 *   makeWorld(seed: number): W,
 *   frame(world: W): { low: Point, high: Point, isDown: boolean },
 *   draw(stage: Stage, world: W, at: number[], policy: Policy, meeting: Meeting): void,
 *   handles(world: W, at: number[]): import("./stage.mjs").Handle[],
 *   look(path: string[], gradient: number[], policy: Policy): { label: string, color: string },
 *   told(world: W): string }} Task */

const TABLE_EVERY = 120; // ms between two tables, which nobody reads faster
const ANSWER = 5000; // ms that an answer stands
const MOST_STEPS = 8; // of a frame: a page that was hidden does not catch up

/** The element with an id. @param {string} id @returns {any} */
const element = (id) => document.getElementById(id);

/** What the page holds as data. */
export function pageData() {
  return JSON.parse(element("data").textContent);
}

/** A task that runs in a page, with everything that can be done to it.
 * @template {World} W */
export class TaskPage {
  /** @param {Task<W>} task @param {Record<string, import("./policies.mjs").Packed>} packed */
  constructor(task, packed) {
    this.task = task;
    this.policies = new Policies(packed);
    this.stage = new Stage(element("stage"));
    this.isPlaying = true;
    this.debt = 0; // s that the world is behind
    this.last = 0; // ms, of the last frame
    this.toldAt = 0;
    this.saidLast = "";
    this.quietUntil = 0; // ms, so that an answer can be read
  }

  /** Begin with the moment of the address. */
  async start() {
    const moment = { seed: this.task.seed, variant: this.variant, ...fromHash(location.hash) };
    element("speed").value = String(this.task.speed);
    this.#connect();
    await this.bringBack(moment);
    this.stage.redraw = () => this.#draw(1);
    this.#showLegend();
    requestAnimationFrame((now) => this.#frame(now));
  }

  /** Which policy the switches choose: "projection+explore+foresight". */
  get variant() {
    const rule = document.querySelector('[name="rule"]:checked').getAttribute("value");
    const explores = element("explore").checked && rule !== "steepest";
    return [rule, explores && "explore", element("foresight").checked && "foresight"]
      .filter(Boolean)
      .join("+");
  }

  /** @param {import("./moment.mjs").Moment} moment */
  async bringBack({ seed, variant, world, memory }) {
    const name = this.policies.packed[variant] ? variant : this.variant;
    this.#set(name);
    element("seed").value = String(seed);
    this.seed = seed;
    const policy = await this.policies.get(name);
    this.name = name;
    /** @type {Episode<W>} */
    this.episode = new Episode(this.task.makeWorld(seed), policy);
    const frame = this.task.frame(this.episode.world);
    this.stage.fit(frame.low, frame.high, frame.isDown);

    // A moment in the middle of an episode, which stands still until it is looked at.
    if (world && memory?.length === policy.memory.length) {
      this.episode.world.numbers = world;
      this.episode.before = this.episode.world.moving;
      policy.memory.set(memory);
      this.#play(false);
    }
    this.debt = 0;
    this.#draw(1);
    this.#tell();
  }

  /** The address of this moment. */
  get moment() {
    const { world, policy } = this.episode;
    return toHash({
      seed: this.seed,
      variant: this.name,
      world: world.numbers,
      memory: Array.from(policy.memory),
    });
  }

  #connect() {
    const on = (/** @type {string} */ id, /** @type {() => void} */ does) =>
      element(id).addEventListener(element(id).tagName === "BUTTON" ? "click" : "change", does);
    const restart = (/** @type {number} */ seed) => {
      this.#play(true);
      return this.bringBack({
        seed: Number.isInteger(seed) && seed >= 0 ? seed : this.seed,
        variant: this.variant,
      });
    };
    on("pause", () => this.#play(!this.isPlaying));
    on("step", () => (this.#play(false), this.#step(), this.#draw(1), this.#tell()));
    on("kick", () => this.#meddle(() => this.episode.world.kick()));
    on("again", () => restart(this.seed));
    on("next", () => restart(this.seed + 1));
    on("seed", () => restart(element("seed").valueAsNumber));
    on("link", () => this.#copyLink());
    for (const id of ["rule", "explore", "foresight"]) on(id, () => this.#choose());
    addEventListener("hashchange", () => {
      if (location.hash === this.ownHash) return;
      void this.bringBack({ seed: this.seed, variant: this.variant, ...fromHash(location.hash) });
    });
  }

  /** @param {boolean} isPlaying */
  #play(isPlaying) {
    this.isPlaying = isPlaying;
    element("pause").textContent = isPlaying ? "Pause" : "Go on";
    if (!isPlaying) this.#draw(1); // where the last step led, no share of it
  }

  /** Let the switches show a policy. @param {string} name */
  #set(name) {
    const [rule, ...others] = name.split("+");
    const choice = /** @type {HTMLInputElement} */ (
      document.querySelector(`[name="rule"][value="${rule}"]`)
    );
    choice.checked = true;
    if (rule !== "steepest") element("explore").checked = others.includes("explore");
    element("explore").disabled = rule === "steepest";
    element("foresight").checked = others.includes("foresight");
  }

  /** The policy that the switches choose goes on. */
  async #choose() {
    const name = this.variant;
    this.#set(name);
    const policy = await this.policies.get(name);
    if (name !== this.variant) return; // somebody was faster
    this.episode.change(policy);
    this.name = name;
    this.#draw(1);
    this.#tell();
  }

  async #copyLink() {
    this.ownHash = this.moment;
    location.hash = this.ownHash;
    this.#play(false);
    const copied = await navigator.clipboard?.writeText(location.href).then(
      () => true,
      () => false,
    );
    this.quietUntil = performance.now() + ANSWER;
    this.#say(
      copied
        ? "The link to this moment is in the clipboard and in the address."
        : "The address of this page is now a link to this moment.",
    );
  }

  /** Change something, and show it though the world may stand still. @param {() => void} does */
  #meddle(does) {
    does();
    this.episode.before = this.episode.world.moving;
    this.#draw(1);
  }

  #step() {
    this.episode.step();
  }

  /** @param {number} now ms */
  #frame(now) {
    const passed = Math.min((now - this.last) / 1000, 0.25);
    this.last = now;
    const { dt } = this.episode.world;
    if (this.isPlaying) {
      this.debt += passed * Number(element("speed").value);
      let steps = 0;
      for (; this.debt >= dt && steps < MOST_STEPS; steps += 1) {
        this.#step();
        this.debt -= dt;
      }
      if (steps === MOST_STEPS) this.debt = 0;
      this.#draw(this.debt / dt);
    }
    if (now - this.toldAt > TABLE_EVERY) {
      this.toldAt = now;
      this.#tell();
    }
    requestAnimationFrame((later) => this.#frame(later));
  }

  /** @returns {Meeting} */
  #meeting() {
    const { policy, world } = this.episode;
    if (world.arrived) return { wants: [], leader: null, against: null, exploring: false };
    const paths = this.policies.paths(this.name, policy.meetings[0]);
    return meetingOf(policy, paths, (path, gradient) => this.task.look(path, gradient, policy));
  }

  /** @param {number} share Of the way to the next step. */
  #draw(share) {
    const { world, policy } = this.episode;
    const at = this.isPlaying ? this.episode.at(share) : world.moving;
    this.task.draw(this.stage, world, at, policy, this.#meeting());
    const handles = this.task.handles(world, at);
    for (const handle of handles) {
      const { move } = handle;
      handle.move = (to) => this.#meddle(() => move(to));
    }
    this.stage.hold(handles);
  }

  /** The numbers, in words and as a table. */
  #tell() {
    const { wants, leader, against, exploring } = this.#meeting();
    const strongest = wants.slice(0, 6);
    element("wants").replaceChildren(
      ...strongest.map((want) => row(want, want.strength / wants[0].strength)),
    );
    const conflict = element("conflict");
    conflict.className = `conflict ${exploring ? "exploring" : against ? "opposed" : ""}`;
    conflict.textContent = conflictInWords(leader, against, exploring, this.name);

    // A screen reader hears what changes, not every number.
    const state = exploring ? "It explores. " : against ? "Two gradients oppose each other. " : "";
    if (performance.now() > this.quietUntil) this.#say(state + this.task.told(this.episode.world));
  }

  /** @param {string} words */
  #say(words) {
    if (words === this.saidLast) return;
    this.saidLast = words;
    element("status").textContent = words;
  }

  #showLegend() {
    element("legend").replaceChildren(
      ...Object.entries(this.task.legend).map(([words, color]) => {
        const item = document.createElement("span");
        item.append(dot(color), words);
        return item;
      }),
    );
  }
}

/** @param {string} color */
function dot(color) {
  const mark = document.createElement("i");
  mark.className = "dot";
  mark.style.setProperty("--color", color);
  return mark;
}

/** @param {import("./meeting.mjs").Want} want @param {number} share */
function row(want, share) {
  const line = document.createElement("tr");
  const name = document.createElement("td");
  name.append(dot(want.color), want.label);
  const rank = want.rank < 0 ? "–" : String(want.rank + 1);
  for (const text of [share.toFixed(2), rank, want.toLeader.toFixed(2)]) {
    line.appendChild(document.createElement("td")).textContent = text;
  }
  line.prepend(name);
  return line;
}

/** @param {import("./meeting.mjs").Want | null} leader @param {import("./meeting.mjs").Want | null} against
 * @param {boolean} exploring @param {string} variant */
function conflictInWords(leader, against, exploring, variant) {
  if (!leader) return "Nothing is left to do.";
  const pair =
    against &&
    `“${leader.label}” against “${against.label}” (cosine ${against.toLeader.toFixed(2)})`;
  if (exploring) {
    return pair
      ? `Conflict: ${pair}. It explores: it moves along the nullspace of the leader.`
      : "It still explores, until it has made progress.";
  }
  if (!pair) return `No conflict: “${leader.label}” leads, and nothing strong opposes it.`;
  /** @type {Record<string, string>} */
  const outcome = { sum: "What is added up cancels.", steepest: "The stronger takes its turn." };
  return `Conflict: ${pair}. ${outcome[variant.split("+")[0]] ?? "What is left of the weaker in the nullspace of the leader goes on."}`;
}
