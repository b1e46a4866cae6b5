import { Policies } from "../core/policies.mjs";
import { pageData } from "../core/task_page.mjs";
import { startFloor } from "./floor.mjs";
import { startForesight } from "./foresight.mjs";
import { startNullspace } from "./nullspace.mjs";
import { startPotential } from "./potential.mjs";
import { startWall } from "./wall.mjs";

const { policies: packed, palette, ...data } = pageData();
const policies = new Policies(packed);
const screens = {
  nullspace: startNullspace,
  wall: startWall,
  floor: startFloor,
  foresight: startForesight,
  potential: startPotential,
};

/** One after the other, since the first one is seen first. */
async function startAll() {
  for (const [name, start] of Object.entries(screens)) {
    await start({ root: document.getElementById(name), policies, palette, data });
  }
}
void startAll();
