// A run as it is shown: where it comes from, its picture, and what is written over that. Two are shown side by side, from the same place.
import {h, mistakeOf} from "./dom.js";
import {showLegend} from "./legend.js";
import {withMoves} from "./moves.js";
import {Stage} from "./stage.js";

export class Side {
    // `look()` is what is shown; `first` is the side that this one stands beside, or null.
    constructor(element, source, info, look, first) {
        Object.assign(this, {element, source, info, words: null, frame: null, before: null});
        this.stage = new Stage(element, source.image && ((camera, size) => source.image(look(), camera, size)), first && first.stage.view);
        if (!first) return;
        this.stage.partner = first.stage;
        first.stage.partner = this.stage;
    }

    static beside(first, source, info, look) {
        const element = h("section", {class: "stage", id: "stage-beside", tabindex: "0",
            "aria-label": "Picture of the catoms of the other run"},
            h("canvas"), h("img", {alt: ""}), h("div", {class: "labels"}), h("div", {class: "box"}), h("div", {class: "legend"}),
            h("div", {class: "message", role: "alert"}));
        first.element.after(element);
        const out = new Side(element, source, info, look, first);
        for (const side of [first, out]) side.element.append(h("div", {class: "name"}, side.title));
        return out;
    }

    get title() { return (this.info.program || "").replace(/^.*\//, ""); }
    get box() { return this.element.querySelector(".box"); }

    // `moves`: with arrows from where catoms were in the tick that was shown before.
    show(words, frame, moves) {
        if (this.words && this.words.tick !== words.tick) this.before = this.frame;
        this.words = words;
        this.frame = frame;
        this.stage.show(moves && this.before ? {...frame, arrows: withMoves(frame.arrows, this.before, frame)} : frame, this.info);
        showLegend(this.element.querySelector(".legend"), words.legend);
    }

    complain(error) {
        const element = this.element.querySelector(".message");
        element.classList.toggle("shown", Boolean(error));
        element.replaceChildren(...(error ? [mistakeOf(error)] : []));
    }
}
