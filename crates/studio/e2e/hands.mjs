// By touch on a phone, and by keys alone: what a mouse can do, fingers and keys can do as well.

import { SCREENS } from "./screens.mjs";
import { send, state, until } from "./visloc.mjs";

/** Where something of the world is on the page, pixels. */
const placeOf = (page, point) => page.evaluate(([x, y]) => {
  const m = window.studio.view.camera.clipFromWorld();
  const w = m[3] * x + m[7] * y + m[15];
  const box = document.querySelector("#world").getBoundingClientRect();
  return [box.left + ((m[0] * x + m[4] * y + m[12]) / w + 1) * box.width / 2,
    box.top + (1 - (m[1] * x + m[5] * y + m[13]) / w) * box.height / 2];
}, point);

/** Has the robot walk around, whatever others have done with it before. */
async function walking(page) {
  await send(page, "autopilot", { is_on: true });
  await until(page, () => window.studio.store.state.controls.is_autopilot);
}

const isDown = (page) => until(page, () => window.studio.store.state.truth.height_m === 0);
const moved = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
const pose = async (page) => (await state(page)).truth.pose;

/** Fingers on a page: each is a list of places over time. */
async function fingers(page, ways, { holdMs = 0 } = {}) {
  const client = await page.context().newCDPSession(page);
  const touch = (type, k) => client.send("Input.dispatchTouchEvent", {
    type, touchPoints: type === "touchEnd" ? [] : ways.map((way, id) => ({ x: way[k][0], y: way[k][1], id })),
  });
  await touch("touchStart", 0);
  for (let k = 1; k < ways[0].length; k += 1) await touch("touchMove", k);
  await page.waitForTimeout(holdMs);
  await touch("touchEnd");
  await client.detach();
}

const line = ([x0, y0], [x1, y1], count = 12) => (
  Array.from({ length: count + 1 }, (_, i) => [x0 + (x1 - x0) * i / count, y0 + (y1 - y0) * i / count]));

/** Drags, drives, turns the view and kidnaps with fingers on a phone. */
export async function touches(open, check) {
  const page = await open(SCREENS["390x844"]);
  await walking(page);
  await page.tap("#autopilot");
  await until(page, () => !window.studio.store.state.controls.is_autopilot);
  await page.tap("[data-view=top]");
  await page.waitForTimeout(300);
  const before = await pose(page);
  const from = await placeOf(page, before);
  const to = await placeOf(page, [before[0] > 0 ? before[0] - 1.5 : before[0] + 1.5, before[1]]);
  const carried = until(page, () => window.studio.store.state.truth.height_m > 0.2);
  await fingers(page, [line(from, to)], { holdMs: 600 });
  await carried;
  await isDown(page);
  check(moved(await pose(page), before) > 1, `a finger carries the robot (${moved(await pose(page), before).toFixed(2)} m)`);
  await page.locator("[aria-label=Ahead]").scrollIntoViewIfNeeded();
  const start = await pose(page);
  const box = await page.locator("[aria-label=Ahead]").boundingBox();
  await fingers(page, [[[box.x + box.width / 2, box.y + box.height / 2]]], { holdMs: 2500 });
  const driven = moved(await pose(page), start);
  check(driven > 0.1, `a thumb on the pad drives it (${driven.toFixed(2)} m)`);
  await page.waitForTimeout(800);
  const rest = await pose(page);
  await page.waitForTimeout(500);
  check(moved(await pose(page), rest) < 0.05, "and it stops when the thumb leaves");
  const slider = page.locator("[aria-label='Head to the left']");
  await slider.scrollIntoViewIfNeeded();
  const rail = await slider.boundingBox();
  const onRail = (share) => [rail.x + rail.width * share, rail.y + rail.height / 2];
  await fingers(page, [line(onRail(0.5), onRail(0.85))]);
  await until(page, () => window.studio.store.state.controls.head?.[0] > 30);
  check(true, "a thumb moves the head by its slider");
  const view = await page.evaluate(() => window.studio.view.camera.distance);
  const middle = await placeOf(page, [0, 1.2]);
  await fingers(page, [line([middle[0] - 20, middle[1]], [middle[0] - 90, middle[1]]), line([middle[0] + 20, middle[1]], [middle[0] + 90, middle[1]])]);
  check(await page.evaluate(() => window.studio.view.camera.distance) < 0.6 * view, "two fingers zoom");
  await page.tap("#kidnap");
  await until(page, () => window.studio.store.state.controls.is_held);
  await isDown(page);
  check(true, "a tap kidnaps it");
  const wide = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  check(wide[0] <= wide[1], `nothing is wider than the phone (${wide})`);
  await page.context().close();
}

/** Everything that a mouse does, by keys. */
export async function keys(open, check) {
  const page = await open();
  const press = async (...all) => { for (const key of all) await page.keyboard.press(key); };
  await walking(page);
  await page.locator("#world").focus();
  await press("p");
  await until(page, () => !window.studio.store.state.controls.is_autopilot);
  const before = await pose(page);
  await press("x", "Shift+ArrowUp", "Shift+ArrowRight", "Shift+ArrowRight", "ArrowLeft", "q", "q");
  const aim = await page.evaluate(() => window.studio.store.aim);
  await press("Shift+Enter");
  await until(page, (y) => window.studio.store.state.truth.height_m === 0 && Math.hypot(window.studio.store.state.truth.pose[0] - y[0],
    window.studio.store.state.truth.pose[1] - y[1]) < 0.15, aim);
  check(moved(aim, before) > 0.5, `keys choose a place and carry the robot there (${moved(aim, before).toFixed(2)} m)`);
  await press("x", "Shift+ArrowLeft", "Enter");
  await until(page, () => window.studio.store.state.controls.target);
  check(true, "and send it to a place");
  const look = () => page.evaluate(() => {
    const { distance, azimuth, elevation, target } = window.studio.view.camera;
    return { distance, azimuth, elevation, x: target[0] };
  });
  const views = [await look()];
  for (const key of ["+", "[", "PageDown", "Shift+ArrowLeft"]) {
    await press(key);
    views.push(await look());
  }
  check(views[1].distance < views[0].distance && views[2].azimuth !== views[1].azimuth && views[3].elevation !== views[2].elevation
    && views[4].x !== views[3].x, "keys zoom, turn, tilt and move the view");
  await press("2");
  check(await page.locator("[data-view=top]").getAttribute("aria-pressed") === "true", "and choose one");
  const start = await pose(page);
  await page.keyboard.down("w");
  await page.waitForTimeout(1500);
  await page.keyboard.up("w");
  check(moved(await pose(page), start) > 0.05, "keys drive");
  await press("c");
  await until(page, () => window.studio.store.state.controls.is_covered);
  await press("c", "l");
  await until(page, () => window.studio.store.state.controls.is_held);
  await press("l", "m");
  await until(page, () => window.studio.store.arrays.likelihood);
  check(true, "keys cover, lift, put down and show the likelihood");
  await press("m", "k");
  await until(page, () => window.studio.store.state.controls.is_held);
  check(true, "a key kidnaps");
  await press("?");
  check(await page.locator("#help-dialog").isVisible(), "a key opens the help");
  await press("Escape");
  await everyControlHasFocus(page, check);
  await page.context().close();
}

/** Tab reaches all that can be pressed, and says what it is. */
async function everyControlHasFocus(page, check) {
  const all = await page.evaluate(() => {
    const usable = [...document.querySelectorAll("button, select, input, [role=slider], [role=tab], #world")]
      .filter((element) => element.checkVisibility() && !element.disabled && !element.closest("dialog:not([open]), .marks"));
    return usable.filter(({ tabIndex, role }) => tabIndex < 0 && role !== "tab").map(({ id, textContent }) => id || textContent);
  });
  check(all.length === 0, `everything is reached by keys ${all}`);
  const named = await page.evaluate(() => [...document.querySelectorAll("button, [role=slider], canvas")]
    .filter((element) => element.checkVisibility() && !(element.textContent.trim() || element.getAttribute("aria-label")))
    .map(({ outerHTML }) => outerHTML));
  check(named.length === 0, `and has a name ${named}`);
}
