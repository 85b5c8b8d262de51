// GROUND: the survey from above, and the section below a place; candidates and markers.

"use strict";

const PERIOD_MS = 1000;
const SETTLED_MS = 80;
const STEP_MM = 5;
const DEEPEST_MM = 500;
// How a key moves the place: across, up, deeper.
const KEYS = {
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0],
  PageUp: [0, 0, -1], PageDown: [0, 0, 1],
};

class Ground {
  constructor(root, app) {
    Object.assign(this, { app, images: new Map(), turn: 0 });
    const [page, folder = ""] = window.location.hash.split("/");
    if (app.ground?.survey !== folder) app.ground = { survey: folder, choice: { layer: "echoes" } };
    Object.assign(this, app.ground);
    Object.assign(this, show("map", root, app));
    this.above = this.plot(this.word("title"), false);
    this.section = this.plot(this.word("along"), true);
    this.pictures.append(this.above.canvas, this.section.canvas);
    this.resized = new ResizeObserver(() => this.draw());
    this.resized.observe(this.pictures);
    Object.assign(this.depth, { step: STEP_MM, max: DEEPEST_MM });
    this.depth.oninput = () => this.change({ depth_mm: Number(this.depth.value) });
    for (const name of ["layer", "along", "polarization"]) {
      const read = name === "polarization" ? Number : String;
      this[name].onchange = () => this.change({ [name]: read(this[name].value) });
      if (this.choice[name]) this[name].value = this.choice[name];
    }
    this.follow.onclick = () => this.change({ x_mm: null, y_mm: null });
    this.follow.hidden = Boolean(folder);
    this.back.hidden = !folder;
    this.back.href = page;
    this.add.onclick = () => this.addMarker();
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

  addMarker() {
    const { place: [x_mm, y_mm], depth_mm } = this.shown;
    const path = `/api/surveys/${this.about.folder}/markers`;
    return this.app.act(async () => {
      await this.app.post(path, { x_mm, y_mm, depth_mm, text: this.text.value });
      this.text.value = "";
      this.poll("1");
    });
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
    return { depth_mm: Math.max(0, Math.min(most, Math.round(depth / STEP_MM) * STEP_MM)) };
  }

  // A section is along one axis: the place on the other one stays.
  across(at) {
    const [x, y] = this.shown.place;
    return this.choice.along === "y" ? { x_mm: x, y_mm: at } : { x_mm: at, y_mm: y };
  }

  touch(plot, across, second) {
    const { marks, section } = this.shown;
    const mark = plot.near(across, second, plot.down ? section.marks : marks);
    if (mark) this.chooseMark(mark);
    else if (!plot.down) this.change({ x_mm: across, y_mm: second });
    else this.change({ ...this.across(across), ...this.deep(second) });
  }

  chooseMark({ place: [x, y, depth] }) {
    this.change({ x_mm: x, y_mm: y, ...(depth === null ? {} : this.deep(depth)) });
  }

  move(plot, across, up, deeper) {
    const { place: [x, y], steps_mm: [stepX, stepY], depth_mm: depth } = this.shown;
    const down = plot.down ? deeper - up : deeper;
    if (down) this.change(this.deep(depth + down * STEP_MM));
    else if (!plot.down) this.change({ x_mm: x + across * stepX, y_mm: y + up * stepY });
    else this.change(this.across(this.choice.along === "y" ? y + across * stepY : x + across * stepX));
  }

  query(changes = {}) {
    const { theme } = document.documentElement.dataset;
    const choice = JSON.stringify({ theme, ...this.choice, ...changes });
    return new URLSearchParams({ choice, survey: this.survey }).toString();
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
    const cells = this.query({ x_mm: null, y_mm: null, depth_mm: 0, layer: "coverage" });
    const wanted = [
      [ground.counts[0][1] !== null, "coverage", `map.png?${cells}`],
      [ground.image, "image", `map.png?${query}`],
      [ground.section, "section", `section.png?${query}`],
      [ground.bar.length, "bar", `bar.png?${query}`],
    ].filter(([is]) => is);
    const before = this.images;
    const made = wanted.map(async ([, name, query]) => {
      const path = `/api/ground/${query}&revision=${revision}`;
      const known = before.get(name);
      if (known?.path === path && known.image) return [name, known];
      return [name, { path, image: await this.app.server.picture(path, this) }];
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
    write(this.depthText, this.word("depth", { depth: shown.depth_mm }));
    const rotations = shown.polarizations ?? [];
    if (this.polarization.length !== rotations.length)
      this.polarization.replaceChildren(...rotations.map((one, number) =>
        element("option", { value: number, selected: number === shown.polarization }, one)));
    this.follow.disabled = (this.choice.x_mm ?? null) === null;
    // What follows the last trace would be read out every second.
    this.lines.setAttribute("aria-live", this.follow.disabled ? "off" : "polite");
    write(this.lines, shown.lines.join(". "));
    write(this.counts, shown.counts.map(([name, count]) => `${name}: ${count ?? "—"}`).join(" · "));
    const notices = shown.section?.notice ?? [];
    write(this.notes, [...shown.notice, ...notices, ...shown.notes].join(" "));
    this.add.disabled = !about.folder || !shown.place;
    if (this.key === (this.key = JSON.stringify(shown.marks))) return;
    // The most important ones are painted last.
    const items = [...shown.marks].reverse().map((one) =>
      element("li", {}, button(one.lines.join(", "), () => this.chooseMark(one))));
    this.marks.replaceChildren(...(items.length ? items : [element("li", {}, this.word("no_marks"))]));
  }

  draw() {
    const { above, section, shown, about, images } = this;
    this.body.hidden = !shown?.area;
    if (this.body.hidden) return;
    const image = (name) => images.get(name)?.image;
    above.begin(shown.area);
    above.image(image("coverage"), shown.area);
    above.image(image("image"), shown.image);
    for (const one of shown.failed) above.ring(...one, 9, "mark-stop-failed");
    if (about.target) above.ring(...about.target, 7, "mark-current");
    if (about.carriage) above.cross(...about.carriage, "mark-carriage", 13);
    if (shown.place) above.cross(...shown.place, "mark-selected", 22);
    shown.marks.forEach((one) => above.mark(one));
    above.axes(["X mm", "Y mm"]);
    if (shown.image) above.bar(image("bar"), shown.bar);
    section.canvas.hidden = !shown.section;
    if (shown.section) this.drawSection(section, shown.section, image);
  }

  drawSection(plot, section, image) {
    const [left, right, ...second] = section.extent;
    const wide = (right - left) / section.columns;
    plot.begin(section.extent);
    plot.fill(section.extent, "mark-not-measured", 2);
    for (const one of section.loading)
      plot.fill([left + one * wide, left + (one + 1) * wide, ...second], "mark-ink", 6);
    plot.image(image("section"), section.extent);
    plot.line("mark-surface", plot.at(left, 0), plot.at(right, 0));
    if (section.at[1] !== null) plot.cross(...section.at, "mark-selected", 22);
    section.marks.forEach((one) => plot.mark(one));
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

const groundPage = {
  name: "map",

  show(root, app) {
    this.ground = new Ground(root, app);
  },

  leave() {
    this.ground.end();
  },
};
