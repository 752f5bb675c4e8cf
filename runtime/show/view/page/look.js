// The left panel: what is shown and how. Bodies are Meld; what is wrong with one stands at its field.
import {firstLook} from "./address.js";
import {Completer} from "./complete.js";
import {h, mistakeOf} from "./dom.js";

// Of each field its title, and which of the program's predicates are an example of it.
const BODIES = [["colour", "Colour by", "value"], ["only", "Show only", "catoms"], ["hide", "Hide", "catoms"], ["links", "Links", "pair"],
    ["arrows", "Arrows", "pair"], ["labels", "Labels", "value"]];
const FORMS = [["", "as the lattice"], ["sphere", "sphere"], ["cube", "cube"], ["rounded", "rounded cube"], ["disc", "disc"], ["hexagon",
    "hexagon"]];
const MAPS = ["viridis", "cividis", "magma", "coolwarm", "grey"];

export class LookPanel {
    // `changed` is called when another frame is to be asked for, `arranged` when the same frame is to be shown in another way.
    // `vocabulary`: of the program; `two`: another run stands beside this one.
    constructor(element, info, given, {vocabulary, two, changed, arranged}) {
        this.vocabulary = vocabulary;
        this.element = element;
        this.changed = changed;
        this.arranged = arranged;
        this.fields = {};
        this.cut = {axis: -1, part: 1, above: false};
        this.size = 1;
        const parts = [h("h2", {}, "What is shown")];
        if (given) parts.push(...this.fixed(given));
        else parts.push(...BODIES.map((body) => this.field(...body)), ...this.mapping(info.maps), this.exposed());
        if (two) parts.push(this.comparing());
        for (const [name, value] of Object.entries(given ? {} : firstLook())) this.set(name, value);
        element.replaceChildren(...parts, h("h2", {}, "View"), ...this.cutting(info.flat), this.sizing(), this.moving());
    }

    // Of a shared run: it was decided when it was shared.
    fixed(look) {
        const rows = BODIES.filter(([name]) => look[name]).flatMap(([name, title]) => [h("dt", {}, title), h("dd", {}, h("code", {},
            look[name]))]);
        return [rows.length ? h("dl", {}, rows) : h("p", {class: "quiet"}, "All catoms, in their own colours.")];
    }

    field(name, title, kind) {
        const input = h("input", {type: "text", id: `look-${name}`, "aria-label": title, onchange: () => this.changed(name)});
        const mistake = h("div", {id: `look-${name}-mistake`});
        this.fields[name] = {input, mistake, kind};
        this.vocabulary.each(() => {
            input.placeholder = this.vocabulary.example(kind);
        });
        return h("div", {class: "field"}, h("label", {for: input.id}, title), new Completer(input, this.vocabulary).element, mistake);
    }

    comparing() {
        this.onDifference = h("input", {type: "checkbox", id: "look-difference", onchange: () => this.changed()});
        return h("label", {class: "check", title: "Colour catoms by how the second run differs from the first"}, this.onDifference,
            "Difference of the runs");
    }

    // A body, or one of the maps or forms that there are.
    set(name, value) {
        const input = this.fields[name] ? this.fields[name].input : this[name];
        input.value = value;
        // What no menu has is left as it was.
        if (input.selectedIndex === -1) input.selectedIndex = 0;
    }

    // Whether catoms have the colours of how two runs differ.
    get difference() { return Boolean(this.onDifference && this.onDifference.checked); }

    mapping(maps) {
        this.map = h("select", {id: "look-map", "aria-label": "Colour map", onchange: () => this.changed()},
            (maps && maps.length ? maps : MAPS).map((map) => h("option", {}, map)));
        this.low = h("input", {type: "text", id: "look-low", placeholder: "least", "aria-label": "Least value",
            onchange: () => this.changed()});
        this.high = h("input", {type: "text", id: "look-high", placeholder: "most", "aria-label": "Greatest value",
            onchange: () => this.changed()});
        this.form = h("select", {id: "look-form", "aria-label": "Form", onchange: () => this.changed()},
            FORMS.map(([value, text]) => h("option", {value}, text)));
        return [h("div", {class: "row"}, this.map, this.low, this.high), h("label", {class: "row"}, "Form", this.form)];
    }

    exposed() {
        this.onlyExposed = h("input", {type: "checkbox", id: "look-exposed", onchange: () => this.changed()});
        return h("label", {class: "check"}, this.onlyExposed, "Exposed catoms only");
    }

    cutting(flat) {
        const slider = h("input", {type: "range", id: "cut", min: "0", max: "1000", value: "1000", "aria-label": "Cut plane",
            oninput: () => {
            this.cut.part = slider.value / 1000;
            this.cutMoved();
        }});
        const axis = h("select", {id: "cut-axis", "aria-label": "Axis of the cut", onchange: () => {
            this.cut.axis = Number(axis.value);
            this.cutMoved();
        }}, h("option", {value: "-1"}, "No cut"), ["x", "y", "z"].slice(0, flat ? 2 : 3).map((name, i) => h("option", {value: i}, name)));
        const side = h("button", {type: "button", title: "The other side", onclick: () => {
            this.cut.above = !this.cut.above;
            this.cutMoved();
        }}, "⇄");
        return [h("div", {class: "row"}, axis, slider, side)];
    }

    sizing() {
        const slider = h("input", {type: "range", id: "size", min: "0.1", max: "1", step: "0.05", value: "1", oninput: () => {
            this.size = Number(slider.value);
            if (this.away) this.changed();
            else this.arranged();
        }});
        return h("label", {class: "row"}, "Size", slider);
    }

    moving() {
        this.onMoves = h("input", {type: "checkbox", id: "moves", onchange: () => this.changed()});
        return h("label", {class: "check", title: "Arrows from where catoms were in the tick that was shown before"}, this.onMoves,
            "Arrows of moves");
    }

    get moves() { return this.onMoves.checked; }

    // `thinned`: hidden catoms were left out of the frame, so that a cut has to ask for others; `away`: the server draws it. `bounds` are
    // of all when nothing is cut.
    seen({thinned, away, bounds}) {
        this.away = away;
        this.asksForCut = thinned || away;
        if (this.cut.axis < 0 || !this.bounds) this.bounds = bounds;
    }

    cutMoved() {
        if (this.asksForCut) this.changed();
        else this.arranged();
    }

    // As the server wants it.
    look() {
        const out = {};
        for (const [name, {input}] of Object.entries(this.fields)) out[name] = input.value.trim();
        if (!this.map) return out;
        out.map = this.map.value;
        const low = parseFloat(this.low.value), high = parseFloat(this.high.value);
        out.range = low < high ? [low, high] : null;
        out.exposed = this.onlyExposed.checked;
        out.form = this.form.value;
        if (this.asksForCut) out.cut = this.cutIn(this.bounds);
        if (this.away && this.size < 1) out.size = this.size;
        return out;
    }

    // Errors stand at the field that their message names, or at that which was changed last. Returns those that have no place here.
    mistaken(errors, name) {
        const fieldOf = ({message}) => BODIES.map(([body]) => body).find((body) => message.startsWith(`${body}: `)) || name;
        for (const [body, {input, mistake, kind}] of Object.entries(this.fields)) {
            const mine = errors.find((error) => fieldOf(error) === body);
            input.classList.toggle("wrong", Boolean(mine));
            mistake.replaceChildren(...(mine ? [mistakeOf({...mine, message: mine.message.replace(`${body}: `, ""),
                hint: this.hintOf(mine, kind)})] : []));
        }
        return errors.filter((error) => !this.fields[fieldOf(error)]);
    }

    // Examples are of this program, and have no options.
    hintOf({hint}, kind) {
        if (!/^Write it as in --/.test(hint || "")) return hint;
        const example = this.vocabulary.example(kind);
        return example && `Write it as in ${example}`;
    }

    // Where the cut is in these bounds; null: nowhere.
    cutIn(bounds) {
        const {axis, part, above} = this.cut;
        if (axis < 0 || !bounds) return null;
        return {axis, above, at: bounds.low[axis] - 0.01 + part * (bounds.high[axis] - bounds.low[axis] + 0.02)};
    }
}
