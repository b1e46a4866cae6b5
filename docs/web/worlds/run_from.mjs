// Run a policy from many starts, in Node.js; ../count_starts.py calls it.
//
// The folder that is named has policy.wasm and task.json: which page's world it is and what that is made of, the
// starts, and how many steps there are at most. Prints for each start whether it arrived, and after how many steps.
import { readFileSync } from "node:fs";
import { Policy } from "../../../examples/web/aicon_policy.mjs";
import { Episode } from "../core/episode.mjs";
import { ArmWorld } from "./arm.mjs";
import { PushingWorld } from "./pushing.mjs";

const folder = process.argv[2];
const { page, sizes, starts, steps } = JSON.parse(readFileSync(`${folder}/task.json`, "utf8"));
const policy = await Policy.load(`${folder}/policy.wasm`);

const rows = starts.map((/** @type {any} */ start) => {
  const world = page === "arm" ? new ArmWorld(sizes, start) : new PushingWorld(sizes, 0, start);
  const episode = new Episode(world, policy);
  while (episode.steps < steps && !world.arrived) episode.step();
  return { success: world.arrived, steps: episode.steps, touches: world.touches ?? 0 };
});
console.log(JSON.stringify(rows));
