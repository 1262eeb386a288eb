// visloc and its page in headless Chromium, for tests, measurements and pictures.

import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";

export const BROWSER = {
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    // A page from a folder counts as one from elsewhere.
    ...(process.env.PAGE ? ["--disable-features=LocalNetworkAccessChecks"] : [])],
};

/** Programs that are started in a folder of their own, and ended with it. */
export class Programs {
  constructor(visloc) {
    this.visloc = visloc;
    this.folder = mkdtempSync(join(tmpdir(), "visloc-studio-"));
    this.children = [];
  }

  /** Starts visloc and gives the first match of what it prints. */
  async start(pattern, ...args) {
    const child = spawn(this.visloc, args, { cwd: this.folder, stdio: ["ignore", "pipe", "inherit"] });
    this.children.push(child);
    for await (const line of createInterface({ input: child.stdout })) {
      const match = line.match(pattern);
      if (match) {
        child.stdout.resume();
        return match[1];
      }
    }
    throw new Error(`visloc ${args.join(" ")} has not started`);
  }

  /** Starts a studio on any free port; gives its address. */
  studio(...more) {
    return this.start(/(http:\S+)/, "studio", "--no-open", "--port", "0", ...more);
  }

  /** Stops a program, as a debugger does, or lets it go on; they are counted from the last one that was started. */
  stall(isStalled, which = -1) {
    this.children.at(which).kill(isStalled ? "SIGSTOP" : "SIGCONT");
  }

  end() {
    for (const child of this.children) child.kill();
    rmSync(this.folder, { recursive: true, force: true });
  }
}

/** With PAGE, a folder, the page's files are taken from there instead of from the program: to try changes without a build. */
async function usePage(context) {
  const { PAGE } = process.env;
  if (!PAGE) return;
  await context.route((url) => existsSync(join(PAGE, url.pathname === "/" ? "index.html" : url.pathname)), (route) => {
    const { pathname } = new URL(route.request().url());
    return route.fulfill({ path: join(PAGE, pathname === "/" ? "index.html" : pathname) });
  });
}

/** Opens a page that shows something; what goes wrong in it is added to `errors`. */
export async function open(browser, url, errors, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: "dark", ...options });
  await usePage(context);
  const page = await context.newPage();
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  await page.goto(url);
  await page.waitForFunction(() => window.studio?.store.state?.number >= 0, null, { timeout: 20000 });
  return page;
}

export const state = (page) => page.evaluate(() => window.studio.store.state);
export const send = (page, type, more) => page.evaluate(([t, m]) => window.studio.socket.send(t, m), [type, more ?? {}]);
export const until = (page, condition, argument, timeout = 60000) => page.waitForFunction(condition, argument, { timeout });
