// The antenna in three dimensions on a 2-D canvas. z is up; axis 0 turns about z and carries axis 1, which turns about
// y; the boresight is x, so a positive second angle lowers it, or -x, so that it raises it. Faces are drawn from the
// farthest to the nearest.
function antenna_view(canvas, colour, names) {
  const TURN = 2 * Math.PI, SEGMENTS = 8;
  const START = {turned: -.95, raised: .38, zoom: 1}, eye = {...START};
  const pen = canvas.getContext("2d");
  let shown = null, palette = null, width = 0, height = 0, reach = 1, faces = [], strokes = [], labels = [];

  // rotations: nine numbers, row by row
  const about_x = q => [1, 0, 0, 0, Math.cos(q), -Math.sin(q), 0, Math.sin(q), Math.cos(q)];
  const about_y = q => [Math.cos(q), 0, Math.sin(q), 0, 1, 0, -Math.sin(q), 0, Math.cos(q)];
  const about_z = q => [Math.cos(q), -Math.sin(q), 0, Math.sin(q), Math.cos(q), 0, 0, 0, 1];
  const times = (a, b) => [0, 3, 6].flatMap(r => [0, 1, 2].map(c => a[r] * b[c] + a[r + 1] * b[c + 3] + a[r + 2] * b[c + 6]));
  const turned = (m, [x, y, z]) => [m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z];

  // solids: faces with their corners, seen from outside against the clock; `both`: a sheet that is seen from both sides
  const minus = (a, b) => a.map((v, k) => v - b[k]), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const across = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  function face(corners, tone, both = false) {
    const n = across(minus(corners[1], corners[0]), minus(corners[2], corners[0])), size = Math.hypot(...n);
    return {corners, normal: n.map(v => v / size), tone, both};
  }
  function box([x0, x1], [y0, y1], [z0, z1], tone) {
    const at = k => [k & 1 ? x1 : x0, k & 2 ? y1 : y0, k & 4 ? z1 : z0];
    return [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]].map(one => face(one.map(at), tone));
  }
  // `lay` puts (along the radius, around, along the axis) into the body
  function drum(radius, [low, high], parts, tone, lay = (u, v, w) => [u, v, w]) {
    const rim = w => [...Array(parts).keys()].map(k => lay(radius * Math.cos(k * TURN / parts), radius * Math.sin(k * TURN / parts), w));
    const bottom = rim(low), top = rim(high);
    return [face(top, tone), face([...bottom].reverse(), tone), ...bottom.map((p, k) => face([p, bottom[(k + 1) % parts], top[(k + 1) % parts], top[k]], tone))];
  }
  const DISH = {radius: .46, depth: .2, vertex: .13, parts: 20}, focus = DISH.vertex + DISH.radius ** 2 / (4 * DISH.depth);
  const on_dish = (r, k) => [DISH.vertex + DISH.depth * (r / DISH.radius) ** 2, r * Math.cos(k * TURN / DISH.parts), r * Math.sin(k * TURN / DISH.parts)];
  function dish(tone) {
    const rings = [.04, .18, .32, DISH.radius], found = [];
    for (let n = 1; n < rings.length; n++) for (let k = 0; k < DISH.parts; k++)
      found.push(face([on_dish(rings[n - 1], k), on_dish(rings[n], k), on_dish(rings[n], k + 1), on_dish(rings[n - 1], k + 1)], tone, true));
    return found;
  }
  // along y, as the bearings of axis 1 lie
  const sideways = (u, v, w) => [v, w, u];
  const FLOOR = -1.1, ARM = .5;
  const BASE = [...drum(.66, [FLOOR - .1, FLOOR], 36, .62), ...drum(.2, [FLOOR, -.86], 18, .7)];
  const OUTER = [...drum(.34, [-.86, -.79], 24, .78), ...box([-.1, .1], [-ARM - .12, ARM + .12], [-.79, -.67], .78),
    ...[-1, 1].flatMap(s => [...box([-.1, .1], s < 0 ? [-ARM - .12, -ARM] : [ARM, ARM + .12], [-.67, .1], .82)]),
    ...drum(.14, [ARM + .12, ARM + .16], 16, .6, sideways), ...drum(.14, [-ARM - .16, -ARM - .12], 16, .6, sideways)];
  const INNER = [...box([-.05, .05], [-ARM, ARM], [-.05, .05], .7), ...box([-.3, -.08], [-.15, .15], [-.12, .12], .66),
    ...box([-.08, .13], [-.06, .06], [-.06, .06], .7), ...dish(.98), ...box([focus - .03, focus + .03], [-.035, .035], [-.035, .035], .6)];
  const STRUTS = [0, 7, 13].map(k => [on_dish(DISH.radius, k), [focus, 0, 0]]);
  const RIM = [...Array(DISH.parts + 1).keys()].map(k => on_dish(DISH.radius, k));
  const BACKS = [0, 5, 10, 15].map(k => [.04, .18, .32, DISH.radius].map(r => on_dish(r, k)));
  const AHEAD = 1.2;

  // what the eye sees: (right, up, distance)
  function seen(point) {
    const c = Math.cos(eye.turned), s = Math.sin(eye.turned), e = Math.cos(eye.raised), f = Math.sin(eye.raised);
    const away = c * point[0] + s * point[1];
    return [-s * point[0] + c * point[1], e * point[2] - f * away, 6 - (e * away + f * point[2])];
  }
  function place([right, up, distance]) {
    const size = reach * eye.zoom * 6 / distance;
    return [width / 2 + right * size, height * .5 - (up + .16) * size];
  }
  function mixed(from, to, share) { return `rgb(${from.map((v, k) => Math.round(v + (to[k] - v) * share)).join()})`; }
  function read_palette() {
    const probe = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
    const rgb = name => { probe.fillStyle = colour(name); probe.fillRect(0, 0, 1, 1); return [...probe.getImageData(0, 0, 1, 1).data.slice(0, 3)]; };
    const dark = dot(rgb("paper"), [1, 1, 1]) < 380;
    palette = {low: dark ? [40, 50, 60] : [84, 96, 110], high: dark ? [205, 216, 226] : [250, 252, 254],
      ...Object.fromEntries(["ink", "soft", "paper", "measured", "second", "torque", "stop"].map(name => [name, colour(name)]))};
  }
  const eye_place = () => [Math.cos(eye.raised) * Math.cos(eye.turned), Math.cos(eye.raised) * Math.sin(eye.turned), Math.sin(eye.raised)].map(v => 6 * v);
  function solid(found, m, pale) {
    const from = eye_place(), light = [.35, -.5, .8].map(v => v / 1.007);
    for (const one of found) {
      let normal = turned(m, one.normal), inside = false;
      const corners = one.corners.map(p => turned(m, p)), away = dot(normal, minus(from, corners[0])) < 0;
      if (away && !one.both) continue;
      if (away) { normal = normal.map(v => -v); inside = true; }
      const at = corners.map(seen), bright = one.tone * (.42 + .58 * Math.max(0, dot(normal, light))) * (inside ? .8 : 1);
      faces.push({at, far: at.reduce((sum, p) => sum + p[2], 0) / at.length, fill: mixed(palette.low, palette.high, bright), pale});
    }
  }
  // a line through points, sorted piece by piece among the faces; `over`: drawn on top of them
  function line(points, style, {wide = 1.5, dash = [], faint = 1, over = false} = {}) {
    const at = points.map(seen);
    if (over || dash.length) { strokes.push({at, style, wide, dash, faint}); return; }
    for (let k = 1; k < at.length; k++) faces.push({at: [at[k - 1], at[k]], far: (at[k - 1][2] + at[k][2]) / 2 - .03, style, wide, faint});
  }
  function straight(from, to) { return [...Array(SEGMENTS + 1).keys()].map(k => from.map((v, n) => v + (to[n] - v) * k / SEGMENTS)); }
  function arc(radius, from, to, lay) {
    const parts = Math.max(2, Math.ceil(Math.abs(to - from) / .09));
    return [...Array(parts + 1).keys()].map(k => lay(radius, from + (to - from) * k / parts));
  }
  function arrow(radius, from, sweep, lay, style) {
    if (Math.abs(sweep) < .02) return;
    const to = from + sweep, back = to - Math.sign(sweep) * Math.min(Math.abs(sweep), .16);
    line(arc(radius, from, to, lay), style, {wide: 3.5, over: true});
    line([lay(radius - .06, back), lay(radius, to), lay(radius + .06, back)], style, {wide: 3.5, over: true});
  }
  // a scale with its travel, both stops, and needles for what is measured and for the second antenna
  function scale(axis, radius, lay) {
    const low = axis.low ?? -Infinity, high = axis.high ?? Infinity, whole = high - low >= TURN;
    line(arc(radius, 0, TURN, lay), palette.soft, {wide: 1, faint: .5});
    for (let k = 0; k < 12; k++) line([lay(radius, k * TURN / 12), lay(radius + (k % 3 ? .03 : .06), k * TURN / 12)], palette.soft, {wide: 1});
    if (!whole) {
      line(arc(radius, low, high, lay), palette.soft, {wide: 3});
      for (const end of [low, high]) line([lay(radius - .05, end), lay(radius + .11, end)], palette.stop, {wide: 4});
    }
    if (axis.second !== null) line([lay(radius - .14, axis.second), lay(radius + .07, axis.second)], palette.second, {wide: 2.5});
    line([lay(radius - .14, axis.at), lay(radius + .07, axis.at)], palette.measured, {wide: 3});
  }
  // sqrt: a torque of one percent of what the axis may give is still seen
  const sweep = axis => axis.torque === null || !axis.most ? 0 : 2.4 * Math.sign(axis.torque) * Math.sqrt(Math.min(1, Math.abs(axis.torque) / axis.most));

  function draw() {
    if (!shown) return;
    const dots = Math.min(window.devicePixelRatio || 1, 2);
    width = canvas.clientWidth; height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * dots) || canvas.height !== Math.round(height * dots)) {
      canvas.width = Math.round(width * dots); canvas.height = Math.round(height * dots);
    }
    pen.setTransform(dots, 0, 0, dots, 0, 0); pen.clearRect(0, 0, width, height);
    reach = Math.min(width / 2.5, height / 2.75); faces = []; strokes = []; labels = [];
    const [first, second] = shown.axes, [roll, pitch, yaw] = shown.base || [0, 0, 0];
    const base = times(about_z(yaw), times(about_y(pitch), about_x(roll)));
    const outer = times(base, about_z(first.at)), inner = times(outer, about_y(second.at));
    const heard = shown.heard ? 1 : .45;
    solid(BASE, base, heard); solid(OUTER, outer, heard); solid(INNER, inner, heard);
    for (const one of STRUTS) line(one.map(p => turned(inner, p)), palette.soft, {wide: 1.5});
    line(straight([focus + .05, 0, 0], [AHEAD, 0, 0]).map(p => turned(inner, p)), palette.measured, {wide: 2.5});
    const flat = (r, q) => turned(base, [r * Math.cos(q), r * Math.sin(q), FLOOR + .005]);
    const beside = (r, q) => turned(outer, [r * Math.cos(q), -ARM - .17, -r * Math.sin(q)]);
    scale(first, .56, flat); scale(second, .26, beside);
    const low = (r, q) => turned(outer, [r * Math.cos(q), r * Math.sin(q), -.825]);
    const near = (r, q) => turned(inner, [r * Math.cos(q), -ARM - .2, -r * Math.sin(q)]);
    arrow(.42, 0, sweep(first), low, palette.torque); arrow(.4, 0, sweep(second), near, palette.torque);
    const both = first.second !== null || second.second !== null;
    if (both) {
      const there = times(base, about_z(first.second ?? first.at)), dished = times(there, about_y(second.second ?? second.at));
      const style = {wide: 1.6, over: true, faint: .75};
      line(RIM.map(p => turned(dished, p)), palette.second, style);
      for (const one of BACKS) line(one.map(p => turned(dished, p)), palette.second, {...style, wide: 1});
      line([[focus, 0, 0], [AHEAD, 0, 0]].map(p => turned(dished, p)), palette.second, {wide: 2, dash: [6, 4]});
      // what is aimed at: a ring with a cross, square to the boresight
      const ring = (r, q) => turned(dished, [AHEAD, r * Math.cos(q), r * Math.sin(q)]);
      line(arc(.09, 0, TURN, ring), palette.second, {wide: 2, over: true});
      for (const q of [0, TURN / 4, TURN / 2, 3 * TURN / 4]) line([ring(.05, q), ring(.14, q)], palette.second, {wide: 2, over: true});
    }
    for (const q of [0, 90, 180, -90]) labels.push([flat(.75, q * TURN / 360), q + "\u00b0", palette.soft]);
    labels.push([turned(base, [0, 0, FLOOR - .1]), names[0], palette.ink, reach * .42], [beside(.44, .4 * TURN), names[1], palette.ink]);
    paint();
  }
  function paint() {
    faces.sort((a, b) => b.far - a.far);
    pen.lineJoin = pen.lineCap = "round";
    for (const one of [...faces, ...strokes]) {
      pen.globalAlpha = one.faint ?? one.pale; pen.setLineDash(one.dash || []);
      pen.beginPath();
      one.at.forEach((p, k) => { const [x, y] = place(p); if (k) pen.lineTo(x, y); else pen.moveTo(x, y); });
      pen.strokeStyle = one.style || one.fill; pen.lineWidth = one.wide || .8;
      if (one.fill) { pen.closePath(); pen.fillStyle = one.fill; pen.fill(); }
      pen.stroke();
    }
    pen.globalAlpha = 1; pen.setLineDash([]); pen.font = "12px system-ui, sans-serif"; pen.textAlign = "center"; pen.lineWidth = 3;
    for (const [point, text, style, below = 0] of labels) {
      const at = place(seen(point)), x = Math.min(Math.max(at[0], 30), width - 30), y = Math.min(at[1] + below * eye.zoom, height - 8);
      pen.strokeStyle = palette.paper; pen.strokeText(text, x, y + 4); pen.fillStyle = style; pen.fillText(text, x, y + 4);
    }
  }
  function turn(by, up, zoom = 1) {
    eye.turned -= by; eye.raised = Math.min(1.45, Math.max(-.3, eye.raised + up)); eye.zoom = Math.min(2.5, Math.max(.6, eye.zoom * zoom));
    draw();
  }
  const KEYS = {ArrowLeft: [-.09, 0], ArrowRight: [.09, 0], ArrowUp: [0, .09], ArrowDown: [0, -.09], "+": [0, 0, 1.15], "-": [0, 0, 1 / 1.15]};
  canvas.tabIndex = 0;
  canvas.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === "Home") Object.assign(eye, START); else if (!KEYS[event.key]) return;
    event.preventDefault(); turn(...(KEYS[event.key] || [0, 0]));
  });
  canvas.addEventListener("pointerdown", event => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", event => {
    if (event.buttons & 1) turn(event.movementX * .01, event.movementY * .01);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { read_palette(); draw(); });
  addEventListener("resize", draw);
  read_palette();
  // What looks along -x, seen by an eye that went half a turn about z, is what looks along x with the second axis
  // turning the other way, on a base that rolls and pitches the other way.
  const minus_of = v => typeof v === "number" ? -v : v;
  function from_aft({base, axes: [first, {at, second, torque, low, high, ...rest}], ...more}) {
    const turning = {...rest, at: -at, second: minus_of(second), torque: minus_of(torque), low: minus_of(high), high: minus_of(low)};
    return {...more, base: base && [-base[0], -base[1], base[2]], axes: [first, turning]};
  }
  // state: {heard, boresight: "x" or "-x", base: [roll, pitch, yaw] or null, axes: two of {at, second, torque, most, low,
  // high}}, rad and N m, null where there is none; `at` is always a number. The same state again is not drawn again.
  return {show(state) {
    const told = JSON.stringify(state, (key, v) => typeof v === "number" ? Math.round(v * 5000) : v);
    if (shown && shown.told === told) return;
    shown = {...(state.boresight === "-x" ? from_aft(state) : state), told}; draw();
  }, eye};
}
// Calls `frame` before each picture of the screen while the canvas is in view; where less motion is asked for, five
// times a second. Answers what counts the frames.
function animated(canvas, frame) {
  const calm = matchMedia("(prefers-reduced-motion: reduce)"), count = {frames: 0};
  let in_view = true, waiting = false;
  const next = () => {
    if (waiting || !in_view) return;
    waiting = true;
    const go = () => { waiting = false; if (!in_view) return; count.frames += 1; frame(performance.now()); next(); };
    if (calm.matches) setTimeout(go, 200); else requestAnimationFrame(go);
  };
  new IntersectionObserver(found => { in_view = found[found.length - 1].isIntersecting; next(); }).observe(canvas);
  next();
  return count;
}
