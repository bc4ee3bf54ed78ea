// A recorded motion beside models of it: the first model for the first half, then the last one, unless somebody chooses.
function motion_player(figure) {
  const told = JSON.parse(figure.querySelector("script").textContent), canvas = figure.querySelector("canvas");
  const [play, slider, ...choices] = figure.querySelectorAll("button, input"), said = figure.querySelector("output");
  const calm = matchMedia("(prefers-reduced-motion: reduce)"), LASTS_S = 20, SNAP_S = .4;
  const end = told.time_s[told.time_s.length - 1], style = getComputedStyle(document.documentElement);
  const view = antenna_view(canvas, name => style.getPropertyValue("--" + name).trim(), told.names);
  let at = 0, playing = false, last = null, chosen = null, labelled = -Infinity, blend = 0;
  const between = (columns, t) => {
    const after = told.time_s.findIndex(one => one > t), k = (after < 0 ? told.time_s.length - 1 : Math.max(after, 1)) - 1;
    const share = Math.min(1, (t - told.time_s[k]) / (told.time_s[k + 1] - told.time_s[k]));
    return columns.map(column => column[k] + (column[k + 1] - column[k]) * share);
  };
  const which = () => chosen ?? (at < end / 2 ? 0 : told.models.length - 1);
  function show(seconds) {
    // from one model to the other in a moment that the eye can follow
    blend += Math.sign(which() - blend) * Math.min(Math.abs(which() - blend), calm.matches ? 1 : seconds / SNAP_S);
    const here = between(told.measured, at), low = told.models[Math.floor(blend)], high = told.models[Math.ceil(blend)];
    const from = between(low.position, at), to = between(high.position, at);
    const ghost = from.map((v, k) => v + (to[k] - v) * (blend - Math.floor(blend)));
    view.show({heard: true, base: null, axes: here.map((v, k) => ({at: v, second: ghost[k], torque: null, most: null, low: null, high: null}))});
    const off = told.names.map((name, k) => name + " " + ((between(told.models[which()].position, at)[k] - here[k]) * 180 / Math.PI).toFixed(2).replace(/^-(?=[0.]*$)/, "") + "\u00b0").join(", ");
    said.textContent = at.toFixed(1) + " s, " + told.models[which()].name + ": ghost minus antenna " + off;
    slider.value = at; play.textContent = playing ? "Pause" : "Play";
    choices.forEach((one, k) => one.setAttribute("aria-pressed", String(k === which())));
    if (!playing || performance.now() - labelled > 1000) { canvas.setAttribute("aria-label", told.title + ". " + said.textContent); labelled = performance.now(); }
  }
  play.onclick = () => { playing = !playing; if (playing && at >= end) { at = 0; chosen = null; blend = 0; } show(0); };
  slider.oninput = () => { playing = false; at = Number(slider.value); show(1); };
  choices.forEach((one, k) => { one.onclick = () => { chosen = k; show(0); }; });
  playing = !calm.matches;
  const count = animated(canvas, now => {
    const seconds = last === null ? 0 : Math.min((now - last) / 1000, .25);
    last = now;
    if (playing) { at = Math.min(end, at + seconds * end / LASTS_S); playing = at < end; }
    if (playing || blend !== which() || labelled === -Infinity || play.textContent === "Pause") show(seconds);
  });
  return {count, position: () => at};
}
