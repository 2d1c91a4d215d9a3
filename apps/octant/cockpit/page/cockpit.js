// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The page of octant cockpit. It shows the state that /api/events sends, and sends commands to /api/command.
import {CLASSES, Plan, chart} from "/plan.js";

const $ = id => document.getElementById(id);
const plan = new Plan($("plan"));
let client = sessionStorage.getItem("client");
if (!client) sessionStorage.setItem("client", client = [...crypto.getRandomValues(new Uint8Array(12))].map(b => b.toString(16).padStart(2, "0")).join(""));
let state = null, floor = null, floorVersion = 0;

/** An element with text; names from outside are only ever text. */
function element(name, text = "", attributes = {}) {
  const made = document.createElement(name);
  made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) key in made ? made[key] = value : made.setAttribute(key, value);
  return made;
}
/** Replaces the children of a list. An element with buttons remains, so that a click on one is not lost: it gets the contents of the new one. */
function fill(list, children) {
  const old = new Map([...list.children].map(child => [child.dataset.key, child]));
  const kept = children.map(child => {
    const same = child.dataset.key && old.get(child.dataset.key);
    return same ? update(same, child) : child;
  });
  for (const child of [...list.children]) if (!kept.includes(child)) child.remove();
  kept.forEach((child, i) => { if (list.children[i] !== child) list.insertBefore(child, list.children[i] ?? null); });
}
/** Gives an element the texts and actions of another one of the same structure. */
function update(old, fresh) {
  const a = [...old.childNodes], b = [...fresh.childNodes];
  if (a.length !== b.length || a.some((node, i) => node.nodeName !== b[i].nodeName)) {
    old.replaceChildren(...b);
  } else a.forEach((node, i) => {
    if (node.nodeType !== Node.TEXT_NODE) update(node, b[i]);
    else if (node.data !== b[i].data) node.data = b[i].data;
  });
  if (old.className !== fresh.className) old.className = fresh.className;
  if (old instanceof HTMLButtonElement) old.onclick = fresh.onclick, old.disabled = fresh.disabled;
  return old;
}
export function length(m) {
  if (m === null || m === undefined || !isFinite(m)) return "–";
  return m >= 1 ? `${m.toPrecision(3)} m` : m >= 0.01 ? `${Math.round(1000 * m)} mm` : `${(1000 * m).toFixed(1)} mm`;
}

async function command(what, more = {}) {
  refused = "", showFailure();
  try {
    const answer = await fetch("/api/command", {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify({do: what, client, ...more})});
    if (!answer.ok) refused = (await answer.json()).error, showFailure();
    return answer.ok;
  } catch { refused = "The cockpit does not answer.", showFailure(); }
}
/** Reasons that the operator has to know: a refused command, rows that are not written, a failed end. */
let refused = "";
function showFailure() {
  const error = state?.recording?.error;
  const words = [refused, error ? `Recording failed. ${error}` : "", state?.finish_failure ? `No deployment was written, and the recording goes on. ${state.finish_failure}` : ""].filter(Boolean).join(" ");
  if ($("failure").textContent !== words) $("failure").textContent = words;
}

function ask(words, yes) {
  $("ask-words").textContent = words, $("ask-ok").textContent = yes;
  return new Promise(resolve => {
    $("ask-dialog").addEventListener("close", () => resolve($("ask-dialog").returnValue === "ok"), {once: true});
    $("ask-dialog").returnValue = "cancel";
    $("ask-dialog").showModal();
  });
}

function showLight() {
  const light = state.light, needed = state.next_stop?.stops_needed, done = state.finished;
  if (!light) return;
  const name = {not_yet: "Not yet", good: "Good enough", contradicted: "Contradicted"}[light.colour];
  $("light").className = `light ${light.colour}`;
  $("light-name").textContent = name + (light.colour === "not_yet" && needed ? `: about ${needed} more stop${needed === 1 ? "" : "s"}` : "");
  $("light-words").textContent = done ? (done.deployment ? `Finished. Deployment: ${done.deployment}. Report: ${done.report}` : `Finished without a deployment. ${done.message}`) : light.words;
}

function showNext() {
  const n = state.next_stop, marked = ["marked", "undecided", "drive"].includes(state.recording?.stop_mode) && !state.recording?.odometry_rows;
  const open = state.open_stop !== null, colour = state.light?.colour;
  $("next").textContent = state.finishing ? "Finishing: the complete run is calibrated." : state.finished ? ""
    : open ? `Stop ${state.open_stop} is open: keep the vehicle still.`
    : state.mode === "setup" ? "Arrivals are recorded already. The calibration starts with the description."
    : n && colour !== "good" ? `Go to x ${n.x_m.toFixed(1)}, y ${n.y_m.toFixed(1)} m, heading ${Math.round(n.heading_rad * 180 / Math.PI)}°. Best for ${n.most_for}: ${length(n.sigma_before_m)} to ${length(n.sigma_after_m)}.`
    : colour === "good" ? "All beacons meet the tolerance. Finish, or add stops." : "Stop anywhere in the hall, then at places well apart.";
  const over = Boolean(state.finished || state.finishing);
  $("begin-stop").disabled = over || open || !marked;
  $("end-stop").disabled = over || !open;
  $("control-point").disabled = over || !(open || state.stops.length);
  $("finish").disabled = over || !state.recording?.arrivals;
  $("stop-help").textContent = state.recording?.stop_mode === "rows" ? "The stream itself says where a stop begins and ends." : state.recording?.odometry_rows ? "The stream has odometry: drive, stops are not needed." : "";
  $("operator").hidden = state.operator === null || state.operator === client;
}

function showFindings() {
  const unknown = Object.entries(state.unknown_beacons).map(([id, n]) => ({text: `Beacon ${id} is received and is not in the site file: ${n} arrivals are in unused.csv`, remedy: "add it to the site file, if it belongs to the site"}));
  const findings = [...unknown, ...state.calibration?.findings ?? []];
  fill($("findings"), findings.length ? findings.map(f => {
    const item = element("li", f.text.replace(/\.?$/, ". ") + f.remedy.charAt(0).toUpperCase() + f.remedy.slice(1) + ".");
    if (f.exchange) {
      const [a, b] = f.exchange, button = element("button", `Swap ${a} and ${b}`, {type: "button"});
      item.dataset.key = `swap ${a} ${b}`;
      button.onclick = () => command("exchange", {a, b});
      item.append(document.createElement("br"), button);
    }
    return item;
  }) : [element("li", "None.")]);
  $("changes").textContent = state.site_changes.length ? `Changed in the site file: ${state.site_changes.join("; ")}.` : "";
  $("undo").hidden = !state.site_changes.length;
}

function beaconState(b, c) {
  if (!b.arrivals) return ["not received", "bad"];
  if (b.last_s > 10 && !state.source.is_over) return [`last received ${Math.round(b.last_s)} s ago`, "wait"];
  if (state.mode === "monitoring") return ["received", "good"];
  if (c?.status === "control_point") return ["control point", "good"];
  if (!c || c.status === "undetermined") return [c ? "not determined" : "received", "wait"];
  const limit = state.tolerance.beacon_m;
  return limit === null ? ["calibrated", "good"] : c.radius95_m <= limit ? ["in tolerance", "good"] : ["not yet", "wait"];
}

function showBeacons() {
  const found = new Map((state.calibration?.beacons ?? []).map(b => [b.id, b]));
  fill($("beacons"), state.beacons.map(b => {
    const c = found.get(b.id), row = element("tr"), [words, kind] = beaconState(b, c);
    row.dataset.key = b.id;
    row.append(element("th", b.id, {scope: "row"}), element("td", words, {className: `words ${kind}`}), element("td", c?.status === "control_point" ? "fixed" : length(c?.radius95_m)), element("td", String(b.arrivals), {className: "wide"}), element("td", b.rate_hz.toFixed(b.rate_hz < 10 ? 1 : 0), {className: "wide"}));
    if (state.mode === "setup") {
      const button = element("button", "Place", {type: "button"});
      button.setAttribute("aria-label", `Place ${b.id}`);
      button.dataset.key = `place ${b.id}`;
      button.onclick = () => placeNext(b.id);
      row.children[1].replaceChildren(button);
    }
    return row;
  }));
}

function showStops() {
  const found = new Map((state.calibration?.stops ?? []).map(s => [s.epoch, s]));
  fill($("stops"), state.stops.slice(-200).reverse().map(s => {
    const c = found.get(s.epoch), row = element("tr"), point = s.control_point;
    const button = element("button", "✕", {type: "button", disabled: Boolean(state.finished || state.finishing)});
    button.setAttribute("aria-label", `Delete stop ${s.epoch}`);
    row.dataset.key = s.epoch;
    button.onclick = async () => { if (await ask(`Delete stop ${s.epoch} with ${s.arrivals} arrivals?`, "Delete")) command("delete_stop", {epoch: s.epoch}); };
    const cell = element("td");
    cell.append(button);
    row.append(element("th", String(s.epoch), {scope: "row"}), cell, element("td", String(s.arrivals)), element("td", String(s.beacons)), element("td", c ? c.rms_sigmas.toFixed(1) : "–"), element("td", point ? `${point.name || "point"} (${point.x_m}, ${point.y_m})` : "", {className: "words"}));
    return row;
  }));
}

function showLive() {
  const r = state.recording, c = state.calibration, facts = [["Source", state.source.name + (state.source.is_over ? " (ended)" : "")]];
  if (r) facts.push(["Recorded", `${r.arrivals} arrivals, ${r.odometry_rows} odometry rows in ${r.folder}`]);
  if (r?.error) facts.push(["Recording failed", r.error]);
  if (r && (r.late || r.between_stops || r.deleted || r.stop_is_over || r.unknown)) facts.push(["In unused.csv", `${r.between_stops} between stops, ${r.deleted} deleted, ${r.late} late, ${r.stop_is_over} after the end of their stop, ${r.unknown} of unknown beacons`]);
  if (r?.late_odometry) facts.push(["Late odometry", `${r.late_odometry} rows`]);
  if (r?.lost) facts.push(["Lost", `${r.lost} rows that could not be written`]);
  const bad = Object.entries(state.source.bad_lines);
  if (bad.length) facts.push(["Invalid lines", bad.map(([words, n]) => `${n} × ${words}`).join("; ")]);
  facts.push(["Fixes", `${state.fixes.ok}, ${state.fixes.no_fix} without a position`]);
  if (state.temperature_degC !== null) facts.push(["Temperature", `${state.temperature_degC.toFixed(1)} °C`]);
  if (c?.speed_mps) facts.push(["Speed", `${c.speed_mps.toFixed(2)} m/s (sigma ${c.speed_sigma_mps.toFixed(2)})`]);
  if (c) facts.push(["Calibration", `${c.arrivals} arrivals, ${c.rejected} left out, ${state.calibration_s.toFixed(1)} s`]);
  fill($("facts"), facts.flatMap(([name, value]) => [element("dt", name), element("dd", value)]));
  chart($("rate"), state.history.map(h => [h[0], h[1]]));
  chart($("residual"), state.history.map(h => [h[0], h[2]]), 1);
  fill($("alarms"), state.alarms.slice(-20).reverse().map(a => element("li", `${a.kind.replaceAll("_", " ")}: ${a.beacon ?? a.receiver ?? ""} ${length(Math.abs(a.size_m ?? 0))}`)));
}

/** Form for a site of which only names are known. */
function showSetup() {
  $("setup-heard").textContent = state.beacons.length ? `Received: ${state.beacons.map(b => b.id).join(", ")}; receivers ${state.receivers.join(", ")}.` : "No arrival yet.";
  $("setup-ring").hidden = state.receivers.length < 2;
  plan.movable = true;
}

function placeNext(id) {
  $("connection").textContent = `Tap the place of ${id} on the plan`;
  $("plan").scrollIntoView({block: "nearest"});
  plan.onTap = (x, y) => {
    plan.onTap = null, plan.fits = false;
    plan.moved.set(id, [x, y]);
    plan.draw();
  };
}

/** Map of the floor with beacons at other places, while they are dragged. */
let asking = false, askAgain = false;
async function askFloor() {
  if (asking) { askAgain = true; return; }
  asking = true;
  const moves = [...plan.moved].map(([id, [x_m, y_m]]) => ({id, x_m, y_m}));
  const answer = await fetch("/api/floor", {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify({moves})});
  if (answer.ok && trying()) plan.show(state, await answer.json());
  asking = false;
  if (askAgain) { askAgain = false; askFloor(); }
}
const trying = () => $("try-places").getAttribute("aria-pressed") === "true";

function show(next) {
  state = next;
  document.body.className = state.mode;
  $("site").textContent = state.site, $("mode").textContent = state.mode;
  if (!plan.onTap && !trying()) $("connection").textContent = state.source.is_over ? "The source has ended" : "Live";
  showLight();
  showFailure();
  if (state.mode === "setup") showSetup();
  if (state.mode !== "monitoring") { showNext(); showFindings(); showStops(); }
  showBeacons();
  showLive();
  plan.show(state, trying() ? plan.floor : floor);
  const v = state.vehicle;
  $("plan").setAttribute("aria-label", `Plan of the site: ${state.beacons.length} beacons, ${state.stops.length} stops` + (v ? `, vehicle at x ${v.x_m.toFixed(1)}, y ${v.y_m.toFixed(1)} m` : ""));
  if (state.floor_version !== floorVersion) loadFloor(state.floor_version);
}

async function loadFloor(version) {
  floorVersion = version;
  const answer = await fetch("/api/floor");
  floor = answer.ok ? await answer.json() : null;
  const limit = floor?.limit_m ?? 0.05;
  let from = 0;
  fill($("legend"), !floor ? [] : [element("li", "Expected error of a fix:"), ...CLASSES.map(([end, colour]) => {
    const item = element("li"), swatch = element("span");
    swatch.style.background = colour;
    item.append(swatch, isFinite(end) ? `to ${length(end * limit)}` : `above ${length(from * limit)}`);
    from = end;
    return item;
  })]);
  plan.show(state, floor);
}

$("begin-stop").onclick = async () => {
  const r = state.recording;
  if (r.stop_mode !== "drive" || !r.arrivals || await ask(`Begin the first stop? ${r.arrivals} arrivals become unused.`, "Begin")) command("begin_stop");
};
$("end-stop").onclick = () => command("end_stop");
/** Numbers of fields by key; an empty field has none. */
function numbers(fields) {
  const filled = Object.entries(fields).filter(([, id]) => $(id).value.trim());
  return Object.fromEntries(filled.map(([key, id]) => [key, Number($(id).value.replace(",", "."))]));
}
$("take-over").onclick = () => command("take_over");
$("undo").onclick = () => command("undo");
$("finish").onclick = async () => {
  const colour = state.light.colour;
  const words = colour === "good" ? "Finish and write the deployment?" : colour === "contradicted" ? "The data contradict the site file. Finish, and write the deployment marked as contradicted?" : "The tolerance is not met yet. Finish all the same?";
  if (await ask(words, "Finish")) command("finish", {accept: colour === "contradicted"});
};
$("control-point").onclick = () => {
  const epoch = state.open_stop ?? state.stops.at(-1).epoch;
  $("point-stop").textContent = `Position of the vehicle's origin at stop ${epoch}, measured by hand.`;
  $("point-dialog").returnValue = "cancel";
  $("point-dialog").addEventListener("close", () => {
    if ($("point-dialog").returnValue === "ok") command("control_point", {epoch, name: $("point-name").value, ...numbers({x_m: "point-x", y_m: "point-y", sigma_m: "point-sigma"})});
  }, {once: true});
  $("point-dialog").showModal();
};
$("setup-form").onsubmit = async e => {
  e.preventDefault();
  const beacons = [...plan.moved].map(([id, [x_m, y_m]]) => ({id, x_m, y_m, sigma_m: 0.5}));
  if (await command("set_site", {kind: $("setup-kind").value, beacons, ...numbers({temperature_degC: "setup-temperature", height_m: "setup-height", ring_radius_m: "setup-radius", beacon_m: "setup-beacon", fix_m: "setup-fix"})})) plan.moved.clear(), plan.movable = false, plan.fits = true;
};
$("try-places").onclick = () => {
  const on = !trying();
  $("try-places").setAttribute("aria-pressed", on);
  plan.movable = on, plan.onMove = on ? askFloor : null, plan.moved.clear();
  $("connection").textContent = on ? "Drag a beacon: the map shows the error of a fix with it there" : "Live";
  on ? askFloor() : plan.show(state, floor);
};
$("zoom-in").onclick = () => plan.zoom(1.4);
$("zoom-out").onclick = () => plan.zoom(1 / 1.4);
$("zoom-fit").onclick = () => plan.fit();

const events = new EventSource("/api/events");
events.addEventListener("state", e => show(JSON.parse(e.data)));
events.onerror = () => { $("connection").textContent = "The cockpit does not answer"; };
