// Frames of a run as the stage shows them, and how they are read: runtime/show/view/scene/block.h describes the bytes.

const MAGIC = 0x46444c4d;
// The form of bodies that are no spheres: each has one of its own.
export const BODY = 5;

export function emptyFrame() {
    return {tick: 0, count: 0, form: 0, positions: new Float32Array(0), diameters: new Float32Array(0), ids: new Float64Array(0),
        colours: new Uint8Array(0), lines: noStrokes(), arrows: noStrokes(), labels: [], triangles: new Float32Array(0), covers: null,
        bodies: null, compounds: [], lamps: [], valueOf: () => undefined};
}

export const noStrokes = () => ({count: 0, ends: new Float32Array(0), colours: new Uint8Array(0)});

export function joinIds(low, high) {
    return Float64Array.from(low, (word, i) => word + (high ? high[i] * 4294967296 : 0));
}

// The value that the catom at a place is coloured by: a number, a word, or null. Each array may be null.
const valuesIn = (numbers, words, names) => (place) => {
    if (words && words[place] > 0) return names[words[place] - 1];
    return numbers && !Number.isNaN(numbers[place]) ? numbers[place] : null;
};

// Reads arrays one after the other.
export class Reader {
    constructor(buffer, at = 0) {
        this.buffer = buffer;
        this.at = at;
    }
    take(type, count) {
        const out = new type(this.buffer, this.at, count);
        this.at += out.byteLength;
        return out;
    }
    words(count) { return this.take(Uint32Array, count); }
    floats(count) { return this.take(Float32Array, count); }
    bytes(count) { return this.take(Uint8Array, count); }
    // They begin at any word.
    doubles(count) {
        const out = new Float64Array(this.buffer.slice(this.at, this.at + 8 * count));
        this.at += 8 * count;
        return out;
    }
    // Padded to whole words.
    text(size) {
        const out = new TextDecoder().decode(new Uint8Array(this.buffer, this.at, size));
        this.at += Math.ceil(size / 4) * 4;
        return out;
    }
    strokes(count) {
        const ends = new Float32Array(6 * count), colours = new Uint8Array(4 * count);
        for (let i = 0; i < count; ++i) {
            ends.set(this.floats(6), 6 * i);
            colours.set(this.bytes(4), 4 * i);
        }
        return {count, ends, colours};
    }
    labels(count) {
        const out = [];
        for (let i = 0; i < count; ++i) {
            const [place, size] = this.words(2);
            out.push({place, text: this.text(size)});
        }
        return out;
    }
}

// Of what goes with it, `names` are the words that catoms may be coloured by, `compounds` the lists of their solids, and `lamps` those that
// stand somewhere: x, y, z and the radius.
export function parseBlock(buffer, {names = [], compounds = [], lamps = []} = {}) {
    const read = new Reader(buffer);
    const [magic, version, tickLow, tickHigh, count, flags, lines, arrows, labels, form, triangles] = read.words(16);
    if (magic !== MAGIC || version !== 2) throw {message: "The server speaks of frames in another way than this page",
        hint: "Load the page again"};
    const frame = {tick: tickLow + tickHigh * 4294967296, count, form, compounds, lamps};
    frame.positions = read.floats(3 * count);
    frame.diameters = read.floats(count);
    const low = read.words(count);
    frame.ids = joinIds(low, flags & 1 ? read.words(count) : null);
    frame.colours = read.bytes(4 * count);
    // Of catoms that hide others, which are left out: how much of their sky their neighbours take.
    frame.covers = flags & 2 ? new Int8Array(read.bytes(4 * count)) : null;
    const numbers = flags & 4 ? read.doubles(count) : null, words = flags & 8 ? read.words(count) : null;
    frame.valueOf = valuesIn(numbers, words, names);
    frame.lines = read.strokes(lines);
    frame.arrows = read.strokes(arrows);
    frame.labels = read.labels(labels);
    frame.triangles = read.floats(9 * triangles);
    // Bodies that are no spheres: half the edges of their cores, their rounding, and how they are turned; see solids.js for compounds.
    frame.bodies = flags & 16 ? read.floats(8 * count) : null;
    if (frame.bodies) frame.form = BODY;
    return frame;
}

// The least and the greatest x, y, z of the middles of catoms; null without any.
export function boundsOf(frame) {
    if (frame.count === 0) return null;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], at = frame.positions;
    for (let i = 0; i < frame.count; ++i)
        for (let axis = 0; axis < 3; ++axis) {
            const x = at[3 * i + axis];
            if (x < low[axis]) low[axis] = x;
            if (x > high[axis]) high[axis] = x;
        }
    return {low, high};
}

// Where a catom is in a frame, whose ids are in order; -1: it is not shown.
export function placeOf(frame, id) {
    let from = 0, to = frame.count;
    while (from < to) {
        const middle = (from + to) >> 1;
        if (frame.ids[middle] < id) from = middle + 1;
        else to = middle;
    }
    return from < frame.count && frame.ids[from] === id ? from : -1;
}
