// Push the T from many starts, in Node.js; ../count_pushes.py runs it.
//
// The folder that is named has policy.wasm and task.json: the table, the starts and how many steps there are at
// most. Prints for each start whether the T came to cover its goal, and after how many steps.
import { readFileSync } from "node:fs";
import { Policy } from "../../../examples/web/aicon_policy.mjs";
import { Episode } from "../core/episode.mjs";
import { PushingWorld } from "./pushing.mjs";

const folder = process.argv[2];
const { table, starts, steps } = JSON.parse(readFileSync(`${folder}/task.json`, "utf8"));
const policy = await Policy.load(`${folder}/policy.wasm`);

const rows = starts.map((/** @type {any} */ start) => {
  const world = new PushingWorld(table, 0, start);
  const episode = new Episode(world, policy);
  while (episode.steps < steps && !world.arrived) episode.step();
  return { success: world.arrived, steps: episode.steps };
});
console.log(JSON.stringify(rows));
