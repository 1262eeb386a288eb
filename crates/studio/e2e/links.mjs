// Stalled pages, slow links, and what an open page costs the robot. Takes long; not a part of any test run.
//
//     node links.mjs stalled VISLOC [MINUTES]     pages that stop reading; memory and frames every 10 s
//     node links.mjs slow VISLOC [MINUTES]        100 kbit/s between robot and desk, and between studio and page; age of what is shown
//     node links.mjs slowdown VISLOC [PAIRS]      time of the algorithm without and with a page
//
// Needs playwright-core and Chromium, as run.mjs.

import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { chromium } from "playwright-core";

import { RawPage } from "./raw_page.mjs";
import { slowLink } from "./throttle.mjs";
import { BROWSER } from "./visloc.mjs";

const [task, visloc, count] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "visloc-links-"));
const children = [];
const TOKEN = "links";
const SLOW_BYTES = 100_000 / 8;
const SAMPLE_SECS = 10;
/** Length of a run that is timed. */
const RUN_SECS = 20;

const sleep = (secs) => new Promise((resolve) => { setTimeout(resolve, 1000 * secs); });
const median = (values) => {
  const sorted = [...values].sort((a, b) => a - b);
  return (sorted[(sorted.length - 1) >> 1] + sorted[sorted.length >> 1]) / 2;
};

/** Starts a program and waits for the first line that a pattern is found in. */
async function start(name, args, pattern) {
  const child = spawn(visloc, args, { stdio: ["ignore", "pipe", "inherit"] });
  children.push(child);
  child.finished = new Promise((resolve) => { child.on("close", resolve); });
  const lines = createInterface({ input: child.stdout });
  const found = await new Promise((resolve, reject) => {
    lines.on("line", (line) => line.match(pattern) && resolve(line.match(pattern)));
    lines.on("close", () => reject(new Error(`${name} has not started`)));
  });
  return { name, child, found };
}

/** A studio on any free port. */
async function studio(name, ...more) {
  const { child, found } = await start(name, ["studio", "--no-open", "--port", "0", ...more], /http:\S+/);
  return { name, child, address: found[0] };
}

/** A run that is published at any free port. */
async function robot(name, secs, ...more) {
  const scenario = join(folder, `walk-${secs}.toml`);
  writeFileSync(scenario, `summary = "a long walk"\nmap = "robocup-spl-2010"\nduration_secs = ${secs}.0\n\n[[motion]]\nwander.secs = ${secs}.0\n`);
  const args = ["localize", `sim:${scenario}`, "--publish", "127.0.0.1:0", "--token", TOKEN, ...more];
  const { child, found } = await start(name, args, /--connect (\S+)/);
  return { name, child, host: found[1], port: Number(found[1].split(":")[1]), address: `http://${found[1]}/?token=${TOKEN}` };
}

/** Memory that is resident, kB. */
function memory({ child }) {
  return Number(readFileSync(`/proc/${child.pid}/status`, "utf8").match(/VmRSS:\s+(\d+)/)[1]);
}

const megabytes = (kilobytes) => (kilobytes / 1024).toFixed(1);

/** First and last memory after a minute of warming up, and how it grew between, for each program. */
function memories(programs, samples, ratePerMinute) {
  for (const program of programs) {
    const all = samples.map((sample) => sample.get(program));
    const settled = all.slice(Math.min(6, all.length - 1));
    const growth = (settled[settled.length - 1] - settled[0]) / 1024 / Math.max(1, settled.length - 1) * ratePerMinute;
    console.log(`${program.name}: ${megabytes(settled[0])} MB after a minute, ${megabytes(settled[settled.length - 1])} MB at the end, `
      + `most ${megabytes(Math.max(...all))} MB, ${growth.toFixed(2)} MB a minute`);
  }
}

async function stalled(minutes) {
  const playground = await studio("studio with stalled pages");
  const walk = 60 * minutes + 30;
  const watched = await robot("robot with a stalled page", walk);
  const alone = await robot("robot without a stalled page", walk);
  const observers = await Promise.all([playground, watched, alone].map(({ address }) => RawPage.open(address)));
  const never = await Promise.all([playground, watched].map(({ address }) => RawPage.open(address, { reads: false })));
  const browser = await chromium.launchServer(BROWSER);
  const page = await (await chromium.connect(browser.wsEndpoint())).newPage();
  await page.goto(playground.address);
  await page.waitForFunction(() => window.studio?.store.state?.number >= 0);
  const stopped = family(browser.process().pid);
  stopped.forEach((pid) => process.kill(pid, "SIGSTOP"));
  console.log(`stopped ${stopped.length} processes of the browser`);
  const programs = [playground, watched, alone];
  const samples = [];
  let before = observers.map((observer) => observer.latest.number);
  for (let i = 0; i < 60 * minutes / SAMPLE_SECS; i += 1) {
    await sleep(SAMPLE_SECS);
    samples.push(new Map(programs.map((program) => [program, memory(program)])));
    const now = observers.map((observer) => observer.latest.number);
    const rates = now.map((number, k) => ((number - before[k]) / SAMPLE_SECS).toFixed(1));
    before = now;
    const texts = programs.map((program, k) => `${megabytes(memory(program))} MB ${rates[k]} fps`);
    console.log(`${SAMPLE_SECS * (i + 1)} s: ${texts.join(" | ")} | load ${loadavg()[0].toFixed(1)}`);
  }
  memories(programs, samples, 60 / SAMPLE_SECS);
  console.log(`sockets that never read: ${never.map(({ isClosed }) => (isClosed ? "closed" : "open"))}`);
  stopped.forEach((pid) => process.kill(pid, "SIGKILL"));
}

/** A process and all below it. */
function family(pid) {
  const rows = execFileSync("ps", ["-eo", "pid=,ppid="]).toString().trim().split("\n").map((row) => row.trim().split(/\s+/).map(Number));
  const all = [pid];
  for (const parent of all) all.push(...rows.filter(([, above]) => above === parent).map(([below]) => below));
  return all;
}

async function slow(minutes) {
  const published = await robot("robot behind a slow link", 60 * minutes + 30);
  const robotLink = await slowLink(published.port, SLOW_BYTES);
  const desk = await studio("desk behind a slow link", "--connect", `127.0.0.1:${robotLink.port}`, "--token", TOKEN);
  const playground = await studio("studio with a slow page", "--scene", "robocup-2010");
  const pageLink = await slowLink(Number(new URL(playground.address).port), SLOW_BYTES);
  const slowAddress = playground.address.replace(/:\d+/, `:${pageLink.port}`);
  const ways = [
    { name: "robot to desk", near: await RawPage.open(published.address), far: await RawPage.open(desk.address) },
    { name: "studio to page", near: await RawPage.open(playground.address), far: await RawPage.open(slowAddress) },
  ];
  const programs = [published, desk, playground];
  const samples = [];
  // How far the simulation is when something of the past is shown: the near page tells.
  const ages = ways.map(() => []);
  const end = performance.now() / 1000 + 60 * minutes;
  let [nextSample, i] = [performance.now() / 1000 + SAMPLE_SECS, 0];
  let images = ways.map(() => 0);
  while (performance.now() / 1000 < end) {
    await sleep(0.1);
    ways.forEach(({ near, far }, k) => {
      if (near.latest && far.latest && !far.latest.isStale) ages[k].push(near.latest.secs - far.latest.secs);
    });
    if (performance.now() / 1000 < nextSample) continue;
    nextSample += SAMPLE_SECS;
    i += 1;
    samples.push(new Map(programs.map((program) => [program, memory(program)])));
    const texts = ways.map(({ name, far }, k) => {
      const recent = ages[k].slice(-10 * SAMPLE_SECS);
      const more = far.images - images[k];
      const most = recent.length ? Math.max(...recent).toFixed(1) : "-";
      return `${name}: age ${recent.length ? median(recent).toFixed(1) : "-"} s, most ${most} s, ${more} images`;
    });
    images = ways.map(({ far }) => far.images);
    console.log(`${SAMPLE_SECS * i} s: ${texts.join(" | ")} | ${programs.map((p) => megabytes(memory(p))).join(", ")} MB | load ${loadavg()[0].toFixed(1)}`);
  }
  for (const { name, far } of ways) {
    const after = (at) => (at - far.openedAt).toFixed(2);
    console.log(`${name}: first state ${after(far.updates.find(({ isStale }) => !isStale).at)} s, first image ${after(far.firstImageAt)} s after the page was opened`);
  }
  ways.forEach(({ name, far }, k) => {
    // The first seconds are those of the scene.
    const all = ages[k].slice(100);
    const half = all.length >> 1;
    console.log(`${name}: age median ${median(all).toFixed(1)} s, most ${Math.max(...all).toFixed(1)} s; first half ${median(all.slice(0, half)).toFixed(1)} s, `
      + `second half ${median(all.slice(half)).toFixed(1)} s; ${far.updates.length} updates, ${far.images} images in ${minutes} min`);
  });
  memories(programs, samples, 60 / SAMPLE_SECS);
}

/** Time that a program's main thread has had a processor, milliseconds; what waits for one does not count. */
function processorMs(pid, before) {
  try {
    return Number(readFileSync(`/proc/${pid}/task/${pid}/schedstat`, "utf8").split(" ")[0]) / 1e6;
  } catch {
    return before;
  }
}

/** One run of 20 s: medians of image analysis and of both, milliseconds a frame, and processor time of the thread that does it. */
async function timed(kind, browser) {
  const json = join(folder, "run.json");
  const { child, host, address } = await robot("run", RUN_SECS, "--json", json);
  let thread = 0;
  const timer = setInterval(() => { thread = processorMs(child.pid, thread); }, 50);
  if (kind === "page elsewhere") await RawPage.open(address);
  const desk = kind === "page here" ? await studio("desk", "--connect", host, "--token", TOKEN) : null;
  const page = desk && await browser.newPage();
  await page?.goto(desk.address);
  await child.finished;
  clearInterval(timer);
  await page?.close();
  desk?.child.kill();
  const result = JSON.parse(readFileSync(json));
  return { both: result.iteration_ms.median, image: result.analysis_ms.median, thread: thread / result.frames };
}

async function slowdown(pairs) {
  const browser = await chromium.launch(BROWSER);
  const kinds = ["published, no page", "page elsewhere", "page here"];
  const times = new Map(kinds.map((kind) => [kind, []]));
  for (let i = 0; i < pairs; i += 1) {
    // In turn, each time beginning with another one.
    for (let k = 0; k < kinds.length; k += 1) {
      const kind = kinds[(i + k) % kinds.length];
      const load = loadavg()[0].toFixed(1);
      const time = await timed(kind, browser);
      times.get(kind).push(time);
      console.log(`${kind}: image ${time.image.toFixed(3)} ms, all ${time.both.toFixed(3)} ms, whole thread ${time.thread.toFixed(2)} ms a frame, load before ${load}`);
    }
  }
  await browser.close();
  const base = times.get(kinds[0]);
  for (const kind of kinds) {
    const all = times.get(kind);
    const ratios = all.map((time, i) => 100 * (time.both / base[i].both - 1));
    console.log(`${kind}: median of ${all.length} runs ${median(all.map((time) => time.both)).toFixed(3)} ms, whole thread `
      + `${median(all.map((time) => time.thread)).toFixed(2)} ms a frame; `
      + `against no page in the same round: median ${median(ratios).toFixed(1)} %, from ${Math.min(...ratios).toFixed(1)} to ${Math.max(...ratios).toFixed(1)} %`);
  }
}

try {
  if (task === "stalled") await stalled(Number(count ?? 10));
  else if (task === "slow") await slow(Number(count ?? 10));
  else if (task === "slowdown") await slowdown(Number(count ?? 5));
  else throw new Error(`expected stalled, slow or slowdown, found ${task}`);
} finally {
  children.forEach((child) => child.kill("SIGKILL"));
  rmSync(folder, { recursive: true, force: true });
}
process.exit(0);
