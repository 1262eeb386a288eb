// Light or dark, and the colors that canvases take from the style sheet.

const KEY = "visloc-studio-theme";
const listeners = [];
const query = matchMedia("(prefers-color-scheme: light)");
let cache = {};

function stored() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}

function apply(name) {
  document.documentElement.dataset.theme = name;
  cache = {};
  for (const listener of listeners) listener();
}

export function startTheme() {
  apply(stored() ?? (query.matches ? "light" : "dark"));
  query.addEventListener("change", () => stored() ?? apply(query.matches ? "light" : "dark"));
}

export function toggleTheme() {
  const next = document.documentElement.dataset.theme === "light" ? "dark" : "light";
  try {
    localStorage.setItem(KEY, next);
  } catch {
    // Then only until the page is closed.
  }
  apply(next);
}

export function onTheme(listener) {
  listeners.push(listener);
}

/** A color of the style sheet by its name: `css("c0")`. */
export function css(name) {
  cache[name] ??= getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  return cache[name];
}

/** The same as red, green, blue and alpha from 0 to 1. */
export function rgba(name, alpha = 1) {
  return fromHex(css(name), alpha);
}

export function fromHex(hex, alpha = 1) {
  const value = Number.parseInt(hex.slice(1), 16);
  return [(value >> 16 & 255) / 255, (value >> 8 & 255) / 255, (value & 255) / 255, alpha];
}

export const isLight = () => document.documentElement.dataset.theme === "light";
