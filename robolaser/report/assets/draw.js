// Draw every chart of the page, and say under the pointer what a mark stands for.
(() => {
  const config = JSON.parse(document.getElementById("chart-look").textContent);
  const note = document.body.appendChild(document.createElement("div"));
  note.id = "under-pointer";
  note.hidden = true;
  const tell = (_, event, item, value) => {
    note.hidden = value == null || value === "";
    if (note.hidden) return;
    const lines = typeof value === "object" ? Object.entries(value) : [["", value]];
    note.replaceChildren(...lines.map(([name, said]) => {
      const line = document.createElement("div");
      line.textContent = name ? `${name}: ${said}` : `${said}`;
      return line;
    }));
    const left = event.clientX + 14, top = event.clientY + 14;
    note.style.left = `${Math.max(4, Math.min(left, innerWidth - note.offsetWidth - 8))}px`;
    note.style.top = `${top + note.offsetHeight > innerHeight ? event.clientY - note.offsetHeight - 10 : top}px`;
  };
  for (const figure of document.querySelectorAll("figure.chart")) {
    const place = figure.querySelector(".plot");
    const spec = JSON.parse(figure.querySelector("script").textContent);
    try {
      const { spec: compiled } = vegaLite.compile(spec, { config, logger: vega.logger(vega.Error) });
      const view = new vega.View(vega.parse(compiled), {
        renderer: "svg", container: place, hover: true, tooltip: tell, logLevel: vega.Error,
      });
      view.runAsync();
    } catch (error) {
      place.textContent = spec.description;
      console.error(error);
    }
  }
})();
