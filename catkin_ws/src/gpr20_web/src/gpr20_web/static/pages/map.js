// MAP: the survey from above, with its layers, candidates and markers.

import { button, element, field, write } from "../dom.js";
import { Ground, sign } from "../ground.js";

const STATES = ["done", "partly", "missing", "failed"];
const TARGETS = ["pmn", "type-72", "fragment"];

export default {
  name: "map",

  show(root, app) {
    const ground = (this.ground = new Ground(root, app, false));
    const word = (name, values) => ground.word(name, values);
    const act = async (path, values, done = () => {}) => {
      try {
        await app.post(path, values);
        done();
        ground.poll("1");
      } catch (error) {
        app.report(error);
      }
    };
    const counts = STATES.map((one) => element("span", {}, sign(app, one), element("span", {})));
    const marks = element("ul", {});
    const text = element("input", { maxlength: 500 });
    const add = button(word("add"), () => {
      const { place: [x_mm, y_mm], depth_mm: depth } = ground.shown;
      const depth_mm = ground.choice.layer === "coverage" ? null : depth;
      const values = { x_mm, y_mm, depth_mm, text: text.value };
      act(`/api/surveys/${ground.about.folder}/markers`, values, () => (text.value = ""));
    });
    const target = element("select", {},
      ...TARGETS.map((one) => element("option", { value: one }, word(`target_${one}`))));
    const { survey } = ground.choice;
    const hide = button(word("hide"), () =>
      act("/api/ground/hide", { survey, target: target.value }));
    const cancel = button(word("cancel"), () => act("/api/ground/cancel", {}));
    const searches = app.mayControl ? [field(word("target"), target), hide, cancel] : [];
    const said = element("p", { role: "status" });
    const hiding = element("p", { class: "muted" });
    root.append(
      element("p", { class: "row" }, ...counts),
      element("div", { class: "columns" },
        element("div", { class: "card" }, element("h2", {}, word("marks")), marks,
          element("div", { class: "row" }, field(word("text"), text), add)),
        element("div", { class: "card" }, element("h2", {}, word("hiding")),
          element("div", { class: "row" }, ...searches), said, hiding)),
    );
    let key = "";
    ground.onAnswer = () => {
      const { shown, about } = ground;
      shown.counts.forEach(([state, name, count]) =>
        write(counts[STATES.indexOf(state)].lastChild, ` ${name}: ${count ?? "—"}`));
      const { running, seconds, said: stage } = about.hide;
      write(said, `${running ? word("works", { seconds }) : ""} ${stage}`.trim());
      hide.disabled = running;
      cancel.disabled = !running;
      add.disabled = !about.folder || !shown.place;
      write(hiding, shown.hiding.join(" "));
      if (key === (key = JSON.stringify(shown.marks))) return;
      const items = shown.marks.map((one) =>
        element("li", {}, button(one.lines.join(", "), () => ground.chooseMark(one))));
      marks.replaceChildren(...(items.length ? items : [element("li", {}, word("no_marks"))]));
    };
  },

  leave() {
    this.ground.end();
  },
};
