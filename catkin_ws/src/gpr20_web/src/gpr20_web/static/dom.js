// Elements without HTML in strings: what people have written stays text.

// Attributes: on... are listeners, false and null are left out, true is an empty one.
export function element(tag, attributes = {}, ...children) {
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

export function button(text, onclick, attributes = {}) {
  return element("button", { type: "button", onclick, ...attributes }, text);
}

// Write a text only where it changes: screen readers announce each change.
export function write(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

// Fill in the words of a part of index.html; return its named elements.
export function parts(root, app) {
  for (const one of root.querySelectorAll("[data-word]"))
    one.textContent = app.word(one.dataset.word);
  for (const one of root.querySelectorAll("[data-label]"))
    one.setAttribute("aria-label", app.word(one.dataset.label));
  const named = [...root.querySelectorAll("[data-part]")];
  return Object.fromEntries(named.map((one) => [one.dataset.part, one]));
}

// Show a template of index.html at the end of an element; return its named elements.
export function show(name, root, app) {
  const content = document.getElementById(name).content.cloneNode(true);
  const found = parts(content, app);
  root.append(content);
  return found;
}

// Ask before something is done; resolves to whether it was confirmed.
export function ask(app, title, lines, yes) {
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
