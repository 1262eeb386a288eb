// Files of this computer are opened by dropping them on the page, or by its dialog.

import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { until } from "./visloc.mjs";

/** Drops a file on the page as a person does. */
async function drop(page, path) {
  const data = readFileSync(path).toString("base64");
  await page.evaluate(([name, text]) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([bytes], name));
    for (const type of ["dragover", "drop"]) {
      document.querySelector("#world").dispatchEvent(new DragEvent(type, { dataTransfer, bubbles: true, cancelable: true }));
    }
  }, [path.split("/").pop(), data]);
}

export async function drops(open, programs, visloc, recording, check) {
  const run = (...args) => execFileSync(visloc, args, { cwd: programs.folder });
  const page = await open(await programs.studio());
  await page.waitForSelector("#open-file:not([hidden])");
  const short = join(programs.folder, "dropped.mcap");
  writeFileSync(short, readFileSync(recording).subarray(0, 8_000_000));
  await drop(page, short);
  await until(page, () => window.studio.store.scene.mode === "replay" && window.studio.store.state.num_frames > 20);
  check(true, "a recording that is dropped is replayed");
  const map = join(programs.folder, "field.toml");
  writeFileSync(map, run("map", "show", "robocup-spl-2010"));
  const bag = join(programs.folder, "walk.mcap");
  run("simulate", "tour", "--frames", "150", "--out", bag);
  await page.setInputFiles("input[aria-label='Files to open']", [bag, map]);
  await until(page, () => window.studio.store.scene.scene.startsWith("source-") && window.studio.store.state.contenders?.[0]?.is_localized);
  check(true, "a bag and its map that are chosen in the dialog are followed");
  const wrong = join(programs.folder, "wrong.toml");
  writeFileSync(wrong, "color = 3\n");
  await drop(page, wrong);
  await until(page, () => /no map .* no calibration/.test(document.querySelector("#notice").textContent));
  check(true, `what is none says why: ${(await page.locator("#notice").textContent()).slice(0, 160)}`);
  await page.context().close();
  const listening = await programs.studio("--listen", "0.0.0.0");
  const token = new URL(listening).searchParams.get("token");
  const answer = await fetch(`${new URL(listening).origin}/files?name=a.toml&token=${token}`, { method: "POST", body: "x" });
  check(answer.status === 403, `a studio that others can reach takes no files: ${await answer.text()}`);
}
