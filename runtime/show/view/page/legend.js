// What colours mean, in a corner of the picture.
import {h, number} from "./dom.js";

// What catoms are coloured by; a body that only holds is the name of its one kind. Empty: they have their own colours.
export const titleOf = (legend) => legend ? legend.title || (legend.kinds && legend.kinds.length ? legend.kinds[0][0] : "") : "";

export function showLegend(element, legend) {
    if (!legend) {
        element.replaceChildren();
        return;
    }
    const {title, kinds} = legend, scale = legend.scale || (legend.stops ? legend : null);
    const parts = title ? [h("b", {}, title)] : [];
    if (scale) {
        const bar = h("div", {class: "bar"});
        bar.style.background = `linear-gradient(to right, ${scale.stops.join(", ")})`;
        parts.push(bar, h("div", {class: "ends"}, h("span", {}, number(scale.low)), h("span", {}, number(scale.high))));
    }
    if (kinds) {
        const most = 24;
        for (const [name, colour] of kinds.slice(0, most)) parts.push(h("div", {class: "kind"}, swatch(colour), name));
        if (kinds.length > most) parts.push(h("div", {class: "quiet"}, `and ${kinds.length - most} more`));
    }
    element.replaceChildren(...parts);
}

function swatch(colour) {
    const out = h("i");
    out.style.background = colour;
    return out;
}
