"use strict";
// The robot, turned by mouse, touch or keys; errors as arrows, deflected shape and compliance beside it.
class View {
  constructor(figure, data) {
    this.figure = figure; this.data = data;
    this.canvas = figure.querySelector("canvas"); this.context = this.canvas.getContext("2d");
    this.shots = data[figure.dataset.shots] || []; this.shot = 0;
    this.arrows = "arrows" in figure.dataset ? data.arrows : null;
    this.control = Object.fromEntries([...figure.querySelectorAll("[data-control]")].map((e) => [e.dataset.control, e]));
    this.camera = new Paint.Camera();
    const points = (this.arrows ? this.shots.slice(0, 1) : this.shots).flatMap((s) => s.points.filter((_, k) => this.reaches.has(k)));
    this.camera.fit(points.concat(this.arrows ? this.arrows.points : []));
    this.hidden = new Set(["frame", "mass", ...(this.arrows ? ["name"] : [])]);
    this.layers(); this.shotNames(); this.listen(); this.draw();
  }
  // Points that say how large the robot is: instruments stand far off.
  get reaches() {
    if (!this.within) this.within = new Set(this.data.parts.filter((p) => p.kind !== "anchor").flatMap((p) => p.points));
    return this.within;
  }
  layers() {
    const words = { name: "names", joint: "joints", frame: "frames", beam: "beams", actuator: "actuators", spring: "springs", mass: "masses", marker: "markers", arrows: "errors", moved: "deflected", compliance: "compliance" };
    const has = (kind) => kind === "name" || this.data.parts.some((p) => p.kind === kind) || (kind === "arrows" && this.arrows) || this.shots.some((s) => s[kind]);
    for (const [kind, word] of Object.entries(words)) {
      if (!has(kind)) continue;
      const label = document.createElement("label"), box = document.createElement("input");
      box.type = "checkbox"; box.checked = !this.hidden.has(kind); box.dataset.layer = kind;
      box.addEventListener("change", () => { box.checked ? this.hidden.delete(kind) : this.hidden.add(kind); this.draw(); });
      label.append(box, " " + word); this.control.layers.append(label);
    }
  }
  shotNames() {
    if (!this.control.shot) return;
    this.shots.forEach((shot, k) => this.control.shot.append(new Option(shot.name, k)));
    if (this.shots.length < 2) this.control.shot.closest("label").hidden = true;
  }
  listen() {
    const canvas = this.canvas, held = new Map();
    const turn = (dx, dy) => { this.camera.yaw -= 0.45 * dx; this.camera.pitch = Math.max(-90, Math.min(90, this.camera.pitch + 0.45 * dy)); this.draw(); };
    canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); held.set(e.pointerId, [e.clientX, e.clientY]); });
    canvas.addEventListener("pointermove", (e) => {
      const last = held.get(e.pointerId);
      if (!last) { this.tip(e.offsetX, e.offsetY); return; }
      const apart = () => { const [a, b] = [...held.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
      const before = held.size === 2 ? apart() : 0;
      held.set(e.pointerId, [e.clientX, e.clientY]);
      if (held.size === 2) { this.near(apart() / Math.max(before, 1)); } else { turn(e.clientX - last[0], e.clientY - last[1]); }
    });
    const release = (e) => held.delete(e.pointerId);
    canvas.addEventListener("pointerup", release); canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", () => { this.figure.querySelector(".tip").hidden = true; });
    // The page scrolls unless the view was chosen by a click or by keys.
    canvas.addEventListener("wheel", (e) => { if (document.activeElement === canvas) { e.preventDefault(); this.near(Math.exp(-0.0015 * e.deltaY)); } }, { passive: false });
    canvas.addEventListener("keydown", (e) => {
      const keys = { ArrowLeft: () => turn(-12, 0), ArrowRight: () => turn(12, 0), ArrowUp: () => turn(0, -12), ArrowDown: () => turn(0, 12), "+": () => this.near(1.15), "=": () => this.near(1.15), "-": () => this.near(1 / 1.15) };
      if (keys[e.key]) { e.preventDefault(); keys[e.key](); }
    });
    this.figure.querySelectorAll("[data-turn]").forEach((button) => button.addEventListener("click", () => {
      [this.camera.yaw, this.camera.pitch] = button.dataset.turn.split(",").map(Number); this.draw();
    }));
    for (const name of ["stage", "scale", "shot"]) this.control[name]?.addEventListener("input", () => { if (name === "shot") this.shot = Number(this.control.shot.value); this.draw(); });
    new ResizeObserver(() => this.draw()).observe(canvas);
  }
  near(factor) { this.camera.zoom = Math.max(0.3, Math.min(30, this.camera.zoom * factor)); this.draw(); }
  tip(x, y) {
    const tip = this.figure.querySelector(".tip"), shot = this.shots[this.shot];
    if (!shot) return;
    let best = [15, null];
    for (const part of this.data.parts) {
      if (this.hidden.has(part.kind) || part.kind === "link") continue;
      const at = part.points.map((k) => this.camera.at(shot.points[k]));
      const [px, py] = part.kind === "joint" || part.kind === "frame" ? at[0] : part.kind === "tool" || part.kind === "marker" ? at[1] : [0, 1].map((c) => at.reduce((sum, p) => sum + p[c], 0) / at.length);
      const far = Math.hypot(px - x, py - y);
      if (far < best[0]) best = [far, part];
    }
    tip.hidden = !best[1];
    if (best[1]) { tip.textContent = best[1].words; tip.style.left = Math.min(x + 14, this.canvas.clientWidth - 180) + "px"; tip.style.top = (this.canvas.offsetTop + y + 12) + "px"; }
  }
  draw() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (!width || !height) return;
    const ratio = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) { this.canvas.width = Math.round(width * ratio); this.canvas.height = Math.round(height * ratio); }
    const c = this.context, color = Paint.colors();
    c.setTransform(ratio, 0, 0, ratio, 0, 0); c.clearRect(0, 0, width, height);
    this.camera.prepare(width, height);
    const sheet = new Paint.Sheet(c, this.camera), shot = this.shots[this.shot];
    const told = [];
    if (shot) {
      if (this.arrows) told.push(`Errors: ${this.control.stage.selectedOptions[0].text}; the robot at ${shot.name}.`);
      this.ground(sheet, color);
      if (this.figure.dataset.shots === "next") this.shots.forEach((other) => { if (other !== shot) this.bones(sheet, other.points, color.grey, 2, 0.25); });
      const moved = shot.moved && !this.hidden.has("moved");
      this.robot(sheet, shot.points, color, moved ? 0.35 : 1);
      if (moved) told.push(this.deflected(sheet, shot, color));
      if (shot.compliance && !this.hidden.has("compliance")) told.push(this.ellipsoid(sheet, shot, color));
    }
    const key = this.arrows && !this.hidden.has("arrows") ? this.errors(sheet, color, shot) : null;
    sheet.paint();
    this.triad(c, color, height);
    if (key) this.key(c, color, key, width, height);
    this.figure.querySelector(".legend").textContent = told.filter(Boolean).join(" ") + (key && key.drawn < key.of ? ` ${key.drawn} of ${key.of} arrows drawn.` : "");
    this.state = { yaw: this.camera.yaw, pitch: this.camera.pitch, zoom: this.camera.zoom, shot: this.shot, arrows: key ? key.drawn : 0, largest: key ? key.largest : 0 };
  }
  ground(sheet, color) {
    const r = 1.6 * this.data.axis, ring = (s) => Array.from({ length: 33 }, (_, k) => [s * r * Math.cos(k * Math.PI / 16), s * r * Math.sin(k * Math.PI / 16), 0]);
    sheet.line(ring(1), color.rule, 1.5); sheet.line(ring(0.6), color.rule, 1);
  }
  bones(sheet, points, color, width, alpha) {
    for (const part of this.data.parts) if (part.kind === "link") sheet.line(part.points.map((k) => points[k]), color, width, { alpha });
  }
  robot(sheet, points, color, alpha) {
    const suspects = new Set(this.data.suspects || []), names = !this.hidden.has("name");
    this.data.parts.forEach((part) => {
      if (this.hidden.has(part.kind)) return;
      const p = part.points.map((k) => points[k]), suspect = (part.sites || []).some((s) => suspects.has(s));
      const own = suspect ? color.orange : null;
      this.part(sheet, part, p, color, own, alpha);
      if (!names) { if (suspect && part.kind !== "link" && part.kind !== "beam") sheet.text(p[0], part.sites.find((s) => suspects.has(s)), color.orange); return; }
      const middle = p.length > 1 ? Paint.add(p[0], Paint.less(p[1], p[0]), 0.5) : p[0];
      const label = { joint: p[0], actuator: middle, spring: middle, marker: p[1], tool: p[1], anchor: p[0], cut: p[0] }[part.kind];
      if (label) sheet.text(label, part.name, own || color.ink, 8, part.kind === "cut" ? 16 : -7);
    });
  }
  part(sheet, part, p, color, own, alpha) {
    const axis = this.data.axis;
    switch (part.kind) {
      case "link": sheet.line(p, own || color.grey, own ? 7 : 5, { alpha: 0.75 * alpha }); break;
      case "beam": this.prism(sheet, p, own || color.blue, color.ink, 0.13 * alpha); break;
      case "joint": {
        const along = Paint.less(p[1], p[0]), tint = own || { variable: color.blue, actuator: color.blue, coupling: color.violet, passive: color.grey }[part.drive];
        const [a, b] = [Paint.add(p[0], along, -0.42), Paint.add(p[0], along, 0.42)];
        sheet.line([a, b], color.paper, 12, { alpha, lift: 0.001 * axis }); sheet.line([a, b], tint, part.form === "prismatic" ? 5 : 9, { alpha, lift: 0.002 * axis });
        if (part.form === "prismatic") { sheet.line([a, b], tint, 11, { alpha: 0.3 * alpha, lift: 0.002 * axis }); }
        sheet.dot(p[0], 2.5, part.drive === "passive" ? color.paper : tint, tint, axis);
        break;
      }
      case "frame": [color.red, color.green, color.blue].forEach((tint, k) => sheet.line([p[0], p[k + 1]], tint, 1.5)); break;
      case "tool": sheet.line([p[0], p[1]], color.grey, 3, { alpha }); [color.red, color.green, color.blue].forEach((tint, k) => sheet.line([p[1], p[k + 2]], tint, 2)); sheet.dot(p[1], 3.5, color.ink, color.paper, axis); break;
      case "cut": sheet.dot(p[0], 7, null, own || color.violet, axis); sheet.line(p, color.violet, 2, { dash: [3, 3] }); break;
      case "actuator": { const half = Paint.add(p[0], Paint.less(p[1], p[0]), 0.55); sheet.line([p[0], half], own || color.green, 8, { alpha }); sheet.line([half, p[1]], own || color.green, 3.5, { alpha }); p.forEach((q) => sheet.dot(q, 3.5, color.paper, own || color.green, axis)); break; }
      case "spring": this.coil(sheet, p[0], p[1], own || color.red, alpha); break;
      case "mass": sheet.dot(p[0], 5, color.paper, color.ink, axis); sheet.dot(p[0], 2, color.ink, null, 1.1 * axis); break;
      case "marker": sheet.line(p, color.grey, 1, { dash: [2, 3] }); sheet.dot(p[1], 4, color.green, color.paper, axis); break;
      case "anchor": sheet.dot(p[0], 5, color.violet, color.paper, axis); break;
    }
  }
  prism(sheet, p, fill, edge, alpha) {
    const n = p.length / 2;
    for (let k = 0; k < n; k++) { const m = (k + 1) % n; sheet.face([p[k], p[m], p[n + m], p[n + k]], fill, edge, alpha); }
    sheet.face(p.slice(0, n), fill, edge, alpha); sheet.face(p.slice(n), fill, edge, alpha);
  }
  coil(sheet, a, b, color, alpha) {
    const along = Paint.less(b, a), length = Paint.norm(along), turns = 9;
    const side = Math.abs(along[2]) < 0.9 * length ? [along[1], -along[0], 0] : [0, along[2], -along[1]];
    const width = 0.28 * this.data.axis / Math.max(Paint.norm(side), 1e-9), points = [a, Paint.add(a, along, 0.12)];
    for (let k = 0; k <= 2 * turns; k++) points.push(Paint.add(Paint.add(a, along, 0.14 + 0.72 * k / (2 * turns)), side, k % 2 ? width : -width));
    points.push(Paint.add(a, along, 0.88), b);
    sheet.line(points, color, 2, { alpha }); [a, b].forEach((q) => sheet.dot(q, 3, color, null, this.data.axis));
  }
  deflected(sheet, shot, color) {
    const bodies = this.data.parts.filter((p) => p.kind === "link" || p.kind === "beam").flatMap((p) => p.points);
    const most = Math.max(...bodies.map((k) => Paint.norm(shot.moved[k]))), times = this.data.magnified || Paint.nice(0.12 * this.camera.span / most);
    if (!(most > 0)) return "";
    const points = shot.points.map((p, k) => Paint.add(p, shot.moved[k], times));
    this.bones(sheet, points, color.orange, 4, 0.9);
    for (const part of this.data.parts) {
      const p = part.points.map((k) => points[k]);
      if (part.kind === "beam" && !this.hidden.has("beam")) this.prism(sheet, p, color.orange, color.orange, 0.1);
      if (part.kind === "tool") { sheet.line([p[0], p[1]], color.orange, 3); sheet.dot(p[1], 3.5, color.orange, color.paper, this.data.axis); }
    }
    this.times = times;
    return `Orange: deflected shape, magnified ${times.toLocaleString("en")} times.`;
  }
  ellipsoid(sheet, shot, color) {
    const tool = this.data.parts.find((p) => p.kind === "tool"), c = shot.compliance;
    const by = (n) => c.map((row) => row[0] * n[0] + row[1] * n[1] + row[2] * n[2]);
    const rings = [[0, 1], [1, 2], [2, 0]].map(([i, j]) => Array.from({ length: 41 }, (_, k) => { const n = [0, 0, 0]; n[i] = Math.cos(k * Math.PI / 20); n[j] = Math.sin(k * Math.PI / 20); return by(n); }));
    const most = Math.max(...rings.flat().map(Paint.norm));
    if (!(most > 0)) return "";
    const times = Paint.nice(0.1 * this.camera.span / (1e3 * most)), at = shot.points[tool.points[1]];
    for (const ring of rings) sheet.line(ring.map((p) => Paint.add(at, p, 1e3 * times)), color.red, 1.4);
    return `Red: displacement of the tool by 1 kN in any direction, magnified ${times.toLocaleString("en")} times; at most ${(1e6 * most).toFixed(3)} mm.`;
  }
  errors(sheet, color, shot) {
    const all = this.arrows.errors[this.control.stage.value] || [], sizes = all.map(Paint.norm).sort((a, b) => a - b);
    if (!sizes.length) return null;
    const common = sizes[Math.floor(0.95 * (sizes.length - 1))] || 1e-6, factor = 10 ** Number(this.control.scale.value);
    const length = factor * 0.1 * this.camera.span / common, here = new Set((shot && shot.rows) || []);
    const low = Math.min(this.arrows.noise, common), tint = (size) => Paint.mix(color.blue, color.red, (size - low) / Math.max(common - low, 1e-9));
    all.forEach((e, k) => {
      const size = Paint.norm(e), own = here.has(this.arrows.rows[k]);
      sheet.arrow(this.arrows.points[k], e.map((v) => v * length), tint(size), own ? 1 : 0.6, own ? 2.6 : 1.5);
    });
    return { length, tint, low, common, largest: sizes[sizes.length - 1], drawn: all.length, of: this.arrows.of };
  }
  key(c, color, key, width, height) {
    const bar = Paint.nice(1.4 * key.common), long = bar * key.length * this.camera.scale, x = width - 16, y = height - 18;
    c.font = "12px system-ui, sans-serif"; c.textAlign = "right"; c.fillStyle = color.ink; c.strokeStyle = color.ink; c.lineWidth = 2;
    const shown = Math.min(long, 0.4 * width);
    c.beginPath(); c.moveTo(x - shown, y); c.lineTo(x, y); c.moveTo(x - shown, y - 4); c.lineTo(x - shown, y + 4); c.moveTo(x, y - 4); c.lineTo(x, y + 4); c.stroke();
    c.fillText(`error of ${Number((bar * shown / long).toPrecision(2))} mm`, x, y - 8);
    const ramp = 110;
    for (let k = 0; k < ramp; k++) { c.fillStyle = key.tint(key.low + (key.common - key.low) * k / ramp); c.fillRect(x - ramp + k, y - 44, 1.5, 8); }
    c.fillStyle = color.ink; c.fillText(`${key.low.toPrecision(2)} to ${key.common.toPrecision(2)} mm and more`, x, y - 50); c.textAlign = "left";
  }
  triad(c, color, height) {
    const [x, y, size] = [34, height - 30, 22], camera = this.camera;
    [["x", color.red], ["y", color.green], ["z", color.blue]].forEach(([name, tint], k) => {
      const dx = size * camera.right[k], dy = -size * camera.up[k];
      c.strokeStyle = tint; c.fillStyle = tint; c.lineWidth = 2; c.beginPath(); c.moveTo(x, y); c.lineTo(x + dx, y + dy); c.stroke();
      c.font = "12px system-ui, sans-serif"; c.fillText(name, x + 1.3 * dx - 3, y + 1.3 * dy + 4);
    });
  }
}
