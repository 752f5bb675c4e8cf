// Numbers over time: what was counted in each tick, and bodies in Meld, several at once, each with its own scale.
import {Completer} from "./complete.js";
import {h, mistakeOf, number} from "./dom.js";

// Colours of lines: --plot0 and so on.
const COLOURS = 6;

// One that is far above all others would leave nothing of them to see.
function isSteep(values, most) {
    const known = values.filter((value) => value !== null).sort((a, b) => a - b);
    return known.length > 0 && known[0] >= 0 && most > 20 * Math.max(1, known[known.length >> 1]);
}

export class Plot {
    // `go(tick)`; `wanted()`: numbers of bodies are to be asked for.
    constructor(vocabulary, {go, wanted}) {
        Object.assign(this, {wanted, lines: [], counted: {ticks: [], series: {}}, first: 0, last: 1, marks: []});
        this.canvas = h("canvas", {id: "plot", title: "Click to go to a tick", onclick: ({offsetX}) => {
            const wide = this.canvas.clientWidth, part = (offsetX - 8) / Math.max(1, wide - 16);
            go(Math.round(this.first + Math.min(1, Math.max(0, part)) * (this.last - this.first)));
        }});
        this.choice = h("select", {id: "series", "aria-label": "Plot what is counted", onchange: () => {
            this.add(this.choice.value, false);
            this.choice.value = "";
        }});
        this.field = h("input", {type: "text", id: "plot-body", "aria-label": "Plot a body in Meld over time",
            onkeydown: (event) => event.key === "Enter" && this.addBody()});
        this.field.addEventListener("change", () => this.field.matches(":focus") && this.addBody());
        vocabulary.each(() => {
            this.field.placeholder = vocabulary.example("value") || "a body";
        });
        this.mistake = h("div", {id: "plot-mistake"});
        this.chips = h("span", {id: "lines"});
        this.asking = h("span", {class: "asking"}, "plot", new Completer(this.field, vocabulary).element, this.choice);
        this.row = [this.chips, this.asking];
        new ResizeObserver(() => this.draw()).observe(this.canvas);
    }

    get bodies() { return this.lines.filter(({isBody}) => isBody).map(({name}) => name); }

    addBody() {
        const body = this.field.value.trim();
        if (!body) return;
        this.field.value = "";
        this.says(null);
        this.add(body, true);
    }

    add(name, isBody) {
        if (!name || this.lines.some((line) => line.name === name && line.isBody === isBody)) return;
        const used = this.lines.map(({colour}) => colour), free = Array.from({length: COLOURS}, (_, i) => i).find((i) => !used.includes(i));
        this.lines.push({name, isBody, colour: free ?? this.lines.length % COLOURS, ticks: [], values: []});
        this.gather();
        if (isBody) this.wanted();
    }

    remove(line) {
        this.lines = this.lines.filter((other) => other !== line);
        this.gather();
    }

    // {ticks, series: {name: [numbers]}}
    learn(metrics) {
        const names = Object.keys(metrics.series), fresh = names.join() !== Object.keys(this.counted.series).join();
        this.counted = metrics;
        if (fresh) {
            this.choice.replaceChildren(h("option", {value: ""}, "count…"), ...names.map((name) => h("option", {}, name)));
            if (!this.lines.length && names.includes("evaluated")) this.add("evaluated", false);
        }
        this.choice.hidden = names.length === 0;
        this.gather();
    }

    // What a body said after each tick, as far as it is known.
    learnBody(body, {ticks, values, done}) {
        const line = this.lines.find(({name, isBody}) => isBody && name === body);
        if (line) Object.assign(line, {ticks, values, done});
        this.gather();
    }

    // A body with a mistake is no line; it stands in the field again.
    wrong(body, error) {
        this.remove(this.lines.find(({name, isBody}) => isBody && name === body));
        if (!this.field.value) this.field.value = body;
        this.says(error);
    }

    says(error) {
        this.field.classList.toggle("wrong", Boolean(error));
        this.mistake.replaceChildren(...(error ? [mistakeOf(error)] : []));
    }

    at(first, last, now, marks) {
        Object.assign(this, {first, last, now, marks});
        this.gather();
    }

    gather() {
        for (const line of this.lines) {
            if (!line.isBody) Object.assign(line, {ticks: this.counted.ticks, values: this.counted.series[line.name] || [], done: true});
            const known = line.values.filter((value) => value !== null);
            line.most = Math.max(...known.slice(-100000), 0);
            line.least = Math.min(...known.slice(-100000), 0);
            line.steep = isSteep(line.values, line.most);
        }
        this.chips.replaceChildren(...this.lines.map((line) => this.chip(line)));
        this.draw();
    }

    chip(line) {
        const {name, isBody, colour, ticks, values, most, least, steep, done} = line, swatch = h("i");
        swatch.style.background = `var(--plot${colour})`;
        // Of the last tick before this one that is known.
        const at = ticks.findLastIndex((tick) => tick <= this.now), now = at < 0 ? null : values[at];
        const range = `from ${number(least)} to ${number(most)}${steep ? ", logarithmic" : ""}`;
        return h("span", {class: "chip", title: `${isBody ? "How often it holds, or its value, " : ""}${range}`}, swatch,
            isBody ? h("code", {}, name) : name, h("b", {class: "now"}, now === null || now === undefined ? "–" : number(now)),
            done === false ? h("span", {class: "is"}, `${Math.round(100 * ticks.length / Math.max(1, this.last - this.first + 1))} %`) : "",
            h("button", {class: "plain", title: "Plot it no more", "aria-label": `Plot ${name} no more`,
                onclick: () => this.remove(line)}, "×"));
    }

    draw() {
        const {canvas} = this, pen = canvas.getContext("2d"), dense = window.devicePixelRatio || 1;
        const width = canvas.clientWidth, height = canvas.clientHeight;
        if (!width) return;
        canvas.width = width * dense;
        canvas.height = height * dense;
        pen.scale(dense, dense);
        const style = getComputedStyle(canvas), ink = (name) => style.getPropertyValue(name);
        const x = (tick) => 8 + (tick - this.first) / Math.max(1, this.last - this.first) * (width - 16);
        for (const {colour, ticks, values, most, least, steep} of this.lines) {
            const part = (value) => steep ? Math.log1p(value) / Math.log1p(most) : (value - least) / Math.max(1e-9, most - least);
            const y = (value) => height - 3 - part(value) * (height - 8);
            pen.strokeStyle = pen.fillStyle = ink(`--plot${colour}`);
            pen.lineWidth = 1.5;
            pen.beginPath();
            let open = false, from = 0;
            const alone = this.lines.length === 1;
            values.forEach((value, i) => {
                if (value === null) {
                    open = false;
                    return;
                }
                if (open) pen.lineTo(x(ticks[i]), y(value));
                else pen.moveTo(from = x(ticks[i]), y(value));
                // One that stands alone is a point.
                if (!open && (i + 1 === values.length || values[i + 1] === null)) pen.fillRect(from - 1, y(value) - 1, 2, 2);
                open = true;
            });
            pen.stroke();
            if (!alone || values.includes(null) || !values.length) continue;
            pen.lineTo(x(ticks[ticks.length - 1]), y(least));
            pen.lineTo(x(ticks[0]), y(least));
            pen.globalAlpha = 0.18;
            pen.fill();
            pen.globalAlpha = 1;
        }
        pen.fillStyle = ink("--accent");
        for (const tick of this.marks) {
            const at = x(tick);
            pen.beginPath();
            pen.moveTo(at - 4, 0);
            pen.lineTo(at + 4, 0);
            pen.lineTo(at, 7);
            pen.fill();
        }
        if (this.now !== undefined) pen.fillRect(x(this.now) - 0.75, 0, 1.5, height);
    }
}
