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

// A labelled field; `input` is an attribute object of <input>, or an element.
export function field(label, input) {
  const control = input instanceof Element ? input : element("input", input);
  return element("label", { class: "field" }, element("span", {}, label), control);
}

// Write a text only where it changes: screen readers announce each change.
export function write(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

// Ask before something is done; resolves to whether it was confirmed.
export function ask(app, title, lines, yes) {
  return new Promise((resolve) => {
    const close = (answer) => {
      sheet.close();
      sheet.remove();
      resolve(answer);
    };
    const sheet = element(
      "dialog",
      { "aria-labelledby": "sheet-title", oncancel: () => close(false) },
      element("h2", { id: "sheet-title" }, title),
      ...lines,
      element(
        "div",
        { class: "row" },
        // What is asked covers the page: the robot can be stopped from here too.
        button(app.word("commands.stop"), () => {
          app.top.stopNow();
          close(false);
        }, { class: "stop-now" }),
        button(app.word("commands.cancel"), () => close(false)),
        button(yes ?? app.word("commands.confirm"), () => close(true), { class: "primary" }),
      ),
    );
    document.body.append(sheet);
    sheet.showModal();
  });
}
