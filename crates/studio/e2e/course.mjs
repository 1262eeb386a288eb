// Time, exports, links and parameters: what is told over the world and beside it.

import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { state, until } from "./visloc.mjs";

/** A place in a plot: its share of the time that is shown. */
async function inPlot(page, share, which = 0) {
  return page.evaluate(([k, s]) => {
    const canvas = document.querySelectorAll(".plot canvas")[k];
    canvas.scrollIntoView();
    const box = canvas.getBoundingClientRect();
    const size = Math.max(10, 0.82 * Number.parseFloat(getComputedStyle(document.documentElement).fontSize));
    const [left, right] = [box.left + 3.4 * size, box.right - 0.5 * size];
    return [left + s * (right - left), box.top + box.height / 2];
  }, [which, share]);
}

async function download(page, selector) {
  const [file] = await Promise.all([page.waitForEvent("download"), page.click(selector)]);
  return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
}

/** Looks back into a run that goes on. */
export async function looksBack(open, check) {
  const page = await open();
  await until(page, () => window.studio.store.past.length > 150);
  const [x, y] = await inPlot(page, 0.95);
  await page.mouse.move(x, y);
  await until(page, () => window.studio.time.pointed !== null);
  const told = await page.evaluate(() => [window.studio.time.pointed, window.studio.store.state.secs, document.querySelector(".at").textContent]);
  check(told[0] < told[1] && told[2].includes("values at"), `a plot tells the values at what is pointed at: ${told[2]}`);
  await page.mouse.click(x, y);
  await until(page, () => window.studio.store.isBack);
  const then = await page.evaluate(() => {
    const { state, image, arrays } = window.studio.store;
    return { secs: state.secs, number: state.number, image: image.header.number, hasArrays: Object.keys(arrays).length > 0 };
  });
  await page.waitForTimeout(600);
  const still = await page.evaluate(() => [window.studio.store.state.number, window.studio.store.latest.number]);
  check(still[0] === then.number && still[1] > then.number, `a click shows world and image of then (${then.secs.toFixed(1)} s) while the run goes on`);
  // A busy page leaves out images; the one that is shown is the last before that moment.
  check(then.image <= then.number && then.number - then.image < 60, `the image is of that moment (frame ${then.image} of ${then.number})`);
  await page.keyboard.press(",");
  await until(page, (number) => window.studio.store.state.number < number, then.number);
  check(true, "a key goes a frame back");
  await page.keyboard.press("n");
  await until(page, () => !window.studio.store.isBack);
  check(true, "and another one returns to now");
  const before = await page.evaluate(() => window.studio.time.range());
  await page.click("#zoom-in");
  const after = await page.evaluate(() => window.studio.time.range());
  check(after[1] - after[0] < 0.6 * (before[1] - before[0]), "the plots are zoomed");
  const csv = await download(page, "#save-csv");
  const lines = csv.bytes.toString().trim().split("\n");
  const columns = lines[0].split(",");
  check(columns[1] === "time [s]" && columns.length === 12 && lines.length > 30 && lines.every((line) => line.split(",").length === 12),
    `what is seen is saved as CSV: ${csv.name}, ${lines.length - 1} rows of ${columns.length}`);
  const png = await download(page, "#save-png");
  check(png.bytes.subarray(1, 4).toString() === "PNG" && png.bytes.length > 50_000, `and as a picture: ${png.name}, ${png.bytes.length >> 10} kB`);
  await page.context().close();
  return png.bytes;
}

/** One cursor through a recording, and a link to a moment of it. */
export async function goesThrough(open, address, check) {
  const page = await open(address);
  await until(page, () => window.studio.store.recording);
  const [x, y] = await inPlot(page, 0.5, 1);
  await page.mouse.click(x, y);
  await until(page, () => {
    const { state, recording } = window.studio.store;
    return !state.is_playing && Math.abs(state.number - recording.rows.length / 2) < recording.rows.length / 20;
  });
  const { number } = await state(page);
  check(Number(await page.locator(".track input").inputValue()) === number, `a click in a plot goes there, and the time line follows (frame ${number})`);
  await page.locator(".plot canvas").first().focus();
  await page.keyboard.press("ArrowRight");
  await until(page, (n) => window.studio.store.state.number === n + 1, number);
  check(true, "keys go on from there");
  await page.click("#permalink");
  const link = page.url();
  check(link.includes(`frame=${number + 1}`), `a link leads to the moment: ${link.slice(link.indexOf("#"))}`);
  await page.keyboard.press("Home");
  await page.context().close();
  const again = await open(link);
  await until(again, (n) => window.studio.store.state.number === n, number + 1);
  check(true, "and whoever opens it sees that moment");
  await again.context().close();
}

/** Parameters of all algorithms: found, refused with the reason, compared with their defaults, and saved. */
export async function parameters(open, visloc, folder, check) {
  const page = await open();
  await page.click("#tab-algorithms");
  await until(page, () => window.studio.store.scene.contenders?.length > 1 && document.querySelector("#parameters input"));
  await page.fill("input[type=search]", "num");
  const titles = await page.$$eval(".part-title", (all) => all.map(({ textContent }) => textContent));
  check(titles.length >= 2, `words are searched in all algorithms: ${titles}`);
  await page.fill("input[type=search]", "");
  await page.selectOption("#panel-algorithms .search select", "1");
  const input = page.locator("#parameters input[type=number]").first();
  const path = await input.getAttribute("data-path");
  const was = await input.inputValue();
  await input.fill("-7");
  await input.press("Enter");
  await page.waitForSelector(".parameter.is-refused .refusal");
  const reason = await page.locator(".refusal").textContent();
  check(reason.includes(was) && await page.locator("[aria-invalid=true]").inputValue() === "-7", `what is refused is marked: ${reason}`);
  const good = page.locator(`#parameters [data-path="${path}"]`);
  await good.fill(String(Number(was) + 1));
  await good.press("Enter");
  await until(page, () => document.querySelector(".parameter.is-changed") && !document.querySelector(".is-refused"));
  check(true, "a good value takes the mark away");
  await page.click("#changed-only");
  check(await page.locator(".parameter").count() === 1, "all that differs is in one view");
  const toml = await download(page, "#save-toml");
  const algorithm = toml.name.replace(".toml", "");
  const file = join(folder, toml.name);
  writeFileSync(file, toml.bytes);
  execFileSync(visloc, ["localize", "sim:tour", "--frames", "3", "--algorithm", algorithm, "--config", file], { cwd: folder, stdio: ["ignore", "ignore", "inherit"] });
  check(toml.bytes.toString().includes(path.split(".").pop()), `and is saved as ${toml.name}, which visloc takes`);
  await page.context().close();
}
