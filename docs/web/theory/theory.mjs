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
for (const [name, start] of Object.entries(screens)) {
  void start({ root: document.getElementById(name), policies, palette, data });
}
