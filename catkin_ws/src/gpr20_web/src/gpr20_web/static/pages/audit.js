// AUDIT: who did what, the newest first.

import { button, element, field } from "../dom.js";

const WITH_ZONE = "00:00:00 GMT-0500".length;
const COLUMNS = ["time", "who", "what"];

const row = (entry, app) => {
  const values = { survey: entry.survey || null, ...entry.values };
  const pairs = Object.entries(values).filter(([, value]) => value !== null);
  const lines = [
    [app.moment(entry.time, WITH_ZONE), ""],
    [entry.user, `${entry.role} ${entry.address}`],
    [[entry.command, entry.outcome].filter(Boolean).join(": "),
      pairs.map(([key, value]) => `${key}: ${value}`).join(", ")],
  ];
  return element("tr", {}, ...lines.map(([main, more]) =>
    element("td", {}, main, element("div", { class: "muted" }, more))));
};

export default {
  name: "audit",
  admin: true,

  show(root, app) {
    const word = (name) => app.word(`audit.${name}`);
    this.text = element("input", { type: "search", maxlength: 200 });
    this.rows = element("tbody");
    this.none = element("p", { role: "status", hidden: true }, word("none"));
    this.older = button(word("older"), () => this.load(app, this.last), { hidden: true });
    const search = (event) => {
      event.preventDefault();
      this.load(app, 0);
    };
    const heads = COLUMNS.map((one) => element("th", { scope: "col" }, word(one)));
    root.append(
      element(
        "form",
        { class: "row", role: "search", onsubmit: search },
        field(word("search"), this.text),
        element("button", {}, word("search")),
      ),
      element("table", { class: "table stack" },
        element("thead", {}, element("tr", {}, ...heads)), this.rows),
      this.none,
      this.older,
    );
    this.load(app, 0);
  },

  async load(app, before) {
    const asked = Symbol("load");
    this.asked = asked;
    try {
      const text = encodeURIComponent(this.text.value);
      const { entries, more } = await app.get(`/api/audit?before=${before}&text=${text}`);
      if (this.asked !== asked) return;
      if (!before) this.rows.replaceChildren();
      this.rows.append(...entries.map((entry) => row(entry, app)));
      this.last = entries.at(-1)?.id;
      this.none.hidden = this.rows.children.length > 0;
      this.older.hidden = !more;
    } catch (error) {
      app.report(error);
    }
  },
};
