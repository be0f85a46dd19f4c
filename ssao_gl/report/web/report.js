"use strict";

// Tables: a click on a heading sorts by it, a second click the other way round. Missing values stay last.
for (const table of document.querySelectorAll("table")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    head.tabIndex = 0;
    const sort = () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach(other => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const key = row => row.cells[column].dataset.v ?? row.cells[column].textContent;
      const numeric = head.classList.contains("n");
      const order = (a, b) => {
        const [x, y] = [key(a), key(b)];
        if (!numeric) return (down ? -1 : 1) * x.localeCompare(y);
        if (x === "" || y === "") return (x === "") - (y === "");
        return (down ? -1 : 1) * (Number(x) - Number(y));
      };
      table.tBodies[0].append(...[...table.tBodies[0].rows].sort(order));
    };
    head.addEventListener("click", sort);
    head.addEventListener("keydown", event => { if (event.key === "Enter") sort(); });
  });
}

// The truth of a view is stored once and shown beside every method.
for (const image of document.querySelectorAll("img[data-same]")) {
  image.src = document.getElementById(image.dataset.same).src;
}

// Zoom: truth, method and error side by side, moved together.
const zoom = document.getElementById("zoom");
const panes = document.getElementById("zoom-panes");
const rows = [...document.querySelectorAll(".trio")];
let shown = -1, scale = 1, x = 0, y = 0;

function place() {
  for (const image of panes.querySelectorAll("img")) image.style.transform = `translate(${x}px, ${y}px) scale(${scale})`;
}

function open(index) {
  shown = (index + rows.length) % rows.length;
  const images = [...rows[shown].querySelectorAll("img")];
  document.getElementById("zoom-title").textContent = rows[shown].dataset.title;
  const fresh = zoom.hidden;
  zoom.hidden = false;
  document.body.style.overflow = "hidden";
  panes.replaceChildren(...images.map(image => {
    const pane = document.createElement("div");
    pane.className = "pane";
    const copy = document.createElement("img");
    copy.src = image.src;
    copy.draggable = false;
    pane.append(copy);
    return pane;
  }));
  if (fresh) {
    const pane = panes.firstChild, image = images[0];
    scale = Math.min(pane.clientWidth / image.naturalWidth, pane.clientHeight / image.naturalHeight);
    x = 0;
    y = (pane.clientHeight - scale * image.naturalHeight) / 2;
  }
  place();
}

rows.forEach((row, index) => row.addEventListener("click", event => { if (event.target.tagName === "IMG") open(index); }));
panes.addEventListener("wheel", event => {
  event.preventDefault();
  const pane = event.target.closest(".pane");
  if (!pane) return;
  const box = pane.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
  const next = Math.min(32, Math.max(0.2, scale * Math.exp(-event.deltaY / 400)));
  x = px - (px - x) * next / scale;
  y = py - (py - y) * next / scale;
  scale = next;
  place();
}, { passive: false });
panes.addEventListener("pointerdown", event => panes.setPointerCapture(event.pointerId));
panes.addEventListener("pointermove", event => {
  if (!event.buttons) return;
  x += event.movementX;
  y += event.movementY;
  place();
});
function close() {
  zoom.hidden = true;
  document.body.style.overflow = "";
}

panes.addEventListener("dblclick", close);
addEventListener("keydown", event => {
  if (zoom.hidden) return;
  if (event.key === "Escape") close();
  if (event.key === "ArrowRight" || event.key === "ArrowDown") open(shown + 1);
  if (event.key === "ArrowLeft" || event.key === "ArrowUp") open(shown - 1);
  if (event.key.startsWith("Arrow")) event.preventDefault();
});
