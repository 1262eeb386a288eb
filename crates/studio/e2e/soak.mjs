// Memory, file handles and threads of a program that runs for long, and whether its answers stay in time. No part of any test run.
//
//     node soak.mjs localize VISLOC MINUTES REPLAY BAG MAP     live ROS 2 topics and a published page; REPLAY is the command of
//                                                              interop/ros2/replay.py, such as "python3 interop/ros2/replay.py"
//     node soak.mjs slam VISLOC MINUTES DIR                    a folder of images over and over, and a published page
//     node soak.mjs studio VISLOC MINUTES                      the playground with one page
//
// One at a time, on a machine that does nothing else. Prints a line a minute and a summary as JSON; exit code 1 if memory at the end is
// more than 3 % above that after five minutes (after a quarter of the time if it is shorter than twenty).

import { spawn } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { createInterface } from "node:readline";

import { RawPage } from "./raw_page.mjs";

const [task, program, minutesText, ...more] = process.argv.slice(2);
const minutes = Number(minutesText);
const visloc = resolve(program);
const folder = mkdtempSync(join(tmpdir(), "visloc-soak-"));
const SAMPLE_SECS = 10;
const MOST_GROWTH = 0.03;
const LATE_MS = 100;
const DOMAIN = String(100 + Math.floor(Math.random() * 100));
const children = [];

const sleep = (secs) => new Promise((done) => { setTimeout(done, 1000 * secs); });

/** Starts a program; `found` is the first match in what it prints. */
async function start(command, args, pattern) {
  const child = spawn(command, args, { cwd: folder, stdio: ["ignore", "pipe", "inherit"], env: { ...process.env, ROS_DOMAIN_ID: DOMAIN } });
  children.push(child);
  child.text = "";
  child.ended = new Promise((done) => { child.on("close", done); });
  const lines = createInterface({ input: child.stdout });
  const found = new Promise((done, fail) => {
    lines.on("line", (line) => {
      child.text += `${line}\n`;
      const match = pattern && line.match(pattern);
      if (match) done(match);
    });
    lines.on("close", () => fail(new Error(`${command} ${args.join(" ")} has ended:\n${child.text}`)));
  });
  found.catch(() => {});
  return { child, found: pattern && await found };
}

/** What the system says of a process. */
function look({ pid }) {
  const status = readFileSync(`/proc/${pid}/status`, "utf8");
  const number = (key) => Number(status.match(new RegExp(`${key}:\\s+(\\d+)`))[1]);
  return { rss_mb: number("VmRSS") / 1024, threads: number("Threads"), handles: readdirSync(`/proc/${pid}/fd`).length };
}

const published = async (args) => {
  const { child, found } = await start(visloc, [...args, "--publish", "127.0.0.1:0", "--token", "soak"], /--connect (\S+)/);
  return { child, address: `http://${found[1]}/?token=soak` };
};

const TASKS = {
  async localize(replay, bag, map) {
    const robot = await published(["localize", "ros2:/camera/image/compressed", "--map", map]);
    const [command, ...args] = replay.split(" ");
    const player = await start(command, [...args.map((arg) => (arg.endsWith(".py") ? resolve(cwd, arg) : arg)), resolve(cwd, bag),
      "--domain", DOMAIN, "--minutes", String(minutes + 0.3)]);
    return { ...robot, player: player.child };
  },
  slam: (images) => published(["slam", `loop:${resolve(cwd, images)}`]),
  async studio() {
    const { child, found } = await start(visloc, ["studio", "--no-open", "--port", "0"], /http:\S+/);
    return { child, address: found[0] };
  },
};

const cwd = process.cwd();
let code = 1;
try {
  const { child, address, player } = await TASKS[task](...more);
  const page = await RawPage.open(address);
  const samples = [];
  let before = 0;
  for (let i = 1; i <= minutes * 60 / SAMPLE_SECS; i += 1) {
    await sleep(SAMPLE_SECS);
    samples.push(look(child));
    const now = page.latest?.number ?? 0;
    if (i % (60 / SAMPLE_SECS) === 0) {
      const { rss_mb, threads, handles } = samples[samples.length - 1];
      console.log(`${i * SAMPLE_SECS / 60} min: ${rss_mb.toFixed(1)} MB, ${threads} threads, ${handles} handles, `
        + `${((now - before) / 60).toFixed(1)} frames a second, load ${loadavg()[0].toFixed(2)}`);
      before = now;
    }
    page.updates.splice(0, Math.max(0, page.updates.length - 10));
  }
  // The mean over a minute on both sides, since allocators give back memory in steps.
  const per = 60 / SAMPLE_SECS;
  const mean = (part, key) => part.reduce((sum, sample) => sum + sample[key], 0) / part.length;
  const early = Math.round(Math.min(5, minutes / 4) * per);
  const [first, last] = [samples.slice(Math.max(0, early - per), early), samples.slice(-per)];
  const growth = mean(last, "rss_mb") / mean(first, "rss_mb") - 1;
  const summary = {
    task, minutes, early_mb: mean(first, "rss_mb"), end_mb: mean(last, "rss_mb"), growth_percent: 100 * growth,
    handles: [mean(first, "handles"), mean(last, "handles")], threads: [mean(first, "threads"), mean(last, "threads")],
    frames: page.latest?.number,
  };
  code = growth > MOST_GROWTH ? 1 : 0;
  if (player) {
    await player.ended;
    summary.answers = JSON.parse(player.text).delay_ms;
    code ||= summary.answers?.later_than_100 ? 1 : 0;
  }
  page.close();
  child.kill("SIGINT");
  await Promise.race([child.ended, sleep(20)]);
  console.log(child.text.trim().split("\n").slice(-12).join("\n"));
  console.log(JSON.stringify(summary, null, 2));
  console.log(`memory ${growth > MOST_GROWTH ? "grows" : "is steady"}; answers later than ${LATE_MS} ms: ${summary.answers?.later_than_100 ?? "-"}`);
} finally {
  children.forEach((child) => child.kill("SIGKILL"));
  rmSync(folder, { recursive: true, force: true });
}
process.exit(code);
