// Completion in a field: while the name of a predicate is written, those of the program that go on so; and a menu of all of them.
import {h} from "./dom.js";

const MOST = 60;

let lists = 0;

export class Completer {
    // `vocabulary` has bodies; `before` names the catom that a fact is about, or is null.
    constructor(input, vocabulary, before = () => null) {
        Object.assign(this, {input, vocabulary, before, found: [], active: -1});
        this.list = h("ul", {class: "completions", role: "listbox", id: `completions${lists++}`, hidden: true, "aria-label": "Predicates"});
        this.button = h("button", {type: "button", class: "menu", tabindex: "-1", title: "The predicates of the program",
            "aria-label": `Predicates for ${input.getAttribute("aria-label") || "this field"}`,
            onmousedown: (event) => event.preventDefault(), onclick: () => this.menu()}, "▾");
        for (const [name, value] of [["role", "combobox"], ["aria-autocomplete", "list"], ["aria-expanded", "false"],
            ["aria-controls", this.list.id], ["autocomplete", "off"], ["spellcheck", "false"]]) input.setAttribute(name, value);
        input.addEventListener("input", () => this.typed());
        input.addEventListener("keydown", (event) => this.key(event), true);
        input.addEventListener("blur", () => this.close());
        this.element = h("span", {class: "complete"}, input, this.button);
        document.body.append(this.list);
        addEventListener("resize", () => this.close());
        addEventListener("scroll", (event) => this.list.contains(event.target) || this.close(), true);
        vocabulary.each(() => {
            this.button.hidden = vocabulary.bodies.length === 0;
        });
    }

    get isOpen() { return !this.list.hidden; }

    // The letters of a name that end at the cursor; variables begin with capitals.
    get word() {
        const {value, selectionStart: at} = this.input, [word] = value.slice(0, at).match(/[a-z_][\w-]*$/i) || [""];
        const goes = /^[\w(-]/.test(value.slice(at)) || /^[A-Z_]/.test(word) || /@$/.test(value.slice(0, at - word.length));
        return goes ? "" : word;
    }

    typed() {
        const {word} = this;
        const found = word ? this.vocabulary.matching(word) : [];
        if (found.length) this.open(found, word);
        else this.close();
    }

    menu() {
        if (this.isOpen) {
            this.close();
            return;
        }
        this.input.focus();
        this.open(this.vocabulary.bodies, "");
    }

    open(found, word) {
        this.found = found.slice(0, MOST);
        this.written = word;
        this.active = -1;
        this.list.replaceChildren(...this.found.map(({body, declaration, own}, i) => h("li", {role: "option", id: `${this.list.id}-${i}`,
            class: own ? "" : "other", title: declaration, onmousedown: (event) => {
            event.preventDefault();
            this.take(i);
        }}, body)));
        this.list.hidden = false;
        this.input.setAttribute("aria-expanded", "true");
        const {left, top, bottom, width} = this.input.getBoundingClientRect(), {style} = this.list;
        const below = innerHeight - bottom, up = below < 160 && top > below;
        Object.assign(style, {left: `${left}px`, minWidth: `${width}px`, maxWidth: `${innerWidth - left - 8}px`,
            maxHeight: `${Math.min(320, (up ? top : below) - 8)}px`, top: up ? "" : `${bottom + 2}px`,
            bottom: up ? `${innerHeight - top + 2}px` : ""});
        this.list.scrollTop = 0;
    }

    close() {
        this.list.hidden = true;
        this.input.setAttribute("aria-expanded", "false");
        this.input.removeAttribute("aria-activedescendant");
    }

    key(event) {
        if (event.key === "ArrowDown" && !this.isOpen && this.vocabulary.bodies.length) {
            this.open(this.word ? this.vocabulary.matching(this.word) : this.vocabulary.bodies, this.word);
            event.preventDefault();
            return;
        }
        if (!this.isOpen) return;
        const {key} = event, count = this.found.length;
        if (key === "ArrowDown") this.mark((this.active + 1) % count);
        else if (key === "ArrowUp") this.mark(this.active <= 0 ? count - 1 : this.active - 1);
        else if (key === "Escape") this.close();
        else if (key === "Tab" && (this.active >= 0 || this.written)) this.take(Math.max(0, this.active));
        else if (key === "Enter" && this.active >= 0) this.take(this.active);
        else {
            if (key === "Enter") this.close();
            return;
        }
        event.preventDefault();
        event.stopImmediatePropagation();
    }

    mark(i) {
        this.active = i;
        [...this.list.children].forEach((item, place) => item.setAttribute("aria-selected", String(place === i)));
        this.list.children[i].scrollIntoView({block: "nearest"});
        this.input.setAttribute("aria-activedescendant", this.list.children[i].id);
    }

    // In the place of the letters that were written, or at the cursor.
    take(i) {
        const {input, written} = this, at = input.selectionStart ?? input.value.length, from = at - written.length;
        const about = this.before(), {name, words, body} = this.found[i];
        const text = about === null ? body : `${name}(${[`@${about}`, ...words.slice(1)].join(", ")})`;
        const before = input.value.slice(0, from), after = input.value.slice(at);
        // From the menu, a body in a field that has one is one condition more.
        const joint = !written && /[\w)\]"]\s*$/.test(before) ? ", " : "";
        input.value = before + joint + text + after;
        const end = from + joint.length + text.length;
        input.setSelectionRange(end, end);
        this.close();
        input.focus();
        input.dispatchEvent(new Event("completed", {bubbles: true}));
        // Nothing else is to be written.
        if (input.value === text) input.dispatchEvent(new Event("change", {bubbles: true}));
    }
}
