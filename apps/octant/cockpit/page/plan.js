// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Plan of the site on a canvas: floor, beacons with ellipses, stops, vehicle, next stop. Drag and pinch move it.

/** Colours by parts of the tolerance, as in the reports: darker is worse. */
export const CLASSES = [[0.25, "#d9f0d3"], [0.5, "#b2dfa5"], [0.75, "#8cc97d"], [1, "#f6b53c"], [1.5, "#e8713c"], [2, "#bf2f2f"], [Infinity, "#6b0f1a"]];
export const colourOf = part => CLASSES.find(([end]) => part <= end)[1];
const INK = "#16202b", ACT = "#0f528f", GOOD = "#0b5d3b", WAIT = "#b35c00", BAD = "#9c1c14";
const FONT = "16px system-ui, sans-serif";
const ELLIPSE_95 = 2.448;  // factor of a two-dimensional sigma

/** Half axes and angle of a 95 % ellipse. */
export function ellipse([xx, xy, yy]) {
  const mean = (xx + yy) / 2, root = Math.hypot((xx - yy) / 2, xy);
  return {a: ELLIPSE_95 * Math.sqrt(Math.max(0, mean + root)), b: ELLIPSE_95 * Math.sqrt(Math.max(0, mean - root)), angle: Math.atan2(2 * xy, xx - yy) / 2};
}

export class Plan {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d", {willReadFrequently: true});  // painted by the processor: tablets without a graphics processor
    this.state = null, this.floor = null, this.view = null, this.fingers = new Map();
    this.fits = true;  // until somebody moves it
    new ResizeObserver(() => this.draw()).observe(canvas);
    this.moved = new Map();  // places of beacons that the operator has chosen
    this.held = null, this.movable = false, this.onMove = null, this.onTap = null;
    canvas.addEventListener("pointerdown", e => this.press(e));
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, e => { this.fingers.delete(e.pointerId); this.held = null; });
    canvas.addEventListener("pointermove", e => this.move(e));
    canvas.addEventListener("wheel", e => { e.preventDefault(); this.zoom(Math.exp(-e.deltaY / 500), e.offsetX, e.offsetY); }, {passive: false});
  }

  /** Holds the beacon under the finger, or tells where the plan was tapped. */
  press(e) {
    this.canvas.setPointerCapture(e.pointerId);
    this.fingers.set(e.pointerId, [e.offsetX, e.offsetY]);
    if (!this.view) return;
    if (this.onTap) return this.onTap(...this.place(e.offsetX, e.offsetY));
    const reach = 28, off = b => { const [px, py] = this.at(b.x, b.y); return Math.hypot(px - e.offsetX, py - e.offsetY); };
    if (this.movable) this.held = this.beacons().filter(b => off(b) < reach).sort((a, b) => off(a) - off(b))[0]?.id ?? null;
  }

  move(e) {
    if (this.held !== null && this.fingers.has(e.pointerId)) {
      this.fits = false;
      this.moved.set(this.held, this.place(e.offsetX, e.offsetY));
      this.onMove?.();
      return this.draw();
    }
    const before = this.fingers.get(e.pointerId);
    if (!before || !this.view) return;
    const other = [...this.fingers].find(([id]) => id !== e.pointerId)?.[1];
    const now = [e.offsetX, e.offsetY];
    if (other) this.zoom(Math.hypot(now[0] - other[0], now[1] - other[1]) / Math.max(1, Math.hypot(before[0] - other[0], before[1] - other[1])), other[0], other[1]);
    else { this.fits = false; this.view.x -= (now[0] - before[0]) / this.view.scale; this.view.y += (now[1] - before[1]) / this.view.scale; }
    this.fingers.set(e.pointerId, now);
    this.draw();
  }

  zoom(factor, px = this.canvas.clientWidth / 2, py = this.canvas.clientHeight / 2) {
    if (!this.view) return;
    this.fits = false;
    const [x, y] = this.place(px, py);
    this.view.scale = Math.min(5000, Math.max(0.05, this.view.scale * factor));
    const [x2, y2] = this.place(px, py);
    this.view.x += x - x2, this.view.y += y - y2;
    this.draw();
  }
  fit() { this.fits = true; this.draw(); }

  place(px, py) { return [this.view.x + (px - this.canvas.clientWidth / 2) / this.view.scale, this.view.y - (py - this.canvas.clientHeight / 2) / this.view.scale]; }
  at(x, y) { return [this.canvas.clientWidth / 2 + (x - this.view.x) * this.view.scale, this.canvas.clientHeight / 2 - (y - this.view.y) * this.view.scale]; }

  /** Positions of the beacons: calibrated ones, else those of the site file. */
  beacons() {
    const found = new Map((this.state?.calibration?.beacons ?? []).map(b => [b.id, b]));
    return (this.state?.beacons ?? []).map(b => {
      const c = found.get(b.id), p = this.moved.get(b.id) ?? c?.position_m ?? b.stated_m;
      return p && {id: b.id, x: p[0], y: p[1], covariance: c?.covariance_xy_m2, radius: c?.radius95_m, status: c?.status ?? (this.state.mode === "monitoring" ? "calibrated" : "stated")};
    }).filter(Boolean);
  }

  fitted() {
    const points = this.beacons().map(b => [b.x, b.y]);
    if (this.floor) points.push(this.floor.origin_m, [this.floor.origin_m[0] + this.floor.cell_m * this.floor.columns, this.floor.origin_m[1] + this.floor.cell_m * this.floor.rows]);
    for (const s of this.state?.calibration?.stops ?? []) points.push([s.x_m, s.y_m]);
    if (!points.length) points.push([0, 0], [20, 15]);
    const xs = points.map(p => p[0]), ys = points.map(p => p[1]);
    const low = [Math.min(...xs), Math.min(...ys)], high = [Math.max(...xs), Math.max(...ys)];
    const scale = Math.min((this.canvas.clientWidth - 90) / Math.max(1, high[0] - low[0]), (this.canvas.clientHeight - 100) / Math.max(1, high[1] - low[1]));
    return {x: (low[0] + high[0]) / 2, y: (low[1] + high[1]) / 2, scale: Math.max(0.05, scale)};
  }

  show(state, floor) {
    this.state = state, this.floor = floor;
    this.draw();
  }

  draw() {
    const {canvas, pen} = this, dense = window.devicePixelRatio || 1;
    if (canvas.width !== Math.round(canvas.clientWidth * dense) || canvas.height !== Math.round(canvas.clientHeight * dense)) {
      canvas.width = Math.round(canvas.clientWidth * dense), canvas.height = Math.round(canvas.clientHeight * dense);
    }
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    if (!this.state) return;
    if (this.fits) this.view = this.fitted();
    if (!this.view) return;
    pen.font = FONT, pen.lineJoin = "round";
    if (this.state.mode === "setup") this.drawGrid();
    this.drawFloor();
    this.drawPaths();
    this.drawStops();
    this.drawBeacons();
    this.drawNext();
    this.drawVehicle();
    this.drawScale();
  }

  /** The map of the floor as a picture with a pixel for each cell, painted once. */
  paintFloor() {
    const f = this.floor, picture = document.createElement("canvas");
    picture.width = f.columns, picture.height = f.rows;
    const pen = picture.getContext("2d", {willReadFrequently: true}), image = pen.createImageData(f.columns, f.rows);
    f.cells.forEach((cell, i) => {
      const value = f.values_m[i], colour = value === null ? "#9aa4ad" : colourOf(value / (f.limit_m ?? 0.05));
      const at = 4 * ((f.rows - 1 - Math.floor(cell / f.columns)) * f.columns + cell % f.columns);
      for (let k = 0; k < 3; ++k) image.data[at + k] = parseInt(colour.slice(1 + 2 * k, 3 + 2 * k), 16);
      image.data[at + 3] = 255;
    });
    pen.putImageData(image, 0, 0);
    this.picture = picture, this.painted = f;
  }

  drawFloor() {
    const f = this.floor;
    if (!f) return;
    if (this.painted !== f) this.paintFloor();
    const size = f.cell_m * this.view.scale, [px, py] = this.at(f.origin_m[0], f.origin_m[1] + f.cell_m * f.rows);
    this.pen.imageSmoothingEnabled = false;
    this.pen.drawImage(this.picture, px, py, size * f.columns, size * f.rows);
  }

  /** A grid of metres for places by hand. */
  drawGrid() {
    const [left, top] = this.place(0, 0), [right, bottom] = this.place(this.canvas.clientWidth, this.canvas.clientHeight);
    const step = this.view.scale > 12 ? 1 : 10;
    for (let x = Math.ceil(left / step) * step; x < right; x += step) this.line([[x, bottom], [x, top]], x ? "#dde3e8" : "#7a8793", 1);
    for (let y = Math.ceil(bottom / step) * step; y < top; y += step) this.line([[left, y], [right, y]], y ? "#dde3e8" : "#7a8793", 1);
  }

  line(points, colour, width, dash = []) {
    this.pen.beginPath();
    points.forEach(([x, y], i) => { const p = this.at(x, y); i ? this.pen.lineTo(...p) : this.pen.moveTo(...p); });
    this.pen.strokeStyle = colour, this.pen.lineWidth = width;
    this.pen.setLineDash(dash);
    this.pen.stroke();
    this.pen.setLineDash([]);
  }

  label(text, px, py, colour = INK) {
    this.pen.lineWidth = 4, this.pen.strokeStyle = "#fff", this.pen.fillStyle = colour;
    const x = Math.min(px, this.canvas.clientWidth - this.pen.measureText(text).width - 4);
    this.pen.strokeText(text, x, py);
    this.pen.fillText(text, x, py);
  }

  drawPaths() {
    for (const track of this.state.calibration?.tracks ?? []) this.line(track, "#5d6b78", 2);
    if (this.state.track?.length > 1) this.line(this.state.track, ACT, 2, [6, 5]);
  }

  drawStops() {
    for (const s of this.state.calibration?.stops ?? []) {
      const [px, py] = this.at(s.x_m, s.y_m);
      this.pen.beginPath();
      this.pen.arc(px, py, 5, 0, 7);
      this.pen.fillStyle = s.rejected > s.used ? BAD : "#fff", this.pen.strokeStyle = INK, this.pen.lineWidth = 2;
      this.pen.fill();
      this.pen.stroke();
    }
  }

  drawBeacons() {
    const limit = this.state.tolerance.beacon_m;
    for (const b of this.beacons()) {
      const [px, py] = this.at(b.x, b.y);
      const colour = b.status === "control_point" ? ACT : b.status === "calibrated" ? (limit && b.radius > limit ? WAIT : GOOD) : BAD;
      if (b.covariance) {
        const e = ellipse(b.covariance), pen = this.pen;
        pen.beginPath();
        pen.ellipse(px, py, Math.max(e.a * this.view.scale, 1), Math.max(e.b * this.view.scale, 1), -e.angle, 0, 7);
        pen.strokeStyle = colour, pen.lineWidth = 2.5;
        pen.stroke();
      }
      this.pen.beginPath();
      if (b.status === "control_point") this.pen.rect(px - 7, py - 7, 14, 14);
      else if (b.status === "calibrated") this.pen.arc(px, py, 7, 0, 7);
      else { this.pen.moveTo(px, py - 9); this.pen.lineTo(px + 9, py + 7); this.pen.lineTo(px - 9, py + 7); this.pen.closePath(); }
      this.pen.fillStyle = colour, this.pen.strokeStyle = "#fff", this.pen.lineWidth = 2;
      this.pen.stroke();
      this.pen.fill();
      this.label(b.id.slice(0, 12), px + 11, py - 9);
    }
  }

  drawNext() {
    const n = this.state.next_stop;
    if (!n || this.state.finished || this.state.light?.colour === "good") return;
    const [px, py] = this.at(n.x_m, n.y_m);
    this.pen.strokeStyle = "#fff", this.pen.lineWidth = 8;
    for (const pass of [0, 1]) {
      this.pen.beginPath();
      this.pen.arc(px, py, 15, 0, 7);
      this.pen.moveTo(px, py), this.pen.lineTo(px + 26 * Math.cos(n.heading_rad), py - 26 * Math.sin(n.heading_rad));
      if (pass) this.pen.strokeStyle = "#7b1fa2", this.pen.lineWidth = 4;
      this.pen.stroke();
    }
    this.label("go here", px + 20, py + 24, "#7b1fa2");
  }

  /** The vehicle now; before the first deployment, its last stop. */
  drawVehicle() {
    const last = this.state.calibration?.stops?.at(-1);
    const v = this.state.vehicle ?? (last && {...last, covariance_xy_m2: [0, 0, 0]});
    if (!v) return;
    const [px, py] = this.at(v.x_m, v.y_m), e = ellipse(v.covariance_xy_m2), pen = this.pen;
    pen.strokeStyle = ACT, pen.lineWidth = 2;
    pen.beginPath();
    pen.ellipse(px, py, Math.max(e.a * this.view.scale, 1), Math.max(e.b * this.view.scale, 1), -e.angle, 0, 7);
    pen.stroke();
    pen.save();
    pen.translate(px, py);
    pen.rotate(-v.heading_rad);
    pen.beginPath();
    for (const [x, y] of [[15, 0], [-10, 10], [-5, 0], [-10, -10]]) pen.lineTo(x, y);
    pen.closePath();
    pen.fillStyle = ACT, pen.strokeStyle = "#fff";
    pen.stroke();
    pen.fill();
    pen.restore();
  }

  drawScale() {
    const wanted = 120 / this.view.scale, power = 10 ** Math.floor(Math.log10(wanted));
    const length = power * (wanted / power >= 5 ? 5 : wanted / power >= 2 ? 2 : 1);
    const y = this.canvas.clientHeight - 16;
    this.pen.fillStyle = INK;
    this.pen.fillRect(16, y, length * this.view.scale, 4);
    this.label(length >= 1 ? `${length} m` : `${Math.round(1000 * length)} mm`, 16, y - 6);
  }
}

/** A line chart of [x, y] points with y from zero. */
export function chart(canvas, points, mark = null) {
  const dense = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight, pen = canvas.getContext("2d", {willReadFrequently: true});
  canvas.width = Math.round(width * dense), canvas.height = Math.round(height * dense);
  pen.setTransform(dense, 0, 0, dense, 0, 0);
  const shown = points.filter(p => p[1] !== null);
  const top = 1.15 * Math.max(mark ?? 0, ...shown.map(p => p[1]), 1e-9);
  const left = 52, x = i => left + (width - left - 6) * i / Math.max(1, points.length - 1), y = v => height - 8 - (height - 16) * v / top;
  pen.font = FONT, pen.fillStyle = INK;
  pen.fillText((top / 1.15).toPrecision(2).replace(/e\+?/, "e"), 4, 20);
  pen.fillText("0", 4, height - 6);
  if (mark !== null) { pen.strokeStyle = "#7a8793"; pen.setLineDash([5, 5]); pen.beginPath(); pen.moveTo(left, y(mark)); pen.lineTo(width, y(mark)); pen.stroke(); pen.setLineDash([]); }
  pen.strokeStyle = ACT, pen.lineWidth = 2;
  pen.beginPath();
  let drawn = false;
  points.forEach((p, i) => { if (p[1] === null) { drawn = false; return; } drawn ? pen.lineTo(x(i), y(p[1])) : pen.moveTo(x(i), y(p[1])); drawn = true; });
  pen.stroke();
}
