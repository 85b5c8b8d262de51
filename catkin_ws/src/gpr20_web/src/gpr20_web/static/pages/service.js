// SERVICE: what is wrong with the robot, the worst first, and the bundle for remote help.

import { button, element, write } from "../dom.js";

const PERIOD_MS = 5000;
const BUNDLE_LIMIT_MS = 200000;
const BUNDLE = "/api/service/bundle";
const CHIPS = {
  ok: "good", note: "", unknown: "warn", warning: "warn", warn: "warn", fault: "bad", error: "bad",
  stale: "bad",
};
const chip = (level, title) => element("span", { class: `chip ${CHIPS[level] ?? ""}` }, title);

export default {
  name: "service",

  show(root, app) {
    const word = (name) => app.word(`service.${name}`);
    this.summary = element("p", { role: "status" }, word("waiting"));
    this.wrong = element("div");
    this.every = element("div");
    this.parts = element("div", { class: "columns" });
    this.said = element("p", { role: "status" });
    this.bundle = button(word("bundle"), () => this.make(app));
    root.append(
      this.summary,
      this.wrong,
      element("details", {}, element("summary", {}, word("all")), this.every,
        element("h2", {}, word("parts")), this.parts),
    );
    if (app.mayControl)
      root.append(element("div", { class: "card" }, element("p", {}, word("contents")),
        this.bundle, this.said));
    this.key = "";
    this.load(app);
    this.timer = setInterval(() => this.load(app), PERIOD_MS);
  },

  leave() {
    clearInterval(this.timer);
  },

  async load(app) {
    try {
      const { summary, findings, parts, making } = await app.get("/api/service");
      write(this.summary, summary || app.word("service.waiting"));
      this.bundle.disabled = making || this.waits;
      const key = JSON.stringify([findings, parts]);
      if (key === this.key) return;
      this.key = key;
      const rows = findings.map((one) => [one, this.card(one, one.remedy)]);
      this.wrong.replaceChildren(...rows.filter(([one]) => one.wrong).map(([, row]) => row));
      this.every.replaceChildren(...rows.filter(([one]) => !one.wrong).map(([, row]) => row));
      this.parts.replaceChildren(...parts.map((one) => this.card(one, one.first)));
    } catch (error) {
      if (error.status) app.report(error); // without an answer, the band says how old this is
    }
  },

  card({ level, title, text, details }, remedy) {
    return element(
      "article",
      { class: "card" },
      element("p", {}, chip(level, title)),
      element("p", {}, text),
      remedy ? element("p", { class: "first" }, `→ ${remedy}`) : null,
      details.length ? element("p", { class: "muted" }, details.join("; ")) : null,
    );
  },

  async make(app) {
    this.waits = true;
    this.bundle.disabled = true;
    write(this.said, app.word("service.making"));
    try {
      await app.server.ask("POST", BUNDLE, {}, BUNDLE_LIMIT_MS);
      element("a", { href: app.server.address(BUNDLE), download: "" }).click();
    } catch (error) {
      app.report(error);
    }
    this.waits = false;
    this.bundle.disabled = false;
    write(this.said, "");
  },
};
