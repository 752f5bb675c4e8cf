// The picture without WebGL and without a server: forms with plain sides, the farthest first.
import {Quaternion, Vector3} from "three";

import {BODY} from "./block.js";
import {setSun} from "./drawn/catoms.js";
import {LAMP} from "./drawn/lamps.js";
import {solidsOf} from "./drawn/solids.js";

const SIDES = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
const HEXAGON = Array.from({length: 6}, (_, i) => [Math.cos((2 * i + 1) * Math.PI / 6) / Math.sqrt(3), Math.sin((2 * i + 1) * Math.PI / 6)
    / Math.sqrt(3), 0]);
const SPHERE = 0, CUBE = 1, HEX = 3, ROUNDED = 4;

const css = (rgb, light) => `rgb(${[0, 1, 2].map((i) => Math.round(Math.min(255, rgb[i] * light))).join(",")})`;

// The corners of a cube's side, around the middle.
function cornersOf(side) {
    const u = [side[1], side[2], side[0]], v = [side[2], side[0], side[1]];
    return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => side.map((x, i) => (x + a * u[i] + b * v[i]) / 2));
}

// Pixels to a diameter, there.
const pixelsAt = (view, at) => view.parallel ? 1 / view.pixel : view.pixels / (2 * view.tangent * at.depth);

// What of a polygon is before the eye, as it is seen.
function inFront(corners, view) {
    const near = 0.05, seen = corners.map((corner) => view.project(...corner)), out = [];
    seen.forEach((here, i) => {
        const next = (i + 1) % seen.length, {depth} = here, far = seen[next].depth;
        if (depth > near) out.push(here);
        if (depth > near === far > near) return;
        const share = (near - depth) / (far - depth);
        // A little farther, so that rounding does not put it behind the eye.
        out.push(view.project(...corners[i].map((x, axis) => x + (1 + 1e-6) * share * (corners[next][axis] - x))));
    });
    return out;
}

// Of a triangle of an obstacle or a joint: as those that graphics draw (solidFragment in shaders.js).
function shadeOf(corners, view, dark) {
    const [a, b, c] = corners.map((corner) => new Vector3(...corner)), sun = new Vector3();
    const normal = b.sub(a).cross(c.sub(a)).normalize();
    if (normal.dot(view.forward) > 0) normal.negate();
    setSun(sun, view);
    const light = 0.74 * (0.72 + 0.28 * normal.z) + 0.4 * Math.max(0, normal.dot(sun));
    return css(dark ? [77, 77, 77] : [204, 199, 191], light ** (1 / 2.2));
}

export class Sketch {
    constructor(canvas) {
        this.canvas = canvas;
        this.pen = canvas.getContext("2d");
    }

    draw(stage) {
        const {frame, view, dark} = stage, dense = window.devicePixelRatio || 1, {pen, canvas} = this;
        canvas.width = view.width * dense;
        canvas.height = view.pixels * dense;
        pen.setTransform(dense, 0, 0, dense, 0, 0);
        pen.fillStyle = dark ? "#14161a" : "#fff";
        pen.fillRect(0, 0, view.width, view.pixels);
        const p = frame.positions, things = [], marked = new Set(stage.marked);
        for (const place of stage.drawn) {
            const at = view.project(p[3 * place], p[3 * place + 1], p[3 * place + 2]);
            if (at.depth > 0) things.push({depth: at.depth, draw: () => this.catom(stage, place, at, marked.has(place))});
        }
        const {triangles} = frame;
        for (let i = 0; i < triangles.length; i += 9) {
            const corners = [0, 3, 6].map((from) => [...triangles.subarray(i + from, i + from + 3)]), ends = inFront(corners, view);
            // It is behind all that stands on it.
            if (ends.length > 2) things.push({depth: Math.max(...ends.map(({depth}) => depth)),
                draw: () => this.facet(ends, shadeOf(corners, view, dark))});
        }
        for (const [x, y, z, radius] of frame.lamps) {
            const at = view.project(x, y, z);
            if (at.depth > 0) things.push({depth: at.depth, draw: () => this.lamp(view, at, radius)});
        }
        things.sort((a, b) => b.depth - a.depth);
        for (const {draw} of things) draw();
        this.strokes(frame.lines, view, false);
        this.strokes(frame.arrows, view, true);
    }

    catom({frame, view, size}, place, at, marked) {
        const {pen} = this, p = frame.positions, diameter = frame.diameters[place] * size;
        const rgb = frame.colours.subarray(4 * place, 4 * place + 3);
        const scale = pixelsAt(view, at);
        pen.strokeStyle = marked ? "#ff591a" : css(rgb, 0.6);
        pen.lineWidth = marked ? 2.5 : 0.7;
        if (frame.form === BODY && this.body({frame, view, size}, place, rgb, scale)) return;
        if (frame.form === CUBE || frame.form === ROUNDED || frame.form === HEX) {
            const sides = frame.form === HEX ? [[[0, 0, 1], HEXAGON]] : SIDES.map((side) => [side, cornersOf(side)]);
            for (const [side, corners] of sides) {
                const middle = [0, 1, 2].map((i) => p[3 * place + i] + diameter * side[i] / 2);
                const {eye, forward} = view;
                const out = view.parallel ? forward.toArray() : [middle[0] - eye.x, middle[1] - eye.y, middle[2] - eye.z];
                const faces = side.reduce((sum, x, i) => sum + x * out[i], 0);
                if (faces >= 0 && frame.form !== HEX) continue;
                const light = frame.form === HEX ? 1 : 0.78 + 0.2 * side[2] + 0.1 * Math.abs(side[0]);
                this.fill(corners.map((corner) => view.project(...corner.map((x, i) => p[3 * place + i] + diameter * x))), css(rgb, light));
                pen.stroke();
            }
            return;
        }
        this.ball(at, diameter * scale / 2, rgb, frame.form === SPHERE || frame.form === BODY);
    }

    lamp(view, at, radius) {
        const {pen} = this;
        pen.beginPath();
        pen.arc(at.x, at.y, Math.max(1.5, radius * pixelsAt(view, at)), 0, 2 * Math.PI);
        pen.fillStyle = LAMP;
        pen.fill();
    }

    // One that is no sphere: a box or a cylinder without its rounding, or a thick line; false: it is a sphere.
    body(stage, place, rgb, scale) {
        const solids = solidsOf(stage.frame, place);
        if (solids.length === 1) return this.solid(stage, solids[0], rgb, scale);
        const depth = ({at}) => stage.view.project(...at).depth, {strokeStyle, lineWidth} = this.pen;
        for (const solid of solids.sort((a, b) => depth(b) - depth(a))) {
            Object.assign(this.pen, {strokeStyle, lineWidth});
            if (!this.solid(stage, solid, rgb, scale))
                this.ball(stage.view.project(...solid.at), solid.body[3] * stage.size * scale, rgb, true);
        }
        return true;
    }

    // Its radius in pixels; a disc is a ball without a bright side.
    ball(at, radius, rgb, bright) {
        const {pen} = this;
        pen.beginPath();
        pen.arc(at.x, at.y, Math.max(0.6, radius), 0, 2 * Math.PI);
        pen.fillStyle = css(rgb, 0.88);
        pen.fill();
        if (radius > 2) pen.stroke();
        if (!bright || radius < 3) return;
        pen.beginPath();
        pen.arc(at.x - radius * 0.25, at.y - radius * 0.3, radius * 0.5, 0, 2 * Math.PI);
        pen.fillStyle = css(rgb, 1.12);
        pen.fill();
    }

    solid({view, size}, {at, body: [cx, cy, cz, rounding, ...turn]}, rgb, scale) {
        const {pen} = this, middle = new Vector3(...at), own = new Quaternion(...turn);
        const point = ([x, y, z]) => new Vector3(x, y, z).multiplyScalar(size).applyQuaternion(own).add(middle);
        const seen = (v) => view.project(v.x, v.y, v.z);
        if (cx === 0 && cy === 0) {
            if (cz === 0) return false;
            const ends = [-cz, cz].map((z) => seen(point([0, 0, z]))), line = pen.strokeStyle, edge = pen.lineWidth;
            pen.lineCap = "round";
            for (const [colour, more] of [[line, 2 * edge], [css(rgb, 0.88), 0]]) {
                pen.strokeStyle = colour;
                pen.lineWidth = Math.max(1.2, 2 * rounding * size * scale) + more;
                pen.beginPath();
                for (const {x, y} of ends) pen.lineTo(x, y);
                pen.stroke();
            }
            return true;
        }
        const toEye = (out) => view.parallel ? view.forward : out.clone().sub(view.eye);
        if (cy === 0) {
            this.cylinder({radius: cx + rounding, half: cz + rounding}, {point, seen, own, toEye}, rgb);
            return true;
        }
        const half = [cx, cy, cz].map((x) => x + rounding);
        for (const side of SIDES) {
            const out = point(side.map((x, i) => x * half[i])), away = new Vector3(...side).applyQuaternion(own);
            if (away.dot(toEye(out)) >= 0) continue;
            const light = 0.78 + 0.2 * away.z + 0.1 * Math.abs(away.x);
            this.fill(cornersOf(side).map((corner) => seen(point(corner.map((x, i) => 2 * x * half[i])))), css(rgb, light));
            pen.stroke();
        }
        return true;
    }

    // Its side in strips, and the cap that is seen.
    cylinder({radius, half}, {point, seen, own, toEye}, rgb) {
        const count = 24, angles = [...Array(count).keys()].map((i) => 2 * Math.PI * i / count);
        const rim = (angle, z) => point([radius * Math.cos(angle), radius * Math.sin(angle), z]);
        const shade = (away) => css(rgb, 0.78 + 0.2 * away.z + 0.1 * Math.abs(away.x));
        for (const angle of angles) {
            const middle = angle + Math.PI / count, next = angle + 2 * Math.PI / count;
            const away = new Vector3(Math.cos(middle), Math.sin(middle), 0).applyQuaternion(own);
            if (away.dot(toEye(rim(middle, 0))) >= 0) continue;
            this.fill([rim(angle, -half), rim(next, -half), rim(next, half), rim(angle, half)].map(seen), shade(away));
        }
        for (const end of [-1, 1]) {
            const away = new Vector3(0, 0, end).applyQuaternion(own);
            if (away.dot(toEye(point([0, 0, end * half]))) >= 0) continue;
            this.fill(angles.map((angle) => seen(rim(angle, end * half))), shade(away));
            this.pen.stroke();
        }
    }

    fill(ends, colour) {
        const {pen} = this;
        pen.beginPath();
        ends.forEach(({x, y}, i) => i ? pen.lineTo(x, y) : pen.moveTo(x, y));
        pen.closePath();
        pen.fillStyle = colour;
        pen.fill();
    }

    // One of many beside each other, between which nothing may shine through.
    facet(ends, colour) {
        const {pen} = this;
        this.fill(ends, colour);
        pen.strokeStyle = colour;
        pen.lineWidth = 0.7;
        pen.stroke();
    }

    strokes({count, ends, colours}, view, arrows) {
        const {pen} = this;
        pen.lineWidth = 1.5;
        for (let i = 0; i < count; ++i) {
            const [from, to] = [0, 3].map((at) => view.project(...ends.subarray(6 * i + at, 6 * i + at + 3)));
            if (from.depth <= 0 || to.depth <= 0) continue;
            const colour = pen.strokeStyle = css(colours.subarray(4 * i, 4 * i + 3), 1);
            pen.beginPath();
            pen.moveTo(from.x, from.y);
            pen.lineTo(to.x, to.y);
            pen.stroke();
            const far = Math.hypot(to.x - from.x, to.y - from.y);
            if (!arrows || far < 1) continue;
            const [u, v] = [(to.x - from.x) / far, (to.y - from.y) / far], head = Math.min(9, far / 2), wide = head / 2;
            const back = {x: to.x - head * u, y: to.y - head * v};
            this.fill([to, {x: back.x - wide * v, y: back.y + wide * u}, {x: back.x + wide * v, y: back.y - wide * u}], colour);
        }
    }
}
