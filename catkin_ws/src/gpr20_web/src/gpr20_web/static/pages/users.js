// USERS: the accounts, for administrators, and everybody's own password.

import { ask, button, element, field, write } from "../dom.js";

const ADMIN = 3;
const ROLES = ["view", "operate", "admin"];
const path = (name) => `/api/users/${encodeURIComponent(name)}`;

const secret = (autocomplete, attributes = {}) =>
  element("input", { type: "password", autocomplete, maxlength: 200, ...attributes });
const newSecret = () => secret("new-password", { minlength: 12, required: true });

export default {
  name: "users",

  show(root, app) {
    this.app = app;
    const forms = element("div", { class: "columns" }, this.ownForm());
    if (app.me.role >= ADMIN) {
      this.rows = element("div", { role: "list" });
      root.append(this.rows);
      forms.prepend(this.addForm());
      this.act(() => app.get("/api/users"));
    }
    root.append(forms);
  },

  word(name, values) {
    return this.app.word(`users.${name}`, values);
  },

  // Every answer about accounts is the list of all of them. Returns whether it succeeded.
  async act(request) {
    try {
      const { users } = await request();
      this.rows.replaceChildren(...users.map((one) => this.row(one)));
      return true;
    } catch (error) {
      this.app.report(error);
      return false;
    }
  },

  row({ name, role, created }) {
    const label = (key) => ({ "aria-label": `${this.word(key)} ${name}` });
    const isOwn = name === this.app.me.name;
    return element(
      "div",
      { class: "card row", role: "listitem" },
      element("strong", {}, name),
      isOwn ? element("span", { class: "chip" }, this.word("you")) : "",
      element("span", {}, this.word(role)),
      element("span", { class: "muted" }, `${this.word("created")} ${this.app.moment(created)}`),
      element(
        "div",
        { class: "row" },
        button(this.word("change"), () => this.change(name, role), label("change")),
        button(this.word("remove"), () => this.remove(name), label("remove")),
      ),
    );
  },

  roles(chosen) {
    return element(
      "select",
      {},
      ...ROLES.map((one) =>
        element("option", { value: one, selected: one === chosen }, this.word(one))),
    );
  },

  async change(name, role) {
    const roles = this.roles(role);
    const password = secret("new-password");
    const lines = [
      field(this.word("role"), roles),
      field(this.word("same_password"), password),
      element("p", {}, this.word("over")),
    ];
    const title = this.word("change_user", { name });
    if (!(await ask(this.app, title, lines, this.word("change")))) return;
    const values = roles.value === role ? {} : { role: roles.value };
    if (password.value) values.password = password.value;
    if (Object.keys(values).length) this.act(() => this.app.post(path(name), values));
  },

  async remove(name) {
    const lines = [element("p", {}, this.word("over"))];
    if (await ask(this.app, this.word("remove_user", { name }), lines, this.word("remove")))
      this.act(() => this.app.remove(path(name)));
  },

  addForm() {
    const name = element("input", {
      autocomplete: "off", autocapitalize: "none", minlength: 2, maxlength: 40, required: true,
    });
    const roles = this.roles("view");
    const password = newSecret();
    const add = async (event) => {
      event.preventDefault();
      const form = event.target;
      const values = { name: name.value, role: roles.value, password: password.value };
      if (await this.act(() => this.app.post("/api/users", values))) form.reset();
    };
    return element(
      "form",
      { class: "card", onsubmit: add },
      element("h2", {}, this.word("add")),
      field(this.word("name"), name),
      field(this.word("role"), roles),
      field(this.word("new_password"), password),
      element("button", { class: "primary" }, this.word("add")),
    );
  },

  ownForm() {
    const { app } = this;
    const old = secret("current-password", { required: true });
    const password = newSecret();
    const again = newSecret();
    const said = element("p", { role: "status" });
    const check = () =>
      again.setCustomValidity(again.value === password.value ? "" : this.word("different"));
    const send = async (event) => {
      event.preventDefault();
      const form = event.target;
      write(said, "");
      try {
        const values = { old: old.value, new: password.value };
        // The browser has another session now, and with it another mark.
        Object.assign(app.me, await app.post("/api/password", values));
        write(said, this.word("changed"));
        form.reset();
      } catch (error) {
        app.report(error);
      }
    };
    return element(
      "form",
      { class: "card", onsubmit: send, oninput: check },
      element("h2", {}, this.word("own")),
      // Password managers look for whose password it is.
      element("input", { autocomplete: "username", value: app.me.name, hidden: true }),
      field(this.word("old_password"), old),
      field(this.word("new_password"), password),
      field(this.word("again"), again),
      element("button", { class: "primary" }, this.word("change_own")),
      said,
    );
  },
};
