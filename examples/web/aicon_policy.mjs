// A policy that aicon-torch exported to WebAssembly: load, reset, step. In browsers and in Node.js.
//
//   const policy = await Policy.load("pusht.wasm");
//   const commands = policy.step(readings);  // once every dt
//   if (!policy.begins) send(commands);
//
// A step allocates nothing, and the module imports nothing: what it computes is all that it can do.

const FORMAT = 2;
const PAGE = 65536; // bytes of WebAssembly's unit of memory

export class Policy {
  // Loads a file and checks that it is whole and computes here what it did when it was exported.
  // The file is an address, a path in Node.js, or what is in it.
  static async load(source) {
    const bytes = await contentOf(source);
    checkSeal(bytes);
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Policy(instance.exports);
  }

  constructor(exports) {
    if (!exports.aicon_step) throw new Error("not an exported policy: it has no aicon_step");
    const [format, width, readings, memory, commands] = new Int32Array(
      exports.memory.buffer, exports.aicon_sizes.value, 5);
    if (format !== FORMAT)
      throw new Error(`the policy has format ${format}, and this class reads format ${FORMAT}`);
    if (!exports.aicon_test())
      throw new Error("the policy computes something else here; export it again");

    // Its readings, memory and commands stand behind its own data.
    this.#exports = exports;
    const place = Math.ceil(exports.__heap_base.value / 8) * 8;
    const end = place + width * (readings + memory + commands);
    const missing = end - exports.memory.buffer.byteLength;
    if (missing > 0) exports.memory.grow(Math.ceil(missing / PAGE));

    const Numbers = width === 4 ? Float32Array : Float64Array;
    const numbers = (from, count) =>
      new Numbers(exports.memory.buffer, place + width * from, count);
    this.#readings = numbers(0, readings);
    this.#memory = numbers(readings, memory);
    this.#commands = numbers(readings + memory, commands);

    this.metadata = JSON.parse(textAt(exports.memory.buffer, exports.aicon_metadata.value));
    this.#layout = layoutOf(this.metadata.memory);
    exports.aicon_blank(this.#memory.byteOffset);
  }

  // The next step is the first of an episode. Goals that were switched stay as they are.
  reset() {
    this.values("begins")[0] = 1;
  }

  // One control step.
  //
  // Takes the readings of all sensors one after the other, in the order of metadata.readings, NaN
  // where there is none, then ages and executed actions, where the policy takes them; returns the
  // commands, which the next step overwrites. Readings that are gone too long bring the robot to rest.
  step(readings) {
    if (readings.length !== this.readings)
      throw new RangeError(`step: ${readings.length} readings, expected ${this.readings}`);
    this.#readings.set(readings);
    const memory = this.#memory.byteOffset;
    this.#exports.aicon_step(
      1, 0, this.#readings.byteOffset, memory, memory, this.#commands.byteOffset);
    return this.#commands;
  }

  // Whether the episode has yet to begin, as a reading that it begins with has not come, or begins
  // anew, as the step broke: send no command then, which may be a place.
  get begins() { return this.#exports.aicon_begins(this.#memory.byteOffset) === 1; }

  // Number of readings and of commands.
  get readings() { return this.#readings.length; }
  get commands() { return this.#commands.length; }

  // The memory, which lives from step to step: what was estimated, and what the last step decided.
  // Copied, it is the moment; policy.memory.set(copy) brings that back.
  get memory() { return this.#memory; }

  // The numbers of one entry of metadata.memory, such as "p_tar", of which steps write the next ones.
  values(name) {
    const entry = this.#layout.get(name);
    if (!entry)
      throw new RangeError(`no ${name} in the memory, which has ${[...this.#layout.keys()].join(", ")}`);
    return this.#memory.subarray(entry.start, entry.stop);
  }

  // The quantities where gradients meet.
  get meetings() {
    const ending = "/gradients";
    return [...this.#layout.keys()].filter((name) => name.endsWith(ending))
      .map((name) => name.slice(0, -ending.length));
  }

  // What the last step decided at a quantity: the gradients that met there, a row each; the rank of
  // each, 0 for the dominant one and -1 where it was not used; the one that it was compared with,
  // the cosine between the two, and whether the quantity explores.
  decided(quantity) {
    const gradients = this.values(`${quantity}/gradients`);
    const [count, size] = this.#layout.get(`${quantity}/gradients`).shape;
    const ranks = new Array(count).fill(-1);
    this.#optional(`${quantity}/rank`).forEach((index, rank) => { if (index >= 0) ranks[index] = rank; });
    return {
      gradients: Array.from(ranks, (_, row) =>
        Array.from(gradients.subarray(row * size, (row + 1) * size))),
      ranks,
      opponent: this.#optional(`${quantity}/opponent`)[0] ?? -1,
      cosine: this.#optional(`${quantity}/cosine`)[0] ?? 1,
      exploring: this.#optional(`${quantity}/exploring`)[0] === 1,
    };
  }

  #exports; #readings; #memory; #commands; #layout;

  #optional(name) { return this.#layout.has(name) ? this.values(name) : []; }
}

async function contentOf(source) {
  if (source instanceof ArrayBuffer) return new Uint8Array(source);
  if (ArrayBuffer.isView(source))
    return new Uint8Array(source.buffer, source.byteOffset, source.byteLength);

  // Node.js fetches no files.
  const isOnDisk = typeof process === "object" && process.versions?.node
    && !/^(https?|data|blob):/.test(String(source));
  if (isOnDisk) {
    const { readFile } = await import("node:fs/promises");
    return new Uint8Array(await readFile(source));
  }
  const response = await fetch(source);
  if (!response.ok) throw new Error(`${source}: ${response.status} ${response.statusText}`);
  return new Uint8Array(await response.arrayBuffer());
}

// The last line is a checksum of all before it (CRC-32, as in zlib).
function checkSeal(bytes) {
  const end = bytes.length - 9;
  const line = new TextDecoder().decode(bytes.subarray(Math.max(end - 93, 0)));
  const found = /\naicon-torch library for (\S+) *, source [0-9a-f]{32}, checksum ([0-9a-f]{8})\n$/.exec(line);
  if (!found) throw new Error("no exported policy, or damaged or cut off: its last line is missing");

  let rest = ~0;
  for (let i = 0; i < end; ++i) {
    rest ^= bytes[i];
    for (let bit = 0; bit < 8; ++bit) rest = (rest >>> 1) ^ (rest & 1 ? 0xedb88320 : 0);
  }
  if ((~rest >>> 0) !== parseInt(found[2], 16))
    throw new Error("the policy is damaged: its checksum is not that of its content");
}

function textAt(buffer, start) {
  const bytes = new Uint8Array(buffer, start);
  return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
}

// Where each named entry stands in the memory.
function layoutOf(entries) {
  const layout = new Map();
  let start = 0;
  for (const { name, shape } of entries) {
    const stop = start + shape.reduce((product, size) => product * size, 1);
    layout.set(name, { start, stop, shape });
    start = stop;
  }
  return layout;
}
