// The frame of the page: login, pages, language, theme, and the band over all of them.

"use strict";

const CONTROL = 2;
const TICK_MS = 400;
const LOAD_LIMIT_MS = 10000;
// As faults.py of this package has it.
const NOT_LOGGED_IN = "web.not_logged_in";
const SERVICE_MS = 5000;
const CHIPS = { ok: "good", unknown: "warn", warning: "warn", fault: "bad" };

// NOW: how far the survey is, where the antennas are, and what is wrong.
const nowPage = {
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
    this.page.raw.hidden = !ground.survey || ground.layer !== "echoes";
    const { theme } = document.documentElement.dataset;
    const choice = JSON.stringify({ layer: ground.layer, theme });
    const picture = new URLSearchParams({ choice, revision: ground.revision });
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

// MORE: how this browser shows the page.
const morePage = {
  name: "more",

  show(root, app) {
    const page = show("more", root, app);
    app.choices(page.choices);
    write(page.name, app.me.name);
    page.leave.onclick = () => app.logOut();
  },
};

// What is wrong with the robot, the worst first.
const servicePage = {
  name: "service",

  show(root, app) {
    const page = show("service", root, app);
    let key = "";
    app.poll("/api/service", SERVICE_MS, ({ summary, findings }) => {
      if (summary) write(page.summary, summary);
      if (key === (key = JSON.stringify(findings))) return;
      const shown = (isWrong) =>
        findings.filter((one) => one.wrong === isWrong).map((one) => this.line(one));
      page.wrong.replaceChildren(...shown(true));
      page.every.replaceChildren(...shown(false));
    });
  },

  line({ level, title, text, remedy }) {
    return element("li", { class: "card" },
      element("span", { class: `chip ${CHIPS[level] ?? ""}` }, title), ` ${text}`,
      remedy ? element("p", { class: "first" }, `→ ${remedy}`) : null);
  },
};

// The first one opens.
const PAGES = [nowPage, groundPage, surveysPage, morePage, servicePage];

class App {
  constructor() {
    this.memory = window.localStorage;
    // Of this tab: what has to outlive that the page is loaded again.
    this.kept = window.sessionStorage;
    this.languages = JSON.parse(document.getElementById("words").textContent);
    const wanted = this.memory.getItem("language") ?? navigator.language.slice(0, 2);
    this.language = wanted in this.languages ? wanted : "en";
    this.words = this.languages[this.language].words;
    this.server = new Server(this.language);
    this.root = document.getElementById("page");
    this.me = undefined;
    this.page = null;
    document.documentElement.lang = this.language;
    const own = window.matchMedia("(prefers-color-scheme: dark)").matches ? "night" : "sun";
    document.documentElement.dataset.theme = this.memory.getItem("theme") ?? own;
    window.addEventListener("hashchange", () => this.show());
  }

  // Over a bad link, until it succeeds; the page says meanwhile that it connects.
  async begin() {
    document.getElementById("stop-warning").hidden = !this.stops.length;
    while (this.me === undefined)
      try {
        // First: whoever loads the page again waits for it. The band sends it again, and says so.
        await Promise.allSettled(this.stops.map(([press]) =>
          this.server.ask("POST", "/api/stop", { press }, PRESS_LIMIT_MS)));
        this.me = (await this.server.ask("GET", "/api/me", null, LOAD_LIMIT_MS)).me;
      } catch (error) {
        console.warn(error);
        await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      }
    if (this.me) this.enter();
    else this.showLogin();
  }

  word(name, values = {}) {
    const text = this.words[name] ?? name;
    return text.replaceAll(/\{(\w+)[^}]*\}/g, (field, key) => this.number(values[key]) ?? field);
  }

  // As the language of the page writes it; what is no number stays as it is.
  number(value) {
    return typeof value === "number" ? `${value}`.replace(".", this.words["shell.point"]) : value;
  }

  post(path, values) {
    return this.server.ask("POST", path, values);
  }

  get state() {
    return this.live?.state ?? {};
  }

  get mayControl() {
    return this.me.role >= CONTROL;
  }

  get inControl() {
    return this.state.holder?.mark === this.me.mark;
  }

  // The presses of STOP that are not confirmed yet, and when; who has no session sends none.
  get stops() {
    return JSON.parse(this.kept.getItem("stops") ?? "[]");
  }

  set stops(presses) {
    this.kept.setItem("stops", JSON.stringify(presses));
  }

  report(error) {
    if (error.code === NOT_LOGGED_IN) {
      this.leave("over");
      return;
    }
    // STOP has ended it.
    if (error.name === "AbortError" && this.stops.length) return;
    const text = error.status ? error.message : this.word("shell.no_answer");
    const shown = element(
      "div",
      { class: "card danger" },
      element("p", {}, text),
      element("p", {}, error.remedy ?? ""),
      button(this.word("shell.close"), () => shown.remove()),
    );
    document.getElementById("alerts").replaceChildren(shown);
  }

  // Do what may be refused; returns whether it was done.
  async act(request) {
    try {
      await request();
      return true;
    } catch (error) {
      this.report(error);
      return false;
    }
  }

  // Ask again and again while a page is shown; without an answer, the band says how old it is.
  poll(path, periodMs, show) {
    const ask = async () => {
      try {
        show(await this.server.ask("GET", path));
      } catch (error) {
        if (error.status) this.report(error);
      }
    };
    clearInterval(this.polls);
    this.polls = setInterval(ask, periodMs);
    ask();
  }

  showLogin() {
    this.root.replaceChildren();
    const login = show("login", this.root, this);
    this.choices(login.form);
    // Why somebody has to log in again; it is said until somebody has.
    const isUndone = this.stops.length > 0;
    login.why.hidden = !isUndone && !this.kept.getItem("why");
    login.undone.hidden = !isUndone;
    login.form.onsubmit = async (event) => {
      event.preventDefault();
      const [name, password] = [login.name.value, login.password.value];
      const isIn = await this.act(async () => {
        this.me = await this.post("/api/login", { name, password });
        this.kept.removeItem("why");
        this.enter();
      });
      if (!isIn) login.password.value = "";
    };
  }

  // Language and theme.
  choices(root) {
    const { language, theme } = show("choices", root, this);
    language.append(...Object.entries(this.languages).map(([code, { own }]) =>
      element("option", { value: code, lang: code, selected: code === this.language }, own)));
    language.onchange = () => this.change("language", language.value);
    const other = document.documentElement.dataset.theme === "night" ? "sun" : "night";
    write(theme, this.word(`shell.${other}`));
    theme.onclick = () => this.change("theme", other);
  }

  change(name, value) {
    this.memory.setItem(name, value);
    window.location.reload();
  }

  enter() {
    const header = document.getElementById("top");
    const bottom = document.getElementById("bottom");
    header.hidden = bottom.hidden = false;
    this.live = new Live(this.server, (state) => this.update(state), () => this.leave("over"));
    this.top = new Top(header, bottom, this);
    this.ticks = setInterval(() => this.live.slept ? this.wake() : this.top.tick(), TICK_MS);
    document.addEventListener("visibilitychange", () => document.hidden || this.wake());
    window.addEventListener("pagehide", () => this.live.rest());
    window.addEventListener("pageshow", ({ persisted }) => persisted && this.wake());
    this.show();
  }

  // The state is grey until a new stream has brought it.
  wake() {
    this.live.wake();
    this.top.tick();
  }

  leave(why = "") {
    this.kept.setItem("why", why);
    this.live?.close();
    clearInterval(this.ticks);
    window.location.reload();
  }

  show() {
    if (!this.me) return;
    const wanted = window.location.hash.slice(1).split("/")[0];
    const page = PAGES.find((one) => one.name === wanted) ?? nowPage;
    this.page?.leave?.();
    clearInterval(this.polls);
    if (page !== this.page) document.getElementById("alerts").replaceChildren();
    this.page = page;
    document.body.dataset.page = page.name;
    const isPlace = page !== servicePage;
    for (const link of document.querySelectorAll("#pages a")) {
      const isCurrent = link.hash === `#${isPlace ? page.name : "more"}`;
      if (isCurrent) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    const title = this.word(`${page.name}.title`);
    document.title = `${title} – GPR-20`;
    const section = element("section", { "aria-labelledby": "page-title" });
    const head = element("h1", { id: "page-title", class: isPlace ? "unseen" : null }, title);
    this.root.replaceChildren(head, section);
    page.show(section, this);
    if (this.state.band) page.update?.(this.state, this);
  }

  async logOut() {
    if (await this.act(() => this.post("/api/logout"))) this.leave();
  }

  update(state) {
    this.top.update(state);
    this.page?.update?.(state, this);
  }
}

const app = new App();
app.begin();
