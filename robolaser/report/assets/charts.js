// Every chart of the page, drawn by Vega without compiling code.
(() => {
  const config = JSON.parse(document.getElementById("chart-look").textContent);
  const tell = (_, event, item, value) => {
    const entries = value == null || value === "" ? [] : typeof value === "object" ? Object.entries(value) : [["", value]];
    report.tell(event, entries.map(([name, said]) => name ? `${name}: ${said}` : `${said}`));
  };
  const read = (data) => { // Vega would compile code to read comma-separated numbers
    if (typeof data.values !== "string") return;
    const [names, ...rows] = data.values.trim().split("\n").map((row) => row.split(","));
    data.values = rows.map((row) => Object.fromEntries(row.map((cell, i) => [names[i], Number(cell)])));
    delete data.format;
  };
  for (const figure of document.querySelectorAll("figure.chart")) {
    const place = figure.querySelector(".plot");
    const spec = JSON.parse(figure.querySelector("script").textContent);
    for (const layer of spec.layer) read(layer.data);
    try {
      const { spec: compiled } = vegaLite.compile(spec, { config, logger: vega.logger(vega.Error) });
      const view = new vega.View(vega.parse(compiled, null, { ast: true }), {
        renderer: "svg", container: place, hover: true, tooltip: tell, logLevel: vega.Error,
        expr: vega.expressionInterpreter,
      });
      view.addEventListener("click", (_, item) => item?.datum?.pose && report.show(item.datum.pose));
      view.runAsync();
    } catch (error) {
      place.textContent = spec.description;
      console.error(error);
    }
  }
})();
