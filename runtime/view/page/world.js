// The world of the run, to be changed: its TOML, what it would be, and its catoms in the picture. The run goes on with the old one.
import {bytes, grouped, h, mistakeOf, number} from "./dom.js";

const PAUSE = 350;  // Milliseconds without a key before what was typed is checked.

export class WorldTab {
    // `shows(frame, said)` shows catoms that no run has.
    constructor(element, source, shows) {
        Object.assign(this, {element, source, shows, isOpen: false, number: 0, text: null});
        this.area = h("textarea", {id: "world-toml", spellcheck: "false", autocomplete: "off", wrap: "off", "aria-label": "World in TOML",
            oninput: () => this.edited(), onscroll: () => this.scrolled(), onkeydown: (event) => this.key(event)});
        this.lines = h("div", {class: "lines", "aria-hidden": "true"});
        this.said = h("div", {id: "world-said", role: "status"});
        this.save = h("button", {id: "world-save", title: "Write the file (Ctrl+S)", onclick: () => this.write()}, "Save");
        this.file = h("code");
        this.done = h("span", {class: "quiet", id: "world-saved"});
        element.append(h("h2", {}, "World ", this.file), h("div", {class: "editor"}, this.lines, this.area),
            h("div", {class: "row"}, this.save, this.done), this.said);
    }

    async show(open) {
        this.isOpen = open;
        this.element.hidden = !open;
        if (!open) return;
        if (this.text !== null && this.text !== this.area.value) return this.check();
        await this.tell(() => this.source.world(), (said) => {
            this.area.value = this.text = said.toml;
            this.file.textContent = said.path;
            this.writable = said.writable;
            this.count();
        });
        this.area.focus();
    }

    edited() {
        this.count();
        this.done.textContent = "";
        clearTimeout(this.later);
        this.later = setTimeout(() => this.check(), PAUSE);
    }

    check() { return this.tell(() => this.source.checkWorld(this.area.value)); }

    async write() {
        if (this.save.disabled) return;
        const text = this.area.value;
        await this.tell(() => this.source.saveWorld(text), (said) => {
            this.text = text;
            this.done.textContent = `${said.path} is written; the next run begins with it`;
        });
    }

    // Of several answers the last one asked for counts.
    async tell(ask, first = () => {}) {
        const turn = ++this.number;
        try {
            const said = await ask();
            if (turn !== this.number) return;
            first(said);
            this.report(said);
        } catch (error) {
            if (turn === this.number) this.report({valid: false, error});
        }
    }

    report(said) {
        const {valid, error} = said;
        const changed = this.text !== this.area.value;
        this.save.disabled = !valid || !this.writable || !changed;
        if (!this.writable) this.done.textContent = "To write it, start with --world FILE";
        this.mark(valid ? 0 : error.line || 0);
        if (!valid) {
            const where = error.line ? h("button", {class: "catom", title: "Go there",
                onclick: () => this.go(error.line, error.column || 1)},
            `Line ${error.line}${error.column ? `, column ${error.column}` : ""}`) : null;
            this.said.replaceChildren(...[where, mistakeOf(error)].filter(Boolean));
            return;
        }
        const {catoms, exact, first, last, target, components, memory, seconds} = said;
        const cell = (at) => `(${at.join(", ")})`, row = (name, value) => [h("dt", {}, name), h("dd", {}, value)];
        this.said.replaceChildren(h("dl", {}, ...row("lattice", said.lattice),
            ...row("catoms", `${exact ? "" : "about "}${grouped(catoms)}`),
            ...(said.lattice === "free" ? [] : row("cells", `${cell(first)} to ${cell(last)}`)), ...(target ? row("target", target) : []),
            ...(components && components.length ? row("components", components.join(", ")) : []),
            ...row("memory", `${bytes(memory.least)} to ${bytes(memory.most)}`),
            ...(seconds === null || seconds === undefined ? [] : row("a full tick", `about ${number(Number(seconds.toPrecision(2)))} s`))),
        ...(memory.message ? [h("div", {class: memory.fits ? "quiet" : "mistake"}, memory.message)] : []),
        ...(said.frame ? [] : [h("p", {class: "quiet"}, "Too many catoms, or none on a lattice, to be shown here.")]));
        if (said.frame) this.shows(said.frame, said);
    }

    count() {
        const lines = this.area.value.split("\n").length;
        while (this.lines.children.length < lines) this.lines.append(h("span", {}, String(this.lines.children.length + 1)));
        while (this.lines.children.length > lines) this.lines.lastChild.remove();
        this.scrolled();
    }

    mark(line) { [...this.lines.children].forEach((child, i) => child.classList.toggle("bad", i + 1 === line)); }
    scrolled() { this.lines.scrollTop = this.area.scrollTop; }

    go(line, column) {
        const at = this.area.value.split("\n").slice(0, line - 1).reduce((sum, text) => sum + text.length + 1, 0) + column - 1;
        this.area.focus();
        this.area.setSelectionRange(at, at);
    }

    key(event) {
        if (!(event.ctrlKey || event.metaKey) || event.key !== "s") return;
        event.preventDefault();
        this.write();
    }
}
