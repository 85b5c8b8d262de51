// The band on every page: state, sign, what to do, PAUSE or RESUME, STOP, remote control.

import { ask, button, element, write } from "./dom.js";
import { nowMs } from "./server.js";

export const SIGNS = {
  working: "▶", paused: "‖", attention: "⚠", fault: "✖", done: "✔", rest: "■", replay: "⟲",
};
// Before 5 s: it was on its way for a while, and the tick may be late.
export const STALE_MS = 4500;
export const PRESS_LIMIT_MS = 5000;
// A STOP that works is confirmed sooner.
const STOP_AGAIN_MS = 1000;

const newPress = () => crypto.randomUUID().replaceAll("-", "");

export class Top {
  constructor(root, app) {
    this.app = app;
    // The last press of this page, until it is shown what became of it.
    this.press = null;
    const word = (name) => app.word(name);
    this.sign = element("span", { class: "sign", "aria-hidden": "true" });
    this.title = element("strong", { id: "state" });
    this.words = element("span", { class: "words" });
    this.more = button("▾", () => this.showAll(), {
      "aria-label": word("now.details"), "aria-expanded": "false", hidden: true,
    });
    this.chip = element("span", { class: "chip simulated" });
    this.age = element("p", { class: "age", role: "status", hidden: true });
    this.band = element(
      "div",
      { class: "band" },
      this.sign,
      element("div", { role: "status" }, this.title, this.chip, this.words),
      this.more,
    );
    this.pause = button("", () => this.pauseOrResume(), { id: "pause", hidden: true });
    this.start = button(word("commands.start"), () => this.begin(), { id: "start", hidden: true });
    const note = element("small", { id: "stop-note" }, word("commands.not_emergency"));
    this.stop = button(word("commands.stop"), () => this.stopNow(),
      { id: "stop", "aria-describedby": note.id });
    this.warning = document.getElementById("stop-warning");
    this.said = element("p", { class: "said", role: "status" });
    this.remote = element("p", { class: "remote" });
    this.bar = element(
      "div",
      { class: "bar" },
      this.band,
      element(
        "div",
        { class: "commands" },
        this.start,
        this.pause,
        element("div", { class: "stop" }, this.stop, note),
      ),
    );
    root.replaceChildren(
      this.bar,
      this.age,
      this.said,
      this.remote,
    );
    for (const [press] of app.stops) this.repeatStop(press);
  }

  get stale() {
    return this.app.live.ageMs() > STALE_MS;
  }

  update(state) {
    const { band, robot, can } = state;
    if (!band) return;
    this.band.dataset.level = band.level;
    write(this.sign, SIGNS[band.level] ?? "?");
    write(this.title, robot.name ? `${robot.name}: ${band.title}` : band.title);
    const words = band.left || band.message;
    write(this.words, band.asked ? `${words.replace(/\.$/, "")}. ${band.asked}` : words);
    write(this.chip, this.app.word("now.simulated"));
    this.chip.hidden = !robot.simulated;
    const { paused } = state.job;
    write(this.pause, this.app.word(paused ? "commands.resume" : "commands.pause"));
    this.pause.hidden = !(state.job.running && (!paused || this.app.mayOperate));
    this.start.hidden = !this.app.mayOperate || !can.start;
    this.stop.hidden = !can.stop;
    this.showCommand(state);
    if (!state.stop_open) this.endStop(state.command?.press);
    this.tick();
  }

  // A telephone cuts the words of the band.
  showAll() {
    const isOpen = this.words.classList.toggle("whole");
    this.more.setAttribute("aria-expanded", isOpen);
    write(this.more, isOpen ? "▴" : "▾");
  }

  // What time and the width alone change.
  tick() {
    const { scrollHeight, clientHeight, classList } = this.words;
    this.more.hidden = scrollHeight <= clientHeight && !classList.contains("whole");
    const { state } = this.app.live;
    const ageMs = this.app.live.ageMs();
    const { stale } = this;
    document.body.classList.toggle("stale", stale);
    this.age.hidden = !stale;
    if (stale)
      write(
        this.age,
        Number.isFinite(ageMs)
          ? this.app.word("shell.stale", { seconds: Math.floor(ageMs / 1000) })
          : this.app.word("shell.connecting"),
      );
    this.showWarning(this.warningOf(state));
    if (!state.can) return;
    const inControl = this.app.inControl;
    const paused = state.job.paused;
    const waits = stale || this.app.stops.length > 0;
    this.pause.disabled = waits || (paused ? !(state.can.resume && inControl) : !state.can.pause);
    this.start.disabled = waits || !inControl;
    this.showRemote(state);
  }

  // Of a STOP of this page that is late, or of anybody's that the main control does not answer.
  warningOf({ stop_warning: warning, stop_open: isOpen, command }) {
    const isLate = this.app.stops.some(([, pressedMs]) => nowMs() - pressedMs > STOP_AGAIN_MS);
    if (!isLate && !(isOpen && command?.outcome === "unknown")) return warning;
    return { title: this.app.word("commands.stop_alarm"), text: warning?.text ?? "" };
  }

  // What is asked covers the page: then it is there.
  showWarning(warning) {
    const above = document.querySelector("dialog h2") ?? this.bar;
    if (above.nextElementSibling !== this.warning) above.after(this.warning);
    const key = JSON.stringify(warning);
    if (key === this.warningKey) return;
    this.warningKey = key;
    this.warning.hidden = !warning;
    this.warning.replaceChildren(
      ...(warning ? [element("strong", {}, warning.title), " ", warning.text] : []));
  }

  showRemote({ remote, control }) {
    if (!this.app.mayOperate) {
      this.remote.hidden = true;
      return;
    }
    this.remote.hidden = false;
    const { app } = this;
    const parts = [];
    if (remote.armed && remote.until_ms !== null) {
      const seconds = Math.floor(app.live.secondsUntil(remote.until_ms));
      const time = `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
      parts.push(app.word("commands.armed", { time }));
    } else parts.push(remote.obstacle);
    const { holder, asked } = control;
    if (app.inControl) parts.push(app.word("control.you"));
    else if (holder) parts.push(app.word("control.other", { name: holder.name }));
    else parts.push(app.word("control.nobody"));
    parts.push(
      asked ? app.word("control.asked", { name: asked.name, seconds: asked.passes_s }) : "");
    // The buttons stay while time alone changes: else a press or the focus is lost.
    const key = JSON.stringify([holder, asked?.mark, app.inControl]);
    if (key !== this.remoteKey) {
      this.remoteKey = key;
      this.remoteTexts = parts.map(() => element("span"));
      this.remote.replaceChildren(...this.remoteTexts.flatMap((one) => [one, " "]),
        ...this.remoteButtons(holder, asked));
    }
    parts[0] = parts[0].replace(/([^.!?])$/, "$1.");
    parts.forEach((text, number) => write(this.remoteTexts[number], text));
  }

  remoteButtons(holder, asked) {
    const { app } = this;
    const send = (path, values) => () => app.post(path, values).catch((error) => app.report(error));
    if (app.inControl && asked)
      return [
        button(app.word("control.pass", { name: asked.name }),
          send("/api/control/pass", { mark: asked.mark })),
        button(app.word("control.keep"), send("/api/control/keep")),
      ];
    if (app.inControl) return [button(app.word("control.release"), send("/api/control/release"))];
    const text = holder
      ? app.word("control.ask", { name: holder.name })
      : app.word("control.take");
    return [button(text, send("/api/control/take"), { id: "take" })];
  }

  async pauseOrResume() {
    const { state } = this.app.live;
    if (!state.job.paused) {
      await this.send("pause", {});
      return;
    }
    const { survey } = state.job;
    const title = this.app.word("commands.confirm_resume");
    if (await ask(this.app, title, [element("p", {}, state.job.name || survey)], this.pause.textContent))
      await this.send("resume", { survey });
  }

  async begin() {
    const { plan } = this.app.live.state.remote;
    if (!plan) return;
    const rows = plan.rows.map(([name, value]) =>
      element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, value)));
    const lines = [
      element("table", { class: "table" }, ...rows),
      plan.doubt ? element("p", { class: "warn" }, plan.doubt) : null,
      element("p", { class: "danger" }, plan.warning),
    ].filter(Boolean);
    const title = this.app.word("commands.confirm_start");
    if (await ask(this.app, title, lines, this.app.word("commands.start")))
      await this.send("start", { plan: plan.id });
  }

  // Sent once: only the state says whether a command arrived whose answer was lost.
  async send(name, values) {
    const press = newPress();
    // By the robot's clock: what is delivered long after it, or after a STOP, is refused.
    const given = { press, pressed_ms: this.app.live.robotMs, ...values };
    const command = this.app.word(`commands.${name}`);
    this.press = press;
    this.say(this.app.word("commands.sent", { command }));
    try {
      await this.app.server.ask("POST", `/api/${name}`, given, PRESS_LIMIT_MS);
    } catch (error) {
      if (this.press === press)
        this.say(error.status ? "" : this.app.word("commands.lost", { command }));
      if (error.status) this.app.report(error);
    }
  }

  stopNow() {
    const press = newPress();
    // The browser has few connections to one computer: none of them is for something else.
    this.app.server.drop();
    this.repeatStop(press);
    this.app.stops = [...this.app.stops, [press, nowMs()]];
    this.tick();
  }

  // STOP moves nothing: it is sent until it is confirmed, whatever else is pressed. Answered is too
  // little: the node may end before it has passed it on.
  async repeatStop(press) {
    const { app } = this;
    this.press = press;
    this.text = app.word("commands.sent", { command: app.word("commands.stop") });
    write(this.said, this.text);
    do {
      try {
        const { confirmed } = await app.server.ask("POST", "/api/stop", { press }, PRESS_LIMIT_MS);
        if (confirmed) this.endStop(press);
      } catch (error) {
        // Nobody logged in, not allowed: another try changes nothing.
        if ([401, 403].includes(error.status)) return app.report(error);
        this.say(this.text);
        app.server.drop();
      }
      await new Promise((resolve) => setTimeout(resolve, STOP_AGAIN_MS));
    } while (app.stops.some(([one]) => one === press));
  }

  // The answer and the document both say that it is confirmed, and with it those before it.
  endStop(press) {
    const place = this.app.stops.findIndex(([one]) => one === press);
    if (place < 0) return;
    this.app.stops = this.app.stops.slice(place + 1);
    this.say(this.text);
  }

  // Nothing hides that a STOP is not confirmed: until then it waits.
  say(text) {
    this.text = text;
    write(this.said, this.app.stops.length ? this.app.word("commands.stop_open") : text);
  }

  showCommand({ command }) {
    const shown = JSON.stringify(command);
    if (shown === this.shownCommand) return;
    const isOld = this.shownCommand === undefined && command?.press !== this.press;
    this.shownCommand = shown;
    // What was done before this page was opened is over: it is not shown.
    if (!command || isOld) return;
    if (command.press === this.press) this.press = null;
    const name = this.app.word(`commands.${command.request}`);
    const ofStop = `shell.stop_${command.outcome}`;
    const isOfStop = command.request === "stop" && ofStop in this.app.words;
    const said = this.app.word(isOfStop ? ofStop : `commands.${command.outcome}`, { command: name });
    this.say([`${command.name}: ${said}.`, command.text].filter(Boolean).join(" "));
  }
}
