// the trace arrives in pieces: it is shown so much later that the next piece is there in time
const LATE_S = .35, SEEN = {measured: "a", second: "b", torque: "green", stop: "red"};
function begin_seen(limits, boresight) {
  const view = antenna_view($("antenna"), name => colour(SEEN[name] || name), AXES);
  seen = {limits, boresight, heard: false};
  seen.count = animated($("antenna"), now => { if (trace.time_s.length) view.show(state_at(now / 1000 - lead - LATE_S)); });
}
function state_at(t) {
  const times = trace.time_s; let k = times.length - 1;
  while (k > 0 && times[k - 1] > t) k -= 1;
  const from = Math.max(k - 1, 0), share = k ? Math.min(1, Math.max(0, (t - times[from]) / (times[k] - times[from]))) : 0;
  const value = name => { const a = trace[name][from], b = trace[name][k]; return a === null || b === null ? b : a + (b - a) * share; };
  const base = ["base_roll", "base_pitch", "base_yaw"].map(value);
  return {heard: seen.heard, boresight: seen.boresight, base: base.includes(null) ? null : base, axes: AXES.map(axis => {
    const l = seen.limits[axis] || {};
    return {at: value("position_" + axis), second: value("position_ref_" + axis), torque: value("torque_" + axis), most: l.torque_nm,
      low: l.position_low_rad ?? null, high: l.position_high_rad ?? null};
  })};
}
const degrees = (v, digits) => (v * 180 / Math.PI).toFixed(digits).replace(/^-(?=[0.]*$)/, "") + "\u00b0";
function travel_of(l) {
  const low = l.position_low_rad ?? null, high = l.position_high_rad ?? null, end = v => v === null ? "no stop" : degrees(v, 1);
  return low === null && high === null ? (l.cable_wrap_turns ? "no stop, cable " + l.cable_wrap_turns + " turns either way" : "no stop") : end(low) + " to " + end(high);
}
function tell_axes(s) {
  seen.limits = s.limits; seen.heard = s.link !== "lost" && AXES.every(axis => s.position_rad[axis] !== null);
  const newest = name => trace[name][trace[name].length - 1] ?? null;
  const told = AXES.map(axis => {
    const at = s.position_rad[axis], ref = newest("position_ref_" + axis), l = s.limits[axis] || {};
    return [axis, at === null ? ["not heard", ""] : [degrees(at, 3), at.toFixed(5) + " rad"],
      [["reference", ref === null ? "none" : degrees(ref, 3) + (at === null ? "" : ", off by " + degrees(ref - at, 3))],
        ["rate", s.rate_rad_s[axis] === null ? "not heard" : degrees(s.rate_rad_s[axis], 2) + "/s"],
        ["torque asked for", s.torque_nm[axis].toFixed(3) + (l.torque_nm ? " of " + l.torque_nm : "") + " N m"], ["travel", travel_of(l)]]];
  });
  $("axes").replaceChildren(...told.map(([axis, [large, small], rest]) => {
    const box = document.createElement("div"), head = document.createElement("h3"), list = document.createElement("dl");
    head.textContent = axis;
    for (const [name, value, cls] of [["position", large, "at"], ...rest]) {
      const dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = name; dd.textContent = value; if (cls) dd.className = cls;
      if (cls && small) { const more = document.createElement("small"); more.textContent = " " + small; dd.append(more); }
      list.append(dt, dd);
    }
    box.append(head, list); return box;
  }));
  if (Date.now() - last_said > 1000)
    $("antenna").setAttribute("aria-label", "the antenna: " + told.map(([axis, [large], [ref]]) => axis + " at " + large + ", reference " + ref[1]).join("; "));
}
// one banner for a stop: what, since when, what happens now, what to do; told to a screen reader once
function tell_trouble(s) {
  const box = $("trouble"), t = s.trouble;
  box.hidden = !t;
  if (!t) { box.dataset.told = ""; return; }
  const told = t.what + t.why + t.since_s;
  if (box.dataset.told !== told) {
    box.dataset.told = told;
    const line = (text, tag) => { const one = document.createElement(tag); one.textContent = text; return one; };
    const head = line("", "p"), since = line("", "span"), by = t.left_by.includes("reset");
    since.id = "trouble_since"; since.setAttribute("aria-hidden", "true");
    const now = line("", "p"); now.id = "trouble_now";
    head.append(line("Stopped: " + t.what, "b"), " ", since);
    box.replaceChildren(head, ...(t.why ? [line(t.why[0].toUpperCase() + t.why.slice(1) + ".", "p")] : []), now, line((t.look_at ? "Look at " + t.look_at + ". " : "")
      + "To go on: " + (by ? "Arm, then Reset fault (or gimbal-hil reset)." : t.left_by + "."), "p"));
  }
  const now = "Now: " + t.happens + ".";
  if ($("trouble_now").textContent !== now) $("trouble_now").textContent = now;
  $("trouble_since").textContent = "for " + Math.max(0, s.time_ns / 1e9 - t.since_s).toFixed(0) + " s (since " + t.since_s.toFixed(1) + " s of the run)";
}
// radians of one unit of the set-points: they are written in radians or degrees, and sent in radians
const radians = () => $("mode").value !== "torque" && $("unit").value === "deg" ? Math.PI / 180 : 1;
// beside a set-point in one unit the same in the other
function in_degrees(axis) {
  const text = $("to_" + axis).value, mode = $("mode").value, value = Number(text) * radians(), a_second = mode === "position" ? "" : "/s";
  $("deg_" + axis).textContent = text === "" || mode === "torque" ? "N m".repeat(mode === "torque")
    : $("unit").value === "deg" ? "\u00b0" + a_second + " (" + value.toFixed(4) + " rad" + a_second + ")" : "rad" + a_second + " (" + degrees(value, 2) + a_second + ")";
}
