// A run that is in this page: frames of some ticks, each as what has changed; runtime/show/view/share/changes.h describes the bytes.
import {BODY, Reader, boundsOf, emptyFrame, joinIds, placeOf} from "./block.js";

// Of large frames, so many states are kept beside the first; and in all, states of so many catoms.
const STATES_BESIDE = 4, MOST_CATOMS_KEPT = 4000000;

export const isShared = () => document.getElementById("share") !== null;

async function inflated(letters) {
    const packed = Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).arrayBuffer();
}

const rgb = (css) => [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16));

const floats = new Float32Array(1), bits = new Uint32Array(floats.buffer);

// Of a number as a float has it, or a NaN with the place of one that no float is among those with colours of their own.
function numberPainter(head, grey, ofFloat) {
    const exact = (head.exact.match(/.{6}/g) || []).map((hex) => rgb("#" + hex));
    return (value) => {
        bits[0] = value;
        if (!Number.isNaN(floats[0])) return ofFloat(floats[0]);
        const place = value & 0x3fffff;
        return place === 0 ? grey : exact[place - 1];
    };
}

// What a record says of a catom's value: a number, a word, null if it has none, or undefined if nobody knows.
function valueIn(head) {
    if (head.colours === "words") return (word) => word === 0 || word > head.words.length ? null : head.words[word - 1];
    if (head.colours === null) return () => undefined;
    return (value) => {
        bits[0] = value;
        if (!Number.isNaN(floats[0])) return floats[0];
        return (value & 0x3fffff) === 0 ? null : undefined;
    };
}

// What a record says of a catom's colour, as red, green and blue.
function painter(head) {
    const grey = [176, 176, 176];
    if (head.colours === "words") {
        const kinds = new Map(head.legend.kinds.map(([name, colour]) => [name, rgb(colour)]));
        const only = head.legend.kinds.length === 1 && rgb(head.legend.kinds[0][1]);
        return (word) => word === 0 || word > head.words.length ? grey : kinds.get(head.words[word - 1]) || only || grey;
    }
    if (head.legend && head.legend.kinds) {
        const kinds = new Map(head.legend.kinds.map(([name, colour]) => [Number(name), rgb(colour)]));
        return numberPainter(head, grey, (number) => kinds.get(number) || grey);
    }
    const {low: least, high: most, stops} = head.legend ? head.legend.scale : {low: 0, high: 1, stops: ["#b0b0b0", "#b0b0b0"]};
    const colours = stops.map(rgb), low = Number(least), high = Number(most);
    return numberPainter(head, grey, (number) => {
        const part = high > low ? Math.min(1, Math.max(0, (number - low) / (high - low))) : 0.5;
        const before = Math.min(Math.floor(part * (colours.length - 1)), colours.length - 2), rest = part * (colours.length - 1) - before;
        return colours[before].map((c, i) => Math.round(c + rest * (colours[before + 1][i] - c)));
    });
}

// Of catoms that are no spheres, as in a frame block: 8 numbers each.
function bodiesOf(cores, turns) {
    const out = new Float32Array(2 * cores.length);
    for (let i = 0; i < cores.length; i += 4) {
        out.set(cores.subarray(i, i + 4), 2 * i);
        out.set(turns.subarray(i, i + 4), 2 * i + 4);
    }
    return out;
}

// Reads one record and makes of the state before it the next one.
function changed(state, read) {
    const [kind, tickLow, tickHigh, catoms, removedCount, setCount, strokes, lines, arrows, labels, factBytes, triangles] = read.words(12);
    const before = (kind & 1) === 0 ? {...emptyFrame(), values: new Uint32Array(0), facts: new Map()} : state;
    const ids = (count) => joinIds(read.words(count), read.words(count));
    const removed = new Set(ids(removedCount)), set = ids(setCount);
    const places = read.floats(3 * setCount), diameters = read.floats(setCount), values = read.words(setCount);
    const bodies = kind & 2 ? bodiesOf(read.floats(4 * setCount), read.floats(4 * setCount)) : null;
    const next = merged(before, removed, set, {positions: places, diameters, values, bodies});
    next.tick = tickLow + tickHigh * 4294967296;
    next.catoms = catoms;
    next.lines = strokes ? read.strokes(lines) : before.lines;
    next.arrows = strokes ? read.strokes(arrows) : before.arrows;
    next.labels = strokes ? read.labels(labels) : before.labels;
    next.triangles = strokes ? read.floats(9 * triangles) : before.triangles;
    next.covers = null;
    next.facts = before.facts;
    if (factBytes > 0) {
        next.facts = new Map(before.facts);
        for (const [id, list] of Object.entries(JSON.parse(read.text(factBytes)))) next.facts.set(Number(id), list);
    }
    return next;
}

// What is the same in both states is one array; others are copied at once. `stale`: whose colours may be others, if there are colours.
function replaced(before, at, values) {
    const {count, ids, positions, diameters} = before;
    const next = {count, ids, positions, diameters, values: before.values.slice(), bodies: before.bodies && before.bodies.slice()};
    const moved = at.some((place, i) => before.diameters[place] !== values.diameters[i] ||
        [0, 1, 2].some((axis) => before.positions[3 * place + axis] !== values.positions[3 * i + axis]));
    if (moved) [next.positions, next.diameters] = [before.positions.slice(), before.diameters.slice()];
    at.forEach((place, i) => {
        next.values[place] = values.values[i];
        if (next.bodies) next.bodies.set(values.bodies.subarray(8 * i, 8 * i + 8), 8 * place);
        if (!moved) return;
        next.positions.set(values.positions.subarray(3 * i, 3 * i + 3), 3 * place);
        next.diameters[place] = values.diameters[i];
    });
    if (before.colours) [next.colours, next.stale] = [before.colours.slice(), before.stale ? [...before.stale, ...at] : at];
    return next;
}

// Catoms of a state without those that are removed, and with those that are set; both in the order of their ids.
function merged(before, removed, set, values) {
    const known = removed.size === 0 && before.count > 0 && set.map((id) => placeOf(before, id));
    if (known && known.every((place) => place >= 0)) return replaced(before, known, values);
    const fresh = set.reduce((count, id) => count + (placeOf(before, id) < 0 ? 1 : 0), 0);
    const count = before.count - removed.size + fresh;
    const next = {count, ids: new Float64Array(count), positions: new Float32Array(3 * count), diameters: new Float32Array(count),
        values: new Uint32Array(count), bodies: before.bodies || values.bodies ? new Float32Array(8 * count) : null};
    let at = 0, old = 0;
    const put = (id, from, i) => {
        next.ids[at] = id;
        for (let axis = 0; axis < 3; ++axis) next.positions[3 * at + axis] = from.positions[3 * i + axis];
        next.diameters[at] = from.diameters[i];
        if (next.bodies) next.bodies.set(from.bodies.subarray(8 * i, 8 * i + 8), 8 * at);
        next.values[at++] = from.values[i];
    };
    const putOld = (limit) => {
        for (; old < before.count && before.ids[old] < limit; ++old)
            if (!removed.has(before.ids[old])) put(before.ids[old], before, old);
    };
    for (let i = 0; i < set.length; ++i) {
        putOld(set[i]);
        if (old < before.count && before.ids[old] === set[i]) ++old;
        put(set[i], values, i);
    }
    putOld(Infinity);
    return next;
}

export class ShareSource {
    constructor() {
        this.head = JSON.parse(document.getElementById("share").textContent);
        this.colour = painter(this.head);
        this.value = valueIn(this.head);
        this.pieces = new Map();  // Those that were looked at last, with their states.
        this.shown = null;
        this.index = 0;  // Of its frame.
        this.live = false;
        this.asks = false;  // No questions in Meld.
        this.ends = [];
        this.head.pieces.reduce((sum, frames) => (this.ends.push(sum + frames), sum + frames), 0);
    }

    // All that the first picture needs.
    async begin(look) {
        return {hello: this.hello(), frame: this.frame(look)};
    }

    async hello() {
        const {title, lattice, flat, form, ticks, catoms, look, facts} = this.head;
        return {program: title, lattice, flat, form, catoms, first: ticks[0], tick: ticks[0], last: ticks[ticks.length - 1], ticks,
            predicates: [], maps: [], look, facts, recorded: true, live: false};
    }

    async states(piece) {
        if (!this.pieces.has(piece)) {
            if (this.pieces.size >= 3) this.pieces.delete(this.pieces.keys().next().value);
            const buffer = await inflated(document.getElementById(`piece${piece}`).textContent);
            // Where each frame begins, as far as they have been read, and the states of some.
            this.pieces.set(piece, {buffer, begins: [0], states: new Map()});
        }
        return this.pieces.get(piece);
    }

    // The state of a frame: from the nearest one before it that is kept. The first is kept, and of the others so many that were made last
    // as memory allows.
    async state(piece, within) {
        const {buffer, begins, states} = await this.states(piece);
        let from = within;
        while (from >= 0 && !states.has(from)) --from;
        let state = states.get(from);
        for (let i = from + 1; i <= within; ++i) {
            const read = new Reader(buffer, begins[i]);
            state = changed(state, read);
            begins[i + 1] = read.at;
            if (i !== 0 && i !== within && within - i >= STATES_BESIDE) continue;
            const most = Math.max(STATES_BESIDE, Math.floor(MOST_CATOMS_KEPT / Math.max(1, state.count)));
            while (states.size > most) states.delete([...states.keys()].find((each) => each !== 0));
            states.set(i, state);
        }
        return state;
    }

    // The frame of this tick, or of the last one before it; without a tick, the frame that is shown.
    async frame(_look, tick) {
        const {ticks, ticks: {length}} = this.head;
        let index = tick === undefined ? this.index : length - 1;
        while (index > 0 && ticks[index] > tick) --index;
        this.index = index;
        const piece = this.ends.findIndex((end) => index < end);
        const within = index - (piece > 0 ? this.ends[piece - 1] : 0);
        const state = await this.state(piece, within);
        this.shown = state;
        const colours = this.painted(state);
        const {compounds = [], lamps = []} = this.head;
        const frame = {...state, compounds, lamps, form: state.bodies ? BODY : this.head.form, colours,
            valueOf: (place) => this.value(state.values[place])};
        const bounds = boundsOf(frame);
        return {words: {tick: state.tick, catoms: state.catoms, shown: state.count, legend: this.head.legend,
            bounds: bounds && [...bounds.low, ...bounds.high]}, frame};
    }

    painted(state) {
        if (state.colours && !state.stale) return state.colours;
        const out = state.colours || (state.colours = new Uint8Array(4 * state.count)), stale = state.stale;
        state.stale = null;
        if (this.head.colours === null && !this.head.look.colour) {
            out.set(new Uint8Array(state.values.buffer));
            return out;
        }
        for (let at = 0; at < (stale ? stale.length : state.count); ++at) {
            const i = stale ? stale[at] : at;
            out.set(this.head.colours === null ? [176, 176, 176] : this.colour(state.values[i]), 4 * i);
            out[4 * i + 3] = 255;
        }
        return out;
    }

    factsOf(id) { return this.shown ? this.shown.facts.get(id) || [] : []; }

    // Catoms that have a fact with this text in it.
    found(text) {
        const out = [];
        for (const [id, list] of this.shown.facts) if (list.some((fact) => fact.includes(text))) out.push(id);
        return out;
    }
}
