// The world of the run, to be changed: its TOML, what it would be, and its catoms in the picture. The run goes on with the old one.
import {placeOf} from "./block.js";
import {withCells, withoutCells} from "./by_mouse.js";
import {bytes, grouped, h, mistakeOf, number} from "./dom.js";
import {besideOf, cellAt, isFlat, piecesOf} from "./drawn/lattice.js";

const PAUSE = 350;  // Milliseconds without a key before what was typed is checked.

export class WorldTab {
    // `shows(frame, said, fits)` shows catoms that no run has.
    constructor(element, source, shows) {
        Object.assign(this, {element, source, shows, isOpen: false, number: 0, text: null});
        this.area = h("textarea", {id: "world-toml", spellcheck: "false", autocomplete: "off", wrap: "off", "aria-label": "World in TOML",
            oninput: () => this.edited(), onscroll: () => this.scrolled(), onkeydown: (event) => this.key(event)});
        this.lines = h("div", {class: "lines", "aria-hidden": "true"});
        this.said = h("div", {id: "world-said", role: "status"});
        this.save = h("button", {id: "world-save", title: "Write the file (Ctrl+S)", onclick: () => this.write()}, "Save");
        this.file = h("code");
        this.done = h("span", {class: "quiet", id: "world-saved"});
        this.chosen = [];  // Places of what is selected.
        this.before = [];  // Texts before what the mouse did.
        element.append(h("h2", {}, "World ", this.file), this.tools(), h("div", {class: "editor"}, this.lines, this.area),
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
        this.says("");
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

    // What the mouse does to the world, and takes back.
    tools() {
        const all = [["select", "Select", "Click or draw a box with Ctrl to select catoms"], ["place", "Place",
            "Click on a side of a catom to place another one there"], ["remove", "Remove",
            "Click on a catom, or draw a box with Ctrl, to remove catoms"], ["copy", "Copy",
            "Click on a side of a catom to place a copy of what is selected there"]];
        this.buttons = new Map(all.map(([name, text, title]) => [name, h("button", {id: `tool-${name}`, title,
            onclick: () => this.take(name)}, text)]));
        this.undoes = h("button", {id: "tool-undo", title: "Take back what the mouse did last", disabled: true, onclick: () => this.undo()},
            "Undo");
        this.take("select");
        return h("div", {class: "row"}, ...this.buttons.values(), this.undoes);
    }

    take(name) {
        this.tool = name;
        for (const [other, button] of this.buttons) button.classList.toggle("on", other === name);
    }

    picked(stage, id, more, [x, y]) {
        this.stage = stage;
        if (this.tool === "select") return this.select(id === null ? [] : [id], more);
        if (this.tool === "remove") return id === null ? null : this.edit(withoutCells, [this.cellOf(id)]);
        const where = this.emptyAt(stage.sideAt(x, y));
        if (!where) return null;
        if (this.tool === "place") return this.edit(withCells, [this.written(cellAt(this.lattice, where))]);
        if (this.chosen.length === 0) return this.says("Select what is to be copied first");
        // The first that was selected comes there.
        const by = where.map((at, i) => at - this.chosen[0][i]);
        return this.edit(withCells, this.chosen.map((place) => this.written(cellAt(this.lattice, place.map((at, i) => at + by[i])))));
    }

    boxed(stage, ids, more) {
        this.stage = stage;
        if (this.tool === "remove") this.edit(withoutCells, ids.map((id) => this.cellOf(id)));
        else this.select(ids, more);
    }

    // Where a catom may be placed: beside the one that is seen there, or in a plane anywhere.
    emptyAt({place, towards, ray: {from, along}}) {
        if (place >= 0) return besideOf(this.lattice, this.placeOf(place), towards);
        if (!isFlat(this.lattice) || Math.abs(along.z) < 1e-6) return null;
        const far = -from.z / along.z;
        return [from.x + far * along.x, from.y + far * along.y, 0];
    }

    placeOf(place) { return [...this.stage.frame.positions.subarray(3 * place, 3 * place + 3)]; }
    cellOf(id) { return this.written(cellAt(this.lattice, this.placeOf(placeOf(this.stage.frame, id)))); }
    // As a world writes it.
    written(cell) { return isFlat(this.lattice) ? cell.slice(0, 2) : cell; }

    select(ids, more) {
        const places = ids.map((id) => this.placeOf(placeOf(this.stage.frame, id)));
        this.chosen = more ? [...this.chosen, ...places] : places;
        this.mark();
        this.says(this.chosen.length ? `${grouped(this.chosen.length)} selected` : "");
    }

    // Numbers of catoms change with the world; their places stay.
    mark() {
        const {frame} = this.stage, word = (place) => cellAt(this.lattice, place).join(" "), all = new Set(this.chosen.map(word)), ids = [];
        for (let i = 0; all.size && i < frame.count; ++i) if (all.has(word(this.placeOf(i)))) ids.push(frame.ids[i]);
        this.stage.select(new Set(ids));
    }

    edit(how, cells) {
        if (how === withCells) cells = this.free(cells);
        if (cells.length === 0) return null;
        this.before.push(this.area.value);
        return this.replace(how(this.area.value, cells));
    }

    // Those that have no catom yet.
    free(cells) {
        const {frame} = this.stage, used = new Set();
        for (let i = 0; i < frame.count; ++i) used.add(this.written(cellAt(this.lattice, this.placeOf(i))).join(" "));
        return cells.filter((cell) => !used.has(cell.join(" ")));
    }

    undo() { return this.replace(this.before.pop()); }

    async replace(toml) {
        this.undoes.disabled = this.before.length === 0;
        this.area.value = toml;
        this.count();
        this.says("");
        this.stays = true;
        await this.check();
    }

    says(words) { this.done.textContent = words; }

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
            ...(said.frame && said.lattice !== "free" ? row("pieces", grouped(piecesOf(said.lattice, said.frame))) : []),
            ...(said.lattice === "free" ? [] : row("cells", `${cell(first)} to ${cell(last)}`)), ...(target ? row("target", target) : []),
            ...(components && components.length ? row("components", components.join(", ")) : []),
            ...row("memory", `${bytes(memory.least)} to ${bytes(memory.most)}`),
            ...(seconds === null || seconds === undefined ? [] : row("a full tick", `about ${number(Number(seconds.toPrecision(2)))} s`))),
        ...(memory.message ? [h("div", {class: memory.fits ? "quiet" : "mistake"}, memory.message)] : []),
        ...(said.frame ? [] : [h("p", {class: "quiet"}, "Too many catoms, or nodes of a graph, are not shown here.")]));
        this.lattice = said.lattice;
        for (const [name, button] of this.buttons) button.disabled = !said.frame || said.lattice === "free";
        if (!said.frame) return;
        this.shows(said.frame, said, !this.stays);
        this.stays = false;
        if (this.stage) this.mark();
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
