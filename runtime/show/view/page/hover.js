// What is under the pointer: a catom's number, and what it is coloured by.
import {placeOf} from "./block.js";
import {h, number} from "./dom.js";
import {titleOf} from "./legend.js";

// How it differs, where two runs are compared.
function apart({difference}, place) {
    if (!difference) return "";
    const by = difference[place];
    if (by === undefined) return ", not in the other run";
    if (by === null) return ", something else in the other run";
    return by === 0 ? ", the same in both" : `, ${by > 0 ? "+" : ""}${number(by)} in the second run`;
}

// The value of a catom as words; what there is to say of one that has none.
function valueOf(frame, words, place) {
    const title = titleOf(words.legend), value = frame.valueOf(place);
    if (!title || value === undefined) return "";
    const shown = typeof value === "number" ? number(value) : value;
    return (value === null ? `no ${title}` : value === "holds" ? title : `${title} = ${shown}`) + apart(frame, place);
}

export class Hover {
    // `side()` is the one whose picture it is.
    constructor(side) {
        this.side = side;
        this.element = h("div", {class: "tip", role: "tooltip", hidden: true});
        side.element.append(this.element);
        side.element.addEventListener("pointermove", (event) => this.moved(event));
        new ResizeObserver(() => this.later()).observe(side.element);
        for (const name of ["pointerleave", "pointerdown", "wheel"])
            side.element.addEventListener(name, () => this.hide(), {passive: true});
    }

    hide() {
        this.at = null;
        this.element.hidden = true;
    }

    moved({buttons, clientX, clientY, pointerType}) {
        if (buttons || pointerType === "touch") {
            this.hide();
            return;
        }
        const {left, top} = this.side.element.getBoundingClientRect();
        this.at = [clientX - left, clientY - top];
        this.later();
    }

    // Once for each picture at most, however often the pointer says where it is.
    later() {
        if (this.waits) return;
        this.waits = requestAnimationFrame(() => {
            this.waits = 0;
            this.show();
        });
    }

    show() {
        const {side, element, at} = this, {stage, words} = side;
        if (!at || !words) return;
        const {clientWidth: width, clientHeight: height} = side.element, away = at[0] > width || at[1] > height;
        const id = away ? null : stage.at(...at), place = id === null ? -1 : placeOf(stage.frame, id);
        element.hidden = place < 0;
        if (place < 0) return;
        const many = words.coarse > 1 ? "one of several catoms here" : valueOf(stage.frame, words, place);
        element.replaceChildren(h("b", {}, `@${id}`), many ? ` ${many}` : "");
        element.dataset.of = id;
        const {offsetWidth: wide, offsetHeight: high} = element;
        // Beside the pointer, on the side where there is room.
        const x = at[0] + 14 + wide > width ? Math.max(0, at[0] - 10 - wide) : at[0] + 14;
        const y = at[1] + 16 + high > height ? Math.max(0, at[1] - 8 - high) : at[1] + 16;
        element.style.transform = `translate(${x}px, ${y}px)`;
    }
}
