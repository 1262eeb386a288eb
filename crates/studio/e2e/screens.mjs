// Every scene on every screen, light and dark: nothing cut, nothing overlapping, all large enough for a finger, and axe's rules.
//
//     node screens.mjs PATH_TO_VISLOC [FOLDER_FOR_PICTURES]
//
// As a part of run.mjs each scene is looked at on three screens; by itself it goes through all of them and takes pictures. A third
// argument names scenes, SCREENS the screens, both with commas between.

import { execFileSync } from "node:child_process";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

import { BROWSER, Programs, open, send, until } from "./visloc.mjs";

const AXE = createRequire(import.meta.url).resolve("axe-core/axe.min.js");
const TOUCH = { hasTouch: true, isMobile: true };
export const SCREENS = {
  "360x740": { viewport: { width: 360, height: 740 }, deviceScaleFactor: 2, ...TOUCH },
  "390x844": { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, ...TOUCH },
  "740x360": { viewport: { width: 740, height: 360 }, deviceScaleFactor: 2, ...TOUCH },
  "1024x768": { viewport: { width: 1024, height: 768 }, ...TOUCH },
  "1920x1080": { viewport: { width: 1920, height: 1080 } },
  "3840x2160": { viewport: { width: 3840, height: 2160 } },
};
/** Least size of what a finger presses, pixels. */
const FINGER_PX = 44;

/** Scenes as functions that give an address; one program for each, started when it is needed. */
export function scenesOf(programs, visloc) {
  const file = join(programs.folder, "screens.mcap");
  let isRecorded = false;
  const recording = () => {
    if (!isRecorded) execFileSync(visloc, ["localize", "sim:kidnaps", "--frames", "600", "--record", file], { stdio: "ignore" });
    isRecorded = true;
    return file;
  };
  const mapOfSlam = () => {
    const map = join(programs.folder, "screens.vmap");
    execFileSync(visloc, ["slam", "sim:office-walk", "--end", "20s", "--save", map], { stdio: "ignore" });
    return map;
  };
  const four = async (page) => {
    const names = await page.evaluate(() => window.studio.store.scene.algorithms.map(({ name }) => name).slice(0, 4));
    await send(page, "algorithms", { names });
    await until(page, () => window.studio.store.state.contenders?.length === 4);
  };
  const away = async (...run) => {
    const address = await programs.start(/--connect (\S+)/, ...run, "--publish", "127.0.0.1:0", "--token", "secret");
    return programs.studio("--connect", address, "--token", "secret");
  };
  const drawn = async (page) => {
    await page.evaluate(() => window.studio.editor.open());
    await page.evaluate(() => {
      const corners = [[0, 0], [8, 0], [8, 2], [0, 2], [0, 0]];
      corners.forEach((at) => window.studio.editor.act(at));
      window.studio.editor.act([4, 5]);
      window.studio.editor.act([9, 4]);
      window.studio.editor.fit();
    });
    await page.waitForTimeout(800);
  };
  const troubled = async (page) => {
    await send(page, "link", { robot: 3, is_on: false });
    await send(page, "lie", { robot: 4, how: "inventing" });
    await until(page, () => window.studio.store.state.team?.robots[1].knows === "half" && window.studio.store.state.team.robots[2].mates.length === 0);
  };
  const recordOne = async (page) => {
    await send(page, "record", { is_on: true });
    await until(page, () => window.studio.store.state.recorder?.num_frames > 3);
    await send(page, "record", { is_on: false });
    await until(page, () => !document.querySelector("#recorded-file").hidden);
  };
  return {
    playground: { open: () => programs.studio() },
    four: { open: () => programs.studio("--scene", "robocup-2010"), prepare: four },
    office: { open: () => programs.studio("--scene", "office"), prepare: recordOne },
    team: { open: () => programs.studio("sim:team"), prepare: troubled },
    slam: { open: () => programs.studio("--scene", "sim:room"), prepare: (page) => until(page, () => window.studio.store.arrays.landmarks?.length > 900) },
    replay: { open: () => programs.studio("--replay", recording()) },
    source: { open: () => programs.studio(recording(), "--map", "robocup-spl-2010") },
    "robot-elsewhere": { open: () => away("localize", "sim:tour") },
    "robot-in-map": { open: () => away("localize", "sim:office-walk", "--map", mapOfSlam(), "--allow-drive") },
    "robot-driven": { open: () => away("localize", "sim:robocup", "--allow-drive") },
    editor: { open: () => programs.studio(), prepare: drawn, isDialog: true },
    "camera-elsewhere": { open: () => away("slam", "sim:room") },
  };
}

/** What is wrong with the layout, as sentences. */
function faultsOf({ least, wide }) {
  const faults = innerWidth === wide ? [] : [`the page is laid out for ${innerWidth} px`];
  const name = (element) => element.id || element.getAttribute("aria-label") || element.textContent.trim().slice(0, 30) || element.className || element.tagName;
  if (document.documentElement.scrollWidth > innerWidth) faults.push(`the page is ${document.documentElement.scrollWidth} px wide`);
  const isShown = (element) => element.checkVisibility({ visibilityProperty: true, opacityProperty: true }) && element.getBoundingClientRect().width > 2;
  const controls = [...document.querySelectorAll("button, select, input, [role=slider]")]
    .filter((element) => isShown(element) && !element.closest("dialog:not([open]), .marks"))
    .filter((element) => !document.querySelector("dialog[open]") || element.closest("dialog"));
  for (const control of controls) {
    const box = control.getBoundingClientRect();
    const scroller = control.closest(".events, .tabpanel");
    if (!control.closest(".events") && (box.left < -0.5 || box.right > innerWidth + 0.5)) faults.push(`${name(control)} is beyond the edge: ${box.left} to ${box.right}`);
    const label = control.closest("label")?.getBoundingClientRect() ?? box;
    const [width, height] = control.type === "checkbox" ? [label.width, label.height] : [box.width, box.height];
    if (least && (height < least - 0.5 || width < least - 0.5)) faults.push(`${name(control)} is ${width.toFixed(0)} x ${height.toFixed(0)} px`);
    if (control.scrollWidth > control.clientWidth + 1 && control.tagName === "BUTTON") faults.push(`the text of ${name(control)} is cut`);
    // What lies over its middle, once it is in sight.
    if (scroller || getComputedStyle(document.body).overflow !== "hidden") control.scrollIntoView({ block: "end", inline: "center" });
    const now = control.getBoundingClientRect();
    const [x, y] = [now.left + now.width / 2, now.top + now.height / 2];
    const top = document.elementFromPoint(x, y);
    if (!top) faults.push(`${name(control)} cannot be brought in sight`);
    else if (top !== control && !control.contains(top) && !top.contains(control)) faults.push(`${name(control)} lies below ${name(top)}`);
  }
  for (const element of document.querySelectorAll("h1, h2, p, th, td, li, label span, .legend span, .card span, .card b, #link, #time")) {
    if (!isShown(element) || element.closest("dialog:not([open]), .sr") || element.matches(".sr")) continue;
    const box = element.getBoundingClientRect();
    if (box.left < -0.5 || box.right > innerWidth + 0.5) faults.push(`"${name(element)}" is beyond the edge: ${box.left.toFixed(0)} to ${box.right.toFixed(0)}`);
    const panel = element.closest(".panel, .card, .plot, .bar")?.getBoundingClientRect();
    const isBelow = !element.closest(".tabpanel") && panel && box.bottom > panel.bottom + 0.5;
    if (isBelow) faults.push(`"${name(element)}" is cut at the lower border of its panel`);
    if (panel && (box.left < panel.left - 0.5 || box.right > panel.right + 0.5)) faults.push(`"${name(element)}" is wider than its panel`);
  }
  const layers = [...document.querySelectorAll(".card, .map-key, .words > *, .views, .actions")].filter(isShown);
  for (const [i, layer] of layers.entries()) {
    const a = layer.getBoundingClientRect();
    for (const other of layers.slice(i + 1)) {
      const b = other.getBoundingClientRect();
      const isApart = a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
      const isScrolled = [layer, other].some((one) => one.matches(".card, .map-key, .actions")) && getComputedStyle(document.body).overflow !== "hidden";
      if (!isApart && !isScrolled) faults.push(`${name(layer)} lies over ${name(other)}`);
    }
  }
  const grid = document.querySelector(".grid");
  const isCut = getComputedStyle(document.body).overflow === "hidden" && grid.scrollHeight > grid.clientHeight + 1;
  if (isCut) faults.push(`the page is cut ${grid.scrollHeight - grid.clientHeight} px above its end`);
  scrollTo(0, 0);
  return faults;
}

/** What axe finds that is serious, as sentences. */
export async function axeOf(page) {
  await page.addScriptTag({ path: AXE });
  const { violations } = await page.evaluate(() => window.axe.run(document, { rules: { "target-size": { enabled: true } } }));
  const serious = violations.filter(({ impact }) => ["serious", "critical"].includes(impact));
  return serious.map(({ id, nodes }) => `${id}: ${nodes.map(({ target, any, all }) => `${target} ${[...any, ...all].map(({ message }) => message)}`).join("; ")}`);
}

/** Looks at one scene on some screens and in some lights; gives what was wrong. */
export async function look(browser, [name, scene], screens, lights, pictures) {
  const faults = [];
  const errors = [];
  scene.address ??= await scene.open();
  for (const screen of screens) {
    for (const colorScheme of lights) {
      const options = { ...SCREENS[screen], colorScheme, bypassCSP: true };
      const page = await open(browser, scene.address, errors, options);
      await scene.prepare?.(page);
      await until(page, () => window.studio.image.bitmap);
      await page.waitForTimeout(700);
      const wide = options.viewport.width;
      // What lies below a dialog is out of reach.
      const tabs = scene.isDialog ? ["editor"] : await page.$$eval("[role=tab]", (all) => all.filter((tab) => tab.checkVisibility()).map(({ id }) => id));
      for (const tab of tabs) {
        if (!scene.isDialog) await page.click(`#${tab}`);
        await page.waitForTimeout(150);
        const where = `${name} at ${screen}, ${colorScheme}, ${tab}`;
        const least = options.hasTouch ? FINGER_PX : 0;
        faults.push(...(await page.evaluate(faultsOf, { least, wide })).map((fault) => `${where}: ${fault}`));
        faults.push(...(await axeOf(page)).map((fault) => `${where}: axe, ${fault}`));
        const isPictured = pictures && (tab === tabs[0] || (screen === "390x844" && name === "playground"));
        if (isPictured) await page.screenshot({ path: join(pictures, `${name}-${screen}-${colorScheme}${tab === tabs[0] ? "" : `-${tab}`}.png`), fullPage: true });
      }
      if (!scene.isDialog && await page.locator("#more").isVisible()) {
        await page.click("#more");
        faults.push(...(await page.evaluate(faultsOf, { least: FINGER_PX, wide })).map((fault) => `${name} at ${screen}, bar: ${fault}`));
      }
      await page.context().close();
    }
  }
  return [...faults, ...errors];
}

async function main(visloc, pictures, only) {
  const programs = new Programs(visloc);
  const browser = await chromium.launch(BROWSER);
  let num = 0;
  try {
    for (const scene of Object.entries(scenesOf(programs, visloc))) {
      if (only && !only.split(",").includes(scene[0])) continue;
      const screens = process.env.SCREENS?.split(",") ?? Object.keys(SCREENS);
      const faults = await look(browser, scene, screens, ["dark", "light"], pictures);
      console.log(`${scene[0]}: ${faults.length ? "" : "nothing wrong"}`);
      [...new Set(faults)].forEach((fault) => console.log(`  ${fault}`));
      num += faults.length;
    }
  } finally {
    await browser.close();
    programs.end();
  }
  process.exitCode = num > 0 ? 1 : 0;
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) await main(...process.argv.slice(2));
