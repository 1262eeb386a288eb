// Puts the page together.

import { Aim } from "./aim.js";
import { Announcer } from "./announcer.js";
import { Bar } from "./bar.js";
import { ByHand } from "./by_hand.js";
import { Cards, Facts } from "./cards.js";
import { byId } from "./dom.js";
import { DrivePanel } from "./drive_panel.js";
import { Editor } from "./editor.js";
import { Files } from "./files.js";
import { Freshness } from "./freshness.js";
import { ImageView } from "./image_view.js";
import { AlgorithmsPanel } from "./parameters.js";
import { followLink } from "./permalink.js";
import { Plots } from "./plots.js";
import { PlotTools } from "./plot_tools.js";
import { Socket } from "./socket.js";
import { Store } from "./store.js";
import { Tabs } from "./tabs.js";
import { TeachPanel } from "./teach_panel.js";
import { TeamPanel } from "./team_panel.js";
import { startTheme } from "./theme.js";
import { Time } from "./time.js";
import { Timeline } from "./timeline.js";
import { showStatus } from "./veil.js";
import { View3d } from "./view3d.js";
import { WorldPanel } from "./world_panel.js";

/** Plots and numbers are drawn so often, milliseconds. */
const SLOW_MS = 90;

startTheme();
const store = new Store();
const freshness = new Freshness(store);
let numToDraw = 0;
let isRequested = false;
let slowAt = 0;
let isSlowDue = false;
let slowTimer = 0;
let cardsAreDue = false;

const socket = new Socket({
  message(message) {
    // Each state is answered when it has been drawn, so a page that is busy or hidden is not sent more.
    if (!store.take(message)) return;
    numToDraw += 1;
    requestSlowDraw();
  },
  pulse: (busySecs) => freshness.hear(busySecs),
  refused(reason) {
    drive.refuse(reason);
    bar.notice(reason);
  },
  status(state, text) {
    if (state === "connecting") numToDraw = 0;
    queueMicrotask(() => {
      showStatus(state, text, socket);
      freshness.setOpen(state === "open");
    });
  },
});

const view = new View3d(byId("world"), store, socket, requestDraw);
const image = new ImageView(store);
const byHand = new ByHand(store);
const cards = new Cards(store);
const facts = new Facts(store);
const time = new Time(store, socket, timeChanged);
const plots = new Plots(store, time);
const timeline = new Timeline(store, socket, time);
const tools = new PlotTools(store, time, view, image, plots);
const aim = new Aim(store, socket);
const drive = new DrivePanel(store, socket, aim);
const panels = [new WorldPanel(store, socket), new TeamPanel(store, socket), new TeachPanel(store, socket), new AlgorithmsPanel(store, socket), new Tabs(store, requestSlowDraw), new Announcer(store)];
const bar = new Bar(store, socket, view, drive, aim, time);
followLink(store, socket);
new Files((text) => bar.notice(text));
const editor = new Editor(socket.token);

/** Another moment is shown or pointed at, or another span of time. */
function timeChanged() {
  view.touch();
  slowAt = 0;
  cardsAreDue = true;
  requestSlowDraw();
}

/** Draws in the next frame: nothing is drawn while nothing is new. */
function requestDraw() {
  if (isRequested) return;
  isRequested = true;
  requestAnimationFrame(draw);
}

/** Plots and numbers as well. */
function requestSlowDraw() {
  isSlowDue = true;
  requestDraw();
}

function draw() {
  isRequested = false;
  view.draw();
  if (numToDraw > 0 || cardsAreDue) {
    cardsAreDue = false;
    cards.draw();
    for (; numToDraw > 0; numToDraw -= 1) socket.drawn();
  }
  drawSlow();
}

function drawSlow() {
  if (!isSlowDue) return;
  const waitMs = slowAt + SLOW_MS - performance.now();
  if (waitMs > 0) {
    clearTimeout(slowTimer);
    slowTimer = setTimeout(drawSlow, waitMs);
    return;
  }
  slowAt = performance.now();
  isSlowDue = false;
  plots.draw();
  timeline.draw();
  tools.draw();
  facts.draw();
}

/** For the page by hand, for tests, and for the curious in the console. */
window.studio = { byHand, store, socket, view, image, bar, panels, freshness, time, editor };
