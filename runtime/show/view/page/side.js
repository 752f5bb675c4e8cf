// A run as it is shown: where it comes from, its picture, and what is written over that. Two are shown side by side, from the same place.
import {h, mistakeOf} from "./dom.js";
import {Hover} from "./hover.js";
import {showLegend} from "./legend.js";
import {withMoves} from "./moves.js";
import {Stage} from "./stage.js";

export class Side {
    // `first` is the side that this one stands beside, or null.
    constructor(stage, source, info, first) {
        Object.assign(this, {stage, element: stage.element, source, info, words: null, frame: null, before: null});
        this.ahead = null;  // A frame that was asked for before there was anything to show it with.
        this.hover = new Hover(this);
        if (!first) return;
        this.stage.partner = first.stage;
        first.stage.partner = this.stage;
    }

    // `look()` is what is shown.
    static beside(first, source, info, look) {
        const element = h("section", {class: "stage", id: "stage-beside", tabindex: "0",
            "aria-label": "Picture of the catoms of the other run"},
            h("canvas"), h("img", {alt: ""}), h("div", {class: "labels"}), h("div", {class: "box"}), h("div", {class: "legend"}),
            h("div", {class: "message", role: "alert"}));
        first.element.after(element);
        const stage = new Stage(element, source.image && ((camera, size) => source.image(look(), camera, size)), first.stage.view);
        const out = new Side(stage, source, info, first);
        for (const side of [first, out]) side.element.append(h("div", {class: "name"}, side.title));
        return out;
    }

    get title() { return (this.info.program || "").replace(/^.*\//, ""); }
    get box() { return this.element.querySelector(".box"); }

    // The frame of a tick, which draw() shows.
    take(words, frame) {
        if (this.words && this.words.tick !== words.tick) this.before = this.frame;
        this.words = words;
        this.frame = frame;
    }

    // `frame` is the one that was taken, perhaps in other colours; `moves`: with arrows from where catoms were in the tick that was shown
    // before.
    draw(frame, legend, moves) {
        this.stage.show(moves && this.before ? {...frame, arrows: withMoves(frame.arrows, this.before, frame)} : frame, this.info);
        showLegend(this.element.querySelector(".legend"), legend);
        this.hover.later();
    }

    complain(error) {
        const element = this.element.querySelector(".message");
        element.classList.toggle("shown", Boolean(error));
        element.replaceChildren(...(error ? [mistakeOf(error)] : []));
    }
}
