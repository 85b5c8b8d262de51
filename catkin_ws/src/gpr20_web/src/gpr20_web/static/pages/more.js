// MORE: the pages that are needed seldom, and how this browser shows all of them.

import { button, element } from "../dom.js";

const LINKS = ["service", "robots"];

export default {
  name: "more",

  show(root, app) {
    root.append(
      element("ul", { class: "list" }, ...LINKS.map((one) =>
        element("li", {},
          element("a", { class: "button", href: `#${one}` }, app.word(`${one}.title`))))),
      app.notices.permission(),
      element("div", { class: "card" }, ...app.choices()),
      element("div", { class: "card row" },
        element("span", {}, app.me.name),
        button(app.word("login.log_out"), () => app.logOut())),
    );
  },
};
