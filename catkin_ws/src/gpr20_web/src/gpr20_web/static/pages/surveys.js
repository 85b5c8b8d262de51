// SURVEYS: the stored surveys, what people add to them, and downloads.

import { ask, button, element, field, write } from "../dom.js";

const LISTED = ["all", "not complete", "imported"];
const FINDS = ["nothing", "scrap", "device"];
const MADE = ["report-html", "candidates-csv", "candidates-geojson"];
const CHIPS = { complete: "good", incomplete: "warn", unreadable: "bad" };
// A page of the list may have few that fit.
const ENOUGH = 20;
const TYPED_MS = 300;
const SEARCH_LIMIT_MS = 600000;

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const number = (attributes) => element("input", { type: "number", step: "any", ...attributes });
const valueOf = (input) => (input.value === "" ? null : Number(input.value));
const size = (count, app) => `${app.number(Math.ceil(count / 1e4) / 100)} MB`;
const paragraphs = (lines, attributes) => lines.map((one) => element("p", attributes, one));

export default {
  name: "surveys",

  show(root, app) {
    this.app = app;
    this.folder = "";
    const hint = this.word("hint");
    this.text = element("input", { type: "search", placeholder: hint, maxlength: 200 });
    this.listed = element(
      "select", {}, ...LISTED.map((one) => element("option", { value: one }, this.word(one))),
    );
    this.rows = element("ul", { class: "list" });
    this.none = element("p", { class: "muted", role: "status" });
    this.older = button(this.word("older"), () => this.read(), { hidden: true });
    this.details = element("div");
    this.text.addEventListener("input", () => this.search(TYPED_MS));
    this.listed.addEventListener("change", () => this.search(0));
    root.append(
      element(
        "div", { class: "columns" },
        element(
          "div", {},
          field(this.word("search"), this.text),
          field(this.word("listed"), this.listed),
          this.rows, this.none, this.older,
        ),
        this.details,
      ),
    );
    this.search(0);
    const [, folder] = window.location.hash.split("/");
    if (folder) this.open(folder);
  },

  leave() {
    this.turn += 1;
    this.folder = "";
  },

  turn: 0,

  word(name, values) {
    return this.app.word(`surveys.${name}`, values);
  },

  // Do what may be refused; returns whether it was done.
  async act(request) {
    try {
      await request();
      return true;
    } catch (error) {
      this.app.report(error);
      return false;
    }
  },

  async search(afterMs) {
    const turn = (this.turn += 1);
    await pause(afterMs);
    if (turn !== this.turn) return;
    this.next = "";
    this.rows.replaceChildren();
    this.read();
  },

  read() {
    const { turn } = this;
    return this.act(async () => {
      const before = this.rows.childElementCount;
      do {
        const query = new URLSearchParams({
          listed: this.listed.value, text: this.text.value, before: this.next,
        });
        const page = await this.app.get(`/api/surveys?${query}`);
        if (turn !== this.turn) return;
        this.next = page.next;
        this.rows.append(...page.surveys.map((one) => this.row(one)));
      } while (this.next && this.rows.childElementCount < before + ENOUGH);
      this.older.hidden = !this.next;
      write(this.none, this.rows.childElementCount ? "" : this.word("none"));
    });
  },

  row(survey) {
    const { folder, title, time, people } = survey;
    const open = button("", () => this.open(folder, title), { "data-folder": folder });
    open.append(
      element("strong", {}, title), " ",
      title === time ? "" : element("span", {}, time), " ",
      ...this.chips(survey), element("br"), element("small", {}, people),
    );
    return element("li", {}, open);
  },

  chips({ ending, state, simulated }) {
    const chips = [element("span", { class: `chip ${CHIPS[state] ?? ""}` }, ending), " "];
    if (simulated) chips.push(element("span", { class: "chip simulated" }, this.word("simulated")));
    return chips;
  },

  path(rest = "") {
    return `/api/surveys/${this.folder}${rest}`;
  },

  // Show a survey, and let the keyboard continue at a heading.
  open(folder, heading) {
    this.folder = folder;
    for (const one of this.rows.querySelectorAll("button"))
      one.setAttribute("aria-current", String(one.dataset.folder === folder));
    return this.act(async () => {
      const survey = await this.app.get(this.path());
      if (folder !== this.folder) return;
      this.details.replaceChildren(
        this.summary(survey), this.candidates(survey), this.found(survey),
        this.notes(survey), this.markers(survey), this.downloads(survey),
      );
      const headings = [...this.details.querySelectorAll("h2")];
      headings.find((one) => one.textContent === heading)?.focus();
    });
  },

  // Send something that is added to the survey, then show it.
  async add(rest, values) {
    const { folder } = this;
    if (await this.act(() => this.app.post(this.path(rest), values)))
      await this.open(folder, this.word(rest.slice(1)));
  },

  card(title, ...content) {
    const heading = element("h2", { tabindex: -1 }, title);
    return element("section", { class: "card" }, heading, ...content);
  },

  form(fields, values) {
    const send = (event) => {
      event.preventDefault();
      this.add(...values());
    };
    return element("form", { onsubmit: send }, ...fields, element("button", {}, this.word("add")));
  },

  summary(survey) {
    const problems = paragraphs(survey.problems, { class: "warn" });
    const lines = paragraphs(survey.lines);
    const link = element(
      "a", { class: "button", href: `#map/${survey.folder}` }, this.app.word("map.title"),
    );
    return this.card(
      survey.title, element("p", {}, ...this.chips(survey)), ...lines, ...problems,
      survey.can_open ? element("div", { class: "row" }, link) : "",
    );
  },

  candidates({ candidates, can_search: can }) {
    this.said = element("p", { role: "status" });
    this.again = button(this.word("find"), () => this.find(), { hidden: !can || Boolean(candidates) });
    const shown = candidates ? this.places(candidates) : [];
    this.list = this.card(this.word("candidates"), ...shown, this.said, this.again);
    return this.list;
  },

  // What nobody has found yet is searched for; else the answer is the one that is known.
  async find() {
    const { list: card, said, again } = this;
    again.disabled = true;
    write(said, this.word("searching"));
    await this.act(async () => {
      const path = this.path("/candidates");
      const found = await this.app.server.ask("POST", path, {}, SEARCH_LIMIT_MS);
      if (card.isConnected) card.replaceWith(this.candidates({ ...found, can_search: true }));
    });
    write(said, "");
    again.disabled = false;
  },

  places({ headline, warnings, notes, list, places, weaker }) {
    const row = (place) =>
      element(
        "tr", {},
        element("th", { scope: "row" }, String(place.number)),
        element(
          "td", {},
          place.place, element("br"), place.found,
          element("details", {}, element("summary", {}, place.line), ...paragraphs(place.why)),
          button(this.word("found"), () => this.ask(place, list), {
            "aria-label": `${this.word("found")} ${place.number}`,
          }),
        ),
      );
    const table = (some) =>
      element("table", { class: "table" }, element("tbody", {}, ...some.map(row)));
    const below = places.filter((place) => place.doubtful);
    return [
      element("p", {}, element("strong", {}, headline)),
      ...paragraphs(warnings, { class: "warn" }),
      ...paragraphs(notes, { class: "muted" }),
      table(places.filter((place) => !place.doubtful)),
      below.length
        ? element("details", {}, element("summary", {}, weaker), table(below))
        : "",
    ];
  },

  // What was found at a place of this list.
  async ask({ id, place }, list) {
    const what = element(
      "select", {}, ...FINDS.map((one) => element("option", { value: one }, this.word(one))),
    );
    const depth = number({ min: 0, max: 10000 });
    const lines = [
      element("p", {}, place), field(this.word("found"), what), field(this.word("depth"), depth),
    ];
    if (await ask(this.app, this.word("found"), lines, this.word("add")))
      this.add("/found", { candidate: id, list, what: what.value, depth_mm: valueOf(depth) });
  },

  found({ found }) {
    return found.length ? this.card(this.word("found"), ...paragraphs(found)) : "";
  },

  notes({ notes }) {
    const shown = (notes ?? []).map(([name, text]) =>
      element("div", {}, element("dt", {}, name), element("dd", { class: "lines" }, text)));
    const text = element("textarea", { required: true, maxlength: 2000, rows: 2 });
    return this.card(
      this.word("notes"), element("dl", {}, ...shown),
      this.form([field(this.word("text"), text)], () => ["/notes", { text: text.value }]),
    );
  },

  markers({ markers }) {
    const shown = (markers ?? []).map((one) => {
      const depth = one.depth_mm === null ? "" : ` (${this.app.number(one.depth_mm)} mm)`;
      const text = `X ${this.app.number(one.x_mm)}  Y ${this.app.number(one.y_mm)}${depth}: ${one.text} (${one.author})`;
      const remove = () => this.add("/markers", { remove: one.marker_id });
      const label = { "aria-label": `${this.word("remove")}: ${text}` };
      return element("li", {}, text, " ", button(this.word("remove"), remove, label));
    });
    const [x, y] = [number({ required: true }), number({ required: true })];
    const depth = number({ min: 0, max: 10000 });
    const text = element("input", { maxlength: 500 });
    const named = [["x", x], ["y", y], ["depth", depth], ["text", text]];
    const fields = named.map(([name, input]) => field(this.word(name), input));
    return this.card(
      this.word("markers"), element("ul", {}, ...shown),
      this.form(fields, () => ["/markers", {
        x_mm: valueOf(x), y_mm: valueOf(y), depth_mm: valueOf(depth), text: text.value,
      }]),
    );
  },

  // A report takes a while to be made, and may be refused with a reason.
  async make(kind, making, said) {
    making.disabled = true;
    write(said, this.word("making"));
    await this.act(() => this.app.server.save(this.path(`/made/${kind}`)));
    write(said, "");
    making.disabled = false;
  },

  downloads({ files, bytes, can_search: can }) {
    if (!files.length) return "";
    const said = element("p", { role: "status" });
    const made = MADE.map((one) => {
      const making = button(this.word(one), () => this.make(one, making, said), { disabled: !can });
      return making;
    });
    const link = (rest, name, count) => element("li", {}, element(
      "a", { href: this.app.server.address(this.path(rest)), download: true },
      `${name} (${size(count, this.app)})`,
    ));
    return this.card(
      this.word("downloads"),
      element("ul", {}, link("/zip", this.word("whole"), bytes),
        ...files.map((one) => link(`/files/${one.name}`, one.name, one.bytes))),
      element("div", { class: "row" }, ...made), said,
    );
  },
};
