// The band on every page: state, sign, what to do, PAUSE or RESUME, STOP, remote control.

"use strict";

const SIGNS = {
  working: "▶", paused: "‖", attention: "⚠", fault: "✖", done: "✔", rest: "■",
};
// Before 5 s: it was on its way for a while, and the tick may be late.
const STALE_MS = 4500;
const PRESS_LIMIT_MS = 5000;
// A STOP that works is confirmed sooner.
const STOP_AGAIN_MS = 1000;

const newPress = () => crypto.randomUUID().replaceAll("-", "");

class Top {
  constructor(header, bottom, app) {
    this.app = app;
    // The last press of this page, until it is shown what became of it.
    this.press = null;
    // When the robot said last whether a STOP of this page is confirmed.
    this.heardMs = -Infinity;
    // Folded on the page SURVEY, for those who may.
    const control = show("control-template", element("div"), app);
    Object.assign(this, parts(header, app), parts(bottom, app), control);
    this.control.hidden = !app.mayControl;
    this.warning = document.getElementById("stop-warning");
    this.pause.onclick = () => this.pauseOrResume();
    this.start.onclick = () => this.begin();
    this.stop.onclick = () => this.stopNow();
    this.take.onclick = () => app.act(() => app.post(`/api/control/${this.take.id}`));
    for (const [press] of app.stops) this.repeatStop(press);
  }

  update(state) {
    const { band, robot, can } = state;
    if (!band) return;
    this.band.dataset.level = band.level;
    write(this.sign, SIGNS[band.level] ?? "?");
    write(this.title, robot.name ? `${robot.name}: ${band.title}` : band.title);
    const words = band.left || band.message;
    write(this.words, band.asked ? `${words.replace(/\.$/, "")}. ${band.asked}` : words);
    this.chip.hidden = !robot.simulated;
    const { paused } = state.job;
    write(this.pause, this.app.word(paused ? "commands.resume" : "commands.pause"));
    this.pause.hidden = !(state.job.running && (!paused || this.app.mayControl));
    this.start.hidden = !this.app.mayControl || !can.start;
    this.showCommand(state);
    if (!state.stop_open) this.endStop(state.command?.press);
    this.tick();
  }

  // What time alone changes.
  tick() {
    const { app } = this;
    const { state } = app.live;
    const ageMs = app.live.ageMs();
    const isStale = ageMs > STALE_MS;
    document.body.classList.toggle("stale", isStale);
    this.age.hidden = !isStale;
    if (isStale)
      write(this.age, Number.isFinite(ageMs)
        ? app.word("shell.stale", { seconds: Math.floor(ageMs / 1000) })
        : app.word("shell.connecting"));
    this.showWarning(this.warningOf(state));
    if (!state.can) return;
    const waits = isStale || app.stops.length > 0;
    const { can, job: { paused } } = state;
    this.pause.disabled = waits || (paused ? !(can.resume && app.inControl) : !can.pause);
    this.start.disabled = waits || !app.inControl;
    this.showRemote(state);
  }

  // Of a STOP of this page of which the robot says nothing: what it has heard, it warns of itself;
  // or of anybody's that the main control does not answer.
  warningOf({ stop_warning: warning, stop_open: isOpen, command }) {
    const isSilent = nowMs() - this.heardMs > 2 * STOP_AGAIN_MS
      || this.app.live.ageMs() > STALE_MS;
    const isLate = isSilent
      && this.app.stops.some(([, pressedMs]) => nowMs() - pressedMs > STOP_AGAIN_MS);
    if (!isLate && !(isOpen && command?.outcome === "unknown")) return warning;
    return { title: this.app.word("commands.stop_alarm"), text: warning?.text ?? "" };
  }

  // What is asked covers the page: then it is there.
  showWarning(warning) {
    const above = document.querySelector("dialog h2") ?? this.band;
    if (above.nextElementSibling !== this.warning) above.after(this.warning);
    const key = JSON.stringify(warning);
    if (key === this.warningKey) return;
    this.warningKey = key;
    this.warning.hidden = !warning;
    this.warning.replaceChildren(
      ...(warning ? [element("strong", {}, warning.title), " ", warning.text] : []));
  }

  // One missing step at a time.
  showRemote({ remote, holder }) {
    const { app } = this;
    let allowed = remote.obstacle.replace(/([^.!?])$/, "$1.");
    if (remote.armed) {
      const seconds = Math.floor(app.live.secondsUntil(remote.until_ms));
      const time = `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
      allowed = app.word("commands.armed", { time });
    }
    let who = remote.armed ? app.word("commands.nobody") : "";
    if (app.inControl) who = app.word("commands.you");
    else if (holder) who = app.word("commands.other", { name: holder.name });
    write(this.allowed, allowed);
    write(this.who, who);
    this.take.id = app.inControl ? "release" : "take";
    write(this.take, app.word(`commands.${this.take.id}`));
  }

  async pauseOrResume() {
    const { paused, survey, name } = this.app.live.state.job;
    if (!paused) {
      await this.send("pause", {});
      return;
    }
    const title = this.app.word("commands.confirm_resume");
    if (await ask(this.app, title, [element("p", {}, name || survey)], this.pause.textContent))
      await this.send("resume", { survey });
  }

  async begin() {
    const { plan } = this.app.live.state.remote;
    if (!plan) return;
    const rows = plan.rows.map(([name, value]) =>
      element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, value)));
    const lines = [
      element("table", { class: "table" }, ...rows),
      plan.doubt ? element("p", { class: "warn" }, plan.doubt) : "",
      element("p", { class: "danger" }, plan.warning),
    ];
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
        this.heardMs = nowMs();
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
    const parts = [`${command.name}: ${said}.`, command.text, command.remedy];
    this.say(parts.filter(Boolean).join(" "));
  }
}
