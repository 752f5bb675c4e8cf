// Elements, made in one expression. Text never becomes markup.

// h("button", {class: "plain", onclick: f}, "words", element, ...)
export function h(tag, attributes = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
        if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
        else if (value === true) element.setAttribute(name, "");
        else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
    }
    element.append(...children.flat().filter((child) => child !== null && child !== undefined));
    return element;
}

export const byId = (id) => document.getElementById(id);

// Text in which each catom (@42) can be clicked.
export function withCatoms(text, choose) {
    return text.split(/(@\d+)/).map((part) => part.startsWith("@") && part.length > 1
        ? h("button", {class: "catom", type: "button", title: `Select ${part}`, onclick: (event) => {
            event.stopPropagation();
            event.preventDefault();
            choose(Number(part.slice(1)));
        }}, part)
        : part);
}

// Calls f once in a while however often the result is called, and after the last call.
export function seldom(f, milliseconds) {
    let timer = 0;
    return () => {
        if (timer) return;
        timer = setTimeout(() => {
            timer = 0;
            f();
        }, milliseconds);
    };
}

// What is wrong in a few words: of a compiler's report its first line and its help, of others all.
export function briefly({message, hint}) {
    const report = String(message).match(/^error(?:\[\w+\])?: (.*)/);
    const words = report ? [report[1], ...[...message.matchAll(/help: (.*)/g)].map((help) => help[1])] : [String(message)];
    return [...words, hint || ""].filter(Boolean);
}

// The same as an element, with the whole report as its title.
export function mistakeOf(error) {
    const [first, ...more] = briefly(error);
    return h("div", {class: "mistake", title: error.message}, first, more.map((words) => h("small", {}, words)));
}

// 1536 -> "1.5 KiB".
export function bytes(count) {
    const units = ["B", "KiB", "MiB", "GiB", "TiB"];
    const power = Math.min(units.length - 1, Math.max(0, Math.floor(Math.log2(Math.max(1, count)) / 10)));
    const value = count / 1024 ** power;
    return `${value < 10 && power ? value.toFixed(1) : Math.round(value)} ${units[power]}`;
}

export const grouped = (number) => Math.round(number).toLocaleString("en-US");

export function number(value) {
    if (!Number.isFinite(value)) return String(value);
    return Number.isInteger(value) ? grouped(value) : String(Number(value.toPrecision(5)));
}
