// Far away: a wrong token is refused at once, and a slow link shows what is new.

import { RawPage } from "./raw_page.mjs";
import { slowLink } from "./throttle.mjs";
import { until } from "./visloc.mjs";

const SLOW_BYTES = 100_000 / 8;
/** The first seconds on a slow link are those of the scene. */
const FIRST_SECS = 8;
const WATCHED_SECS = 15;
const MOST_SECS = 2;

const sleep = (secs) => new Promise((resolve) => { setTimeout(resolve, 1000 * secs); });

/** Pages and desks with a wrong token are told so within a second. */
export async function wrongToken(browser, programs, check) {
  const robot = await programs.start(/--connect (\S+)/, "localize", "sim:tour", "--publish", "127.0.0.1:0", "--token", "right");
  const page = await browser.newPage();
  await page.goto(`http://${robot}/?token=wrong`);
  const opened = performance.now();
  await until(page, () => document.querySelector("#link").textContent === "refused" && document.querySelector("#veil form input"));
  const secs = (performance.now() - opened) / 1000;
  check(secs < 1, `a page with a wrong token is refused after ${secs.toFixed(2)} s`);
  await page.fill("#veil input", "right");
  await page.click("#veil button");
  await until(page, () => window.studio.store.state?.number >= 0);
  check(true, "and opens with the right one");
  await page.close();
  const desk = await RawPage.open(await programs.studio("--connect", robot, "--token", "wrong"));
  const asked = performance.now();
  while (!desk.latest?.notice?.includes("token") && performance.now() - asked < 5000) await sleep(0.02);
  const told = (performance.now() - asked) / 1000;
  check(told < 1, `a desk with a wrong token is told after ${told.toFixed(2)} s: ${desk.latest?.notice}`);
  desk.close();
}

/** On 100 kbit/s the newest state that is shown is at most 2 s old. */
export async function slow(programs, check) {
  const address = await programs.studio("--scene", "robocup-2010");
  const link = await slowLink(Number(new URL(address).port), SLOW_BYTES);
  const near = await RawPage.open(address);
  const far = await RawPage.open(address.replace(/:\d+/, `:${link.port}`));
  await sleep(FIRST_SECS);
  let most = 0;
  const start = far.updates.length;
  for (let i = 0; i < 10 * WATCHED_SECS; i += 1) {
    await sleep(0.1);
    most = Math.max(most, near.latest.secs - (far.latest?.secs ?? -Infinity));
  }
  check(most < MOST_SECS, `on a link of 100 kbit/s the newest state is at most ${most.toFixed(1)} s old (${far.updates.length - start} in ${WATCHED_SECS} s)`);
  near.close();
  far.close();
  link.close();
}
