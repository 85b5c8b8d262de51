// What a person must learn: an alert in the page, and a notification of the browser if allowed.

import { button, element } from "./dom.js";

const LOOKS = { fault: "card danger", no_contact: "card danger", paused: "card warn" };

export class Notices {
  constructor(app) {
    this.app = app;
    this.place = element("div", { id: "notices", role: "alert" });
    document.getElementById("alerts").before(this.place);
  }

  update({ notice, robot }) {
    if (notice === undefined) return;
    const id = notice?.id ?? null;
    if (id === this.id) return;
    // What was so before the page was opened is in the band.
    const isNew = this.id !== undefined && notice;
    this.id = id;
    this.place.replaceChildren(...(isNew ? [this.card(notice)] : []));
    if (isNew) this.notify(notice, robot?.name);
  }

  card({ level, title, text, remedy }) {
    const close = button(this.app.word("shell.close"), () => this.place.replaceChildren());
    return element(
      "article",
      { class: LOOKS[level] ?? "card" },
      element("h2", {}, title),
      element("p", {}, text),
      remedy ? element("p", { class: "first" }, remedy) : null,
      close,
    );
  }

  notify({ title, text, remedy }, robot) {
    if (globalThis.Notification?.permission !== "granted") return;
    const body = [text, remedy].filter(Boolean).join("\n");
    try {
      const shown = new Notification(robot ? `${robot}: ${title}` : title, { body, tag: "gpr20" });
      shown.onclick = () => window.focus();
    } catch (error) {
      // Some telephones have the permission but not this way to use it; the alert is there.
      if (!(error instanceof TypeError)) throw error;
    }
  }

  // A button that asks for the permission, or what the answer was.
  permission() {
    const place = element("p", { class: "row muted" });
    const show = () => {
      const answer = globalThis.Notification?.permission ?? "denied";
      const word = (name) => this.app.word(`notices.${name}`);
      place.replaceChildren(
        answer === "default"
          ? button(word("allow"), async () => {
            await Notification.requestPermission();
            show();
          })
          : word(answer === "granted" ? "allowed" : "denied"),
      );
    };
    show();
    return place;
  }
}
