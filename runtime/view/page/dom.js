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

export const grouped = (number) => Math.round(number).toLocaleString("en-US");

export function number(value) {
    if (!Number.isFinite(value)) return String(value);
    return Number.isInteger(value) ? grouped(value) : String(Number(value.toPrecision(5)));
}
