// The picture: draws the frame when something has changed, first fast, then well; finds what is under the pointer.
import {Scene, WebGLRenderer} from "three";

import {wantsImages} from "./address.js";
import {boundsOf, emptyFrame, placeOf} from "./block.js";
import {View} from "./camera.js";
import {Catoms, met} from "./drawn/catoms.js";
import {coverOf} from "./drawn/occlusion.js";
import {h} from "./dom.js";
import {Labels} from "./labels.js";
import {Lamps} from "./drawn/lamps.js";
import {Obstacles} from "./drawn/obstacles.js";
import {Sketch} from "./sketch.js";
import {Strokes} from "./drawn/strokes.js";

const FAST = 60;   // Milliseconds that a picture may take while something moves.
const SLOW = 600;  // With more it is drawn with fewer pixels also when nothing moves.
const MOST_PIXELS = 16e6;  // Of a picture with more pixels than are shown.

// Of a frame from which others have left out what is hidden.
const known = (frame, kept) => ({drawn: kept, cover: Float32Array.from({length: 4 * kept.length},
    (_, i) => frame.covers[4 * kept[i >> 2] + (i & 3)] / 127)});

export class Stage {
    // `paint` asks the server for a picture, where there is no WebGL: (camera, size) -> bytes of a PNG.
    // `view` is shared by stages that are seen from the same place.
    constructor(element, paint, view = null) {
        this.element = element;
        this.paint = paint;
        this.canvas = element.querySelector("canvas");
        this.picture = element.querySelector("img");
        this.view = view || new View();
        this.partner = null;  // Draws when this one does.
        this.frame = emptyFrame();
        this.drawn = this.kept = new Uint32Array(0);
        this.lattice = "";
        this.cut = null;  // {axis, at, above}: what is beyond it is not shown.
        this.size = 1;
        this.dark = false;
        this.selected = new Set();
        this.labels = new Labels(element.querySelector(".labels"));
        this.scale = 1;  // Of the canvas's own pixels while it moves.
        this.well = 0;  // How long the last good picture took.
        this.wanted = false;
        this.ready = false;  // Nothing has been shown yet.
        this.changed = () => {};  // Called when something else draws from now on, which wants other frames.
        this.start();
        new ResizeObserver(() => this.resize()).observe(element);
        this.resize();
    }

    start() {
        const context = wantsImages() ? null
            : this.canvas.getContext("webgl2", {antialias: false, alpha: false, preserveDrawingBuffer: true});
        if (!context) {
            this.drawOtherwise(this.canvas);
            return;
        }
        this.canvas.addEventListener("webglcontextlost", (event) => {
            // Otherwise it does not come back.
            event.preventDefault();
            this.lose();
        });
        this.canvas.addEventListener("webglcontextrestored", () => this.restore(context));
        this.build(context);
    }

    // Without WebGL: a server's pictures, or a sketch on this canvas.
    drawOtherwise(canvas) {
        this.drawsItself = false;
        if (!this.paint) this.sketch = new Sketch(canvas);
        this.element.classList.toggle("images", !this.sketch);
    }

    // Where the server draws: this canvas does, plainly, while colours are shown that the server does not know.
    sketchInstead(on) {
        if (this.drawsItself || !this.paint || on === Boolean(this.sketch)) return;
        // A canvas has one kind of context for ever.
        if (on && this.lost && !this.spare) this.canvas.after(this.spare = h("canvas"));
        this.sketch = on ? new Sketch(this.spare || this.canvas) : null;
        this.element.classList.toggle("images", !on);
    }

    // The browser has taken its graphics away: a driver was restarted, or the machine has slept.
    lose() {
        if (!this.drawsItself) return;
        this.renderer.dispose();
        // A canvas has one kind of context for ever.
        this.spare = this.paint ? null : h("canvas");
        if (this.spare) this.canvas.after(this.spare);
        this.drawOtherwise(this.spare);
        this.lost = h("div", {class: "lost", role: "status"}, "The browser has lost its graphics. Until they are back, ",
            this.paint ? "the server draws the picture." : "the picture is plainer.");
        this.element.append(this.lost);
        this.changed();
        this.draw();
    }

    restore(context) {
        if (this.drawsItself) return;
        for (const gone of [this.spare, this.lost]) if (gone) gone.remove();
        this.spare = this.lost = this.sketch = null;
        this.element.classList.remove("images");
        this.build(context);
        this.ratio = 0;
        this.arrange();
        this.changed();
    }

    build(context) {
        this.drawsItself = true;
        this.renderer = new WebGLRenderer({canvas: this.canvas, context});
        this.renderer.sortObjects = true;
        this.scene = new Scene();
        this.catoms = new Catoms(this.scene);
        this.strokes = new Strokes(this.scene);
        this.obstacles = new Obstacles(this.scene);
        this.lamps = new Lamps(this.scene);
        this.catoms.shape(0);
    }

    // By a server, which also writes labels.
    get drawnAway() { return !this.drawsItself && !this.sketch; }

    resize() {
        const {clientWidth: width, clientHeight: height} = this.element;
        if (!width || !height) return;
        this.view.resize(width, height);
        this.ratio = 0;
        this.draw();
    }

    show(frame, info) {
        this.ready = true;
        const first = this.frame.count === 0;
        this.frame = frame;
        this.lattice = info.lattice;
        this.flat = info.flat;
        this.bounds = boundsOf(frame);
        if (first) this.home();
        else if (this.bounds) this.view.note(this.around());
        this.arrange();
    }

    // The bounds of what is seen here and beside it.
    around() {
        const other = this.partner && this.partner.bounds, {bounds} = this;
        if (!other || !bounds) return bounds || other;
        return {low: bounds.low.map((x, i) => Math.min(x, other.low[i])), high: bounds.high.map((x, i) => Math.max(x, other.high[i]))};
    }

    // From above where all is in a plane.
    home() {
        Object.assign(this.view, this.flat ? {azimuth: -90, elevation: 90, angle: 0} : {azimuth: -60, elevation: 25, angle: 25});
        this.view.update();
        this.fit();
    }

    fit() {
        this.view.fit(this.around(), this.flat);
        this.draw();
    }

    // What of the frame is drawn.
    arrange() {
        const {frame, cut} = this;
        const beyond = (x) => cut && (cut.above ? x < cut.at : x > cut.at);
        let kept = new Uint32Array(frame.count), count = 0;
        for (let i = 0; i < frame.count; ++i) if (!cut || !beyond(frame.positions[3 * i + cut.axis])) kept[count++] = i;
        kept = kept.subarray(0, count);
        const whole = this.size === 1 && frame.diameters.every((diameter) => diameter === 1);
        const {drawn, cover} = frame.covers ? known(frame, kept) : coverOf(whole ? this.lattice : "", frame, kept, true);
        this.drawn = drawn;
        if (this.drawsItself) {
            this.catoms.size = this.size;
            this.catoms.show(frame, drawn, cover);
            this.strokes.show(frame, this.dark);
            this.obstacles.show(frame, this.dark);
            this.lamps.show(frame);
        }
        this.kept = kept;
        this.shown = kept.length === frame.count ? null : new Set(kept);
        this.mark();
    }

    select(ids) {
        this.selected = ids;
        this.mark();
    }

    mark() {
        const places = [...this.selected].map((id) => placeOf(this.frame,
            id)).filter((place) => place >= 0 && (!this.shown || this.shown.has(place)));
        if (this.drawsItself) this.catoms.select(this.frame, places);
        this.marked = places;
        this.draw();
    }

    draw() {
        this.drawOwn();
        if (this.partner) this.partner.drawOwn();
    }

    drawOwn() {
        // Before there is anything to draw, nothing is: software that draws takes as long for nothing.
        if (this.wanted || !this.ready) return;
        this.wanted = true;
        requestAnimationFrame(() => {
            this.wanted = false;
            if (this.drawsItself) this.drawFast();
            else if (this.sketch) this.sketch.draw(this);
            else this.drawByServer();
            // When the first picture was there, in milliseconds since the page was asked for.
            this.element.dataset.first ||= Math.round(performance.now());
            this.labels.place(this, this.drawnAway);
            clearTimeout(this.later);
            this.later = setTimeout(() => this.drawWell(), 160);
        });
    }

    render(ratio) {
        if (this.ratio !== ratio) {
            this.renderer.setPixelRatio(ratio);
            this.renderer.setSize(this.view.width, this.view.pixels, false);
            this.ratio = ratio;
        }
        this.renderer.setClearColor(this.dark ? 0x14161a : 0xffffff);
        this.catoms.update(this.view);
        this.strokes.update(this.view);
        this.obstacles.update(this.view);
        const begin = performance.now();
        this.renderer.render(this.scene, this.view.camera);
        const pixel = new Uint8Array(4), gl = this.renderer.getContext();
        // Otherwise the time is not known.
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
        return performance.now() - begin;
    }

    drawFast() {
        const most = window.devicePixelRatio || 1;
        this.took = this.render(Math.min(most, this.scale * most));
        this.element.dataset.took = Math.round(this.took);
        if (this.took > 1.5 * FAST) this.scale = Math.max(0.5, this.scale * 0.75);
        else if (this.took < FAST / 2) this.scale = Math.min(1, this.scale * 1.2);
    }

    // Nothing has moved for a while: with more pixels than are shown, and with labels only where their catoms are seen.
    drawWell() {
        const most = window.devicePixelRatio || 1;
        // As good as the last good one was fast.
        const fits = 4 * most * most * this.view.width * this.view.pixels < MOST_PIXELS;
        if (this.drawsItself) this.well = this.render(this.well < SLOW && most < 2 && fits ? 2 * most : most);
        this.labels.place(this, this.drawnAway, true);
        this.element.dataset.pictures = Number(this.element.dataset.pictures || 0) + 1;
    }

    async drawByServer() {
        if (this.painting || !this.paint) {
            this.again = true;
            return;
        }
        this.painting = true;
        try {
            const bytes = await this.paint(this.view.words(), [this.view.width, this.view.pixels]);
            if (bytes) {
                const old = this.picture.src;
                this.picture.src = URL.createObjectURL(new Blob([bytes], {type: "image/png"}));
                if (old) URL.revokeObjectURL(old);
            }
        } finally {
            this.painting = false;
        }
        if (this.again) {
            this.again = false;
            this.draw();
        }
    }

    // The id of the catom at a pixel; null: none.
    at(x, y) {
        const {place} = met(this.frame, this.drawn, this.size, this.view.ray(x, y));
        return place < 0 ? null : this.frame.ids[place];
    }

    // Which side of which catom is at a pixel: its place, and from its middle to where the ray meets it; place -1: none.
    sideAt(x, y) {
        const ray = this.view.ray(x, y), {place, far} = met(this.frame, this.drawn, this.size, ray), p = this.frame.positions;
        if (place < 0) return {place, ray};
        return {place, ray, towards: ["x", "y", "z"].map((axis, i) => ray.from[axis] + far * ray.along[axis] - p[3 * place + i])};
    }

    // Those whose middles are within a rectangle of pixels, also behind others.
    within(x0, y0, x1, y1) {
        const out = [], p = this.frame.positions;
        for (const place of this.kept) {
            const at = this.view.project(p[3 * place], p[3 * place + 1], p[3 * place + 2]);
            if (at.depth > 0 && at.x >= x0 && at.x <= x1 && at.y >= y0 && at.y <= y1) out.push(this.frame.ids[place]);
        }
        return out;
    }

    lookTo(id) {
        const place = placeOf(this.frame, id);
        if (place < 0) return;
        this.view.target.set(...this.frame.positions.subarray(3 * place, 3 * place + 3));
        this.view.update();
        this.draw();
    }
}
