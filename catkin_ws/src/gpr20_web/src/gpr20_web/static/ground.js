// The ground of a survey: MAP and RADAR ask for it, draw it, and choose places on it.

import { button, element, field, write } from "./dom.js";
import { Plot } from "./plot.js";

const PERIOD_MS = 1000;
const SETTLED_MS = 80;
const STEP_MM = 5;
const DEEPEST_MM = 500;
const theme = () => document.documentElement.dataset.theme;
// How a key moves the place: across, up, deeper.
const KEYS = {
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0],
  PageUp: [0, 0, -1], PageDown: [0, 0, 1],
};

export class Ground {
  constructor(root, app, hasSection) {
    Object.assign(this, { app, hasSection, images: new Map(), turn: 0 });
    const [page, folder = ""] = window.location.hash.split("/");
    if (app.ground?.survey !== folder) {
      const layer = app.state.job?.running && !folder ? "coverage" : "echoes";
      app.ground = { survey: folder, layer };
    }
    this.choice = app.ground;
    this.title = element("strong", { role: "status" });
    this.age = element("span", {});
    this.head = element("p", { class: "card" }, this.title, " ", this.age);
    this.notes = element("p");
    this.lines = element("p", { class: "card" });
    this.above = this.plot(app.word("map.title"), false);
    this.section = this.plot(app.word("radar.along"), true);
    const plots = hasSection ? [this.section, this.above] : [this.above];
    const pictures = element("div", { class: "columns" }, ...plots.map((one) => one.canvas));
    this.resized = new ResizeObserver(() => this.draw());
    this.resized.observe(pictures);
    this.depth = element("input", {
      type: "range", min: 0, step: STEP_MM, max: DEEPEST_MM,
      oninput: () => this.change({ depth: this.depth.value }),
    });
    this.depthField = field(this.word("depth", { depth: 0 }), this.depth);
    this.follow = button(this.word("follow"), () => this.change({ x: "", y: "" }));
    this.controls = element("div", { class: "row" });
    this.addChoice("layer", this.word("layer"),
      ["coverage", "echoes", "focused"].map((one) => [one, this.word(one)]));
    this.polarization = this.addChoice("polarization", this.word("polarization"), []);
    const back = element("a", { class: "button", href: page }, this.word("back"));
    root.append(
      this.head, pictures,
      element("div", { class: "row" }, this.depthField, folder ? back : this.follow),
      this.lines,
      element("details", {}, element("summary", {}, this.word("options")), this.controls),
      this.notes,
    );
    this.poll();
  }

  word(name, values) {
    return this.app.word(`map.${name}`, values);
  }

  plot(name, down) {
    const plot = new Plot(
      `${name}. ${this.word("keys")}`, down,
      (across, second) => this.touch(plot, across, second),
      (event) => {
        if (!this.shown?.place || !KEYS[event.key]) return;
        event.preventDefault();
        this.move(plot, ...KEYS[event.key]);
      },
      (text) => this.app.number(text),
    );
    return plot;
  }

  addChoice(name, label, options) {
    const select = element(
      "select", { onchange: () => this.change({ [name]: select.value }) },
      ...options.map(([value, text]) =>
        element("option", { value, selected: value === (this.choice[name] ?? "") }, text)),
    );
    this.controls.append(field(label, select));
    return select;
  }

  // A slider that is dragged changes faster than pictures come.
  change(changes) {
    Object.assign(this.choice, changes);
    this.turn++;
    this.app.server.drop(this);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.poll(), SETTLED_MS);
  }

  deep(depth) {
    const most = this.shown.deepest_mm ?? DEEPEST_MM;
    return { depth: Math.max(0, Math.min(most, Math.round(depth / STEP_MM) * STEP_MM)) };
  }

  // A section is along one axis: the place on the other one stays.
  across(at) {
    return this.choice.along === "y" ? { x: this.shown.place[0], y: at } : { x: at, y: this.shown.place[1] };
  }

  touch(plot, across, second) {
    const { marks, section } = this.shown;
    const mark = plot.near(across, second, plot.down ? section.marks : marks);
    if (mark) this.chooseMark(mark);
    else if (!plot.down) this.change({ x: across, y: second });
    else this.change({ ...this.across(across), ...(section.in_time ? {} : this.deep(second)) });
  }

  chooseMark({ place: [x, y, depth] }) {
    this.change({ x, y, ...(depth === null ? {} : this.deep(depth)) });
  }

  move(plot, across, up, deeper) {
    const { place: [x, y], steps_mm: [stepX, stepY], depth_mm: depth } = this.shown;
    const down = plot.down ? deeper - up : deeper;
    if (down) this.change(this.deep(depth + down * STEP_MM));
    else if (!plot.down) this.change({ x: x + across * stepX, y: y + up * stepY });
    else this.change(this.across(this.choice.along === "y" ? y + across * stepY : x + across * stepX));
  }

  query(changes = {}) {
    const section = this.hasSection ? "1" : "0";
    const values = { theme: theme(), section, ...this.choice, ...changes };
    const given = Object.entries(values).filter(([, one]) => one !== "" && one !== undefined);
    return new URLSearchParams(given).toString();
  }

  // Ask every second, and after each choice; an answer to an earlier choice is dropped.
  async poll(again = "") {
    const { server } = this.app;
    server.drop(this);
    clearTimeout(this.timer);
    const turn = ++this.turn;
    const isLast = () => turn === this.turn && !this.ended;
    const query = this.query();
    const known = query === this.asked ? this.about.revision : "";
    try {
      if (!document.hidden || !this.shown) {
        const path = `/api/ground?${query}&known=${known}&again=${again}`;
        const about = await server.ask("GET", path, null, undefined, this);
        const images = about.ground ? await this.load(about) : this.images;
        if (!isLast()) return;
        Object.assign(this, { about, images, shown: about.ground ?? this.shown, asked: query });
        this.write();
        this.draw();
      }
    } catch (error) {
      if (error.status && isLast()) write(this.title, error.message);
    }
    if (isLast()) this.timer = setTimeout(() => this.poll(), PERIOD_MS);
  }

  // The pictures of an answer; those that are here already are not asked for again.
  async load({ ground, revision }) {
    const query = this.query();
    const small = { x: "", y: "", depth: "", section: "0" };
    const wanted = Object.keys(ground.layers).map((name) =>
      [name, `map.png?${name === "image" ? query : this.query({ ...small, layer: name })}`]);
    if (ground.section) wanted.push(["section", `section.png?${query}`]);
    if (ground.bar.length) wanted.push(["bar", `bar.png?${query}`]);
    const before = this.images;
    const made = wanted.map(async ([name, path]) => {
      const { server } = this.app;
      const address = server.address(`/api/ground/${path}&revision=${revision}`);
      const known = before.get(name);
      return [name, known?.address === address ? known : await server.picture(address, this)];
    });
    return new Map(await Promise.all(made));
  }

  write() {
    const { about, shown } = this;
    const age = about.past || about.age_s === null ? "" : this.word("age", { seconds: about.age_s });
    this.head.classList.toggle("past", about.past);
    write(this.title, about.title);
    write(this.age, age);
    this.depth.max = shown.deepest_mm ?? DEEPEST_MM;
    this.depth.value = shown.depth_mm;
    write(this.depthField.firstChild, this.word("depth", { depth: shown.depth_mm }));
    const rotations = shown.polarizations ?? [];
    if (this.polarization.length !== rotations.length)
      this.polarization.replaceChildren(...rotations.map((one, number) =>
        element("option", { value: number, selected: number === shown.polarization }, one)));
    this.follow.disabled = (this.choice.x ?? "") === "";
    // What follows the last trace would be read out every second.
    this.lines.setAttribute("aria-live", this.follow.disabled ? "off" : "polite");
    write(this.lines, shown.lines.join(". "));
    const notices = shown.section?.notice ?? [];
    write(this.notes, [...shown.notice, ...notices, ...shown.notes].join(" "));
    this.onAnswer?.();
  }

  draw() {
    const { above, section, shown, about, images } = this;
    if (!shown?.area) return;
    const image = (name) => images.get(name)?.image;
    above.begin(shown.area);
    for (const name of ["coverage", "image", "loading", "hiding"])
      above.image(image(name), shown.layers[name]);
    for (const one of shown.frames)
      above.stroke("mark-ink", (pen) => pen.rect(...above.box(one)));
    for (const one of shown.failed) above.ring(...one, 9, "mark-stop-failed");
    if (about.target) above.ring(...about.target, 7, "mark-current");
    if (about.carriage) above.cross(...about.carriage, "mark-carriage", 13);
    shown.marks.forEach((one) => above.mark(one));
    if (shown.place) above.cross(...shown.place, "mark-selected", 22);
    above.axes(["X mm", "Y mm"]);
    if (shown.layers.image) above.bar(image("bar"), shown.bar);
    if (this.hasSection && shown.section) this.drawSection(section, shown.section, image);
  }

  drawSection(plot, section, image) {
    const [left, right, ...second] = section.extent;
    const wide = (right - left) / section.columns;
    plot.begin(section.extent);
    plot.fill(section.extent, "mark-not-measured", 2);
    for (const one of section.loading)
      plot.fill([left + one * wide, left + (one + 1) * wide, ...second], "mark-ink", 6);
    plot.image(image("section"), section.extent);
    if (!section.in_time) plot.line("mark-surface", plot.at(left, 0), plot.at(right, 0));
    section.marks.forEach((one) => plot.mark(one));
    if (section.at[1] !== null) plot.cross(...section.at, "mark-selected", 22);
    plot.axes(section.titles);
    plot.bar(image("bar"), this.shown.bar);
  }

  end() {
    this.ended = true;
    this.app.server.drop(this);
    clearTimeout(this.timer);
    this.resized.disconnect();
  }
}

// The pattern of a state, for a legend with its word.
export const sign = (app, cell) =>
  element("img", {
    src: app.server.address(`/api/ground/sign.png?cell=${cell}&theme=${theme()}`),
    alt: "", width: 24, height: 24,
  });
