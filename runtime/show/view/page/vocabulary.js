// The predicates of the program as bodies in Meld: for fields that complete them, and for the examples that stand in empty fields.

// "node, (int, int), min float X" -> its arguments.
function argumentsIn(text) {
    const out = [""];
    let depth = 0;
    for (const letter of text) {
        depth += "([{<".includes(letter) ? 1 : ")]}>".includes(letter) ? -1 : 0;
        if (letter === "," && depth === 0) out.push("");
        else out[out.length - 1] += letter;
    }
    return out.map((words) => words.trim());
}

// Variables have the names of the declaration, and others letters, each once.
function bodyOf({name, declaration, arguments: after, own, linear}) {
    const open = declaration.indexOf("("), said = open < 0 ? [] : argumentsIn(declaration.slice(open + 1, declaration.lastIndexOf(")")));
    // The catom comes first.
    const count = 1 + Number(after), types = said.length === count ? said : Array(count).fill("");
    const named = types.map((words) => (words.match(/\s([A-Z]\w*)$/) || [])[1]);
    const letters = [..."ABCDEFGHIJKLMNOPQRSTUVWXYZ"].filter((letter) => !named.includes(letter));
    const words = named.map((given, i) => given || letters.shift() || `X${i}`);
    const isCatom = types.map((type, i) => /\b(node|catom)$/.test(type.replace(/\s[A-Z]\w*$/, "")) || (i === 0 && !type));
    return {name, declaration, own, linear, body: `${name}(${words.join(", ")})`, words, isCatom};
}

export class Vocabulary {
    constructor(predicates) {
        this.listeners = [];
        this.learn(predicates);
    }

    // The program has other predicates now.
    learn(predicates) {
        const all = (predicates || []).map(bodyOf);
        // Those of the program's own text first.
        this.bodies = [...all.filter(({own}) => own), ...all.filter(({own}) => !own)];
        for (const listener of this.listeners) listener();
    }

    // `listener` is called now, and when there are others.
    each(listener) {
        this.listeners.push(listener);
        listener();
    }

    // What could stand in a field of this kind: "value", a catom and what it has; "catoms", those for which something holds; "pair", a
    // catom and another; "fact", anything about the catom `at`. Empty: the program has none.
    example(kind, at = null) {
        const fits = {value: ({words, isCatom}) => words.length > 1 && !isCatom[words.length - 1],
            catoms: ({words}) => words.length === 1, pair: ({isCatom}) => isCatom[0] && isCatom[1], fact: () => true}[kind];
        const found = this.bodies.find(fits) || (kind === "catoms" || kind === "value" ? this.bodies[0] : null);
        if (!found) return "";
        return at === null ? found.body : `${found.name}(${[`@${at}`, ...found.words.slice(1)].join(", ")})`;
    }

    // Those that begin with these letters, then those that have them somewhere.
    matching(letters) {
        const begins = this.bodies.filter(({name}) => name.startsWith(letters));
        return [...begins, ...this.bodies.filter(({name}) => !name.startsWith(letters) && name.includes(letters))];
    }
}
