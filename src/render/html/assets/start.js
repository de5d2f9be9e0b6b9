"use strict";
(() => {
  const theme = new URLSearchParams(location.search).get("theme");
  if (theme) document.documentElement.dataset.theme = theme;
  const data = JSON.parse(document.getElementById("scene").textContent);
  const views = [...document.querySelectorAll("figure.scene")].map((figure) => new View(figure, data));
  const redraw = () => views.forEach((view) => view.draw());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  matchMedia("print").addEventListener("change", redraw);
  document.querySelectorAll("details.section").forEach((section) => section.addEventListener("toggle", redraw));
  addEventListener("beforeprint", () => { document.querySelectorAll("details").forEach((d) => { d.open = true; }); redraw(); });
  document.querySelectorAll("nav a").forEach((link) => link.addEventListener("click", () => { document.querySelector(link.getAttribute("href")).open = true; }));
  window.elastogeo = { views };
})();
