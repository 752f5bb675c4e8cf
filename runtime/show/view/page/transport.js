// The bar below: where in its ticks the run is, and how it moves. Bookmarks and the plot of numbers by ticks lie under the slider.
import {Bookmarks} from "./bookmarks.js";
import {Completer} from "./complete.js";
import {grouped, h, mistakeOf} from "./dom.js";
import {Plot} from "./plot.js";

const SPEEDS = [[1, "1 tick/s"], [5, "5 ticks/s"], [20, "20 ticks/s"], [0, "as fast as it goes"]];

export class Transport {
    // `go(tick)`; `step(ticks)`; `play(speed)`, 0: as fast as it goes; `pause()`; `until(body)`, `run()`: of live runs only;
    // `wanted()`: the plot wants more numbers.
    constructor(element, info, vocabulary, actions) {
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
        this.goal = h("input", {type: "text", id: "until", "aria-label": "A body in Meld"});
        const goal = new Completer(this.goal, vocabulary).element;
        vocabulary.each(() => {
            this.goal.placeholder = vocabulary.example("catoms") || "a body";
        });
        this.mistake = h("div", {id: "until-mistake"});
        this.stop = button("interrupt", "End what is being done", "Stop", () => actions.interrupt());
        this.stop.hidden = true;
        this.scrub = h("input", {type: "range", id: "scrub", step: "1", "aria-label": "Tick",
            oninput: () => actions.go(Number(this.scrub.value))});
        this.plot = new Plot(vocabulary, {go: actions.go, wanted: actions.wanted});
        this.bookmarks = new Bookmarks(info.key, {go: actions.go, changed: () => this.mark()});
        const live = info.live === false ? [] : [button("run", "To the end of the run", "Run to the end", actions.run),
            h("span", {class: "goal"}, "until", goal,
                button("go-until", "Go on until it holds", "Go", () => actions.until(this.goal.value.trim())))];
        element.replaceChildren(h("div", {class: "row"}, button("start", "First tick (Home)", "|◀", () => actions.go(this.first)),
            button("back", "One tick back (←)", "◀", () => actions.step(-1)), this.playButton,
            button("step", "One tick on (→)", "▶|", () => actions.step(1)),
            this.speed, this.tick, this.bookmarks.button, ...live, this.stop, this.state), this.mistake, this.scrub,
        this.numbers = h("div", {class: "row numbers"}, ...(info.asks ? this.plot.row : []), this.bookmarks.element),
        this.plot.mistake, this.plot.canvas);
        this.goal.addEventListener("keydown", (event) => event.key === "Enter" && actions.until(this.goal.value.trim()));
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
        this.bookmarks.at(tick);
        this.mark();
    }

    mark() { this.plot.at(this.first, this.last, this.now, this.bookmarks.ticks); }

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
}
