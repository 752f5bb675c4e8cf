// Arrows from where catoms were to where they are.
import {placeOf} from "./block.js";

const COLOUR = [226, 90, 28, 255];

// Strokes as those of a frame, with what they are to be drawn beside.
export function withMoves(arrows, before, frame) {
    const ends = [], p = frame.positions;
    for (let i = 0; i < frame.count; ++i) {
        const was = placeOf(before, frame.ids[i]);
        if (was < 0) continue;
        const from = before.positions.subarray(3 * was, 3 * was + 3), to = p.subarray(3 * i, 3 * i + 3);
        if (Math.hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]) > 1e-3) ends.push(...from, ...to);
    }
    const count = ends.length / 6, out = {count: arrows.count + count, ends: new Float32Array(arrows.ends.length + ends.length),
        colours: new Uint8Array(arrows.colours.length + 4 * count)};
    out.ends.set(arrows.ends);
    out.ends.set(ends, arrows.ends.length);
    out.colours.set(arrows.colours);
    for (let i = 0; i < count; ++i) out.colours.set(COLOUR, arrows.colours.length + 4 * i);
    return out;
}
