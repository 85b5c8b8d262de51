// SURVEYS: the stored surveys, what people add to them, and downloads.

"use strict";

const MADE = ["report-html", "candidates-csv", "candidates-geojson"];
const ENDINGS = { complete: "good", incomplete: "warn", unreadable: "bad" };
// A page of the list may have few that fit.
const ENOUGH = 20;
const TYPED_MS = 300;
const SEARCH_LIMIT_MS = 600000;

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const paragraphs = (lines, attributes) => lines.map((one) => element("p", attributes, one));

const surveysPage = {
  name: "surveys",

  show(root, app) {
    this.app = app;
    this.folder = "";
    Object.assign(this, show("surveys", root, app));
    this.text.placeholder = this.word("hint");
    this.text.oninput = () => this.search(TYPED_MS);
    this.older.onclick = () => this.read();
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
    return this.app.act(async () => {
      const before = this.rows.childElementCount;
      do {
        const query = new URLSearchParams({ text: this.text.value, before: this.next });
        const page = await this.app.server.ask("GET", `/api/surveys?${query}`);
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
      title.startsWith(time) ? "" : element("span", {}, time), " ",
      ...this.chips(survey), element("br"), element("small", {}, people),
    );
    return element("li", {}, open);
  },

  chips({ ending, state, simulated }) {
    const chips = [element("span", { class: `chip ${ENDINGS[state] ?? ""}` }, ending), " "];
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
    return this.app.act(async () => {
      const survey = await this.app.server.ask("GET", this.path());
      if (folder !== this.folder) return;
      this.details.replaceChildren();
      const card = show("survey", this.details, this.app);
      write(card.title, survey.title);
      card.chips.append(...this.chips(survey));
      card.lines.append(
        ...paragraphs(survey.lines), ...paragraphs(survey.problems, { class: "warn" }));
      card.ground.href = `#map/${folder}`;
      card.ground.hidden = !survey.can_open;
      this.candidates(card, survey);
      // One that cannot be read has none of these.
      const { found = [], notes = [] } = survey;
      card.finds.append(...paragraphs(found));
      card.finds.hidden = !found.length;
      card.notes.append(...notes.map(([name, text]) =>
        element("div", {}, element("dt", {}, name), element("dd", { class: "lines" }, text))));
      card.form.onsubmit = (event) => {
        event.preventDefault();
        this.add("/notes", { text: card.text.value });
      };
      this.downloads(card, survey);
      const headings = [...this.details.querySelectorAll("h2")];
      headings.find((one) => one.textContent === heading)?.focus();
    });
  },

  // Send something that is added to the survey, then show it.
  async add(rest, values) {
    const { folder } = this;
    if (await this.app.act(() => this.app.post(this.path(rest), values)))
      await this.open(folder, this.word(rest.slice(1)));
  },

  // What nobody has found yet is searched for; else the answer is the one that is known.
  candidates(card, { candidates, can_search: can }) {
    card.find.hidden = !can || Boolean(candidates);
    card.find.onclick = () => this.work(card.find, card.searching, "searching", async () => {
      const path = this.path("/candidates");
      const found = await this.app.server.ask("POST", path, {}, SEARCH_LIMIT_MS);
      if (card.find.isConnected) this.candidates(card, { ...found, can_search: true });
    });
    card.candidates.replaceChildren(...(candidates ? this.places(candidates) : []));
  },

  // Ask for what takes a while, and may be refused with a reason.
  async work(pressed, said, word, request) {
    pressed.disabled = true;
    write(said, this.word(word));
    await this.app.act(request);
    write(said, "");
    pressed.disabled = false;
  },

  places({ headline, warnings, notes, list, places, weaker }) {
    const row = (place) =>
      element(
        "tr", {},
        element("th", { scope: "row" }, String(place.number)),
        element(
          "td", {},
          place.place, place.doubtful ? ` – ${this.word("weak")}` : "",
          element("br"), place.found,
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
    const lines = element("div");
    const find = show("find", lines, this.app);
    write(find.place, place);
    if (await ask(this.app, this.word("found"), [lines], this.word("add")))
      this.add("/found", {
        candidate: id, list, what: find.what.value,
        depth_mm: find.depth.value === "" ? null : Number(find.depth.value),
      });
  },

  downloads(card, { bytes, can_search: can }) {
    card.downloads.hidden = bytes === undefined;
    const size = this.app.number(Math.ceil(bytes / 1e4) / 100);
    card.whole.href = this.app.server.address(this.path("/zip"));
    write(card.whole, `${this.word("whole")} (${size} MB)`);
    for (const one of MADE) {
      const save = () => this.app.server.save(this.path(`/made/${one}`));
      const make = () => this.work(making, card.making, "making", save);
      const making = button(this.word(one), make, { disabled: !can });
      card.files.append(making);
    }
  },
};
