// Elements without HTML in strings: what people have written stays text. And pictures with axes.

"use strict";

const REACH_PX = 24;
const MARGIN_PX = 38;
const BAR_PX = 48;
const TOP_PX = 6;
const LEAST_PX = 140;
const HIGHEST = 0.6;

// Attributes: on... are listeners, false and null are left out, true is an empty one.
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined)
      made.setAttribute(name, value);
  }
  made.append(...children.flat().filter((one) => one !== null && one !== undefined && one !== ""));
  return made;
}

function button(text, onclick, attributes = {}) {
  return element("button", { type: "button", onclick, ...attributes }, text);
}

// Write a text only where it changes: screen readers announce each change.
function write(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

// Fill in the words of a part of index.html; return its named elements.
function parts(root, app) {
  for (const one of root.querySelectorAll("[data-word]"))
    one.textContent = app.word(one.dataset.word);
  for (const one of root.querySelectorAll("[data-label]"))
    one.setAttribute("aria-label", app.word(one.dataset.label));
  const named = [...root.querySelectorAll("[data-part]")];
  return Object.fromEntries(named.map((one) => [one.dataset.part, one]));
}

// Show a template of index.html at the end of an element; return its named elements.
function show(name, root, app) {
  const content = document.getElementById(name).content.cloneNode(true);
  const found = parts(content, app);
  root.append(content);
  return found;
}

// Ask before something is done; resolves to whether it was confirmed.
function ask(app, title, lines, yes) {
  return new Promise((resolve) => {
    const asked = show("ask", document.body, app);
    const close = (answer) => {
      asked.sheet.close();
      asked.sheet.remove();
      resolve(answer);
    };
    write(asked.title, title);
    asked.lines.append(...lines);
    write(asked.yes, yes);
    asked.sheet.oncancel = () => close(false);
    asked.stop.onclick = () => {
      app.top.stopNow();
      close(false);
    };
    asked.no.onclick = () => close(false);
    asked.yes.onclick = () => close(true);
    asked.sheet.showModal();
  });
}

const ink = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// A picture on a canvas with its axes, in mm; the second one goes up, or down for depths.
class Plot {
  constructor(label, down, onPlace, onKey, shown) {
    Object.assign(this, { down, shown });
    this.canvas = element("canvas", {
      tabindex: 0, role: "application", "aria-label": label,
      onclick: (event) => this.extent && onPlace(...this.place(event.offsetX, event.offsetY)),
      onkeydown: onKey,
    });
  }

  begin(extent) {
    const [left, right, low, high] = extent;
    const width = this.canvas.clientWidth || 300;
    const room = width - MARGIN_PX - BAR_PX;
    const wanted = this.down ? 0.6 * room : (room * (high - low)) / (right - left);
    const most = HIGHEST * window.innerHeight;
    const height = Math.round(Math.min(most, Math.max(LEAST_PX, wanted + MARGIN_PX + TOP_PX)));
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.pen = this.canvas.getContext("2d");
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.imageSmoothingEnabled = false;
    this.pen.font = "13px system-ui, sans-serif";
    this.scale = [room / (right - left), (height - MARGIN_PX - TOP_PX) / (high - low)];
    // From above it is true to scale.
    if (!this.down) this.scale.fill(Math.min(...this.scale));
    this.extent = extent;
  }

  at(across, second) {
    const [left, , low, high] = this.extent;
    const from = this.down ? second - low : high - second;
    return [MARGIN_PX + (across - left) * this.scale[0], TOP_PX + from * this.scale[1]];
  }

  place(x, y) {
    const [left, , low, high] = this.extent;
    const from = (y - TOP_PX) / this.scale[1];
    return [left + (x - MARGIN_PX) / this.scale[0], this.down ? low + from : high - from];
  }

  near(across, second, marks) {
    const [x, y] = this.at(across, second);
    const away = ({ at }) => Math.hypot(this.at(...at)[0] - x, this.at(...at)[1] - y);
    return marks.filter((one) => away(one) < REACH_PX).sort((a, b) => away(a) - away(b))[0];
  }

  box([left, right, low, high]) {
    const [x, y] = this.at(left, this.down ? low : high);
    return [x, y, (right - left) * this.scale[0], (high - low) * this.scale[1]];
  }

  image(image, extent) {
    if (image && extent) this.pen.drawImage(image, ...this.box(extent));
  }

  // A line with a rim in the colour of the paper: it is seen on every shade.
  stroke(colour, path, dash = []) {
    this.pen.setLineDash(dash);
    for (const [style, width] of [["mark-paper", 5], [colour, 2]]) {
      Object.assign(this.pen, { strokeStyle: ink(style), lineWidth: width });
      this.pen.beginPath();
      path(this.pen);
      this.pen.stroke();
    }
    this.pen.setLineDash([]);
  }

  ring(across, second, radius, colour, dash) {
    const [x, y] = this.at(across, second);
    this.stroke(colour, (pen) => pen.arc(x, y, radius, 0, 2 * Math.PI), dash);
  }

  line(colour, ...points) {
    this.stroke(colour, (pen) => points.forEach((one) => pen.lineTo(...one)));
  }

  text(text, x, y, align = "center") {
    Object.assign(this.pen, { textAlign: align, textBaseline: "middle", fillStyle: ink("mark-paper") });
    const wide = this.pen.measureText(this.shown(text)).width;
    const left = { left: x, center: x - wide / 2, right: x - wide }[align];
    this.pen.fillRect(left - 2, y - 8, wide + 4, 16);
    this.pen.fillStyle = ink("mark-ink");
    this.pen.fillText(this.shown(text), x, y);
  }

  // Dots where nothing was measured, dashes where it is not here yet.
  fill(extent, colour, dotPx) {
    const [x, y, width, height] = this.box(extent);
    this.pen.fillStyle = ink(colour);
    for (let row = 3; row < height; row += 8)
      for (let column = 1; column < width; column += 8)
        this.pen.fillRect(x + column, y + row, dotPx, 2);
  }

  mark({ at, number, candidate, doubtful, near }) {
    const [x, y] = this.at(...at);
    if (candidate) {
      if (near) this.text(number, x, y);
      this.ring(...at, near ? 12 : 5, "mark-candidate", doubtful ? [4, 3] : []);
    } else this.line("mark-marker", [x, y], [x, y - 22], [x + 12, y - 16], [x, y - 10]);
  }

  cross(across, second, colour, arm) {
    const [x, y] = this.at(across, second);
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]])
      this.line(colour, [x + 5 * dx, y + 5 * dy], [x + arm * dx, y + arm * dy]);
  }

  axes([across, second]) {
    const [left, right, low, high] = this.extent;
    const [x, y, width, height] = this.box(this.extent);
    Object.assign(this.pen, { strokeStyle: ink("mark-border"), lineWidth: 1 });
    this.pen.strokeRect(x, y, width, height);
    for (const one of ticks(left, right, width / 60))
      this.text(one, this.at(one, low)[0], y + height + 9);
    for (const one of ticks(low, high, height / 30)) this.text(one, x - 4, this.at(left, one)[1], "right");
    this.text(across, x + width / 2, y + height + 24);
    this.text(second, x + 6, y + 12, "left");
  }

  // What the colours mean, the strongest at the top.
  bar(image, levels) {
    if (!image) return;
    const [x, y, width, height] = this.box(this.extent);
    const left = x + width + 8;
    this.pen.drawImage(image, left, y, 10, height);
    let last = Infinity;
    for (const [level, part] of levels) {
      const at = y + (1 - part) * height;
      if (last - at > 14) this.text(level, left + 13, (last = at), "left");
    }
    this.text("dB", left, y + height + 24, "left");
  }
}

function ticks(low, high, most) {
  const least = (high - low) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(least));
  const step = power * [1, 2, 5, 10].find((one) => one * power >= least);
  const found = [];
  for (let one = Math.ceil(low / step); one * step <= high; one++)
    found.push(Number((one * step).toPrecision(12)));
  return found;
}
