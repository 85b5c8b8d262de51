// ROBOTS: every robot of the ROS master, one line each.

import { element } from "../dom.js";
import { SIGNS } from "../top.js";

const PERIOD_MS = 3000;
const CHIPS = { working: "good", done: "good", paused: "warn", attention: "warn", fault: "bad" };

export default {
  name: "robots",

  show(root, app) {
    const word = (name) => app.word(`robots.${name}`);
    const heads = ["name", "state"].map((one) =>
      element("th", { scope: "col" }, word(one)));
    this.rows = element("tbody");
    root.append(
      element("table", { class: "table" },
        element("thead", {}, element("tr", {}, ...heads)), this.rows),
    );
    this.key = "";
    this.load(app);
    this.timer = setInterval(() => this.load(app), PERIOD_MS);
  },

  leave() {
    clearInterval(this.timer);
  },

  async load(app) {
    try {
      const { robots } = await app.get("/api/robots");
      const key = JSON.stringify(robots);
      if (key === this.key) return;
      this.key = key;
      this.rows.replaceChildren(...robots.map((one) => this.row(one, app)));
    } catch (error) {
      if (error.status) app.report(error); // without an answer, the band says how old this is
    }
  },

  row({ name, level, title, since, shown }, app) {
    const time = since && app.moment(since);
    const sign = element("span", { "aria-hidden": "true" }, SIGNS[level] ?? "?");
    return element(
      "tr",
      {},
      element("th", { scope: "row" }, name,
        shown ? element("div", { class: "muted" }, app.word("robots.shown")) : null),
      element("td", {}, element("span", { class: `chip ${CHIPS[level] ?? ""}` }, sign, " ", title),
        time ? element("div", { class: "muted" }, app.word("robots.since", { time })) : null),
    );
  },
};
