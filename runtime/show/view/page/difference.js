// Two runs at one tick: catoms in the colours of how the second differs from the first.
import {placeOf} from "./block.js";
import {grouped} from "./dom.js";
import {titleOf} from "./legend.js";

// The ends and the middle of coolwarm: less, the same, more.
const STOPS = ["#3b4cc0", "#9abbff", "#dddddd", "#f7a889", "#b40426"];
const SAME = "#dddddd", OTHER = "#d55e00", ALONE = "#7e22ce", UNKNOWN = "#8a8f98";

const rgb = (css) => [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16));

function mixed(part) {
    const colours = STOPS.map(rgb), last = STOPS.length - 1;
    const at = Math.min(Math.max(part, 0), 1) * last, i = Math.min(Math.floor(at), last - 1);
    return colours[i].map((c, axis) => Math.round(c + (at - i) * (colours[i + 1][axis] - c)));
}

// Of two catoms: a number, if both have numbers; otherwise whether they are the same.
function apart(one, i, other, j) {
    const a = one.valueOf(i), b = other.valueOf(j);
    if (typeof a === "number" && typeof b === "number") return b - a;
    // Without values they have the colours that they have given themselves.
    if (a === null && b === null) return [0, 1, 2].every((c) => one.colours[4 * i + c] === other.colours[4 * j + c]) ? 0 : null;
    return a === b ? 0 : null;
}

// The frames in these colours, and the legend of both; or null: of so many catoms each frame has others, so nothing can be said.
export function difference([first, second], [words, others]) {
    if (words.coarse > 1 || others.coarse > 1) return null;
    const frames = [first, second], thinned = first.covers || second.covers;
    const found = frames.map((frame, side) => Array.from({length: frame.count}, (_, i) => {
        const other = frames[1 - side], j = placeOf(other, frame.ids[i]);
        if (j < 0) return undefined;
        return side === 0 ? apart(first, i, second, j) : apart(first, j, second, i);
    }));
    let most = 0, differ = 0, both = 0, alone = 0, worded = false;
    found.forEach((list, side) => list.forEach((value) => {
        if (value === undefined) ++alone;
        else if (side === 0) {
            ++both;
            if (value === null) worded = true;
            else most = Math.max(most, Math.abs(value));
            if (value !== 0) ++differ;
        }
    }));
    const colourOf = (value) => value === undefined ? rgb(thinned ? UNKNOWN : ALONE) : value === null ? rgb(OTHER)
        : mixed(most > 0 ? 0.5 + value / (2 * most) : 0.5);
    const title = titleOf(words.legend) || titleOf(others.legend) || "colour";
    const kinds = [...(worded ? [["not the same", OTHER]] : []), ...(alone ? [[thinned ? "not sent by both" : "only in one run",
        thinned ? UNKNOWN : ALONE]] : [])];
    const legend = {title: `${title}: second less first, ${grouped(differ)} of ${grouped(both)} differ`,
        scale: most > 0 ? {low: -most, high: most, stops: STOPS} : null, kinds: most > 0 ? kinds : [["the same", SAME], ...kinds]};
    return {legend, frames: frames.map((frame, side) => {
        const colours = new Uint8Array(4 * frame.count);
        found[side].forEach((value, i) => colours.set([...colourOf(value), 255], 4 * i));
        return {...frame, colours, difference: found[side]};
    })};
}
