// A field above the page of messages that hides every message that does not fit its words.
document.addEventListener("DOMContentLoaded", () => {
  if (!document.querySelector("#messages")) return;
  const title = document.querySelector(".md-content h1");
  const messages = [...document.querySelectorAll(".md-content article > ul > li")];
  const others = [...document.querySelectorAll(".md-content article > :not(h1):not(ul)")];
  const field = document.createElement("input");
  field.type = "search";
  field.className = "gpr20-find";
  field.placeholder = "Type a code or words of what to do · Escriba un código o palabras";
  title.after(field);
  const plain = (text) => text.toLowerCase().normalize("NFD").replace(/[\u0300-\u036f]/g, "");
  // Values stand for themselves in a message, and as names on the page.
  const words = (text) => plain(text).match(/[a-z]+/g) || [];
  const known = messages.map((one) => new Set(words(one.textContent)));
  const show = () => {
    const wanted = words(field.value);
    const fits = known.map((one) => wanted.filter((word, at) => one.has(word) ||
      (at === wanted.length - 1 && [...one].some((longer) => longer.startsWith(word)))).length);
    // The best ones: some words of a message are values, such as the name of a survey.
    const best = Math.max(...fits);
    messages.forEach((one, at) => {
      one.classList.toggle("gpr20-hidden", wanted.length > 0 && (!best || fits[at] < best));
    });
    others.forEach((one) => one.classList.toggle("gpr20-hidden", wanted.length > 0));
  };
  field.addEventListener("input", show);
  field.value = decodeURIComponent(location.hash.split("#find=")[1] || "");
  show();
  field.focus();
});
