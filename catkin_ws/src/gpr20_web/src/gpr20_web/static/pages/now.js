// NOW: how far the survey is, where the antennas are, and what is wrong.

import { element, show, write } from "../dom.js";

export default {
  name: "now",

  show(root, app) {
    this.page = show("now", root, app);
    this.page.card.append(app.top.control);
    this.page.map.alt = app.word("map.title");
    this.faultKey = this.mapKey = "";
  },

  update(state, app) {
    const { page } = this;
    const { job, result } = state;
    const { stored, planned } = job;
    const texts = {
      survey: job.name || job.survey.slice(0, 8),
      stored: stored === null ? "" : app.word("now.traces", { stored, planned }),
      line: job.line,
      area: job.area,
      position: job.place ?? "",
    };
    for (const [name, text] of Object.entries(texts)) {
      page[name].parentElement.hidden = !text;
      write(page[name], text);
    }
    page.percent.hidden = page.progress.hidden = job.percent === null;
    write(page.percent, `${job.percent} %`);
    page.progress.value = job.percent ?? 0;
    page.result.hidden = !result;
    if (result) page.result.href = `#surveys/${result.folder}`;
    write(page.result, result ? `${app.word("now.result")}: ${result.text}` : "");
    this.showMap(state, app);
    this.showFault(state, app);
  },

  showMap({ ground }, app) {
    const key = JSON.stringify(ground);
    if (!ground || key === this.mapKey) return;
    this.mapKey = key;
    this.page.map.hidden = !ground.survey;
    const { theme } = document.documentElement.dataset;
    const picture = `layer=${ground.layer}&theme=${theme}&revision=${ground.revision}`;
    if (ground.survey) this.page.map.src = app.server.address(`/api/ground/map.png?${picture}`);
  },

  showFault({ fault }, app) {
    const key = JSON.stringify(fault);
    if (key === this.faultKey) return;
    this.faultKey = key;
    this.page.fault.replaceChildren(...(fault ? [this.card(fault, app)] : []));
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
