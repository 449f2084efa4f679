// Draws worn teeth with plotly from the data in the page, which turning.py writes.
(async () => {
  "use strict";
  const by = id => document.getElementById(id);
  const figure = by("turning"), view = by("turning-view"), data = JSON.parse(by("turning-told").textContent);

  const unpacked = async id => {
    const bytes = Uint8Array.from(atob(by(id).textContent), c => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  };
  const drawable = () => {
    const context = document.createElement("canvas").getContext("webgl");
    return context !== null && typeof DecompressionStream !== "undefined";
  };
  if (!drawable()) return;

  const numbers = new Uint16Array(await unpacked("turning-data"));
  const array = stored => {
    const size = stored.shape.reduce((a, b) => a * b, 1), values = new Float32Array(size);
    for (let k = 0; k < size; k++) values[k] = stored.low + stored.step * numbers[stored.at + k];
    return values;
  };
  for (const body of data.bodies) {
    [body.rows, body.faces] = body.flank.shape;
    body.fillets = body.fillet.shape[0];
    for (const name of ["flank", "normal", "back", "fillet", "backFillet", "wear"]) body[name] = array(body[name]);
    if (body.line) [body.line, body.load] = [array(body.line), array(body.load)];
    for (const quantity of body.quantities) {
      quantity.steps = quantity.values.shape[0];
      quantity.values = array(quantity.values);
    }
  }
  const meshing = data.engagement;
  const rolls = meshing ? meshing.roll.length : 0;
  if (meshing) meshing.share = array(meshing.share);

  const library = document.createElement("script");
  library.textContent = new TextDecoder().decode(await unpacked("turning-library"));
  document.head.append(library);
  const Plotly = window.Plotly;

  const figures = (value, digits = 3) => Number(value.toPrecision(digits)).toLocaleString("en", {useGrouping: false});
  const slider = id => by(id) ? Number(by(id).value) : 0;
  const chosen = () => {
    const body = data.bodies[slider("turning-body")];
    return {body, step: slider("turning-step"), roll: slider("turning-roll"),
      quantity: body.quantities[Number(by("turning-quantity").value)], factor: Number(by("turning-factor").value)};
  };

  // Points (x, y, z) of the worn flank: each moves along its normal by its wear [µm] times `factor`.
  const worn = ({body, step, factor}) => {
    const size = body.rows * body.faces, points = new Float32Array(3 * size);
    for (let k = 0; k < size; k++) {
      const depth = 1e-3 * factor * body.wear[step * size + k];
      for (let c = 0; c < 3; c++) points[3 * k + c] = body.flank[3 * k + c] - depth * body.normal[3 * k + c];
    }
    return points;
  };
  const row = (points, faces, r) => points.subarray(3 * r * faces, 3 * (r + 1) * faces);
  const column = (points, faces, rows, f) => Array.from({length: rows}, (_, r) =>
    points.subarray(3 * (r * faces + f), 3 * (r * faces + f) + 3));
  const grid = rows => ["x", "y", "z"].reduce((all, name, c) => ({...all,
    [name]: rows.map(points => Array.from({length: points.length / 3}, (_, k) => points[3 * k + c]))}), {});
  const flat = points => Float32Array.from(points.flatMap(point => Array.from(point)));
  const each = (count, make) => Array.from({length: count}, (_, k) => make(k));

  const light = {x: 3e4, y: 1e5, z: 8e4};
  const material = () => ({showscale: false, hoverinfo: "skip", colorscale: [[0, dark() ? "#8593a1" : "#b9c4cf"],
    [1, dark() ? "#8593a1" : "#b9c4cf"]], lighting: {ambient: 0.6, diffuse: 0.5, specular: 0.05},
    lightposition: light, type: "surface"});
  // The rest of the tooth: from the tip over the other flank and its fillet, below, and up the flank's own fillet.
  const rest = (body, points) => {
    const {rows, faces, fillets} = body, last = rows - 1;
    const strip = [row(points, faces, last), ...each(rows, r => row(body.back, faces, last - r)),
      ...each(fillets, k => row(body.backFillet, faces, k)), ...each(fillets, k => row(body.fillet, faces, fillets - 1 - k)),
      row(points, faces, 0)];
    const cap = f => [[body.fillet, points], [body.backFillet, body.back]].map(([fillet, flank]) =>
      flat([...column(fillet, faces, fillets, f).reverse(), ...column(flank, faces, rows, f)]));
    return [strip, cap(0), cap(faces - 1)].map(part => ({...material(), ...grid(part)}));
  };
  const edge = ({flank, rows, faces}) => {
    const round = [row(flank, faces, 0), flat(column(flank, faces, rows, faces - 1)), row(flank, faces, rows - 1),
      flat(column(flank, faces, rows, 0))];
    const [x, y, z] = [0, 1, 2].map(c => round.flatMap((points, k) => {
      const values = Array.from({length: points.length / 3}, (_, n) => points[3 * n + c]);
      return k > 1 ? values.reverse() : values;
    }));
    return {type: "scatter3d", mode: "lines", x, y, z, hoverinfo: "skip", showlegend: false,
      line: {dash: "dash", width: 3, color: ink()}};
  };
  // Labels in front of the tooth: tip and root at the middle of the face, its ends at the corners below.
  const labels = body => {
    const {flank, back, fillet, rows, faces, fillets} = body, middle = Math.floor(faces / 2);
    const at = (points, r, f) => Array.from(points.subarray(3 * (r * faces + f), 3 * (r * faces + f) + 3));
    const low = f => fillets ? at(fillet, fillets - 1, f) : at(flank, 0, f);
    // seen from the flank's side, x grows to the left
    const [left, right] = low(0)[0] > low(faces - 1)[0] ? [0, faces - 1] : [faces - 1, 0];
    const label = (text, [x, y, z], xanchor, yanchor, yshift = 0) => ({text, x, y, z, xanchor, yanchor, yshift,
      showarrow: false, font: {color: ink(), size: 13}, bgcolor: dark() ? "#18212bc0" : "#ffffffc0", borderpad: 0});
    const ends = left ? [...body.ends].reverse() : body.ends;
    return [label("tip", at(back, rows - 1, middle), "center", "bottom"),
      label("root", at(flank, 0, middle), "center", "top"),
      label(ends[0], low(left), "left", "top"), label(ends[1], low(right), "right", "top", -18)];
  };
  // The loaded part of the contact line at the roll position, on the worn flank.
  const contact = ({body, step, roll}, points) => {
    const line = {type: "scatter3d", mode: "lines", x: [], y: [], z: [], hoverinfo: "skip", showlegend: false,
      line: {width: 9, color: "#00e5ff"}};
    if (!body.line) return line;
    for (let f = 0; f < body.faces; f++) {
      const load = body.load[(step * rolls + roll) * body.faces + f];
      const row = body.line[roll * body.faces + f], low = Math.min(Math.floor(row), body.rows - 2);
      ["x", "y", "z"].forEach((name, c) => {
        const a = 3 * (low * body.faces + f), b = a + 3 * body.faces, weight = row - low;
        const lift = 0.04 * ((1 - weight) * body.normal[a + c] + weight * body.normal[b + c]);
        line[name].push(load > 0 ? (1 - weight) * points[a + c] + weight * points[b + c] + lift : null);
      });
    }
    return line;
  };
  const surface = (now, points) => {
    const {body, step, quantity} = now, size = body.rows * body.faces;
    const shown = quantity.steps > 1 ? step : 0;
    const values = each(body.rows, r => Array.from(
      quantity.values.subarray(shown * size + r * body.faces, shown * size + (r + 1) * body.faces)));
    const text = values.map(row => row.map(value => `${quantity.title} ${figures(value)} ${quantity.units}`));
    return {type: "surface", ...grid(each(body.rows, r => row(points, body.faces, r))), surfacecolor: values, text,
      hoverinfo: "text", cmin: 0, cmax: quantity.greatest, lighting: {ambient: 0.85, diffuse: 0.3, specular: 0.02},
      lightposition: light,
      colorscale: quantity.colours.map((colour, k, all) => [k / (all.length - 1), colour]),
      colorbar: {title: {text: quantity.units, side: "top", font: {size: 13}}, thickness: 14, len: 0.8, x: 1,
        xanchor: "right", tickfont: {color: ink()}}};
  };

  const scheme = window.matchMedia("(prefers-color-scheme: dark)");
  const dark = () => scheme.matches;
  const ink = () => dark() ? "#e4eaf0" : "#1d2733";
  const bounds = body => {
    const parts = [body.flank, body.back, body.fillet, body.backFillet];
    const ranges = [0, 1, 2].map(c => {
      const values = parts.flatMap(points => Array.from(points).filter((_, k) => k % 3 === c));
      return [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
    });
    const room = 0.05 * (ranges[2][1] - ranges[2][0]);
    return ranges.map(([low, high]) => [low - room, high + room]);
  };
  const scaled = body => {
    body.bounds ??= bounds(body);
    const sizes = body.bounds.map(([low, high]) => high - low);
    return {sizes, scale: 2.8 / Math.hypot(...sizes), middle: body.bounds.map(([low, high]) => (low + high) / 2)};
  };
  // Margins beside and above the tooth [pixels], for labels and the colour scale; half the vertical angle of view.
  const beside = 12, above = 34, colourScale = 62, halfAngle = Math.PI / 8;
  const tall = () => Math.max(view.clientHeight, 1), wide = () => Math.max(view.clientWidth - colourScale, 1);
  // Initial view: the same direction for every tooth, at the least distance at which all of it is visible.
  const home = body => {
    const {scale, middle} = scaled(body), size = Math.hypot(0.45, 1.5, 0.75);
    const [x, y, z] = [0.45 / size, 1.5 / size, 0.75 / size], flat = Math.hypot(x, y), slope = Math.tan(halfAngle);
    const upright = slope * (1 - 2 * above / tall()), across = slope * (wide() - 2 * beside) / tall();
    let distance = 0;
    for (const points of [body.flank, body.back, body.fillet, body.backFillet]) {
      for (let k = 0; k < points.length; k += 3) {
        const [a, b, c] = [0, 1, 2].map(n => scale * (points[k + n] - middle[n]));
        const towards = a * x + b * y + c * z, up = c * flat - (a * x + b * y) * z / flat, side = (b * x - a * y) / flat;
        distance = Math.max(distance, towards + Math.abs(up) / upright, towards + Math.abs(side) / across);
      }
    }
    return {eye: {x: distance * x, y: distance * y, z: distance * z}, center: {x: 0, y: 0, z: 0}, up: {x: 0, y: 0, z: 1},
      projection: {type: "perspective"}};
  };
  let camera = null;
  const layout = body => {
    const {sizes, scale} = scaled(body);
    const axis = c => ({visible: false, showspikes: false, range: body.bounds[c]});
    return {margin: {l: 0, r: 0, t: 0, b: 0}, paper_bgcolor: "rgba(0,0,0,0)", font: {color: ink()},
      uirevision: "kept", scene: {xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), aspectmode: "manual", camera,
        aspectratio: {x: scale * sizes[0], y: scale * sizes[1], z: scale * sizes[2]}, annotations: labels(body),
        domain: {x: [0, wide() / (wide() + colourScale)], y: [0, 1]}, dragmode: "turntable"}};
  };

  const describe = now => {
    const {body, step, quantity, factor, roll} = now, size = body.rows * body.faces;
    const deepest = body.wear.subarray(step * size, (step + 1) * size).reduce((a, b) => Math.max(a, b), 0);
    const drawn = factor === 1 ? "drawn to scale" : `drawn ${factor} times as deep as it is`;
    by("turning-when").textContent = data.steps[step];
    const note = quantity.note ? ` Colours: ${quantity.note}.` : "";
    by("turning-told-aloud").textContent =
      `${body.name[0].toUpperCase()}${body.name.slice(1)}, ${data.steps[step]}: greatest wear ${figures(deepest)} µm, ${drawn}.${note}`;
    if (!by("turning-roll")) return;
    const share = Math.round(100 * meshing.share[step * rolls + roll]);
    by("turning-where").textContent = `${meshing.roll[roll]}: the tooth carries ${share} % of the load`;
  };
  const draw = () => {
    const now = chosen(), points = worn(now);
    describe(now);
    return Plotly.react(view, [surface(now, points), ...rest(now.body, points), edge(now.body), contact(now, points)], layout(now.body), {displayModeBar: false, responsive: true});
  };
  const options = (id, texts, at) => by(id).replaceChildren(...texts.map(([value, text], k) =>
    new Option(text, value, k === at, k === at)));
  const fill = () => {
    const {quantities, factors} = data.bodies[slider("turning-body")];
    options("turning-quantity", quantities.map(({title}, k) => [k, title]), 0);
    const initial = Math.max(factors.length - 2, 0);
    options("turning-factor", factors.map(n => [n, n === 1 ? "to scale" : `${n} times as deep`]), initial);
  };

  const turn = direction => {
    const eye = {...camera.eye}, flat = Math.hypot(eye.x, eye.y), initial = Math.hypot(flat, eye.z);
    let around = Math.atan2(eye.y, eye.x), above = Math.atan2(eye.z, flat), distance = initial;
    const by10 = Math.PI / 18;
    if (direction === "left") around -= by10;
    if (direction === "right") around += by10;
    if (direction === "up") above = Math.min(above + by10, 1.5);
    if (direction === "down") above = Math.max(above - by10, -1.5);
    if (direction === "in") distance /= 1.15;
    if (direction === "out") distance *= 1.15;
    camera = direction === "home" ? home(chosen().body) : {...camera, eye: {x: distance * Math.cos(above) * Math.cos(around),
      y: distance * Math.cos(above) * Math.sin(around), z: distance * Math.sin(above)}};
    Plotly.relayout(view, {"scene.camera": camera});
  };
  const keys = {ArrowLeft: "left", ArrowRight: "right", ArrowUp: "up", ArrowDown: "down", "+": "in", "-": "out"};

  figure.hidden = false;
  fill();
  camera = home(chosen().body);
  await draw();
  document.documentElement.classList.add("turns-here");
  view.on("plotly_relayout", () => { camera = view.layout.scene.camera; });
  view.addEventListener("keydown", event => {
    if (!keys[event.key]) return;
    event.preventDefault();
    turn(keys[event.key]);
  });
  for (const button of figure.querySelectorAll("[data-turn]")) button.onclick = () => turn(button.dataset.turn);
  for (const id of ["turning-quantity", "turning-factor", "turning-step", "turning-roll"]) {
    if (by(id)) by(id).addEventListener("input", draw);
  }
  if (by("turning-body")) by("turning-body").addEventListener("input", () => {
    fill();
    camera = home(chosen().body);
    draw();
  });
  scheme.addEventListener("change", draw);
  figure.dataset.drawn = "yes";
})();
