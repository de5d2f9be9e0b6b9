"use strict";
// Projection and strokes of the 3-D view: an orthographic camera over a 2-D canvas, nearer things painted last.
const Paint = (() => {
  const colors = () => {
    const style = getComputedStyle(document.documentElement);
    const of = (name) => style.getPropertyValue("--" + name).trim();
    return Object.fromEntries(["ink", "paper", "soft", "rule", "grey", "blue", "orange", "red", "green", "violet"].map((n) => [n, of(n)]));
  };
  const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
  const less = (a, b) => add(a, b, -1);
  const norm = (a) => Math.hypot(a[0], a[1], a[2]);

  class Camera {
    constructor() { this.yaw = -50; this.pitch = 20; this.zoom = 1; this.center = [0, 0, 0]; this.span = 1; }
    // What is to be seen, m: from where the camera stands now it fills the picture, and turning changes no size.
    fit(points) {
      this.points = points;
      const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
      for (const p of points) for (let k = 0; k < 3; k++) { low[k] = Math.min(low[k], p[k]); high[k] = Math.max(high[k], p[k]); }
      if (!(high[0] >= low[0])) return;
      this.center = low.map((v, k) => 0.5 * (v + high[k]));
      this.span = Math.max(norm(less(high, low)), 1e-3);
    }
    prepare(width, height) {
      const [y, p] = [this.yaw * Math.PI / 180, this.pitch * Math.PI / 180];
      const [cy, sy, cp, sp] = [Math.cos(y), Math.sin(y), Math.cos(p), Math.sin(p)];
      // Right, up, towards the eye. At yaw 0 and pitch 0 the eye stands at -y: x to the right, z up.
      this.right = [cy, sy, 0];
      this.up = [-sp * sy, sp * cy, cp];
      this.eye = [cp * sy, -cp * cy, sp];
      this.middle = [width / 2, height / 2];
      if (this.size !== width + "x" + height) { this.size = width + "x" + height; this.unit = this.filling(width, height); }
      this.scale = this.unit * this.zoom;
    }
    // Pixels a metre at which all points are within the picture, as the camera stands.
    filling(width, height) {
      const reach = [1e-6, 1e-6];
      for (const p of this.points || []) {
        const d = less(p, this.center);
        [this.right, this.up].forEach((a, k) => { reach[k] = Math.max(reach[k], Math.abs(a[0] * d[0] + a[1] * d[1] + a[2] * d[2])); });
      }
      return 0.5 * Math.min(0.9 * width / reach[0], 0.8 * height / reach[1]);
    }
    // Screen x, screen y, depth (greater is nearer).
    at(point) {
      const d = less(point, this.center);
      const dot = (a) => a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
      return [this.middle[0] + this.scale * dot(this.right), this.middle[1] - this.scale * dot(this.up), dot(this.eye)];
    }
  }

  // Strokes collected with their depths, then painted from the back.
  class Sheet {
    constructor(context, camera) { this.context = context; this.camera = camera; this.strokes = []; this.names = []; }
    later(depth, draw) { this.strokes.push([depth, draw]); }
    line(points, color, width, { dash = [], alpha = 1, lift = 0 } = {}) {
      const at = points.map((p) => this.camera.at(p));
      for (let k = 1; k < at.length; k++) {
        const [a, b] = [at[k - 1], at[k]];
        this.later(0.5 * (a[2] + b[2]) + lift, (c) => {
          c.globalAlpha = alpha; c.strokeStyle = color; c.lineWidth = width; c.lineCap = "round"; c.setLineDash(dash);
          c.beginPath(); c.moveTo(a[0], a[1]); c.lineTo(b[0], b[1]); c.stroke();
        });
      }
    }
    face(points, color, edge, alpha) {
      const at = points.map((p) => this.camera.at(p));
      this.later(at.reduce((sum, p) => sum + p[2], 0) / at.length, (c) => {
        c.beginPath(); at.forEach((p, k) => (k ? c.lineTo(p[0], p[1]) : c.moveTo(p[0], p[1]))); c.closePath();
        c.setLineDash([]); c.globalAlpha = alpha; c.fillStyle = color; c.fill();
        c.globalAlpha = Math.min(1, 2.2 * alpha); c.strokeStyle = edge; c.lineWidth = 1; c.stroke();
      });
    }
    dot(point, radius, fill, edge, lift = 0) {
      const p = this.camera.at(point);
      this.later(p[2] + lift, (c) => {
        c.globalAlpha = 1; c.setLineDash([]); c.beginPath(); c.arc(p[0], p[1], radius, 0, 2 * Math.PI);
        if (fill) { c.fillStyle = fill; c.fill(); }
        if (edge) { c.strokeStyle = edge; c.lineWidth = 1.5; c.stroke(); }
      });
    }
    arrow(from, vector, color, alpha, width = 1.6) {
      const a = this.camera.at(from), b = this.camera.at(add(from, vector));
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      this.later(b[2], (c) => {
        c.globalAlpha = alpha; c.strokeStyle = color; c.fillStyle = color; c.lineWidth = width; c.setLineDash([]); c.lineCap = "round";
        c.beginPath(); c.moveTo(a[0], a[1]); c.lineTo(b[0], b[1]); c.stroke();
        if (length < 3) { c.beginPath(); c.arc(a[0], a[1], 1.4, 0, 2 * Math.PI); c.fill(); return; }
        const head = Math.min(7, 0.45 * length), [ux, uy] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
        c.beginPath(); c.moveTo(b[0], b[1]);
        c.lineTo(b[0] - head * (ux + 0.5 * uy), b[1] - head * (uy - 0.5 * ux));
        c.lineTo(b[0] - head * (ux - 0.5 * uy), b[1] - head * (uy + 0.5 * ux)); c.fill();
      });
    }
    // Names at one place are written side by side.
    text(point, text, color, dx = 7, dy = -7) {
      const p = this.camera.at(point), at = [p[0] + dx, p[1] + dy];
      const near = this.names.find((n) => Math.hypot(n.at[0] - at[0], n.at[1] - at[1]) < 12);
      if (near) near.text += ", " + text; else this.names.push({ at, text, color });
    }
    paint() {
      this.strokes.sort((a, b) => a[0] - b[0]);
      const c = this.context;
      for (const [, draw] of this.strokes) draw(c);
      c.globalAlpha = 1; c.setLineDash([]);
      c.font = "12px system-ui, sans-serif"; c.lineWidth = 3; c.lineJoin = "round"; c.strokeStyle = colors().paper;
      for (const { at, text, color } of this.names) { c.strokeText(text, at[0], at[1]); c.fillStyle = color; c.fillText(text, at[0], at[1]); }
    }
  }

  // The nearest of 1, 2, 5 times a power of ten below a number.
  const nice = (value) => {
    if (!(value > 0) || !isFinite(value)) return 1;
    const size = 10 ** Math.floor(Math.log10(value)), m = value / size;
    return (m >= 5 ? 5 : m >= 2 ? 2 : 1) * size;
  };
  // From a to b, colours as #rrggbb.
  const mix = (a, b, share) => {
    const of = (h, k) => parseInt(h.slice(1 + 2 * k, 3 + 2 * k), 16);
    const s = Math.max(0, Math.min(1, share));
    return "rgb(" + [0, 1, 2].map((k) => Math.round(of(a, k) + s * (of(b, k) - of(a, k)))).join(",") + ")";
  };
  return { Camera, Sheet, colors, add, less, norm, nice, mix };
})();
