// The bar below: where in its ticks the run is, and how it moves. The plot of a number by ticks lies under the slider.
import {grouped, h, mistakeOf, number} from "./dom.js";

const SPEEDS = [[1, "1 tick/s"], [5, "5 ticks/s"], [20, "20 ticks/s"], [0, "as fast as it goes"]];

export class Transport {
    // `go(tick)`; `step(ticks)`; `play(speed)`, 0: as fast as it goes; `pause()`; `until(body)`, `run()`: of live runs only.
    constructor(element, info, actions) {
        this.actions = actions;
        this.first = info.first;
        this.last = Math.max(info.last === null || info.last === undefined ? info.tick : info.last, info.first + 1);
        this.playing = false;
        const button = (id, title, text, act) => h("button", {id, title, onclick: act}, text);
        this.tick = h("span", {id: "tick"});
        this.state = h("span", {id: "state", role: "status"});
        this.speed = h("select", {id: "speed", "aria-label": "Speed"}, SPEEDS.map(([value, text]) => h("option", {value,
            selected: value === 5}, text)));
        this.playButton = button("play", "Play or pause (space)", "▶", () => this.toggle());
        this.goal = h("input", {type: "text", id: "until", spellcheck: "false", placeholder: "leader(A)", "aria-label": "A body in Meld"});
        this.mistake = h("div", {id: "until-mistake"});
        this.stop = button("interrupt", "End what is being done", "Stop", () => actions.interrupt());
        this.stop.hidden = true;
        this.scrub = h("input", {type: "range", id: "scrub", step: "1", "aria-label": "Tick",
            oninput: () => actions.go(Number(this.scrub.value))});
        this.series = h("select", {id: "series", "aria-label": "What is plotted", onchange: () => this.plot()});
        this.canvas = h("canvas", {id: "plot",
            onclick: (event) => actions.go(Math.round(this.first + event.offsetX / this.canvas.clientWidth * (this.last - this.first)))});
        const live = info.live === false ? [] : [button("run", "To the end of the run", "Run to the end", actions.run), "until", this.goal,
            button("go-until", "Go on until it holds", "Go", () => actions.until(this.goal.value.trim()))];
        element.replaceChildren(h("div", {class: "row"}, button("start", "First tick (Home)", "|◀", () => actions.go(this.first)),
            button("back", "One tick back (←)", "◀", () => actions.step(-1)), this.playButton,
            button("step", "One tick on (→)", "▶|", () => actions.step(1)),
            this.speed, this.tick, ...live, this.stop, this.state, this.series), this.mistake, this.scrub, this.canvas);
        this.goal.addEventListener("keydown", (event) => event.key === "Enter" && actions.until(this.goal.value.trim()));
        new ResizeObserver(() => this.plot()).observe(this.canvas);
    }

    toggle() {
        this.setPlaying(!this.playing);
        if (this.playing) this.actions.play(Number(this.speed.value));
        else this.actions.pause();
    }

    setPlaying(playing) {
        this.playing = playing;
        this.playButton.textContent = playing ? "⏸" : "▶";
        this.playButton.classList.toggle("on", playing);
    }

    at(tick, last, words) {
        this.last = Math.max(this.last, tick, last || 0);
        this.now = tick;
        Object.assign(this.scrub, {min: this.first, max: this.last});
        this.scrub.value = tick;
        this.tick.textContent = `tick ${grouped(tick)}`;
        this.state.textContent = words;
        this.plot();
    }

    // Something is being done that may take long: it can be ended.
    setBusy(busy) {
        clearTimeout(this.waits);
        this.stop.hidden = true;
        if (busy) this.waits = setTimeout(() => { this.stop.hidden = false; }, 300);
    }

    says(words) { this.state.textContent = words; }

    mistaken(error) {
        this.goal.classList.toggle("wrong", Boolean(error));
        this.mistake.replaceChildren(...(error ? [mistakeOf(error)] : []));
    }

    // {ticks, series: {name: [numbers]}}
    metrics(metrics) {
        this.known = metrics;
        const names = Object.keys(metrics.series || {}), chosen = this.series.value;
        if (names.join() !== this.names) {
            this.names = names.join();
            this.series.replaceChildren(...names.map((name) => h("option", {selected: name === chosen}, name)));
            if (!chosen && names.includes("evaluated")) this.series.value = "evaluated";
        }
        this.series.hidden = names.length === 0;
        this.plot();
    }

    plot() {
        const {canvas, known} = this, pen = canvas.getContext("2d"), dense = window.devicePixelRatio || 1;
        const width = canvas.clientWidth, height = canvas.clientHeight;
        if (!width) return;
        canvas.width = width * dense;
        canvas.height = height * dense;
        pen.scale(dense, dense);
        const style = getComputedStyle(canvas), ink = (name) => style.getPropertyValue(name);
        const x = (tick) => 8 + (tick - this.first) / Math.max(1, this.last - this.first) * (width - 16);
        const values = known && known.series[this.series.value];
        if (values && values.length) {
            const most = Math.max(...values.slice(-100000), 1e-9), middle = [...values].sort((a, b) => a - b)[values.length >> 1];
            // One tick that is far above all others would leave nothing of them to see.
            const steep = most > 20 * Math.max(1, middle), part = (value) => steep ? Math.log1p(value) / Math.log1p(most) : value / most;
            const y = (value) => height - 3 - part(value) * (height - 12);
            pen.beginPath();
            pen.moveTo(x(known.ticks[0]), height);
            values.forEach((value, i) => pen.lineTo(x(known.ticks[i]), y(value)));
            pen.lineTo(x(known.ticks[values.length - 1]), height);
            pen.fillStyle = pen.strokeStyle = ink("--plot");
            pen.globalAlpha = 0.18;
            pen.fill();
            pen.globalAlpha = 1;
            pen.stroke();
            pen.fillStyle = ink("--faint");
            pen.font = `${parseFloat(getComputedStyle(document.documentElement).fontSize) * 0.85}px system-ui, sans-serif`;
            pen.fillText(steep ? `${number(most)}, logarithmic` : number(most), 10, 10);
            const at = known.ticks.indexOf(this.now);
            if (at >= 0) pen.fillText(number(values[at]), Math.min(x(this.now) + 5, width - 50), 22);
        }
        pen.fillStyle = ink("--accent");
        if (this.now !== undefined) pen.fillRect(x(this.now) - 0.75, 0, 1.5, height);
    }
}
