// MORE: how this browser shows the page, and two pages that are needed seldom.

import { button, element, write } from "../dom.js";
import { SIGNS } from "../top.js";

const SERVICE_MS = 5000;
const ROBOTS_MS = 3000;
// Of findings, parts and robots.
const CHIPS = {
  ...{ ok: "good", unknown: "warn", warning: "warn", warn: "warn", error: "bad", stale: "bad" },
  ...{ working: "good", done: "good", paused: "warn", attention: "warn", fault: "bad" },
};
const chip = (level, ...title) =>
  element("span", { class: `chip ${CHIPS[level] ?? ""}` }, ...title);

// A button that asks whether the browser may notify, or what the answer was.
function permission(app) {
  const answer = globalThis.Notification?.permission ?? "denied";
  const word = (name) => app.word(`notices.${name}`);
  const ask = async () => {
    await Notification.requestPermission();
    place.replaceWith(permission(app));
  };
  const place = element("p", { class: "row muted" }, answer === "default"
    ? button(word("allow"), ask)
    : word(answer === "granted" ? "allowed" : "denied"));
  return place;
}

export const more = {
  name: "more",

  show(root, app) {
    root.append(
      element("ul", { class: "list" }, ...[service, robots].map(({ name }) =>
        element("li", {},
          element("a", { class: "button", href: `#${name}` }, app.word(`${name}.title`))))),
      permission(app),
      element("div", { class: "card" }, ...app.choices()),
      element("div", { class: "card row" },
        element("span", {}, app.me.name),
        button(app.word("login.log_out"), () => app.logOut())),
    );
  },
};

// What is wrong with the robot, the worst first.
export const service = {
  name: "service",

  show(root, app) {
    const word = (name) => app.word(`service.${name}`);
    const summary = element("p", { role: "status" }, word("waiting"));
    const [wrong, every, parts] = [0, 1, 2].map(() => element("ul", { class: "list" }));
    root.append(summary, wrong, element("details", {}, element("summary", {}, word("all")),
      every, element("h2", {}, word("parts")), parts));
    let key = "";
    app.poll("/api/service", SERVICE_MS, (answer) => {
      write(summary, answer.summary || word("waiting"));
      if (key === (key = JSON.stringify(answer))) return;
      const shown = (found) => found.map((one) => this.line(one));
      wrong.replaceChildren(...shown(answer.findings.filter((one) => one.wrong)));
      every.replaceChildren(...shown(answer.findings.filter((one) => !one.wrong)));
      parts.replaceChildren(...shown(answer.parts));
    });
  },

  line({ level, title, text, remedy }) {
    return element("li", { class: "card" }, chip(level, title), ` ${text}`,
      remedy ? element("p", { class: "first" }, `→ ${remedy}`) : null);
  },
};

// Every robot of the ROS master, one line each.
export const robots = {
  name: "robots",

  show(root, app) {
    const word = (name) => app.word(`robots.${name}`);
    const heads = ["name", "state"].map((one) => element("th", { scope: "col" }, word(one)));
    const rows = element("tbody");
    root.append(element("table", { class: "table" },
      element("thead", {}, element("tr", {}, ...heads)), rows));
    app.poll("/api/robots", ROBOTS_MS, ({ robots: found }) =>
      rows.replaceChildren(...found.map(({ name, level, title, shown }) =>
        element("tr", {},
          element("th", { scope: "row" }, name,
            shown ? element("div", { class: "muted" }, word("shown")) : null),
          element("td", {}, chip(level,
            element("span", { "aria-hidden": "true" }, SIGNS[level] ?? "?"), ` ${title}`))))));
  },
};
