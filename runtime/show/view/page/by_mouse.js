// What the mouse does to a world: cells that are added and taken out stand at the end of its text.
const HEAD = "# Placed and taken out by mouse.";
const BLOCK = new RegExp(`\\n*${HEAD}\\n(?:\\[\\[body\\]\\]\\ncells = (.*)\\n)?\\n?(?:\\[without\\]\\ncells = (.*)\\n)?$`);

const word = (cell) => cell.join(", ");
const cellsIn = (list) => new Map((list ? JSON.parse(list) : []).map((cell) => [word(cell), cell]));

// The rest of the text, and the cells at its end.
function apart(toml) {
    const found = toml.match(BLOCK);
    if (!found) return {rest: toml, placed: new Map(), taken: new Map()};
    return {rest: toml.slice(0, found.index) + "\n", placed: cellsIn(found[1]), taken: cellsIn(found[2])};
}

function joined(rest, placed, taken) {
    const list = (cells) => `[${[...cells.values()].map((cell) => `[${word(cell)}]`).join(", ")}]`, parts = [];
    if (placed.size) parts.push(`[[body]]\ncells = ${list(placed)}\n`);
    if (taken.size) parts.push(`[without]\ncells = ${list(taken)}\n`);
    if (parts.length === 0) return rest;
    // A single body may be written as a table, of which there cannot be two.
    const bodies = placed.size ? rest.replace(/^\[body\]/m, "[[body]]") : rest;
    return `${bodies.replace(/\n*$/, "\n\n")}${HEAD}\n${parts.join("\n")}`;
}

// A world with catoms on these cells too. On flat lattices cells have two numbers.
export function withCells(toml, cells) {
    const {rest, placed, taken} = apart(toml);
    for (const cell of cells) if (!taken.delete(word(cell))) placed.set(word(cell), cell);
    return joined(rest, placed, taken);
}

export function withoutCells(toml, cells) {
    const {rest, placed, taken} = apart(toml);
    for (const cell of cells) {
        placed.delete(word(cell));
        taken.set(word(cell), cell);
    }
    return joined(rest, placed, taken);
}
