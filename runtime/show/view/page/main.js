// The viewer: shows a run that a server holds, or one that is in the page.
import {briefly, byId, grouped, h, mistakeOf, seldom} from "./dom.js";
import {firstLook} from "./address.js";
import {boundsOf, placeOf} from "./block.js";
import {Completer} from "./complete.js";
import {difference} from "./difference.js";
import {listenToKeys} from "./keys.js";
import {showLegend} from "./legend.js";
import {LookPanel} from "./look.js";
import {Panel} from "./panel.js";
import {listen} from "./pointer.js";
import {ServerSource} from "./source_server.js";
import {ShareSource, isShared} from "./source_share.js";
import {Side} from "./side.js";
import {Stage} from "./stage.js";
import {Transport} from "./transport.js";
import {Vocabulary} from "./vocabulary.js";
import {WorldTab} from "./world.js";

class Viewer {
    // `asked`: what early.js has asked for.
    constructor(source, asked) {
        this.first = source;
        this.early = asked;
        this.selected = new Set();
        this.primary = null;  // The catom that the panel is about.
        this.asked = null;    // The next frame to ask for, while one is on its way.
        this.sides = [];
        this.active = null;   // The side that was clicked last.
    }

    get source() { return this.active.source; }
    get editing() { return this.world && this.world.isOpen; }
    get stage() { return this.active.stage; }
    get words() { return this.active.words; }

    async start() {
        const source = this.first;
        const look = () => this.look ? this.look.look() : {};
        // All that is needed for the first picture has been asked for, and the graphics are made while the server is at work.
        const {hello, beside, frame: ahead} = await this.early;
        const stage = new Stage(byId("stage"), source.image && ((camera, size) => source.image(look(), camera, size)));
        const info = this.info = await hello;
        this.active = new Side(stage, source, info, null);
        this.active.ahead = ahead;
        this.sides.push(this.active);
        const other = await beside;
        if (other) this.sides.push(Side.beside(this.active, other, other.info, look));
        const title = this.sides.map((side) => side.title).filter(Boolean).join(" beside ") || "Claymeld";
        byId("title").textContent = title;
        byId("title").title = this.sides.map((side) => side.info.program).join(" beside ");
        document.title = title === "Claymeld" ? title : `${title} - Claymeld`;
        this.vocabulary = new Vocabulary(info.predicates);
        this.look = new LookPanel(byId("look"), info, source.asks ? null : info.look, {vocabulary: this.vocabulary,
            two: this.sides.length > 1, changed: (field) => this.refresh(undefined, field), arranged: () => this.arrange()});
        this.panel = new Panel(byId("panel"), source, info, this.vocabulary, {choose: (id) => this.choose(id), did: () => this.refresh()});
        const last = Math.max(...this.sides.map((side) => side.info.last ?? side.info.tick ?? 0));
        this.transport = new Transport(byId("transport"), {...info, last, live: source.live, asks: source.asks, key: title},
            this.vocabulary, this.moves());
        for (const side of this.sides) side.stage.changed = () => this.refresh();
        for (const side of this.sides)
            listen(side.stage, side.box, {picked: (id, more, at) => this.editing ? this.world.picked(side.stage, id, more, at)
                : this.selectIn(side, id === null ? [] : [id], more),
            boxed: (ids, more) => this.editing ? this.world.boxed(side.stage, ids, more) : this.selectIn(side, ids, more)});
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
        if (this.source.asks) {
            const find = byId("find");
            byId("search").append(new Completer(find, this.vocabulary).element);
            this.vocabulary.each(() => {
                find.placeholder = `42, or ${this.vocabulary.example("catoms") || "a body"}`;
            });
        } else byId("find").placeholder = "42, or part of a fact";
        byId("search").addEventListener("submit", (event) => {
            event.preventDefault();
            this.search(byId("find").value.trim());
        });
        if (matchMedia("(prefers-color-scheme: dark)").matches) this.darken(true);
        this.first.onevent = (event) => this.told(event);
        this.first.onclosed = (lost) => this.complain(lost);
        if (!this.first.world) return;
        this.world = new WorldTab(byId("world"), this.first, (frame, said, fits) => this.preview(frame, said, fits));
        byId("edit-world").hidden = false;
        byId("edit-world").addEventListener("click", () => this.editWorld(!this.world.isOpen));
    }

    // The world instead of the run, or the run again.
    async editWorld(open) {
        document.body.classList.toggle("world", open);
        byId("edit-world").classList.toggle("on", open);
        this.active.stage.select(new Set());
        await this.world.show(open);
        if (!open) {
            this.active.stage.select(this.selected);
            await this.refresh();
        }
        this.active.stage.home();
    }

    // `fits`: all of it is to be seen.
    preview(frame, said, fits) {
        if (!this.editing) return;
        const {stage} = this.active, flat = said.lattice === "square" || said.lattice === "hex", turned = flat !== stage.flat;
        stage.show(frame, {lattice: said.lattice, flat});
        if (turned) stage.home();
        else if (fits) stage.fit();
        showLegend(byId("legend"), null);
    }

    // One request at a time; of those that come meanwhile only the last is made. `field` is the one whose change asks for it.
    async refresh(tick, field) {
        if (tick !== undefined && !this.editing) this.wanted = tick;
        if (this.busy) {
            this.asked = [tick === undefined && this.asked ? this.asked[0] : tick, field];
            return;
        }
        if (this.editing) return;
        this.busy = true;
        const mistakes = [];
        for (const side of this.sides) {
            try {
                const {words, frame} = await (side.ahead || side.source.frame(this.look.look(), tick));
                side.ahead = null;
                side.complain(null);
                // Bodies that were left out: the frame is there without them.
                mistakes.push(...words.mistakes || []);
                side.take(words, frame);
                if (!this.look.difference) {
                    side.stage.sketchInstead(false);
                    side.draw(frame, words.legend, this.look.moves);
                }
                if (side === this.active) {
                    const bounds = boundsOf(frame), away = side.stage.drawnAway;
                    this.look.seen({thinned: frame.covers !== null, away, bounds});
                }
            } catch (error) {
                if (!error.message || error instanceof Error) console.error(error);
                side.ahead = null;
                if (this.look.mistaken([error], field).length) side.complain(error);
                else mistakes.push(error);
            }
        }
        if (this.look.difference) this.compare();
        this.look.mistaken(mistakes, field);
        if (this.words) this.showWords();
        this.busy = false;
        if (!this.asked) this.wanted = null;
        if (this.asked) {
            const [next, of] = this.asked;
            this.asked = null;
            await this.refresh(next, of);
        }
    }

    // Both runs in the colours of how they differ.
    compare() {
        const {sides} = this;
        if (!sides.every(({frame}) => frame)) return;
        const said = difference(sides.map(({frame}) => frame), sides.map(({words}) => words));
        for (const {stage} of sides) stage.sketchInstead(said !== null);
        sides.forEach((side, i) => side.draw(said ? said.frames[i] : side.frame, said ? said.legend : side.words.legend, this.look.moves));
        if (!said) this.active.complain({message: "So many catoms cannot be compared", hint: "Cut, or show fewer"});
    }

    showWords() {
        const {words, info: {lattice}} = this.active;
        if (this.look.cut.axis >= 0) this.arrange();
        const some = words.shown === words.catoms ? "" : `${grouped(words.shown)} of `;
        const coarse = words.coarse > 1 ? `, as ${grouped(words.sent)} balls` : "";
        byId("about").title = coarse ? `Each stands for what is in a cube with sides of ${words.coarse} diameters` : "";
        byId("about").textContent = `${some}${grouped(words.catoms)} catoms, ${lattice}${coarse}`;
        if (this.ended && this.ended.tick !== words.tick) this.ended = null;
        this.transport.at(words.tick, words.last || this.info.last, this.ended ? this.ended.words : "");
        this.panel.show(this.primary, this.selected);
        if (this.refreshMetrics) this.refreshMetrics();
        document.body.dataset.tick = words.tick;
    }

    arrange() {
        for (const {stage} of this.sides) {
            stage.cut = this.look.asksForCut ? null : this.look.cutIn(stage.bounds);
            stage.size = this.look.size;
            stage.arrange();
        }
    }

    // What was counted, and what bodies say after each tick: of those, ticks that nobody has asked for come a few at a time.
    async plot() {
        const {source, transport: {plot}} = this;
        if (!source.metrics) return;
        this.plotsAgain = true;
        if (this.plotting) return;
        this.plotting = true;
        try {
            while (this.plotsAgain) {
                this.plotsAgain = false;
                plot.learn(await this.source.metrics());
                for (const body of plot.bodies) await this.plotBody(body);
            }
        } catch (error) {
            this.transport.says(error.message);
        } finally {
            this.plotting = false;
        }
    }

    async plotBody(body) {
        const {plot} = this.transport;
        try {
            for (let done = false; !done && plot.bodies.includes(body);) {
                const said = await this.source.series(body);
                plot.learnBody(body, said);
                done = said.done;
            }
        } catch (error) {
            plot.wrong(body, error);
        }
    }

    moves() {
        const source = this.first, each = (act) => Promise.all(this.sides.map((side) => act(side.source)));
        const step = (ticks) => {
            if (!source.asks) return this.refresh(this.beside(ticks));
            return this.command(ticks < 0 ? `back ${-ticks}` : `step ${ticks}`);
        };
        return {
            go: (tick) => this.refresh(tick),
            step,
            run: () => this.command("run"),
            until: async (body) => this.transport.mistaken(body ? await this.command(`until ${body}`,
                true) : {message: "Write what it is to wait for", hint: this.example("As in ")}),
            play: (speed) => source.asks ? each((one) => one.play(speed)).catch((error) => this.complain(error)) : this.playShared(speed),
            interrupt: () => source.interrupt(),
            wanted: () => this.plot(),
            pause: () => source.asks ? each((one) => one.pause()).catch((error) => this.complain(error)) : clearTimeout(this.timer),
        };
    }

    // The tick of a frame before or after the one that is shown, or that is on its way: keys may come faster than frames.
    beside(frames) {
        const {ticks} = this.info, from = this.wanted ?? this.words.tick, at = ticks.findLastIndex((tick) => tick <= from);
        return ticks[Math.min(Math.max(at + frames, 0), ticks.length - 1)];
    }

    async playShared(speed) {
        if (!this.transport.playing) return;
        const next = this.words.tick === this.info.last ? this.info.first : this.beside(1);
        await this.refresh(next);
        if (next === this.info.last) this.transport.setPlaying(false);
        else this.timer = setTimeout(() => this.playShared(speed), speed ? 1000 / speed : 0);
    }

    // Goes somewhere, all sides; the error, if there is one.
    async command(line, quiet = false) {
        this.transport.setBusy(true);
        let wrong = null;
        for (const side of this.sides) {
            try {
                const {answer, tick} = await side.source.command(line);
                if (side === this.active) this.ended = {tick, words: this.endOf(answer)};
            } catch (error) {
                wrong = wrong || error;
            }
        }
        this.transport.setBusy(false);
        await this.refresh();
        if (wrong && !quiet) this.complain(wrong);
        return wrong;
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
        if (event.event === "moved") {
            if (event.ended && !event.run) this.ended = {tick: event.tick, words: this.endOf(event)};
            this.info.last = event.last || event.latest || this.info.last;
            this.refresh();
        }
        if (event.event === "reloaded") this.reloaded(event);
        if (event.event === "stopped" && !event.run) {
            this.transport.setPlaying(false);
            const words = event.why === "error" ? briefly(event.error)[0] : event.why === "stop" ? (event.stops || []).join(", ")
                : {end: "the run has ended", interrupted: "interrupted"}[event.why];
            if (words) this.ended = {tick: event.tick, words};
            this.refresh();
        }
    }

    // The program has changed while it runs.
    async reloaded({ok, text, error}) {
        this.notice(ok ? "The program was read again" : "The program has a mistake; the run goes on under its old rules", ok ? text
            : `${error.message}\n${error.hint || ""}`, !ok);
        if (!ok) return;
        this.vocabulary.learn((await this.first.hello()).predicates);
        await this.refresh();
    }

    notice(title, text, wrong) {
        const element = byId("notice");
        element.hidden = false;
        element.classList.toggle("wrong", wrong);
        element.replaceChildren(h("button", {class: "small", title: "Close", onclick: () => {
            element.hidden = true;
        }}, "×"), h("b", {}, title), h("pre", {}, (text || "").trim()));
    }

    // A click or a box in one of two pictures.
    selectIn(side, ids, more) {
        const stays = side === this.active;
        if (!stays) this.stage.select(new Set());
        this.active = side;
        this.panel.source = side.source;
        if (!stays) this.refreshMetrics();
        this.select(ids, more && stays);
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
            this.says(briefly(error).join("; "));
        }
    }

    async ask(body) {
        const {answer: {columns, rows}} = await this.source.command(`query ${body}`);
        const column = columns.findIndex(({type}) => type === "node" || type === "catom");
        if (column < 0) throw {message: "No variable is a catom", hint: this.example("Write it as in ")};
        return [...new Set(rows.map((row) => row[column]))].sort((a, b) => a - b);
    }

    // A body of this program behind these words; nothing if it has none.
    example(words) {
        const body = this.vocabulary.example("catoms");
        return body && words + body;
    }

    complain(error) {
        if (this.active) this.active.complain(error);
        else byId("stage").append(mistakeOf(error));
    }

    darken(dark) {
        for (const {stage} of this.sides) stage.dark = dark;
        document.documentElement.classList.toggle("dark", dark);
        byId("theme").textContent = dark ? "Light" : "Dark";
        this.arrange();
        this.transport.plot.draw();
    }

    keys() {
        const {stage} = this.sides[0], {view} = stage, moves = this.moves();
        const from = (azimuth, elevation) => () => {
            Object.assign(view, {azimuth, elevation});
            view.update();
            stage.fit();
        };
        return {
            toggle: () => this.transport.toggle(), on: () => moves.step(1), back: () => moves.step(-1),
                start: () => moves.go(this.info.first),
            end: () => moves.go(this.transport.last), fit: () => stage.fit(),
                centre: () => this.primary !== null && this.stage.lookTo(this.primary),
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
            box: () => this.sides.forEach((side) => side.element.classList.toggle("boxing")),
            labels: () => {
                for (const side of this.sides) side.stage.labels.shown = !side.stage.labels.shown;
                stage.draw();
            },
            bookmark: () => this.transport.bookmarks.toggle(this.words.tick),
            mark: (key) => {
                const tick = this.transport.bookmarks.beside(key === "[" ? -1 : 1);
                if (tick !== undefined) moves.go(tick);
            },
            theme: () => this.darken(!stage.dark), search: () => byId("find").focus(), nothing: () => this.select([]),
                help: () => byId("keys").showModal(),
        };
    }
}

// All of the page is there when early.js runs this.
const source = isShared() ? new ShareSource() : window.early ? window.early.source : new ServerSource();
const viewer = new Viewer(source, window.early && !isShared() ? window.early.asked : source.begin(firstLook()));
window.viewer = viewer;
viewer.start().catch((error) => {
    console.error(error);
    viewer.complain(error);
});
