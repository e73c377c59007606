// What all parts of a page share: words under the pointer, a pose that all of them show, and tables that sort.
const report = (() => {
  const note = document.body.appendChild(document.createElement("div"));
  note.id = "under-pointer";
  note.hidden = true;
  const tell = (event, lines) => {
    note.hidden = !lines.length;
    if (note.hidden) return;
    note.replaceChildren(...lines.map((text) => {
      const line = document.createElement("div");
      line.textContent = text;
      return line;
    }));
    const left = event.clientX + 14, top = event.clientY + 14;
    note.style.left = `${Math.max(4, Math.min(left, innerWidth - note.offsetWidth - 8))}px`;
    note.style.top = `${top + note.offsetHeight > innerHeight ? event.clientY - note.offsetHeight - 10 : top}px`;
  };
  const show = (pose) => document.dispatchEvent(new CustomEvent("pose", { detail: pose }));

  const value = (cell) => {
    const text = cell.textContent.trim(), number = Number.parseFloat(cell.dataset.order ?? text.replace("\u2212", "-"));
    return Number.isNaN(number) ? text : number;
  };
  const compare = (a, b) => typeof a === "number" && typeof b === "number"
    ? a - b : String(a).localeCompare(String(b), "en", { numeric: true });
  for (const table of document.querySelectorAll("table:not(.matrix)")) {
    const body = table.tBodies[0];
    if (body.rows.length < 3) continue;
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      const button = document.createElement("button");
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const sign = head.ariaSort === "ascending" ? -1 : 1;
        for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
        body.append(...[...body.rows].sort((a, b) => sign * compare(value(a.cells[column]), value(b.cells[column]))));
      });
    });
  }
  return { tell, show };
})();
