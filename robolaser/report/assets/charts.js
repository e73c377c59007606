// Every chart of the page, drawn by Vega.
(() => {
  const config = JSON.parse(document.getElementById("chart-look").textContent);
  const tell = (_, event, item, value) => {
    const entries = value == null || value === "" ? [] : typeof value === "object" ? Object.entries(value) : [["", value]];
    report.tell(event, entries.map(([name, said]) => name ? `${name}: ${said}` : `${said}`));
  };
  for (const figure of document.querySelectorAll("figure.chart")) {
    const place = figure.querySelector(".plot");
    const spec = JSON.parse(figure.querySelector("script").textContent);
    try {
      const { spec: compiled } = vegaLite.compile(spec, { config, logger: vega.logger(vega.Error) });
      const view = new vega.View(vega.parse(compiled), {
        renderer: "svg", container: place, hover: true, tooltip: tell, logLevel: vega.Error,
      });
      view.addEventListener("click", (_, item) => item?.datum?.pose && report.show(item.datum.pose));
      view.runAsync();
    } catch (error) {
      place.textContent = spec.description;
      console.error(error);
    }
  }
})();
