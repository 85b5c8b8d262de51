// NOW: how far the survey is, where the antennas are, and the last fault.

import { element, write } from "../dom.js";

const figure = (name) =>
  element("div", {}, element("dt", {}, name), element("dd", {}, ""));

export default {
  name: "now",

  show(root, app) {
    const word = (name) => app.word(`now.${name}`);
    this.percent = element("p", { class: "percent" });
    this.progress = element("progress", { max: 100, "aria-label": word("stored") });
    this.left = element("p", { class: "left" });
    this.figures = Object.fromEntries(
      ["survey", "stored", "line", "area", "position", "height"].map((one) => [
        one, figure(word(one)),
      ]),
    );
    this.result = element("a", { class: "button", hidden: true });
    this.cards = element("div", { class: "cards" });
    this.map = element("img", { class: "map", alt: app.word("map.title"), hidden: true });
    root.append(
      element(
        "div",
        { class: "columns" },
        element(
          "div",
          { class: "card" },
          this.percent,
          this.progress,
          this.left,
          this.result,
          element("dl", {}, ...Object.values(this.figures)),
          app.top.control,
        ),
        element("div", { class: "card" }, this.map),
      ),
      this.cards,
    );
    this.cardsKey = "";
  },

  update(state, app) {
    const { job, band } = state;
    const put = (name, text) => {
      this.figures[name].hidden = !text;
      write(this.figures[name].lastChild, text);
    };
    this.percent.hidden = job.percent === null;
    write(this.percent, `${job.percent} %`);
    this.progress.hidden = job.percent === null;
    this.progress.value = job.percent ?? 0;
    write(this.left, band.left);
    put("survey", job.name || job.survey.slice(0, 8));
    const { stored, planned } = job;
    put("stored", stored === null ? "" : app.word("now.traces", { stored, planned }));
    put("line", job.line);
    put("area", job.area);
    put("position", job.place);
    put("height", job.height_mm === null ? "" : `${job.height_mm} mm`);
    const { result } = state;
    this.result.hidden = !result;
    if (result) this.result.href = `#surveys/${result.folder}`;
    write(this.result, result ? `${app.word("now.result")}: ${result.text}` : "");
    this.showMap(state, app);
    const key = JSON.stringify([state.fault, state.refusal]);
    if (key !== this.cardsKey) {
      this.cardsKey = key;
      this.cards.replaceChildren(...this.cardsOf(state, app));
    }
  },

  // What is measured until all is, then what it shows.
  showMap({ ground, job }, app) {
    const layer = job.percent === 100 ? "echoes" : "coverage";
    if (!ground || this.shown === `${layer} ${ground.survey} ${ground.revision}`) return;
    this.shown = `${layer} ${ground.survey} ${ground.revision}`;
    const theme = document.documentElement.dataset.theme;
    this.map.hidden = !ground.survey;
    if (ground.survey)
      this.map.src = app.server.address(
        `/api/ground/map.png?layer=${layer}&theme=${theme}&revision=${ground.revision}`,
      );
  },

  cardsOf({ fault, refusal }, app) {
    const cards = [];
    if (refusal) cards.push(this.card(refusal, app, refusal.title));
    if (fault) cards.push(this.card(fault, app, `${app.word("now.last_fault")}: ${fault.title}`));
    return cards;
  },

  card(notice, app, title) {
    return element(
      "article",
      { class: notice.over ? "card" : "card warn" },
      element("h2", {}, title),
      element("p", {}, notice.text),
      notice.first ? element("p", { class: "first" }, notice.first) : null,
      notice.then ? element("p", {}, notice.then) : null,
      notice.details.length
        ? element("details", {}, element("summary", {}, app.word("now.details")),
          element("pre", {}, notice.details.join("\n")))
        : null,
    );
  },

  leave() {
    this.shown = null;
  },
};
