"use strict";
// For tests: what went wrong is in the document.
window.addEventListener("error", event => { document.body.dataset.error = event.message; });

const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const on = (event, selector, within, act) => all(selector, within).forEach(
    element => element.addEventListener(event, seen => act(element, seen)));
const isOff = element => element.classList.contains("off");
const tip = document.getElementById("tip");

function showTip(element, event) {
    tip.textContent = element.dataset.tip;
    tip.classList.remove("off");
    const box = tip.getBoundingClientRect();
    tip.style.left = `${Math.max(Math.min(event.clientX + 16, innerWidth - box.width - 8), 8)}px`;
    tip.style.top = `${Math.max(Math.min(event.clientY + 16, innerHeight - box.height - 8), 8)}px`;
}

/** By number where both are numbers, else by text. */
function compare(a, b) {
    return a !== "" && b !== "" && !isNaN(a) && !isNaN(b) ? a - b : a.localeCompare(b);
}

function sortBy(head) {
    const table = head.closest("table");
    const sign = head.ariaSort === "ascending" ? -1 : 1;
    all("thead th", table).forEach(other => { other.ariaSort = "none"; });
    head.ariaSort = sign < 0 ? "descending" : "ascending";
    const keyOf = ({ cells: { [head.cellIndex]: cell } }) => cell.dataset.value ?? cell.textContent;
    all(".detail", table).forEach(row => row.remove());
    const rows = [...table.tBodies[0].rows].sort((a, b) => sign * compare(keyOf(a), keyOf(b)));
    table.tBodies[0].append(...rows);
}

/** Below a row of the matrix: all that its cells say. */
function toggleDetail(row) {
    if (row.nextElementSibling?.classList.contains("detail")) {
        row.nextElementSibling.remove();
        return;
    }
    const detail = document.createElement("tr");
    detail.className = "detail";
    const cell = detail.insertCell();
    cell.colSpan = row.cells.length;
    cell.textContent = all("[data-tip]", row).map(
        answer => answer.dataset.tip.replaceAll("\n", ", ").replaceAll("\t", " ")).join("\n");
    row.after(detail);
}

/** What is in the field of a section, parted by commas, hides the rows that lack one part, and their
 * marks. */
class Section {
    constructor(section) {
        this.section = section;
        this.rows = all(".points tbody tr, .matrix tbody tr", section);
        this.rowOf = new Map(this.rows.map(row => [row.dataset.point, row]));
        on("input", ".find", section, () => this.update());
        on("click", ".matrix tbody tr", section, toggleDetail);
        const points = ".points tbody tr, .panels g[id]";
        on("mouseenter", points, section,
           ({ id, dataset }) => this.highlight(this.rowOf.get(dataset.point ?? id)));
        on("mouseleave", points, section, () => this.highlight());
        this.update();
    }

    update() {
        const field = this.section.querySelector(".find")?.value ?? "";
        const words = field.toLowerCase().split(",").map(word => word.trim());
        all(".detail", this.section).forEach(row => row.remove());
        for (const row of this.rows) {
            // What a cell of the matrix says is in its data, as its text is a letter.
            const cells = [...row.cells].map(cell => cell.dataset.words ?? cell.textContent);
            const said = cells.join("\n").toLowerCase();
            row.classList.toggle("off", !words.every(word => said.includes(word)));
        }
        // Marks, labels and crosses are named FAMILY-NUMBER.., ways FAMILY-way-NUMBER-NUMBER..
        for (const part of all(".panels g[id]", this.section)) {
            const [family, ...numbers] = part.id.split("-");
            const rows = numbers.map(number => this.rowOf.get(`${family}-${number}`));
            part.classList.toggle("off", rows.some(row => row && isOff(row)));
        }
        for (const count of all(".count", this.section)) {
            const shown = this.rows.filter(row => !isOff(row)).length;
            count.textContent = `${shown} of ${this.rows.length} ${count.dataset.what}`;
        }
    }

    /** The same setting in all scenes. */
    highlight(wanted) {
        this.section.classList.toggle("dim", Boolean(wanted));
        for (const row of this.rows) {
            const isSame = row.dataset.method === wanted?.dataset.method &&
                row.dataset.setting === wanted?.dataset.setting;
            row.classList.toggle("same", isSame);
            document.getElementById(row.dataset.point)?.classList.toggle("same", isSame);
        }
    }
}

for (const title of all("svg title")) {
    title.parentElement.dataset.tip = title.textContent;
    title.remove();
}
on("mouseenter", "[data-tip]", document, showTip);
on("mouseleave", "[data-tip]", document, () => tip.classList.add("off"));
on("click", "thead th", document, sortBy);
for (const head of all("thead th")) {
    const below = head.closest("table").tBodies[0].rows[0]?.cells[head.cellIndex];
    head.classList.toggle("number", Boolean(below?.classList.contains("number")));
}
all("section").forEach(section => new Section(section));
