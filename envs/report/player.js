"use strict";

// Plays recorded episodes on one or two canvases. Positions are world metres in centimetre steps;
// the view of a scenario maps them to the canvas. Everything it needs stands in the page.

const RECORDS = JSON.parse(document.getElementById("records").textContent);
const TRAIL_SECONDS = 2.8;
const TRUTHS = 8; // true paths are drawn for this many people nearest to the robot
const COLORS = {
  person: "#2f6fb3", unseen: "#8a93a0", robot: "#e4572e", goal: "#1a9850",
  forecast: "#8e44ad", truth: "#111827", history: "#2f6fb3", contact: "#d6152b", halo: "#ffffff",
};

async function decode(packed) {
  const bytes = Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const values = new Int16Array(await new Response(stream).arrayBuffer());
  const row = values.length / Math.max(packed.rows, 1);
  for (let i = row; i < values.length; i += 1) values[i] += values[i - row];
  return values;
}

class Episode {
  constructor(record) {
    this.record = record;
    this.ready = null;
  }

  load() {
    this.ready ??= this.decodeAll();
    return this.ready;
  }

  async decodeAll() {
    const r = this.record;
    [this.people, this.ids, this.robot, this.seen, this.goals] = await Promise.all(
      [r.people, r.ids, r.robot, r.seen, r.goal].map(decode));
    if (r.forecast) {
      [this.forecast, this.columns] = await Promise.all([r.forecast, r.columns].map(decode));
    }
  }

  get last() { return this.record.steps - 1; }

  id(t, n) { return this.ids[t * this.record.count + n]; }

  person(t, n) {
    const i = 2 * (t * this.record.count + n);
    return [this.people[i] / 100, this.people[i + 1] / 100];
  }

  goal(t) { return [this.goals[2 * t] / 100, this.goals[2 * t + 1] / 100]; }

  robotAt(t) {
    return [this.robot[3 * t] / 100, this.robot[3 * t + 1] / 100, this.robot[3 * t + 2] / 1000];
  }
}

class Stage {
  constructor(root) {
    this.root = root;
    this.canvas = root.querySelector("canvas");
    this.caption = root.querySelector("figcaption");
    this.context = this.canvas.getContext("2d");
    this.episode = null;
  }

  show(episode, view, image) {
    [this.episode, this.view, this.image] = [episode, view, image];
    this.canvas.setAttribute("aria-label", `Replay of ${episode.record.arm}: ${episode.record.outcome_text}`);
    this.resize();
  }

  resize() {
    if (!this.view) return;
    const width = this.canvas.clientWidth;
    const [x0, y0, x1, y1] = this.view.bounds;
    this.canvas.style.aspectRatio = `${x1 - x0} / ${y1 - y0}`;
    const ratio = window.devicePixelRatio;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round((width * (y1 - y0)) / (x1 - x0) * ratio);
    this.scale = this.canvas.width / (x1 - x0);
  }

  x(x) { return (x - this.view.bounds[0]) * this.scale; }
  y(y) { return (this.view.bounds[3] - y) * this.scale; }

  draw(time, layers) {
    const episode = this.episode;
    const t = Math.min(time, episode.last);
    const row = Math.floor(t);
    this.context.setTransform(1, 0, 0, 1, 0, 0);
    this.context.drawImage(this.image, 0, 0, this.canvas.width, this.canvas.height);
    this.drawGoal(episode.goal(row));
    if (layers.history) this.drawHistories(row, t);
    if (layers.truth) this.drawTruth(row);
    if (layers.forecast && episode.forecast) this.drawForecasts(row);
    this.drawPeople(row, t);
    this.drawRobot(t, layers.history);
    this.describe(t);
  }

  // Positions between two rows are interpolated for the eye only; a new id never glides in.
  between(row, t, n) {
    const e = this.episode;
    const next = Math.min(row + 1, e.last);
    const here = e.person(row, n);
    if (e.id(next, n) !== e.id(row, n)) return here;
    const there = e.person(next, n);
    const share = t - row;
    return [here[0] + share * (there[0] - here[0]), here[1] + share * (there[1] - here[1])];
  }

  line(points, color, width, alpha, dash) {
    if (points.length < 2) return;
    const c = this.context;
    c.save();
    c.globalAlpha = alpha;
    c.strokeStyle = color;
    c.lineWidth = width * this.scale;
    c.lineJoin = c.lineCap = "round";
    c.setLineDash((dash ?? []).map((d) => d * this.scale));
    c.beginPath();
    points.forEach(([x, y], i) => (i ? c.lineTo(this.x(x), this.y(y)) : c.moveTo(this.x(x), this.y(y))));
    c.stroke();
    c.restore();
  }

  disc([x, y], radius, fill, alpha, edge) {
    const c = this.context;
    c.save();
    c.globalAlpha = alpha;
    c.beginPath();
    c.arc(this.x(x), this.y(y), Math.max(radius * this.scale, 1), 0, 2 * Math.PI);
    c.fillStyle = fill;
    c.fill();
    if (edge) {
      c.lineWidth = Math.max(0.035 * this.scale, 1);
      c.strokeStyle = edge;
      c.stroke();
    }
    c.restore();
  }

  drawGoal([x, y]) {
    const c = this.context;
    c.beginPath();
    for (let k = 0; k < 10; k += 1) {
      const r = (k % 2 ? 0.2 : 0.48) * this.scale;
      const a = -Math.PI / 2 + (k * Math.PI) / 5;
      c.lineTo(this.x(x) + r * Math.cos(a), this.y(y) + r * Math.sin(a));
    }
    c.closePath();
    c.fillStyle = COLORS.goal;
    c.strokeStyle = "#ffffff";
    c.lineWidth = Math.max(0.05 * this.scale, 1);
    c.fill();
    c.stroke();
  }

  stretch(n, from, to, id) {
    const points = [];
    for (let t = from; t <= to && this.episode.id(t, n) === id; t += 1) points.push(this.episode.person(t, n));
    return points;
  }

  drawHistories(row, t) {
    const e = this.episode;
    const back = Math.round(TRAIL_SECONDS / e.record.dt);
    for (let n = 0; n < e.record.count; n += 1) {
      const id = e.id(row, n);
      if (id < 0) continue;
      const points = [];
      for (let k = row; k >= Math.max(0, row - back) && e.id(k, n) === id; k -= 1) points.push(e.person(k, n));
      this.line([this.between(row, t, n), ...points], COLORS.history, 0.07, 0.55);
    }
  }

  nearestSeen(row) {
    const e = this.episode;
    const [x, y] = e.robotAt(row);
    const near = [];
    for (let n = 0; n < e.record.count; n += 1) {
      if (e.id(row, n) < 0 || !e.seen[row * e.record.count + n]) continue;
      const [px, py] = e.person(row, n);
      near.push([Math.hypot(px - x, py - y), n]);
    }
    return near.sort((a, b) => a[0] - b[0]).slice(0, TRUTHS).map((pair) => pair[1]);
  }

  drawTruth(row) {
    const e = this.episode;
    const ahead = Math.min(e.last, row + Math.round(e.record.horizon / e.record.dt));
    for (const n of this.nearestSeen(row)) {
      const path = this.stretch(n, row, ahead, e.id(row, n));
      this.line(path, COLORS.halo, 0.11, 0.7);
      this.line(path, COLORS.truth, 0.05, 0.9);
    }
  }

  drawForecasts(row) {
    const e = this.episode;
    const { slots, frames, count } = e.record;
    for (let k = 0; k < slots; k += 1) {
      const n = e.columns[row * slots + k];
      if (n < 0 || n >= count) continue;
      const points = [e.person(row, n)];
      for (let f = 0; f < frames; f += 1) {
        const i = 2 * ((row * slots + k) * frames + f);
        points.push([e.forecast[i] / 100, e.forecast[i + 1] / 100]);
      }
      this.line(points, COLORS.forecast, 0.06, 0.9, [0.16, 0.14]);
      points.slice(1).forEach((p) => this.disc(p, 0.065, COLORS.forecast, 0.95));
    }
  }

  drawPeople(row, t) {
    const e = this.episode;
    const next = Math.min(row + 1, e.last);
    for (let n = 0; n < e.record.count; n += 1) {
      if (e.id(row, n) < 0) continue;
      const seen = e.seen[row * e.record.count + n];
      const at = this.between(row, t, n);
      const radius = e.record.radius[n];
      this.disc(at, radius, seen ? COLORS.person : COLORS.unseen, 0.95, "#ffffff");
      const [here, there] = [e.person(row, n), e.person(next, n)];
      if (e.id(next, n) === e.id(row, n)) this.nose(at, there[0] - here[0], there[1] - here[1], radius);
    }
  }

  nose([x, y], dx, dy, radius) {
    const length = Math.hypot(dx, dy);
    if (length < 0.01) return;
    this.line([[x, y], [x + (dx / length) * radius * 1.5, y + (dy / length) * radius * 1.5]], "#ffffff", 0.07, 1);
  }

  drawRobot(t, trail) {
    const e = this.episode;
    const row = Math.floor(t);
    const [x, y, heading] = e.robotAt(row);
    const [nx, ny] = e.robotAt(Math.min(row + 1, e.last));
    const at = [x + (t - row) * (nx - x), y + (t - row) * (ny - y)];
    if (trail) {
      const path = [];
      for (let k = 0; k <= row; k += 1) path.push(e.robotAt(k).slice(0, 2));
      this.line([...path, at], COLORS.robot, 0.09, 0.8);
    }
    this.disc(at, e.record.robot_radius, COLORS.robot, 1, "#ffffff");
    this.nose(at, Math.cos(heading), Math.sin(heading), e.record.robot_radius);
    if (t >= e.last && e.record.outcome.startsWith("collision")) this.ring(at);
  }

  ring([x, y]) {
    const c = this.context;
    c.beginPath();
    c.arc(this.x(x), this.y(y), 0.75 * this.scale, 0, 2 * Math.PI);
    c.lineWidth = 0.12 * this.scale;
    c.strokeStyle = COLORS.contact;
    c.stroke();
  }

  describe(t) {
    const r = this.episode.record;
    const done = t >= this.episode.last;
    this.caption.dataset.outcome = done ? r.outcome : "";
    const end = done ? `: ${r.outcome_text} at ${(this.episode.last * r.dt).toFixed(1)} s` : "";
    this.caption.textContent = `${r.arm}${end}`;
  }
}

class Player {
  constructor(root) {
    this.root = root;
    this.find = (name) => root.querySelector(`[data-player="${name}"]`);
    this.stages = [...root.querySelectorAll("figure")].map((figure) => new Stage(figure));
    this.episodes = RECORDS.episodes.map((record) => new Episode(record));
    this.time = 0;
    this.playing = false;
    this.choice = 0;
    this.images = new Map();
    this.fillGroups();
    this.listen();
  }

  fillGroups() {
    RECORDS.groups.forEach((group, i) => this.find("group").add(new Option(group.title, i)));
    this.fillArms();
  }

  fillArms() {
    const group = RECORDS.groups[this.find("group").value];
    ["left", "right"].forEach((side, i) => {
      const select = this.find(side);
      const kept = select.selectedOptions[0]?.text;
      select.replaceChildren();
      if (side === "right") select.add(new Option("nothing", ""));
      group.episodes.forEach((e) => select.add(new Option(RECORDS.episodes[e].arm, e)));
      const same = [...select.options].find((o) => o.text === kept);
      const fallback = i === 0 ? select.options[select.options.length - 1] : select.options[group.compare + 1];
      (same ?? fallback).selected = true;
    });
  }

  listen() {
    this.find("group").addEventListener("change", () => { this.fillArms(); this.choose(); });
    ["left", "right"].forEach((side) => this.find(side).addEventListener("change", () => this.choose()));
    this.find("play").addEventListener("click", () => this.toggle());
    this.find("scrub").addEventListener("input", (event) => {
      this.pause();
      this.seek(Number(event.target.value));
    });
    this.root.querySelectorAll("[data-layer]").forEach((box) => box.addEventListener("change", () => this.draw()));
    this.root.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => { this.stages.forEach((s) => s.resize()); this.draw(); }).observe(this.root);
  }

  key(event) {
    const typing = ["SELECT", "INPUT", "BUTTON"].includes(event.target.tagName);
    if (event.key === " " && !typing) this.toggle();
    else if (event.key === "ArrowRight" && !typing) this.seek(this.time + 1);
    else if (event.key === "ArrowLeft" && !typing) this.seek(this.time - 1);
    else return;
    event.preventDefault();
  }

  image(url) {
    if (!this.images.has(url)) {
      const image = new Image();
      image.src = url;
      this.images.set(url, image.decode().then(() => image));
    }
    return this.images.get(url);
  }

  async choose() {
    this.pause();
    this.choice += 1;
    const choice = this.choice;
    const group = RECORDS.groups[this.find("group").value];
    const view = RECORDS.views[group.view];
    const chosen = ["left", "right"].map((side) => this.find(side).value);
    const shown = chosen.map((value) => (value === "" ? null : this.episodes[Number(value)]));
    const [image] = await Promise.all([this.image(view.image), ...shown.map((e) => e?.load())]);
    if (choice !== this.choice) return; // a later choice has overtaken this one
    this.stages.forEach((stage, i) => { stage.root.hidden = shown[i] === null; });
    this.stages.forEach((stage, i) => {
      stage.episode = null;
      if (shown[i]) stage.show(shown[i], view, image);
    });
    this.dt = shown[0].record.dt;
    this.end = Math.max(...shown.filter(Boolean).map((e) => e.last));
    this.find("scrub").max = this.end;
    this.seek(0);
    this.root.dataset.ready = "true";
  }

  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.end);
    this.find("scrub").value = this.time;
    const text = `${(this.time * this.dt).toFixed(1)} s`;
    this.find("scrub").setAttribute("aria-valuetext", text);
    this.find("time").textContent = `${text} of ${(this.end * this.dt).toFixed(1)} s`;
    this.draw();
  }

  draw() {
    const layers = {};
    this.root.querySelectorAll("[data-layer]").forEach((box) => { layers[box.dataset.layer] = box.checked; });
    this.stages.forEach((stage) => { if (stage.episode) stage.draw(this.time, layers); });
  }

  toggle() { if (this.playing) this.pause(); else this.play(); }

  pause() {
    this.playing = false;
    this.find("play").textContent = "Play";
  }

  play() {
    if (this.time >= this.end) this.seek(0);
    this.playing = true;
    this.find("play").textContent = "Pause";
    let before = performance.now();
    const advance = (now) => {
      if (!this.playing) return;
      const speed = Number(this.find("speed").value);
      this.seek(this.time + ((now - before) / 1000) * (speed / this.dt));
      before = now;
      if (this.time >= this.end) this.pause();
      else requestAnimationFrame(advance);
    };
    requestAnimationFrame(advance);
  }
}

const root = document.getElementById("player");
if (root) new Player(root).choose();
