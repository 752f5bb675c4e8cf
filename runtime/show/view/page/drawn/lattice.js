// Lattices: the neighbours of a catom, cells and where they are; the numbers of docs/reference/worlds.md.
const THIRD = Math.sqrt(3) / 2, LAYER = Math.SQRT1_2;
// The neighbours, in diameters, and what coordinates are multiples of.
export const LATTICES = {
    square: {unit: [1, 1, 1], ways: [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]},
    hex: {unit: [0.5, THIRD, 1], ways: [[1, 0, 0], [0.5, THIRD, 0], [-0.5, THIRD, 0], [-1, 0, 0], [-0.5, -THIRD, 0], [0.5, -THIRD, 0]]},
    cubic: {unit: [1, 1, 1], ways: [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]},
    fcc: {unit: [0.5, 0.5, LAYER], ways: [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0],
        [0.5, 0.5, LAYER], [0.5, -0.5, LAYER], [-0.5, 0.5, LAYER], [-0.5, -0.5, LAYER],
        [0.5, 0.5, -LAYER], [0.5, -0.5, -LAYER], [-0.5, 0.5, -LAYER], [-0.5, -0.5, -LAYER]]},
};
const odd = (z) => z & 1;

const positions = {
    square: ([x, y]) => [x, y, 0],
    hex: ([x, y]) => [x + y / 2, y * THIRD, 0],
    cubic: ([x, y, z]) => [x, y, z],
    fcc: ([x, y, z]) => [x + odd(z) / 2, y + odd(z) / 2, z * LAYER],
};

export const isFlat = (lattice) => lattice === "square" || lattice === "hex";
export const positionOf = (lattice, cell) => positions[lattice](cell);

// The cell whose middle is nearest to a position.
export function cellAt(lattice, [x, y, z]) {
    if (lattice === "hex") {
        const row = Math.round(y / THIRD);
        return [Math.round(x - row / 2), row, 0];
    }
    if (lattice !== "fcc") return [Math.round(x), Math.round(y), lattice === "square" ? 0 : Math.round(z)];
    const layer = Math.round(z / LAYER);
    return [Math.round(x - odd(layer) / 2), Math.round(y - odd(layer) / 2), layer];
}

// The position beside one at which the neighbour in this direction stands.
export function besideOf(lattice, position, towards) {
    const flat = isFlat(lattice), [x, y, z] = flat ? [towards[0], towards[1], 0] : towards;
    const along = (way) => way[0] * x + way[1] * y + way[2] * z;
    const best = LATTICES[lattice].ways.reduce((one, other) => along(other) > along(one) ? other : one);
    return position.map((at, i) => at + best[i]);
}

// In how many pieces catoms are that do not touch each other.
export function piecesOf(lattice, frame) {
    const {unit, ways} = LATTICES[lattice], at = frame.positions, key = (x, y, z) => `${x} ${y} ${z}`, places = new Map();
    const grid = (i) => unit.map((size, axis) => Math.round(at[3 * i + axis] / size));
    for (let i = 0; i < frame.count; ++i) places.set(key(...grid(i)), i);
    const steps = ways.map((way) => way.map((x, axis) => Math.round(x / unit[axis]))), seen = new Uint8Array(frame.count);
    let pieces = 0;
    for (let i = 0; i < frame.count; ++i) {
        if (seen[i]) continue;
        ++pieces;
        seen[i] = 1;
        const left = [i];
        while (left.length) {
            const [x, y, z] = grid(left.pop());
            for (const [dx, dy, dz] of steps) {
                const next = places.get(key(x + dx, y + dy, z + dz));
                if (next === undefined || seen[next]) continue;
                seen[next] = 1;
                left.push(next);
            }
        }
    }
    return pieces;
}
