// Replays recorded readings through a policy in WebAssembly, in Node.js, and tells how long a step takes.
//
//   node replay.mjs FOLDER [STEPS]
//
// FOLDER has policy.wasm, and rows of doubles in readings.bin, commands.bin and starts.bin (1 where an episode begins),
// as scripts/record_replay.py --target wasm32-web writes them. The commands must be those that were recorded, bit by bit.

import { readFileSync } from "node:fs";
import { Policy } from "./aicon_policy.mjs";

const [folder, steps = "100000"] = process.argv.slice(2);
// Node.js puts small files side by side in one buffer.
const numbers = (name) => new Float64Array(new Uint8Array(readFileSync(`${folder}/${name}`)).buffer);

const loading = performance.now();
const policy = await Policy.load(`${folder}/policy.wasm`);
console.log(`loaded in ${(performance.now() - loading).toFixed(1)} ms`);

const readings = numbers("readings.bin"), commands = numbers("commands.bin"), starts = numbers("starts.bin");
if (readings.length !== starts.length * policy.readings || commands.length !== starts.length * policy.commands)
  throw new Error("readings.bin, commands.bin and starts.bin do not fit the policy");

// The episodes again and again.
const taken = new Float64Array(Number(steps));
for (let step = 0; step < taken.length; ++step) {
  const row = step % starts.length;
  if (starts[row]) policy.reset();
  const read = readings.subarray(row * policy.readings, (row + 1) * policy.readings);

  const start = performance.now();
  const command = policy.step(read);
  taken[step] = performance.now() - start;

  if (command.some((value, index) => !Object.is(value, commands[row * policy.commands + index])))
    throw new Error(`step ${step}: another command than recorded`);
}

taken.sort();
const [median, late, largest] = [0.5, 0.99, 1].map((part) => taken[Math.ceil(part * taken.length) - 1]);
console.log(`${taken.length} steps, every command as recorded`);
console.log(`one step: median ${(1e3 * median).toFixed(2)} us, 99th percentile ${(1e3 * late).toFixed(2)} us, ` +
  `largest ${(1e3 * largest).toFixed(1)} us`);
