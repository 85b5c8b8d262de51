// Requests to the robot's computer, and the state that it sends as it changes.

"use strict";

const REQUEST_LIMIT_MS = 30000;
const SAVE_LIMIT_MS = 3600000;
const AGAIN_MS = 2000;
// A connection that was silent for so long is made again: TCP waits ever longer.
const SILENT_MS = 10000;
// Between two messages, the two clocks of this computer differ more only if it slept, or one was set.
const SLEPT_MS = 2000;

// Also for what is kept when the page is loaded again; whoever sets the clock does not change it.
const nowMs = () => performance.timeOrigin + performance.now();

class ServerError extends Error {
  constructor(values, status) {
    super(values.error ?? "");
    this.remedy = values.remedy ?? "";
    this.code = values.code ?? "";
    this.status = status;
  }
}

class Server {
  constructor(language) {
    this.language = language;
    // What is not answered yet, and by whom it is awaited; STOP is never among it.
    this.asked = new Map();
  }

  address(path) {
    return `${path}${path.includes("?") ? "&" : "?"}language=${this.language}`;
  }

  ask(method, path, values, limitMs = REQUEST_LIMIT_MS, by = null) {
    const options = { method };
    if (method !== "GET") {
      options.headers = { "Content-Type": "application/json" };
      options.body = JSON.stringify(values ?? {});
    }
    return this.request(path, options, limitMs, by, (response) => response.json());
  }

  async request(path, options, limitMs, by, read) {
    const controller = new AbortController();
    const timer = setTimeout(() => controller.abort(), limitMs);
    if (path !== "/api/stop") this.asked.set(controller, by);
    try {
      const response = await fetch(this.address(path), { ...options, signal: controller.signal });
      if (!response.ok) throw new ServerError(await response.json(), response.status);
      return await read(response);
    } finally {
      clearTimeout(timer);
      this.asked.delete(controller);
    }
  }

  // End what one awaits, or all: a browser has few connections to one computer.
  drop(by = null) {
    for (const [one, whose] of this.asked) if (by === null || whose === by) one.abort();
  }

  // A picture; null if there is none.
  picture(path, by) {
    return this.request(path, {}, REQUEST_LIMIT_MS, by, async (response) =>
      createImageBitmap(await response.blob()),
    ).catch((error) => {
      if (error.status) return null;
      throw error;
    });
  }

  // Let the browser save what takes too long to be made for a plain link.
  async save(path) {
    const [type, blob] = await this.request(path, {}, SAVE_LIMIT_MS, null, async (response) =>
      [response.headers.get("Content-Disposition"), await response.blob()]);
    const [, name] = type.match(/filename="(.*)"/);
    const href = URL.createObjectURL(blob);
    element("a", { href, download: name }).click();
    URL.revokeObjectURL(href);
  }
}

// performance.now() may stand still while the computer sleeps; this clock may be set.
const gapMs = () => Date.now() - performance.now();

// The live document: parts come as they change, and one sign of life a second.
class Live {
  constructor(server, onChange, onEnd) {
    this.server = server;
    this.onChange = onChange;
    this.onEnd = onEnd;
    this.state = {};
    // Between the clocks of both computers, by the fastest way between them.
    this.offsetMs = Infinity;
    this.sentMs = null;
    this.open();
  }

  open() {
    this.source?.close();
    this.askedMs = performance.now();
    this.gapMs = gapMs();
    this.source = new EventSource(this.server.address("/api/live"));
    this.source.onmessage = (message) => this.take(JSON.parse(message.data));
    this.source.onerror = () => this.again(AGAIN_MS);
    this.waitFor(SILENT_MS);
  }

  waitFor(limitMs) {
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.again(0), limitMs);
  }

  async again(delayMs) {
    this.source.close();
    if (delayMs) {
      this.waitFor(delayMs);
      return;
    }
    const asked = this.server.ask("GET", "/api/me", null, SILENT_MS);
    const isOver = await asked.then(({ me }) => !me, () => false);
    if (isOver) this.onEnd();
    else if (!this.closed) this.open();
  }

  get slept() {
    return Math.abs(gapMs() - this.gapMs) > SLEPT_MS;
  }

  // Nobody knows how old what is shown, or still on its way, has become.
  wake() {
    this.sentMs = null;
    if (!this.closed) this.open();
  }

  take(changes) {
    if (this.slept) {
      this.wake();
      return;
    }
    this.gapMs = gapMs();
    this.takenMs = Date.now();
    this.sentMs = changes.sent_ms;
    // It was sent after it was asked for: if not, the clock of the robot's computer began again.
    if (this.askedMs - this.sentMs > this.offsetMs) this.offsetMs = Infinity;
    this.offsetMs = Math.min(this.offsetMs, performance.now() - this.sentMs);
    this.waitFor(SILENT_MS);
    delete changes.sent_ms;
    Object.assign(this.state, changes);
    this.onChange(this.state, changes);
  }

  // How old what is shown is [ms]; also of what was long on its way.
  ageMs() {
    if (this.sentMs === null) return Infinity;
    return Math.max(performance.now() - this.sentMs - this.offsetMs, Date.now() - this.takenMs);
  }

  // The robot's clock.
  get robotMs() {
    return performance.now() - this.offsetMs;
  }

  // Time until a moment of the robot's clock [s].
  secondsUntil(untilMs) {
    return Math.max(0, (untilMs - this.robotMs) / 1000);
  }

  // The browser may keep a page that was left, with its connection.
  rest() {
    clearTimeout(this.waiting);
    this.source.close();
  }

  close() {
    this.closed = true;
    this.rest();
  }
}
