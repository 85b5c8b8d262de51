// NOW: how far the survey is, where the antennas are, and what is wrong.

import { element, write } from "../dom.js";

const FIGURES = ["survey", "stored", "line", "area", "position", "height"];

export default {
  name: "now",

  show(root, app) {
    const word = (name) => app.word(`now.${name}`);
    this.percent = element("p", { class: "percent" });
    this.progress = element("progress", { max: 100, "aria-label": word("stored") });
    this.left = element("p", { class: "left" });
    this.figures = FIGURES.map((one) =>
      element("div", {}, element("dt", {}, word(one)), element("dd", {}, "")));
    this.result = element("a", { class: "button", hidden: true });
    this.fault = element("div");
    this.map = element("img", { class: "map", alt: app.word("map.title"), hidden: true });
    root.append(
      element("div", { class: "columns" },
        element("div", { class: "card" }, this.percent, this.progress, this.left, this.result,
          element("dl", {}, ...this.figures), app.top.control),
        element("div", { class: "card" }, this.map)),
      this.fault,
    );
    this.faultKey = this.mapKey = "";
  },

  update(state, app) {
    const { job, band, result } = state;
    const { stored, planned } = job;
    const texts = {
      survey: job.name || job.survey.slice(0, 8),
      stored: stored === null ? "" : app.word("now.traces", { stored, planned }),
      line: job.line,
      area: job.area,
      position: job.place,
      height: job.height_mm === null ? "" : `${job.height_mm} mm`,
    };
    this.figures.forEach((figure, number) => {
      const text = texts[FIGURES[number]];
      figure.hidden = !text;
      write(figure.lastChild, text);
    });
    this.percent.hidden = this.progress.hidden = job.percent === null;
    write(this.percent, `${job.percent} %`);
    this.progress.value = job.percent ?? 0;
    write(this.left, band.left);
    this.result.hidden = !result;
    if (result) this.result.href = `#surveys/${result.folder}`;
    write(this.result, result ? `${app.word("now.result")}: ${result.text}` : "");
    this.showMap(state, app);
    this.showFault(state, app);
  },

  // What is measured until all is, then what it shows.
  showMap({ ground, job }, app) {
    const layer = job.percent === 100 ? "echoes" : "coverage";
    const key = `layer=${layer}&revision=${ground?.revision}&survey=${ground?.survey}`;
    if (!ground || key === this.mapKey) return;
    this.mapKey = key;
    this.map.hidden = !ground.survey;
    const { theme } = document.documentElement.dataset;
    const picture = `layer=${layer}&theme=${theme}&revision=${ground.revision}`;
    if (ground.survey) this.map.src = app.server.address(`/api/ground/map.png?${picture}`);
  },

  showFault({ fault }, app) {
    const key = JSON.stringify(fault);
    if (key === this.faultKey) return;
    this.faultKey = key;
    this.fault.replaceChildren(...(fault ? [this.card(fault, app)] : []));
  },

  card({ title, text, first, then, details }, app) {
    return element("article", { class: "card warn" },
      element("h2", {}, title),
      element("p", {}, text),
      first ? element("p", { class: "first" }, first) : null,
      then ? element("p", {}, then) : null,
      details.length
        ? element("details", {}, element("summary", {}, app.word("now.details")),
          element("pre", {}, details.join("\n")))
        : null);
  },
};
