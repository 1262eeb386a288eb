// A first visit and a first map of one's own, as people do them, with the time that they take.

import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";

import { SCREENS } from "./screens.mjs";
import { open as openPage, state, until } from "./visloc.mjs";

/** Steps with the time that each took. */
class Watch {
  constructor() {
    this.startedAt = performance.now();
    this.steps = [];
  }

  step(what) {
    const secs = (performance.now() - this.startedAt) / 1000;
    this.steps.push(`${what} ${secs.toFixed(1)} s`);
  }

  toString() {
    return this.steps.join(", ");
  }
}

const localized = (page, most = 0.3) => until(page, (m) => {
  const { contenders, truth } = window.studio.store.state;
  return truth?.height_m === 0 && contenders?.every((c) => c.is_localized && c.error[0] < m);
}, most);

async function shot(page, pictures, name) {
  if (pictures) await page.screenshot({ path: join(pictures, name), type: "jpeg", quality: 80 });
}

/** Opens the page, kidnaps, watches, and changes a parameter. */
export async function firstVisit(browser, programs, errors, check, pictures) {
  const watch = new Watch();
  const page = await openPage(browser, await programs.studio(), errors);
  watch.step("page open at");
  await localized(page);
  watch.step("both know the place at");
  await shot(page, pictures, "studio-minute-1.jpg");
  await page.click("#kidnap");
  await until(page, () => window.studio.store.state.contenders.every((c) => !c.is_localized));
  watch.step("carried away at");
  await page.waitForTimeout(600);
  await shot(page, pictures, "studio-minute-2.jpg");
  await until(page, () => !window.studio.store.state.controls.is_held);
  await localized(page);
  watch.step("found again at");
  await shot(page, pictures, "studio-minute-3.jpg");
  await page.click("#tab-algorithms");
  await page.fill("input[type=search]", "num_particles");
  const input = page.locator("#panel-algorithms [data-path$=num_particles]").first();
  await input.fill("400");
  await input.press("Enter");
  await until(page, () => window.studio.store.state.contenders.some((c) => c.num_individuals === 400));
  watch.step("400 particles at");
  await page.context().close();
  check(true, `a first visit: ${watch}`);
}

/** A page with the editor open, and a way to press at a place of the plan. */
async function editor(browser, programs, errors, options) {
  const page = await openPage(browser, await programs.studio(), errors, options);
  if (await page.locator("#more").isVisible()) await page.click("#more");
  await page.click("#draw");
  await page.waitForSelector("#editor[open]");
  const press = async (...at) => {
    const [x, y] = await page.evaluate((point) => {
      const { left, top } = document.querySelector("#plan").getBoundingClientRect();
      const [px, py] = window.studio.editor.view.toPx(point);
      return [left + px, top + py];
    }, at);
    if (options?.hasTouch) await page.touchscreen.tap(x, y);
    else await page.mouse.click(x, y);
  };
  return [page, press];
}

const parts = (page) => page.evaluate(() => {
  const { walls, doors } = window.studio.editor.plan.data;
  return [walls.length, doors.length];
});
const says = (page, pattern) => page.waitForFunction((text) => new RegExp(text).test(document.querySelector("#plan-state").textContent), pattern.source);

/** Draws a corridor with five doors, saves it, and has robots find themselves in it. */
export async function firstMap(browser, programs, errors, check, pictures) {
  const watch = new Watch();
  const [page, press] = await editor(browser, programs, errors);
  watch.step("editor open at");
  // Not quite straight and not quite on the first corner, as by hand.
  for (const at of [[0, 0], [10.03, 0.2], [9.96, 1.85], [0.1, 2.02], [0.05, 0.06]]) await press(...at);
  await page.click("#tool-door");
  for (const at of [[1.5, 0.05], [4.2, -0.05], [7.4, 0.03], [3, 1.9], [8.2, 1.9]]) await press(...at);
  await page.fill("#plan-name", "first floor");
  await page.keyboard.press("Tab");
  await says(page, /^Fine: .* m² of floor, 5 doors/);
  watch.step("corridor with five doors at");
  check(String(await parts(page)) === "4,5", `what is drawn is checked: ${await page.locator("#plan-state").textContent()}`);
  await page.click("#fit-plan");
  await shot(page, pictures, "studio-editor.jpg");
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-plan")]);
  const file = join(programs.folder, download.suggestedFilename());
  await download.saveAs(file);
  watch.step("saved at");
  await page.click("#try-plan");
  await until(page, () => window.studio.store.scene.scene.startsWith("map-") && !document.querySelector("#editor").open);
  await localized(page);
  watch.step("found in it at");
  await page.waitForTimeout(4000);
  await shot(page, pictures, "studio-own-building.jpg");
  const { contenders } = await state(page);
  await page.context().close();
  check(true, `a first map: ${watch} (${contenders.map((c) => `${c.name} ${c.error[0].toFixed(3)} m`).join(", ")})`);
  const run = (...args) => execFileSync(programs.visloc, args, { cwd: programs.folder, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
  const checked = run("map", "check", file);
  check(checked.includes("first-floor.toml: fine"), `visloc map check: ${checked.split("\n")[0]}`);
  const scenario = join(programs.folder, "first-floor-walk.toml");
  writeFileSync(scenario, `map = "first-floor.toml"\nduration_secs = 20.0\nstart = { x_m = 1.0, y_m = 1.0, yaw_deg = 0.0 }\n[robot]\nneck_height_m = 0.42\n`
    + "[[motion]]\nwalk = { through_m = [[3.0, 1.2], [6.0, 0.8], [8.5, 1.0]], speed_m_per_s = 0.4 }\n[light]\nunevenness = 0.6\nambient = 0.5\n");
  const text = run("localize", `sim:${scenario}`);
  const error = Number(text.match(/position error, mean \/ median\s+\S+ \/ (\S+) m/)?.[1]);
  check(error < 0.1, `visloc localize on it: ${error} m (median)`);
}

/** The editor by keys alone, by touch, and its ways back. */
export async function draws(browser, programs, errors, check) {
  const [page, press] = await editor(browser, programs, errors);
  const keys = async (...all) => { for (const key of all) await page.keyboard.press(key); };
  const times = (number, key) => Array(number).fill(key);
  await press(0, 0);
  await keys(...times(5, "Shift+ArrowRight"), "Enter", ...times(2, "Shift+ArrowUp"), "Enter", ...times(5, "Shift+ArrowLeft"), "Enter",
    ...times(2, "Shift+ArrowDown"), "Enter");
  check(String(await parts(page)) === "4,0", "keys draw walls all around");
  await keys("d", ...times(2, "Shift+ArrowRight"), "Enter");
  await says(page, /^Fine: .*1 door\./);
  check(String(await parts(page)) === "4,1", "and put a door on one");
  await keys("u");
  await says(page, /to look at/);
  check((await page.locator("#plan-findings").textContent()).startsWith("no doors"), "a key leads back, and what is missing is said");
  await keys("y", "Delete");
  check(String(await parts(page)) === "4,0", "and forth; a key takes the door away");
  await keys("w");
  await press(7, 1);
  await keys("Escape");
  check(await page.locator("#editor").isVisible() && String(await parts(page)) === "4,0", "Esc ends the walls first");
  await page.setInputFiles("#plan-file", { name: "broken.toml", mimeType: "text/plain", buffer: Buffer.from("kind = \"office\"\nname = 3\n") });
  await says(page, /broken\.toml, line 2/);
  check(String(await parts(page)) === "4,0", `a file that cannot be read changes nothing: ${await page.locator("#plan-state").textContent()}`);
  const office = execFileSync(programs.visloc, ["map", "show", "office"]);
  await page.setInputFiles("#plan-file", { name: "office.toml", mimeType: "text/plain", buffer: office });
  await says(page, /^Fine: .*21 doors/);
  check((await parts(page))[1] === 21, "a building is loaded");
  await keys("u");
  check((await parts(page))[1] === 0, "and undone");
  await keys("Escape");
  check(await page.locator("#editor").isHidden(), "Esc closes the editor");
  await page.context().close();
  const [phone, tap] = await editor(browser, programs, errors, SCREENS["390x844"]);
  for (const at of [[0, 0], [6, 0], [6, 2], [0, 2], [0, 0]]) await tap(...at);
  await phone.tap("#tool-door");
  await tap(2, 0);
  await says(phone, /^Fine: .*1 door\./);
  check(String(await parts(phone)) === "4,1", "fingers draw a room with a door");
  await phone.context().close();
}
