// MORE: how this browser shows the page, and the page of service.

import { element, show, write } from "../dom.js";

const SERVICE_MS = 5000;
const CHIPS = { ok: "good", unknown: "warn", warning: "warn", fault: "bad" };

export const more = {
  name: "more",

  show(root, app) {
    const page = show("more", root, app);
    app.choices(page.choices);
    write(page.name, app.me.name);
    page.leave.onclick = () => app.logOut();
  },
};

// What is wrong with the robot, the worst first.
export const service = {
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
