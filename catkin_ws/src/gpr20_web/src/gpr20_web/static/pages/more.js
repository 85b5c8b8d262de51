// MORE: how this browser shows the page, and the page of service.

import { button, element, write } from "../dom.js";

const SERVICE_MS = 5000;
// Of findings and parts.
const CHIPS = {
  ...{ ok: "good", unknown: "warn", warning: "warn", warn: "warn", error: "bad", stale: "bad" },
  fault: "bad",
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
      element("a", { class: "button", href: "#service" }, app.word("service.title")),
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
