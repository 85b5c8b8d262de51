// A field above the page of messages that hides every message that does not fit its words.
document.addEventListener("DOMContentLoaded", () => {
  if (!document.querySelector("#messages")) return;
  const title = document.querySelector(".md-content h1");
  const rows = [...document.querySelectorAll(".md-content tbody tr")];
  const field = document.createElement("input");
  field.type = "search";
  field.className = "gpr20-find";
  field.placeholder = "Type words of the message · Escriba palabras del mensaje";
  title.after(field);
  const plain = (text) => text.toLowerCase().normalize("NFD").replace(/[\u0300-\u036f]/g, "");
  const texts = rows.map((row) => plain(row.textContent));
  field.addEventListener("input", () => {
    const words = plain(field.value).split(/\s+/).filter(Boolean);
    rows.forEach((row, at) => {
      const fits = words.every((word) => texts[at].includes(word));
      row.classList.toggle("gpr20-hidden", !fits);
    });
    for (const table of document.querySelectorAll(".md-content table")) {
      const shown = table.querySelector("tbody tr:not(.gpr20-hidden)");
      const box = table.closest(".md-typeset__scrollwrap") || table;
      box.classList.toggle("gpr20-hidden", !shown);
    }
  });
  field.focus();
});
