"use strict";
// Figures are drawn when one comes near them, before printing, and again when the colours change.
(() => {
  const DARK = window.matchMedia("(prefers-color-scheme: dark)"), PRINT_WIDTH = 680, SHEET = 560;
  // the same hues, light enough to be seen on a dark page
  const LIGHTER = {"#1f6f8b": "#5bb3d0", "#d1603d": "#ee8a66", "#6a4c93": "#b59ae0", "#8a94a0": "#a5afba",
    "#b3261e": "#ff7b70", "#4a8c5c": "#7cc492", "#b8860b": "#d9a93a", "#1c2530": "#dde5ec"};
  // of the words beside a figure, as plotly draws them
  const DASHES = {dash: "6 3", dot: "2 2", dashdot: "6 2 2 2", longdash: "9 3"};
  const SHAPES = {square: "M7 2h8v8h-8z", diamond: "M11 0l6 6-6 6-6-6z", "triangle-up": "M11 1l5 9h-10z",
    "triangle-down": "M11 11l5-9h-10z", cross: "M9 1h4v3h3v4h-3v3h-4v-3h-3v-4h3z",
    x: "M7 1l4 3 4-3 2 2-3 3 3 3-2 2-4-3-4 3-2-2 3-3-3-3z", pentagon: "M11 1l5 4-2 6h-6l-2-6z",
    hexagon: "M8 1h6l3 5-3 5h-6l-3-5z", star: "M11 0l2 4h4l-3 3 1 5-4-3-4 3 1-5-3-3h4z"};
  const places = [...document.querySelectorAll(".plot")];
  let held = null, printing = false, alone = false;

  const inflated = async id => {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), c => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  };

  const load = async () => {
    const [source, figures] = await Promise.all([inflated("packed:library"), inflated("packed:figures")]);
    const script = document.createElement("script");
    script.textContent = source;
    document.head.append(script);
    held = JSON.parse(figures);
  };

  // a copy in the colours of now; `title` where the picture leaves the page
  const figure_of = (place, title) => {
    const found = held.figures[held.places[Number(place.dataset.figure)]], dark = DARK.matches && !printing && !title;
    let text = JSON.stringify({...found, template: held.templates[found.template]});
    if (dark) for (const [from, to] of Object.entries(LIGHTER)) text = text.replaceAll(from, to);
    const {data, layout, template} = JSON.parse(text);
    const faint = dark ? "#333e49" : "#dfe4ea", line = dark ? "#5a6673" : "#c8d0d8";
    layout.template = template;
    for (const name of Object.keys(layout).filter(name => /^[xy]axis/.test(name)))
      Object.assign(layout[name], {gridcolor: faint, linecolor: line, zerolinecolor: line});
    if (title) return {data, layout: {...layout, showlegend: true}};
    const panels = (layout.annotations || []).some(a => a.yref === "y domain" && a.text);
    const narrow = place.clientWidth < 560;
    layout.margin = {...layout.margin, t: panels ? 30 : 12, l: Math.min(layout.margin.l, narrow ? 40 : 1e3),
      r: narrow ? 12 : layout.margin.r};
    Object.assign(layout, {title: undefined, showlegend: false, paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)", dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom"});
    if (narrow || printing) layout.font = {...layout.font, size: printing ? 10 : 11};
    // as large as the numbers beside it: a longer one is cut off on a phone
    for (const name of Object.keys(layout).filter(name => /^[xy]axis/.test(name)))
      layout[name].title = {...layout[name].title, font: {size: layout.font.size}};
    // level numbers, and no more of them than a phone has room for: of more than two decades the powers of ten
    for (const name of Object.keys(layout).filter(name => /^xaxis/.test(name))) {
      const axis = layout[name], ticks = axis.tickvals || [];
      axis.tickangle = axis.tickangle || 0;
      if (narrow && axis.type === "log" && ticks.length > 15) {
        axis.ticktext = axis.ticktext.map((text, k) => Number.isInteger(Math.round(1e6 * Math.log10(ticks[k])) / 1e6) ? text : "");
      } else if (narrow && !ticks.length) axis.nticks = 5;
    }
    // on paper two figures of usual height fit on a sheet, and none is cut in two
    if (printing && !alone) layout.height = Math.min(0.6 * layout.height, SHEET);
    place.style.height = `${layout.height}px`;
    layout.width = printing ? Math.min(PRINT_WIDTH, place.clientWidth || PRINT_WIDTH) : undefined;
    return {data, layout};
  };

  const swatch = trace => {
    const lines = (trace.mode || "").includes("lines") && trace.line, colour = (lines ? trace.line : trace.marker).color;
    const dash = lines && DASHES[trace.line.dash] || "none";
    const [symbol, open] = String([(trace.marker || {}).symbol || "circle"].flat()[0]).split(/-(?=open)/);
    const mark = symbol in SHAPES ? `<path d="${SHAPES[symbol]}"/>` : '<circle cx="11" cy="6" r="4"/>';
    const shape = lines ? `<line x1="0" x2="22" y1="6" y2="6" stroke-width="2.5" stroke-dasharray="${dash}"/>${
        (trace.mode || "").includes("markers") ? mark : ""}`
      : symbol.startsWith("line-ns") ? '<rect x="10" y="0" width="2" height="12"/>'
      : trace.type === "bar" ? '<rect x="6" y="1" width="10" height="10"/>'
      : mark;
    const span = document.createElement("span");
    span.innerHTML = `<svg width="22" height="12" aria-hidden="true">${shape}</svg>`;
    const one = Array.isArray(colour) ? colour[0] : colour;
    span.firstChild.setAttribute("fill", open ? "none" : one);
    if (lines || open) span.firstChild.setAttribute("stroke", one);
    return span.firstChild;
  };

  // the words beside the figure are its legend: they wrap, they lie over nothing, and a keyboard reaches them
  const legend = place => {
    for (const button of place.parentElement.querySelectorAll(".legend button")) {
      const name = button.textContent, which = place._fullData.flatMap((t, k) => t.name === name ? [k] : []);
      button.replaceChildren(swatch(place._fullData[which[0]]), name);
      button.setAttribute("aria-pressed", "true");
      button.onclick = () => {
        const on = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(on));
        Plotly.restyle(place, {visible: on}, which);
      };
    }
  };

  const draw = place => {
    const {data, layout} = figure_of(place, false);
    Plotly.react(place, data, layout, {displayModeBar: false, responsive: !printing});
    legend(place);
    place.dataset.drawn = "yes";
    const save = place.parentElement.querySelector(".save"), title = place.parentElement.querySelector("h3");
    const [svg, pdf] = save.children;
    save.hidden = false;
    svg.onclick = () => Plotly.downloadImage(figure_of(place, true), {format: "svg", width: 960,
      height: place.clientHeight, filename: (title ? title.textContent : "figure").replace(/[^\w]+/g, "-")});
    pdf.onclick = () => print_alone(place);
  };

  // a figure with its words on a sheet of its own size: what the browser prints to PDF then is the figure
  const print_alone = place => {
    const figure = place.parentElement, sheet = document.createElement("style");
    printing = alone = true;
    document.body.classList.add("alone");
    figure.classList.add("chosen");
    draw(place);
    sheet.textContent = `@page{size:${PRINT_WIDTH + 40}px ${figure.offsetHeight + 60}px;margin:20px}`;
    document.head.append(sheet);
    window.addEventListener("afterprint", () => {
      printing = alone = false;
      sheet.remove();
      document.body.classList.remove("alone");
      figure.classList.remove("chosen");
      draw(place);
    }, {once: true});
    window.print();
  };

  // a document left open in a hidden frame: the page counts as loading until it can draw, so what prints it as soon as
  // it is loaded (chromium --print-to-pdf) prints figures
  const frame = document.createElement("iframe");
  frame.hidden = true;
  document.body.append(frame);
  frame.contentDocument.open();
  const library = load().finally(() => { frame.contentDocument.close(); frame.remove(); });
  const near = new IntersectionObserver(async found => {
    await library;
    for (const one of found) if (one.isIntersecting && !one.target.dataset.drawn) { draw(one.target); near.unobserve(one.target); }
  }, {rootMargin: "300px"});
  const again = all => { for (const place of places) if (all || place.dataset.drawn) draw(place); };

  places.forEach(place => near.observe(place));
  DARK.addEventListener("change", () => held && again(false));
  window.addEventListener("beforeprint", () => {
    if (alone) return;
    printing = true;
    for (const fold of document.querySelectorAll("details:not([open])")) { fold.open = true; fold.dataset.folded = "yes"; }
    if (held) again(true);
  });
  window.addEventListener("afterprint", () => {
    if (alone || !printing) return;
    printing = false;
    for (const fold of document.querySelectorAll("details[data-folded]")) fold.open = false;
    if (held) again(false);
  });
})();
