"""The live page: one self-contained document that polls `/live.json`; no network, no library."""

from __future__ import annotations

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>gimbal-hil daemon</title>
<style>
 body { font: 14px/1.4 system-ui, sans-serif; margin: 1rem auto; max-width: 1100px; color: #1c2430;
  background: #fafbfc }
 h1 { font-size: 1.1rem; margin: 0 0 .5rem } h2 { font-size: .9rem; margin: .8rem 0 .2rem; font-weight: 600 }
 canvas { width: 100%; height: 150px; background: #fff; border: 1px solid #d8dee6; border-radius: 4px }
 .grid { display: grid; grid-template-columns: 1fr 1fr; gap: 0 1rem }
 .facts { display: flex; flex-wrap: wrap; gap: .3rem 1.2rem } .facts b { font-weight: 600 }
 .bad { color: #b00020 } .key { font-size: .8rem; color: #5a6675 } .key i { font-style: normal; margin-right: .8rem }
</style></head><body>
<h1>gimbal-hil daemon <span id="lost" class="bad"></span></h1>
<div class="facts" id="facts"></div>
<div class="grid" id="plots"></div>
<div class="grid"><div><h2>wake-up latency (us, counts on a log scale)</h2><canvas id="latency"></canvas></div>
<div><h2>missed ticks by cause</h2><canvas id="causes"></canvas></div></div>
<script>
"use strict";
const SPAN_S = 20, KEEP = 3000;
const PLOTS = [["position", "rad", ["position", "position_ref"]], ["rate", "rad/s", ["rate", "rate_ref"]],
  ["torque", "N m", ["torque"]]];
const COLOURS = ["#1f6feb", "#d9822b"];
const trace = {time_s: []};
let since = -1, AXES = [];
function draw_boxes() { for (const [name, unit, columns] of PLOTS) for (const axis of AXES) {
  const box = document.createElement("div");
  const key = columns.length > 1 ? "<i style='color:#1f6feb'>measured</i><i style='color:#d9822b'>reference</i>" : "";
  box.innerHTML = `<h2><b></b> ${name} (${unit}) <span class="key">${key}</span></h2><canvas></canvas>`;
  box.querySelector("b").textContent = axis; box.querySelector("canvas").id = `${name}_${axis}`;
  document.getElementById("plots").append(box);
} }
function surface(id) {
  const canvas = document.getElementById(id), scale = window.devicePixelRatio || 1;
  canvas.width = canvas.clientWidth * scale; canvas.height = canvas.clientHeight * scale;
  const pen = canvas.getContext("2d"); pen.scale(scale, scale); pen.font = "11px system-ui";
  return [pen, canvas.clientWidth, canvas.clientHeight];
}
function lines(id, columns) {
  const [pen, width, height] = surface(id), times = trace.time_s;
  if (!times.length) return;
  const end = times[times.length - 1], start = end - SPAN_S;
  const from = times.findIndex(t => t >= start);
  let low = Infinity, high = -Infinity;
  for (const c of columns) for (let k = from; k < times.length; k++) {
    const v = trace[c][k];
    if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); }
  }
  if (low > high) return;
  const margin = Math.max((high - low) * 0.08, 1e-4); low -= margin; high += margin;
  const x = t => (t - start) / SPAN_S * width, y = v => height - (v - low) / (high - low) * height;
  columns.forEach((c, n) => {
    pen.strokeStyle = COLOURS[n]; pen.beginPath();
    let down = false;
    for (let k = from; k < times.length; k++) {
      const v = trace[c][k];
      if (v === null) { down = false; continue; }
      if (down) pen.lineTo(x(times[k]), y(v)); else pen.moveTo(x(times[k]), y(v));
      down = true;
    }
    pen.stroke();
  });
  pen.fillStyle = "#5a6675"; pen.fillText(high.toPrecision(4), 4, 12); pen.fillText(low.toPrecision(4), 4, height - 4);
}
function bars(id, items, logarithmic) {
  const [pen, width, height] = surface(id);
  if (!items.length) return;
  const size = v => logarithmic ? Math.log10(1 + v) : v;
  const top = Math.max(...items.map(i => size(i[1])), 1e-9), step = width / items.length;
  items.forEach(([name, value], n) => {
    const h = size(value) / top * (height - 30);
    pen.fillStyle = "#1f6feb"; pen.fillRect(n * step + 1, height - 16 - h, Math.max(step - 2, 1), h);
    pen.fillStyle = "#5a6675";
    if (step > 60) pen.fillText(name.replace("_", " "), n * step + 2, height - 4, step - 4);
    else if (n % Math.ceil(60 / step) === 0) pen.fillText(name, n * step + 2, height - 4);
    if (step > 60) pen.fillText(value, n * step + 2, height - 20 - h);
  });
}
function facts(s) {
  const t = s.statistics, show = v => v === null ? "-" : v;
  const state = s.host_state + (s.cause === "none" ? "" : " (" + s.cause + ")");
  const items = [["state", state], ["link", s.link], ["drive", show(s.drive_state)], ["fault", show(s.drive_fault)],
    ["mode", Object.values(s.mode).join(" / ")], ["tick", s.tick], ["missed", t.missed],
    ["rejected frames", s.rejected_frames],
    ["latency p99", t.latency_us.p99.toFixed(0) + " us"], ["computing p99", t.computing_us.p99.toFixed(0) + " us"]];
  const box = document.getElementById("facts");
  box.replaceChildren(...items.map(([name, value]) => {
    const item = document.createElement("span"), strong = document.createElement("b");
    strong.textContent = value; if (String(value).startsWith("fault") || value === "lost") strong.className = "bad";
    item.append(name + " ", strong);
    return item;
  }));
}
async function poll() {
  try {
    const live = await (await fetch("/live.json?since=" + since)).json();
    for (const [name, column] of Object.entries(live.trace))
      trace[name] = (trace[name] || []).concat(column).slice(-KEEP);
    if (trace.time_s.length) since = trace.time_s[trace.time_s.length - 1];
    if (!AXES.length) { AXES = Object.keys(live.status.mode); draw_boxes(); }
    facts(live.status);
    for (const [name, , columns] of PLOTS) for (const axis of AXES)
      lines(`${name}_${axis}`, columns.map(c => `${c}_${axis}`));
    bars("latency", live.latency_bins_us.map(([bound, count]) => [bound.toFixed(0), count]), true);
    bars("causes", Object.entries(live.status.statistics.missed_by_cause), false);
    document.getElementById("lost").textContent = "";
  } catch (error) {
    document.getElementById("lost").textContent = "(the daemon does not answer)";
  }
  setTimeout(poll, 200);
}
poll();
</script></body></html>
"""
