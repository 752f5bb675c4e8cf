// The right panel: everything about the selected catom at this tick, and why it is so.
import {Completer} from "./complete.js";
import {h, grouped, mistakeOf, withCatoms} from "./dom.js";
import {whyTree} from "./why.js";

export class Panel {
    // `choose` selects a catom; `did` is called when something has been changed by hand.
    constructor(element, source, info, vocabulary, {choose, did}) {
        this.vocabulary = vocabulary;
        this.element = element;
        this.source = source;
        this.info = info;
        this.selected = new Set();
        this.choose = choose;
        this.did = did;
        this.facts = h("div");
        this.more = h("div");
        this.number = 0;
        this.empty(0);
    }

    empty(selected) {
        this.element.replaceChildren(h("h2", {}, selected ? `${grouped(selected)} catoms selected` : "Nothing selected"),
            h("p", {class: "quiet"}, "Click a catom, drag a box with Ctrl, or search."));
    }

    // About this catom, or about none; `selected` are all.
    async show(id, selected) {
        const number = ++this.number;
        if (id === null) return this.empty(selected.size);
        const head = h("h2", {id: "catom"}, `Catom @${id}`, selected.size > 1 ? ` and ${grouped(selected.size - 1)} more` : "");
        if (!this.source.asks) {
            this.facts.replaceChildren(...this.listed(this.source.factsOf(id)));
            this.element.replaceChildren(head, this.facts);
            return;
        }
        if (this.id !== id) this.more.replaceChildren();
        this.id = id;
        const about = await this.ask(`facts @${id}`);
        if (number !== this.number) return;
        if (about.error) this.facts.replaceChildren(about.error);
        else {
            const {facts, catom} = about.answer;
            this.facts.replaceChildren(...this.whereIs(catom), ...this.listed(facts), ...this.coming(catom));
        }
        const messages = h("details", {ontoggle: async () => {
            if (!messages.open || messages.children.length > 1) return;
            const told = await this.ask(`messages @${id}`);
            messages.append(told.error || h("pre", {class: "fact"}, withCatoms(told.text, this.choose)));
        }}, h("summary", {}, "Messages of this tick"));
        // What is being written stays.
        if (!this.byHand) this.byHand = this.hands();
        this.field.placeholder = this.vocabulary.example("fact", id);
        this.selected = selected;
        if (this.byHand.parentNode !== this.element)
            this.element.replaceChildren(h("h2"), this.facts, h("details"), this.byHand, this.more);
        this.element.children[0].replaceWith(head);
        if (this.element.children[2].dataset.of !== `${id} ${about.tick}`) this.element.children[2].replaceWith(messages);
        messages.dataset.of = `${id} ${about.tick}`;
    }

    whereIs(catom) {
        if (!catom) return [];
        const rows = [];
        if (catom.cell) rows.push(h("dt", {}, "cell"), h("dd", {}, `(${catom.cell.join(", ")})`));
        else if (catom.position) rows.push(h("dt", {}, "position"), h("dd", {}, `(${catom.position.map((x) => x.toFixed(3)).join(", ")})`));
        if (catom.links && catom.links.length) rows.push(h("dt", {}, "neighbours"), h("dd", {},
            catom.links.flatMap(({catom: other}) => [...withCatoms(`@${other}`, this.choose), " "])));
        return [h("dl", {}, rows)];
    }

    listed(facts) {
        if (facts.length === 0) return [h("p", {class: "quiet"}, "No facts.")];
        return [h("ul", {class: "facts", id: "facts"}, facts.map((fact) => {
            const plain = fact.replace(/\.$/, "");
            const buttons = !this.source.asks ? [] : [["why", "Why does it hold?"], ["history", "When did it come?"], ["take",
                "Take it away by hand"]]
                .map(([verb, title]) => h("button", {class: `small ${verb}`, title, onclick: () => this.do(verb, plain)}, verb));
            return h("li", {}, h("span", {class: "fact"}, withCatoms(plain, this.choose)), buttons);
        }))];
    }

    coming(catom) {
        if (!catom || !catom.coming || catom.coming.length === 0) return [];
        return [h("h2", {}, "Under way to it"), h("ul", {class: "facts"}, catom.coming.map(({fact, tick}) =>
            h("li", {}, h("span", {class: "fact"}, withCatoms(fact, this.choose)), h("span", {class: "is"}, `tick ${tick}`))))];
    }

    hands() {
        const fact = this.field = h("input", {type: "text", id: "fact", spellcheck: "false", autocomplete: "off", "aria-label": "A fact"});
        const button = (verb, title) => h("button", {id: verb, title, onclick: () => fact.value.trim() && this.do(verb,
            fact.value.trim())}, verb);
        const fails = (verb, title) => h("button", {id: verb, title: `${title}: what is selected, or all catoms of the body in the field`,
            disabled: verb !== "kill" && !this.info.links, onclick: () => this.strike(verb, fact.value.trim())}, verb);
        const strikes = (verb, title) => h("button", {id: `${verb}-links`, title,
            disabled: !this.info.links || (verb === "jam" && !this.info.jams),
            onclick: () => this.strikeLinks(verb, fact.value.trim())}, verb);
        this.jam = h("input", {type: "number", id: "jam-ticks", min: "1", value: "10", title: "For so many ticks", "aria-label": "Ticks",
            disabled: !this.info.jams});
        const tap = h("button", {id: "tap", title: "Tap what is selected", onclick: () => this.tap()}, "tap");
        const save = h("button", {id: "save-events", title: "Write a file with all that was done by hand", onclick: () => {
            const name = fact.value.trim() || "events.toml";
            this.do("save-events", /\.toml$/.test(name) ? name : "events.toml");
        }}, "save events");
        return h("div", {}, h("h2", {}, "By hand"), h("div", {class: "row"},
            new Completer(fact, this.vocabulary, () => this.id).element),
            h("div", {class: "row"}, button("give", "Give it this fact"), button("take", "Take this fact"), button("why",
                "Why does it hold?"),
                button("why-not", "Why does it not hold?"), tap),
            h("div", {class: "row"}, fails("kill", "End"), fails("hang", "Do nothing any more"), fails("restart", "Begin anew")),
            h("div", {class: "row"}, strikes("cut", "Cut the links of the selected catom, the link of two, or those around more"),
                strikes("heal", "Bring such links back"), strikes("jam", "Nothing arrives over such links"), this.jam),
            this.lacks(), h("div", {class: "row"}, save));
    }

    // What has to be known from the start.
    lacks() {
        const {links, jams} = this.info;
        if (links && jams) return null;
        return h("p", {class: "quiet"}, links ? "Jams need a world with [network] longest_jam = 50."
            : "For hang, restart and links, start the viewer with --by-links.");
    }

    get named() { return [...this.selected].map((id) => `@${id}`).join(" "); }

    // What is selected, in words.
    get chosen() { return this.selected.size === 1 ? this.named : `${grouped(this.selected.size)} catoms`; }

    strike(verb, body) { return this.act(`${verb} ${body || this.chosen}`, `${verb} ${body || this.named}`); }

    strikeLinks(verb, body) {
        const head = verb === "jam" ? `jam ${this.jam.value}` : verb, around = body || this.selected.size > 2 ? "around " : "";
        const chosen = this.selected.size < 3 ? this.named : this.chosen;
        return this.act(`${head} ${around}${body || chosen}`, `${head} ${around}${body || this.named}`);
    }

    async tap() {
        for (const id of this.selected) if (!await this.act("tap", `give tap(@${id})`)) return;
    }

    // Whether it could be done; it happens in the next tick.
    async act(title, line) {
        const told = await this.ask(line);
        this.more.replaceChildren(h("h2", {}, withCatoms(title, this.choose)));
        if (told.error) this.more.append(told.error);
        else {
            this.more.append(h("p", {class: "quiet"}, told.text.trim(), h("br"), `It happens in tick ${grouped(told.tick + 1)}.`));
            await this.did();
        }
        this.more.scrollIntoView({block: "nearest"});
        return !told.error;
    }

    // Whether it could be done.
    async do(verb, what) {
        const told = await this.ask(`${verb} ${what}`);
        this.more.replaceChildren(h("h2", {}, `${verb} `, h("code", {}, withCatoms(what, this.choose))));
        if (told.error) this.more.append(told.error);
        else if (verb === "why" || verb === "why-not") this.more.append(whyTree(told.answer, this.choose));
        else if (verb === "history") this.more.append(h("pre", {class: "fact"}, withCatoms(told.text, this.choose)));
        else {
            this.more.append(h("p", {class: "quiet"}, told.text));
            await this.did();
        }
        this.more.scrollIntoView({block: "nearest"});
        return !told.error;
    }

    // The answer, or the element that says what is wrong.
    async ask(line) {
        try {
            return await this.source.command(line);
        } catch (error) {
            return {error: mistakeOf(error)};
        }
    }
}
