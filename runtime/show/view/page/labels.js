// Words at catoms, over the picture: of those that are nearest, as many as have room.
import {met} from "./drawn/catoms.js";
import {h} from "./dom.js";

const MOST = 300;

export class Labels {
    constructor(element) {
        this.element = element;
        this.shown = true;
    }

    // `carefully`: only where nothing is in front of the catom.
    place(stage, bare, carefully = false) {
        const {frame, view} = stage;
        if (bare || !this.shown || frame.labels.length === 0) {
            this.element.replaceChildren();
            return;
        }
        const p = frame.positions, seen = [], used = new Set(), drawn = new Set(stage.drawn);
        for (const {place, text} of frame.labels) {
            if (!drawn.has(place)) continue;
            const at = view.project(p[3 * place], p[3 * place + 1], p[3 * place + 2]);
            if (at.depth > 0 && at.x > 0 && at.y > 0 && at.x < view.width && at.y < view.pixels) seen.push({...at, place, text});
        }
        seen.sort((a, b) => a.depth - b.depth);
        const spans = [];
        for (const label of seen) {
            if (spans.length >= MOST) break;
            // One for each piece of the picture.
            const wide = Math.max(24, 8 * label.text.length), key = `${Math.round(label.x / wide)} ${Math.round(label.y / 15)}`;
            if (used.has(key)) continue;
            if (carefully && met(frame, stage.drawn, stage.size, view.ray(label.x, label.y)).place !== label.place) continue;
            used.add(key);
            const span = h("span", {}, label.text);
            span.style.transform = `translate(-50%, -50%) translate(${label.x.toFixed(1)}px, ${label.y.toFixed(1)}px)`;
            spans.push(span);
        }
        this.element.replaceChildren(...spans);
    }
}
