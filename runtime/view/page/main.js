// The viewer: shows a run that a server holds, or one that is in the page.
import {byId, grouped, h, seldom} from "./dom.js";
import {placeOf} from "./block.js";
import {listenToKeys} from "./keys.js";
import {showLegend} from "./legend.js";
import {LookPanel} from "./look.js";
import {Panel} from "./panel.js";
import {listen} from "./pointer.js";
import {ServerSource} from "./source_server.js";
import {ShareSource, isShared} from "./source_share.js";
import {Stage} from "./stage.js";
import {Transport} from "./transport.js";

class Viewer {
    constructor(source) {
        this.source = source;
        this.selected = new Set();
        this.primary = null;  // The catom that the panel is about.
        this.asked = null;    // The next frame to ask for, while one is on its way.
    }

    async start() {
        if (this.source.open) await this.source.open();
        const {source} = this, info = this.info = await source.hello();
        byId("title").textContent = info.program || "Claymeld";
        document.title = info.program ? `${info.program} - Claymeld` : "Claymeld";
        this.stage = new Stage(byId("stage"), source.image && ((camera, size) => source.image(this.look.look(), camera, size)));
        this.look = new LookPanel(byId("look"), info, source.asks ? null : info.look, {changed: (field) => this.refresh(undefined,
            field), arranged: () => this.arrange()});
        this.panel = new Panel(byId("panel"), source, {choose: (id) => this.choose(id), did: () => this.refresh()});
        this.transport = new Transport(byId("transport"), {...info, live: source.live}, this.moves());
        listen(this.stage, byId("box"), {picked: (id, more) => this.select(id === null ? [] : [id], more), boxed: (ids,
            more) => this.select(ids, more)});
        listenToKeys(this.keys(), byId("keys"));
        this.wire();
        this.refreshMetrics = seldom(() => this.plot(), 400);
        await this.refresh();
        document.body.dataset.ready = "yes";
    }

    wire() {
        const keys = this.keys();
        for (const [id, action] of [["view-top", "top"], ["view-front", "front"], ["view-side", "side"], ["fit", "fit"], ["projection",
            "projection"], ["theme", "theme"], ["help", "help"]])
            byId(id).addEventListener("click", () => keys[action]());
        byId("find").placeholder = this.source.asks ? "42, or a body: dist(A, 3)" : "42, or part of a fact";
        byId("search").addEventListener("submit", (event) => {
            event.preventDefault();
            this.search(byId("find").value.trim());
        });
        if (matchMedia("(prefers-color-scheme: dark)").matches) this.darken(true);
        this.source.onevent = (event) => this.told(event);
        this.source.onclosed = (lost) => this.complain(lost);
    }

    // One request at a time; of those that come meanwhile only the last is made. `field` is the one whose change asks for it.
    async refresh(tick, field) {
        if (this.busy) {
            this.asked = [tick === undefined && this.asked ? this.asked[0] : tick, field];
            return;
        }
        this.busy = true;
        try {
            const {words, frame} = await this.source.frame(this.look.look(), tick);
            this.look.mistaken(null);
            this.complain(null);
            this.show(words, frame);
        } catch (error) {
            if (!error.message || error instanceof Error) console.error(error);
            if (!this.look.mistaken(error, field)) this.complain(error);
        } finally {
            this.busy = false;
        }
        if (this.asked) {
            const [next, of] = this.asked;
            this.asked = null;
            await this.refresh(next, of);
        }
    }

    show(words, frame) {
        this.words = words;
        this.stage.flat = this.info.flat;
        this.stage.show(frame, this.info);
        if (this.look.cut.axis >= 0) this.arrange();
        showLegend(byId("legend"), words.legend);
        const {lattice} = this.info;
        const some = words.shown === words.catoms ? "" : `${grouped(words.shown)} of `;
        byId("about").textContent = `${some}${grouped(words.catoms)} catoms, ${lattice}`;
        this.transport.at(words.tick, words.last || this.info.last, this.ended || "");
        this.panel.show(this.primary, this.selected);
        if (this.refreshMetrics) this.refreshMetrics();
        document.body.dataset.tick = words.tick;
    }

    arrange() {
        this.stage.cut = this.look.cutIn(this.stage.bounds);
        this.stage.size = this.look.size;
        this.stage.arrange();
    }

    async plot() {
        if (!this.source.metrics) {
            this.transport.metrics({ticks: [], series: {}});
            return;
        }
        try {
            this.transport.metrics(await this.source.metrics());
        } catch (error) {
            this.transport.says(error.message);
        }
    }

    moves() {
        const {source} = this;
        const step = (ticks) => {
            if (!source.asks) return this.refresh(this.beside(ticks));
            return this.command(ticks < 0 ? `back ${-ticks}` : `step ${ticks}`);
        };
        return {
            go: (tick) => this.refresh(tick),
            step,
            run: () => this.command("run"),
            until: async (body) => this.transport.mistaken(body ? await this.command(`until ${body}`,
                true) : {message: "Write what it is to wait for", hint: "As in leader(A)"}),
            play: (speed) => source.asks ? source.play(speed).catch((error) => this.complain(error)) : this.playShared(speed),
            pause: () => source.asks ? source.pause().catch((error) => this.complain(error)) : clearTimeout(this.timer),
        };
    }

    // The tick of a frame before or after the one that is shown.
    beside(frames) {
        const {ticks} = this.info, at = ticks.findLastIndex((tick) => tick <= this.words.tick);
        return ticks[Math.min(Math.max(at + frames, 0), ticks.length - 1)];
    }

    async playShared(speed) {
        if (!this.transport.playing) return;
        const next = this.words.tick === this.info.last ? this.info.first : this.beside(1);
        await this.refresh(next);
        if (next === this.info.last) this.transport.setPlaying(false);
        else this.timer = setTimeout(() => this.playShared(speed), speed ? 1000 / speed : 0);
    }

    // Goes somewhere; the error, if there is one.
    async command(line, quiet = false) {
        try {
            const {answer} = await this.source.command(line);
            this.ended = this.endOf(answer);
            await this.refresh();
            return null;
        } catch (error) {
            if (!quiet) this.complain(error);
            return error;
        }
    }

    endOf(answer) {
        if (!answer) return "";
        const stop = (answer.stops || [])[0];
        if (stop) return `${stop.what}: ${(stop.ways || [])[0] || "it holds"}`;
        return {quiet: "nothing more happens", ticks: "the run has all of its ticks", finished: "the run has ended",
            interrupted: "interrupted", failed: "the program has failed"}[answer.ended] || "";
    }

    told(event) {
        if (event.event === "progress") this.transport.says(event.text || "");
        if (event.event === "moved" || event.event === "reloaded") {
            this.ended = this.endOf(event);
            this.info.last = event.last || event.latest || this.info.last;
            this.refresh();
        }
        if (event.event === "stopped") {
            this.transport.setPlaying(false);
            if (event.message) this.transport.says(event.message);
        }
    }

    select(ids, more = false) {
        const before = this.selected;
        this.selected = new Set(more ? before : []);
        for (const id of ids) {
            if (more && ids.length === 1 && before.has(id)) this.selected.delete(id);
            else this.selected.add(id);
        }
        this.primary = ids.length && this.selected.has(ids[0]) ? ids[0] : [...this.selected][0] ?? null;
        this.stage.select(this.selected);
        this.panel.show(this.primary, this.selected);
    }

    // From a text about it.
    choose(id) {
        this.select([id]);
        if (placeOf(this.stage.frame, id) < 0) this.says(`@${id} is not shown`);
    }

    says(words) { byId("found").textContent = words; }

    async search(text) {
        this.says("");
        byId("find").classList.remove("wrong");
        if (!text) return;
        const id = text.match(/^@?(\d+)$/);
        if (id) {
            this.choose(Number(id[1]));
            this.stage.lookTo(Number(id[1]));
            return;
        }
        try {
            const ids = this.source.asks ? await this.ask(text) : this.source.found(text);
            this.select(ids);
            this.says(ids.length === 1 ? "1 catom" : `${grouped(ids.length)} catoms`);
        } catch (error) {
            byId("find").classList.add("wrong");
            this.says(`${error.message}${error.hint ? `. ${error.hint}` : ""}`);
        }
    }

    async ask(body) {
        const {answer: {columns, rows}} = await this.source.command(`query ${body}`);
        const column = columns.findIndex(({type}) => type === "node" || type === "catom");
        if (column < 0) throw {message: "No variable is a catom", hint: "Write it as in dist(A, 3)"};
        return [...new Set(rows.map((row) => row[column]))].sort((a, b) => a - b);
    }

    complain(error) {
        const element = byId("message");
        element.classList.toggle("shown", Boolean(error));
        element.replaceChildren(...(error ? [String(error.message), error.hint ? h("div", {class: "quiet"}, error.hint) : ""] : []));
    }

    darken(dark) {
        this.stage.dark = dark;
        document.documentElement.classList.toggle("dark", dark);
        byId("theme").textContent = dark ? "Light" : "Dark";
        this.stage.arrange();
        this.transport.plot();
    }

    keys() {
        const {stage} = this, {view} = stage, moves = this.moves();
        const from = (azimuth, elevation) => () => {
            Object.assign(view, {azimuth, elevation});
            view.update();
            stage.fit();
        };
        return {
            toggle: () => this.transport.toggle(), on: () => moves.step(1), back: () => moves.step(-1),
                start: () => moves.go(this.info.first),
            end: () => moves.go(this.transport.last), fit: () => stage.fit(),
                centre: () => this.primary !== null && stage.lookTo(this.primary),
            front: from(-90, 0), side: from(0, 0), top: from(-90, 90),
            projection: () => {
                view.angle = view.parallel ? 25 : 0;
                view.update();
                byId("projection").textContent = view.parallel ? "Perspective" : "Parallel";
                stage.draw();
            },
            zoom: (key) => {
                view.zoom(key === "-" ? 0.8 : 1.25, view.width / 2, view.pixels / 2);
                stage.draw();
            },
            box: () => stage.element.classList.toggle("boxing"),
            labels: () => {
                stage.labels.shown = !stage.labels.shown;
                stage.draw();
            },
            theme: () => this.darken(!stage.dark), search: () => byId("find").focus(), nothing: () => this.select([]),
                help: () => byId("keys").showModal(),
        };
    }
}

// A run that is in the page stands behind this program.
addEventListener("DOMContentLoaded", () => {
    const viewer = new Viewer(isShared() ? new ShareSource() : new ServerSource());
    window.viewer = viewer;
    viewer.start().catch((error) => {
        console.error(error);
        viewer.complain(error);
    });
});
