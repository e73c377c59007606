// Scenes that one can turn: paths, dots, magnified errors and named marks, drawn on a canvas, and the pose's image.
for (const figure of document.querySelectorAll("figure.scene")) {
  const scene = JSON.parse(figure.querySelector("script").textContent);
  const make = (tag, parent, more = {}) => parent.appendChild(Object.assign(document.createElement(tag), more));
  const stage = document.createElement("div");
  figure.insertBefore(stage, figure.querySelector("figcaption"));
  stage.className = "stage";
  const canvas = make("canvas", stage, { tabIndex: 0 }), pen = canvas.getContext("2d");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", scene.alt);
  const bar = make("div", figure, { className: "controls" });
  figure.insertBefore(bar, figure.querySelector("figcaption"));
  figure.querySelector("figcaption").prepend(scene.frames.length > 1 ? "Drag to turn, step through the poses. " : "Drag to turn. ");

  const all = scene.shapes.flatMap(({ at }) => at.flat(Array.isArray(at[0]?.[0]) ? 1 : 0)).filter((p) => p?.[0] != null);
  const side = (axis, pick) => all.reduce((best, p) => pick(best, p[axis]), pick === Math.min ? Infinity : -Infinity);
  const low = [0, 1, 2].map((axis) => side(axis, Math.min)), high = [0, 1, 2].map((axis) => side(axis, Math.max));
  const centre = low.map((l, axis) => (l + high[axis]) / 2);
  const size = Math.hypot(...low.map((l, axis) => high[axis] - l)) || 1;
  const home = { turn: -0.9, rise: 0.35, zoom: 1 };
  let look = { ...home }, frame = 0, magnification = scene.magnification, marks = [];
  const hidden = new Set();
  const colours = getComputedStyle(document.documentElement);
  const colour = (name) => name.startsWith("var(") ? colours.getPropertyValue(name.slice(4, -1)).trim() : name;

  function unscaled([x, y, z], { turn, rise }) {
    const dx = x - centre[0], dy = y - centre[1], dz = z - centre[2];
    const c = Math.cos(turn), s = Math.sin(turn), cr = Math.cos(rise), sr = Math.sin(rise);
    const away = c * dy - s * dx, depth = away * cr - dz * sr, near = 1 / (1 + 0.35 * depth / size);
    return [near * (c * dx + s * dy), -near * (dz * cr + away * sr), depth];
  }
  const first = scene.shapes.flatMap(({ at }) => Array.isArray(at[0]?.[0]) ? at[0] : at).filter((p) => p?.[0] != null);
  const seen = first.map((p) => unscaled(p, home)); // at first all of this pose is in view
  const [across, upright] = [0, 1].map((axis) => seen.reduce(([l, h], p) => [Math.min(l, p[axis]), Math.max(h, p[axis])], [0, 0]));
  const scaled = () => look.zoom * 0.8 * Math.min(canvas.clientWidth / (across[1] - across[0] || 1), canvas.clientHeight / (upright[1] - upright[0] || 1));
  function project(place) {
    const [x, y, depth] = unscaled(place, look), { clientWidth: wide, clientHeight: tall } = canvas, scale = scaled();
    return [wide / 2 + scale * (x - (across[0] + across[1]) / 2), tall / 2 + scale * (y - (upright[0] + upright[1]) / 2), depth];
  }
  const pale = (shape, i) => scene.frames.length > 1 && shape.of.length && shape.of[i] !== frame ? 0.4 : 1;
  const stroke = (points, shape, width) => {
    pen.beginPath();
    points.forEach(([x, y], i) => i ? pen.lineTo(x, y) : pen.moveTo(x, y));
    pen.lineWidth = width;
    pen.strokeStyle = colour(shape.colour);
    pen.stroke();
  };
  const painters = {
    path(shape, add) {
      const points = (shape.at[frame] ?? shape.at[0] ?? []).filter((p) => p[0] != null).map(project);
      if (shape.closed && points.length) add(Math.max(...points.map((p) => p[2])), () => {
        pen.globalAlpha = shape.opacity;
        pen.beginPath();
        points.forEach(([x, y], i) => i ? pen.lineTo(x, y) : pen.moveTo(x, y));
        pen.fillStyle = colour(shape.colour);
        pen.fill();
      });
      else points.slice(1).forEach((end, i) => add((points[i][2] + end[2]) / 2, () => {
        pen.globalAlpha = shape.opacity;
        const near = 1 / (1 + 0.35 * end[2] / size);
        stroke([points[i], end], shape, Math.max(shape.width, 2 * shape.radius * near * scaled()));
      }));
    },
    dots(shape, add) {
      shape.at.forEach((place, i) => {
        if (place[0] == null) return;
        const [x, y, depth] = project(place);
        if (shape.names[i]) marks.push([x, y, shape.names[i]]);
        add(depth, () => {
          pen.globalAlpha = pale(shape, i);
          pen.fillStyle = colour(typeof shape.colour === "string" ? shape.colour : shape.colour[i]);
          pen.fillRect(x - shape.size / 2, y - shape.size / 2, shape.size, shape.size);
        });
      });
    },
    arrows(shape, add) {
      if (hidden.has(shape.series)) return;
      shape.at.forEach((place, i) => {
        if (place[0] == null || shape.by[i][0] == null) return;
        const start = project(place), end = project(place.map((p, axis) => p + magnification * shape.by[i][axis]));
        marks.push([end[0], end[1], shape.names[i]]);
        add(start[2], () => {
          pen.globalAlpha = pale(shape, i);
          stroke([start, end], shape, 1.3);
        });
      });
    },
    labels(shape, add) {
      (shape.at[frame] ?? shape.at[0]).forEach((place, i) => {
        if (place[0] == null) return;
        const [x, y] = project(place);
        marks.push([x, y, shape.names[i]]);
        add(-2 * size, () => {
          if (shape.size) {
            pen.beginPath();
            pen.arc(x, y, shape.size, 0, 7);
            pen.fillStyle = colour(shape.bold ? shape.colour : "var(--paper)");
            pen.strokeStyle = colour(shape.colour);
            pen.lineWidth = 2;
            pen.fill();
            pen.stroke();
          }
          texts.push([x, y, shape, shape.names[i]]);
        });
      });
    },
  };
  let texts = [];
  function write() { // the important first; a name that would cover another is left to the pointer
    const taken = [];
    for (const [x, y, shape, text] of texts.sort((a, b) => b[2].bold - a[2].bold)) {
      pen.font = `${shape.bold ? "600 13" : "11"}px system-ui, sans-serif`;
      const wide = pen.measureText(text).width;
      const left = x + 10 + wide > canvas.clientWidth ? x - 10 - wide : x + 10;
      const free = [y + 4, y - 10, y + 18, y + 32].find((at) => !taken.some(
        ([l, t, r]) => left < r && left + wide > l && Math.abs(at - t) < 14));
      if (free === undefined) continue;
      taken.push([left, free, left + wide]);
      pen.lineWidth = 3;
      pen.strokeStyle = colour("var(--paper)");
      pen.strokeText(text, left, free);
      pen.fillStyle = colour(shape.colour);
      pen.fillText(text, left, free);
    }
  }
  function rule() { // a length to compare with, as long as it is in the middle of the scene
    const scale = scaled(), power = 10 ** Math.floor(Math.log10(120 / scale));
    const length = power * [5, 2, 1].find((step) => step * power * scale <= 120), y = canvas.clientHeight - 16;
    stroke([[16, y - 4], [16, y], [16 + length * scale, y], [16 + length * scale, y - 4]], { colour: "var(--muted)" }, 1.5);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = colour("var(--muted)");
    pen.fillText(`${Number(length.toPrecision(1)).toLocaleString("en")} mm`, 16, y - 8);
  }
  function draw() {
    const dense = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * dense;
    canvas.height = canvas.clientHeight * dense;
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.lineCap = pen.lineJoin = "round";
    marks = [];
    texts = [];
    const parts = [];
    for (const shape of scene.shapes) painters[shape.kind](shape, (depth, paint) => parts.push([depth, paint]));
    for (const [, paint] of parts.sort((a, b) => b[0] - a[0])) {
      pen.globalAlpha = 1;
      paint();
    }
    pen.globalAlpha = 1;
    write();
    rule();
  }

  const photo = Object.keys(scene.photos).length ? make("div", stage, { className: "photo" }) : null;
  function showPhoto() {
    const name = scene.frames[frame], found = scene.photos[name];
    if (!photo) return;
    photo.replaceChildren();
    if (!found) return make("p", photo, { className: "quiet", textContent: `The image of ${name} is not in this page.` });
    make("img", photo, { src: found.source, alt: `Image of pose ${name}` });
    const over = photo.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "svg"));
    over.setAttribute("viewBox", `-0.5 -0.5 ${found.size[0]} ${found.size[1]}`);
    const mark = (name, values) => {
      const one = over.appendChild(document.createElementNS("http://www.w3.org/2000/svg", name));
      for (const [key, value] of Object.entries(values)) one.setAttribute(key, value);
      return one;
    };
    found.points.forEach(([u, v], i) => {
      if (u == null) return;
      const [du, dv] = found.misses[i].map((miss) => (miss ?? NaN) * scene.inPhotos * magnification / scene.magnification);
      const shown = [mark("circle", { cx: u, cy: v, r: found.size[0] / 160 })];
      if (!Number.isNaN(du)) shown.push(mark("line", { x1: u, y1: v, x2: u + du, y2: v + dv }));
      for (const one of shown) {
        one.addEventListener("pointermove", (event) => report.tell(event, found.names[i].split("\n")));
        one.addEventListener("pointerleave", (event) => report.tell(event, []));
      }
    });
  }
  function to(number) {
    frame = (number + scene.frames.length) % scene.frames.length;
    choice.selectedIndex = frame;
    showPhoto();
    draw();
  }
  const choice = document.createElement("select");
  if (scene.frames.length > 1) {
    choice.setAttribute("aria-label", "Pose");
    let timer = null;
    const play = make("button", bar, { textContent: "Play", onclick() {
      timer = timer === null ? setInterval(() => to(frame + 1), 700) : clearInterval(timer) ?? null;
      play.textContent = timer === null ? "Play" : "Stop";
    } });
    make("button", bar, { textContent: "◂", ariaLabel: "Previous pose", onclick: () => to(frame - 1) });
    bar.append(choice);
    make("button", bar, { textContent: "▸", ariaLabel: "Next pose", onclick: () => to(frame + 1) });
    for (const name of scene.frames) make("option", choice, { textContent: `pose ${name}` });
    choice.onchange = () => to(choice.selectedIndex);
    document.addEventListener("pose", ({ detail }) => {
      const found = scene.frames.indexOf(detail);
      if (found < 0) return;
      to(found);
      figure.scrollIntoView({ block: "nearest", behavior: "smooth" });
    });
  }
  if (magnification) {
    const label = make("label", bar), said = make("span", label), slider = make("input", label, {
      type: "range", min: -1.5, max: 1.5, step: 0.05, value: 0 });
    slider.oninput = () => {
      magnification = scene.magnification * 10 ** slider.value;
      const times = (factor) => `× ${Number(factor.toPrecision(2)).toLocaleString("en")}`;
      said.textContent = `errors ${times(magnification)}${photo ? `, in the image ${times(scene.inPhotos * 10 ** slider.value)}` : ""} `;
      showPhoto();
      draw();
    };
    slider.oninput();
  }
  for (const shape of scene.shapes.filter((one) => one.series)) {
    const label = make("label", bar), box = make("input", label, { type: "checkbox", checked: true });
    make("span", label, { textContent: shape.series }).style.color = shape.colour;
    box.onchange = () => { hidden[box.checked ? "delete" : "add"](shape.series); draw(); };
  }

  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) {
      look.turn -= event.movementX / 150;
      look.rise = Math.max(-1.5, Math.min(1.5, look.rise + event.movementY / 150));
      return draw();
    }
    const [x, y] = [event.offsetX, event.offsetY];
    const [far, text] = marks.reduce((best, [mx, my, name]) => {
      const away = Math.hypot(mx - x, my - y);
      return away < best[0] ? [away, name] : best;
    }, [9, ""]);
    report.tell(event, far < 9 ? text.split("\n") : []);
  });
  canvas.addEventListener("pointerleave", (event) => report.tell(event, []));
  canvas.addEventListener("dblclick", () => { look = { ...home }; draw(); });
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    look.zoom *= Math.exp(-event.deltaY / 400);
    draw();
  }, { passive: false });
  canvas.addEventListener("keydown", ({ key }) => {
    const step = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[key];
    if (step) { look.turn += step[0]; look.rise += step[1]; }
    if (key === "+" || key === "-") look.zoom *= key === "+" ? 1.2 : 1 / 1.2;
    draw();
  });
  new ResizeObserver(draw).observe(canvas);
  for (const look of ["(prefers-color-scheme: dark)", "print"]) matchMedia(look).addEventListener("change", draw);
  if (scene.frames.length) to(frame); else draw();
}
