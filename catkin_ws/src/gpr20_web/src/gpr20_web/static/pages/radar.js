// RADAR: the ground below a line, and from above at a depth.

import { Ground } from "../ground.js";

const GAINS = [0, 1, 2, 3, 4, 6, 8, 10];

export default {
  name: "radar",

  show(root, app) {
    const ground = (this.ground = new Ground(root, app, true));
    const choices = (...names) => names.map((one) => [one, app.word(`radar.${one}`)]);
    const add = (name, options) => ground.addChoice(name, app.word(`radar.${name}`), options);
    add("along", choices("x", "y"));
    add("gain", GAINS.map((one) => [String(one), `${one} dB/ns`]));
    add("background", [["1", app.word("radar.removed")], ["0", app.word("radar.included")]]);
    add("colours", choices("envelope", "grey", "red white blue"));
  },

  leave() {
    this.ground.end();
  },
};
