"use strict";
// For tests: what went wrong is in the document.
window.addEventListener("error", event => { document.body.dataset.error = event.message; });

const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const isOff = element => element.classList.contains("off");
const tip = document.getElementById("tip");

function showTip(words, event) {
    tip.textContent = words;
    tip.classList.remove("off");
    const box = tip.getBoundingClientRect();
    const left = Math.min(event.clientX + 16, innerWidth - box.width - 8);
    const top = Math.min(event.clientY + 16, innerHeight - box.height - 8);
    tip.style.left = `${Math.max(left, 8)}px`;
    tip.style.top = `${Math.max(top, 8)}px`;
}

/** By number where both are numbers, else by text. */
function compare(a, b) {
    return a !== "" && b !== "" && !isNaN(a) && !isNaN(b) ? a - b : a.localeCompare(b);
}

function sortBy(table, column) {
    const heads = [...table.tHead.rows[0].cells];
    const down = heads[column].ariaSort === "ascending";
    heads.forEach(head => { head.ariaSort = "none"; });
    heads[column].ariaSort = down ? "descending" : "ascending";
    const keyOf = row => row.cells[column].dataset.value ?? row.cells[column].textContent.trim();
    all(".detail", table).forEach(row => row.remove());
    table.tBodies[0].append(...[...table.tBodies[0].rows].sort(
        (a, b) => (down ? -1 : 1) * compare(keyOf(a), keyOf(b))));
}

/** Filters of a section: chips hide what has their data, words and answers hide rows of tables. */
class Section {
    constructor(section) {
        this.section = section;
        this.chips = all(".chip", section);
        this.rows = all(".points tbody tr, .matrix tbody tr", section);
        this.rowOf = new Map(this.rows.map(row => [row.dataset.point, row]));
        for (const chip of this.chips) {
            chip.addEventListener("click", () => {
                chip.ariaPressed = String(chip.ariaPressed !== "true");
                this.update();
            });
        }
        for (const button of all("[data-all]", section)) {
            button.addEventListener("click", () => {
                const chips = this.chips.filter(chip => chip.dataset.kind === button.dataset.all);
                const on = !chips.every(chip => chip.ariaPressed === "true");
                chips.forEach(chip => { chip.ariaPressed = String(on); });
                this.update();
            });
        }
        for (const input of all("select, .find", section)) {
            input.addEventListener("input", () => this.update());
        }
        for (const row of this.rows) {
            row.addEventListener("mouseenter", () => this.highlight(row));
            row.addEventListener("mouseleave", () => this.highlight(null));
            row.addEventListener("click", () => this.toggleDetail(row));
        }
        for (const mark of all(".panels g[id]", section)) {
            const row = this.rowOf.get(mark.id);
            mark.addEventListener("mouseenter", () => this.highlight(row ?? null));
            mark.addEventListener("mouseleave", () => this.highlight(null));
        }
        this.update();
    }

    update() {
        const chosen = {};
        for (const { dataset, ariaPressed } of this.chips) {
            (chosen[dataset.kind] ??= new Set()).add(ariaPressed === "true" && dataset.value);
        }
        const fits = element => Object.entries(chosen).every(
            ([kind, values]) => !(kind in element.dataset) || values.has(element.dataset[kind]));
        const valueOf = selector => this.section.querySelector(selector)?.value ?? "";
        const [words, method, verdict] = [".find", ".of-method", ".of-verdict"].map(valueOf);
        const isAnswered = row => !(method || verdict) || all(".answer", row).some(
            ({ dataset }) => (!method || dataset.method === method) &&
                (!verdict || dataset.verdict === verdict));
        all(".detail", this.section).forEach(row => row.remove());
        for (const row of this.rows) {
            const isFound = row.textContent.toLowerCase().includes(words.toLowerCase());
            row.classList.toggle("off", !(fits(row) && isFound && isAnswered(row)));
        }
        all(".panels > *", this.section).forEach(panel => this.updatePanel(panel, fits));
        all(".matrix", this.section).forEach(table => this.addUp(table));
        const count = this.section.querySelector(".count");
        if (count) {
            count.textContent = `${this.rows.filter(row => !isOff(row)).length} of ` +
                `${this.rows.length} ${count.dataset.what}`;
        }
    }

    /** Marks, labels and crosses are named FAMILY-NUMBER.., ways FAMILY-way-NUMBER-NUMBER.. */
    updatePanel(panel, fits) {
        panel.classList.toggle("off", !fits(panel));
        for (const part of all("g[id]", panel)) {
            const [family, ...numbers] = part.id.split("-");
            const rows = numbers.map(number => this.rowOf.get(`${family}-${number}`));
            part.classList.toggle("off", rows.some(row => row && isOff(row)));
        }
        this.drawFront(panel, "-anyfront-", () => true);
        this.drawFront(panel, "-front-", row => row.dataset.answers === "right");
    }

    /** The front of what is shown: on the picture left is exacter and lower is faster. */
    drawFront(panel, name, isAllowed) {
        const places = all("g[id]", panel).map(mark => [mark, this.rowOf.get(mark.id)])
            .filter(([mark, row]) => row && !isOff(row) && "found" in row.dataset && isAllowed(row))
            .map(([mark]) => mark.querySelector("use"))
            .map(use => [Number(use.getAttribute("x")), Number(use.getAttribute("y"))])
            .sort(([x, y], [otherX, otherY]) => otherY - y || x - otherX);
        let way = "";
        let left = Infinity;
        for (const [x, y] of places) {
            if (x < left) {
                way += way === "" ? `M${x},${y}` : `V${y}H${x}`;
                left = x;
            }
        }
        panel.querySelector(`g[id*="${name}"] path`)?.setAttribute("d", way);
    }

    /** The same setting in all scenes. */
    highlight(wanted) {
        const isPoint = wanted?.dataset.point !== undefined;
        this.section.classList.toggle("dim", isPoint);
        for (const row of this.rows) {
            const isSame = isPoint && row.dataset.method === wanted.dataset.method &&
                row.dataset.setting === wanted.dataset.setting;
            row.classList.toggle("same", isSame);
            document.getElementById(row.dataset.point)?.classList.toggle("same", isSame);
        }
    }

    addUp(table) {
        for (const sum of all(".sum", table)) {
            const asked = all("tbody tr:not(.off) .answer", table)
                .filter(({ dataset }) => dataset.method === sum.dataset.method)
                .map(({ dataset }) => dataset.verdict)
                .filter(verdict => verdict !== "not applicable");
            const right = asked.filter(verdict => verdict === "pass").length;
            sum.textContent = asked.length > 0 ? `${right}/${asked.length}` : "–";
        }
    }

    /** Below a row of the matrix: all that its cells say. */
    toggleDetail(row) {
        if (row.nextElementSibling?.classList.contains("detail")) {
            row.nextElementSibling.remove();
            return;
        }
        const detail = document.createElement("tr");
        detail.className = "detail";
        const cell = detail.insertCell();
        cell.colSpan = row.cells.length;
        cell.textContent = all("[data-tip]", row).map(
            answer => answer.dataset.tip.split("\n").join(", ").replaceAll("\t", " ")).join("\n");
        if (cell.textContent) {
            row.after(detail);
        }
    }
}

for (const title of all("svg title")) {
    title.parentElement.dataset.tip = title.textContent;
    title.remove();
}
for (const element of all("[data-tip]")) {
    element.addEventListener("mouseenter", event => showTip(element.dataset.tip, event));
    element.addEventListener("mouseleave", () => tip.classList.add("off"));
}
for (const head of all("thead th")) {
    head.addEventListener("click", () => sortBy(head.closest("table"), head.cellIndex));
}
for (const section of all("section")) {
    new Section(section);
}
