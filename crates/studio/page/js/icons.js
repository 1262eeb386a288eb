// Icons as paths of a 16 x 16 grid.

const PATHS = {
  play: "M4 2.5v11l9-5.5z",
  pause: "M3.5 2.5h3v11h-3zM9.5 2.5h3v11h-3z",
  step: "M3 2.5v11l7-5.5zM11 2.5h2v11h-2z",
  open: "M1 3h5l1.5 2H15v8H1zM3 7v4h10V7z",
  more: "M2 3h12v2H2zM2 7h12v2H2zM2 11h12v2H2z",
  draw: "M1 1h14v2H3v10h10V9h2v6H1zM6 8l7-6 2 2-6 7-3 1z",
  theme: "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1zm0 2v10A5 5 0 0 1 8 3z",
};

export function setIcon(element, name) {
  if (element.dataset.icon === name) return;
  element.dataset.icon = name;
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", PATHS[name]);
  svg.append(path);
  element.replaceChildren(svg);
}
