// Which catoms of a lattice nobody can see, and how much of each one's sky its neighbours take.

import {LATTICES} from "./lattice.js";

const MOST_CELLS = 1 << 27;

// `kept` are the places of the catoms that count. Returns those that may be seen, and of each what the shader wants: the sum of the ways to
// its neighbours and their number, so scaled that a catom in the middle of others has 1 in the last.
export function coverOf(lattice, frame, kept, culls) {
    const none = () => ({drawn: kept, cover: new Float32Array(4 * kept.length)});
    const kind = LATTICES[lattice];
    if (!kind || kept.length === 0) return none();
    const {unit, ways} = kind, at = frame.positions;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const grid = new Int32Array(3 * kept.length);
    for (let i = 0; i < kept.length; ++i)
        for (let axis = 0; axis < 3; ++axis) {
            const x = Math.round(at[3 * kept[i] + axis] / unit[axis]);
            grid[3 * i + axis] = x;
            if (x < low[axis]) low[axis] = x;
            if (x > high[axis]) high[axis] = x;
        }
    // A border of two is free.
    const size = low.map((x, axis) => high[axis] - x + 5);
    if (size[0] * size[1] * size[2] > MOST_CELLS) return none();
    const row = size[0], layer = size[0] * size[1];
    const cells = new Uint8Array(layer * size[2]), index = new Int32Array(kept.length);
    for (let i = 0; i < kept.length; ++i) {
        index[i] = grid[3 * i] - low[0] + 2 + row * (grid[3 * i + 1] - low[1] + 2) + layer * (grid[3 * i + 2] - low[2] + 2);
        cells[index[i]] = 1;
    }
    const steps = ways.map(([x, y, z]) => Math.round(x / unit[0]) + row * Math.round(y / unit[1]) + layer * Math.round(z / unit[2]));
    const flat = lattice === "square" || lattice === "hex", count = ways.length, scale = flat ? 0 : 4 / count;
    for (let i = 0; i < kept.length; ++i) {
        let neighbours = 0;
        for (let w = 0; w < count; ++w) if (cells[index[i] + steps[w]]) ++neighbours;
        if (neighbours === count) cells[index[i]] = 2;
    }
    // Between balls one sees as far as the neighbours of those outside.
    const balls = frame.form === 0 || frame.form === 4;
    const drawn = new Uint32Array(kept.length), cover = new Float32Array(4 * kept.length);
    let out = 0;
    for (let i = 0; i < kept.length; ++i) {
        let neighbours = 0, inside = cells[index[i]] === 2, x = 0, y = 0, z = 0;
        for (let w = 0; w < count; ++w) {
            const cell = cells[index[i] + steps[w]];
            if (cell === 0) continue;
            if (balls && cell === 1) inside = false;
            ++neighbours;
            x += ways[w][0];
            y += ways[w][1];
            z += ways[w][2];
        }
        if (inside && culls && !flat) continue;
        cover.set([0.5 * scale * x, 0.5 * scale * y, 0.5 * scale * z, 0.25 * scale * neighbours], 4 * out);
        drawn[out++] = kept[i];
    }
    return {drawn: drawn.subarray(0, out), cover: cover.subarray(0, 4 * out)};
}
