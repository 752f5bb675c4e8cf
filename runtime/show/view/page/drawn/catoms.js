// Catoms as the graphics processor draws them, and which of them a ray meets.
import {Mesh, Quaternion, RawShaderMaterial, Vector3} from "three";

import {emptyFrame} from "../block.js";
import {cornersOf} from "./corners.js";
import {catomFragment, catomVertex, haloFragment, reaches} from "./shaders.js";
import {reachOfBody, solidsOf} from "./solids.js";

// So many that are selected shine through what is in front of them.
const MOST_VEILED = 60;
// Of the triangle in front of a catom.
const CORNERS = 3;

// Where the light comes from, as in runtime/show/render/paint.cpp.
export const setSun = (sun, view) => sun.set(0, 0, 0.9).addScaledVector(view.right, -0.5).addScaledVector(view.forward, -0.45).normalize();

// The solids of bodies at these places of a frame, each as a catom of its own in a frame without compounds.
function apart(frame, places, cover) {
    const solids = [...places].flatMap((place, i) => solidsOf(frame, place).map((solid) => ({...solid, place, i})));
    const count = solids.length, out = {positions: new Float32Array(3 * count), diameters: new Float32Array(count),
        colours: new Uint8Array(4 * count), bodies: new Float32Array(8 * count), compounds: []};
    const covers = new Float32Array(4 * count);
    solids.forEach(({at, body, place, i}, to) => {
        out.positions.set(at, 3 * to);
        out.diameters[to] = frame.diameters[place];
        out.colours.set(frame.colours.subarray(4 * place, 4 * place + 4), 4 * to);
        out.bodies.set(body, 8 * to);
        for (let k = 0; k < 4; ++k) covers[4 * to + k] = cover[4 * i + k];
    });
    return gathered(out, solids.map((_, to) => to), covers);
}

// The catoms at these places of a frame.
function gathered(frame, places, cover) {
    if (frame.bodies && frame.compounds.length > 0) return apart(frame, places, cover);
    const count = places.length, at = new Float32Array(4 * count), colours = new Uint8Array(4 * count), shade = new Int8Array(4 * count);
    for (let i = 0; i < count; ++i) {
        const from = places[i];
        at[4 * i] = frame.positions[3 * from];
        at[4 * i + 1] = frame.positions[3 * from + 1];
        at[4 * i + 2] = frame.positions[3 * from + 2];
        at[4 * i + 3] = frame.diameters[from];
        colours[4 * i] = frame.colours[4 * from];
        colours[4 * i + 1] = frame.colours[4 * from + 1];
        colours[4 * i + 2] = frame.colours[4 * from + 2];
        colours[4 * i + 3] = 255;
    }
    // It lies between -1 and 1.
    for (let i = 0; i < 4 * count; ++i) shade[i] = Math.round(127 * cover[i]);
    const arrays = {position: [at, 4, false], colour: [colours, 4, true], cover: [shade, 4, true]};
    if (frame.bodies) {
        const part = (from) => {
            const out = new Float32Array(4 * count);
            for (let i = 0; i < count; ++i) out.set(frame.bodies.subarray(8 * places[i] + from, 8 * places[i] + from + 4), 4 * i);
            return out;
        };
        Object.assign(arrays, {core: [part(0), 4, false], turn: [part(4), 4, false]});
    }
    return cornersOf(CORNERS, arrays);
}

export class Catoms {
    constructor(scene) {
        this.scene = scene;
        this.meshes = [];
        this.size = 1;
        this.form = -1;
    }

    uniforms(more) {
        return {parallel: {value: false}, reach: {value: reaches[this.form]}, size: {value: this.size}, ...more};
    }

    mesh(order, fragment, more, options) {
        const material = new RawShaderMaterial({vertexShader: catomVertex(this.form), fragmentShader: fragment(this.form),
            uniforms: this.uniforms(more), ...options});
        const mesh = new Mesh(gathered(emptyFrame(), [], []), material);
        mesh.frustumCulled = false;
        mesh.renderOrder = order;
        this.scene.add(mesh);
        return mesh;
    }

    shape(form) {
        if (form === this.form) return;
        this.form = form;
        for (const mesh of this.meshes) {
            this.scene.remove(mesh);
            mesh.material.dispose();
            mesh.geometry.dispose();
        }
        const accent = () => ({accent: {value: new Vector3(1, 0.35, 0.1)}});
        this.solid = this.mesh(0, catomFragment, {sun: {value: new Vector3(0, 0, 1)}}, {});
        this.halo = this.mesh(1, haloFragment, {...accent(), strength: {value: 1}}, {});
        this.veil = this.mesh(2, haloFragment, {...accent(), strength: {value: 0.3}}, {transparent: true, depthTest: false,
            depthWrite: false});
        this.meshes = [this.solid, this.halo, this.veil];
    }

    show(frame, drawn, cover) {
        this.shape(frame.form);
        this.solid.geometry.dispose();
        this.solid.geometry = gathered(frame, drawn, cover);
    }

    select(frame, places) {
        const geometry = gathered(frame, places, new Float32Array(4 * places.length));
        this.halo.geometry.dispose();
        for (const mesh of [this.halo, this.veil]) {
            mesh.geometry = geometry;
            mesh.visible = places.length > 0;
        }
        // Many over each other would be a wall before everything.
        this.veil.visible = places.length > 0 && places.length <= MOST_VEILED;
    }

    update(view) {
        for (const mesh of this.meshes) {
            mesh.material.uniforms.parallel.value = view.parallel;
            mesh.material.uniforms.size.value = this.size * (mesh === this.solid ? 1 : mesh === this.halo ? 1.22 : 1.05);
        }
        if (this.solid)
            setSun(this.solid.material.uniforms.sun.value, view);
    }
}

// How far along a ray a catom's form begins, in the ray's length; Infinity: it misses. `x`, `y`, `z`: the ray's start from its middle.
function meeting(form, radius, x, y, z, along) {
    const {x: dx, y: dy, z: dz} = along;
    if (form === 0) {
        const middle = -(x * dx + y * dy + z * dz), rest = radius * radius - (x * x + y * y + z * z - middle * middle);
        return rest < 0 ? Infinity : middle - Math.sqrt(rest);
    }
    // Rounded ones as cubes.
    const box = form === 1 || form === 4, high = box ? radius : 0.3 * radius;
    let enters = -Infinity, leaves = Infinity;
    const slab = (from, way, half) => {
        if (Math.abs(way) < 1e-9) {
            if (Math.abs(from) > half) enters = Infinity;
            return;
        }
        const a = (-half - from) / way, b = (half - from) / way;
        enters = Math.max(enters, Math.min(a, b));
        leaves = Math.min(leaves, Math.max(a, b));
    };
    slab(z, dz, high);
    if (form === 2) {
        const at = enters, px = x + at * dx, py = y + at * dy;
        return px * px + py * py <= radius * radius ? at : Infinity;
    }
    slab(x, dx, radius);
    if (box) slab(y, dy, radius);
    else for (const s of [0.5, -0.5]) slab(s * x + 0.8660254 * y, s * dx + 0.8660254 * dy, radius);
    return enters <= leaves ? enters : Infinity;
}

// The same of a body that is no sphere, as a box: the ray is turned into its frame.
function meetingBody([cx, cy, cz, rounding, qx, qy, qz, qw], size, from, along) {
    const own = (v) => v.clone().applyQuaternion(new Quaternion(-qx, -qy, -qz, qw));
    const begin = own(from), way = own(along);
    // Of a cylinder, the box around it.
    const half = new Vector3(cx, cx > 0 && cy === 0 ? cx : cy, cz).addScalar(rounding).multiplyScalar(size);
    let enters = -Infinity, leaves = Infinity;
    for (const axis of ["x", "y", "z"]) {
        const slope = 1 / (Math.abs(way[axis]) < 1e-9 ? 1e-9 : way[axis]);
        const a = (-half[axis] - begin[axis]) * slope, b = (half[axis] - begin[axis]) * slope;
        enters = Math.max(enters, Math.min(a, b));
        leaves = Math.min(leaves, Math.max(a, b));
    }
    return enters <= leaves ? enters : Infinity;
}

// How far a catom reaches from its middle, at most.
function reachOf(frame, place, size) {
    if (!frame.bodies) return 0.5 * size * frame.diameters[place];
    return size * reachOfBody(frame, place);
}

// The place in the frame of the catom that a ray meets first, and how far it is; -1: none.
export function met(frame, drawn, size, {from, along}) {
    let place = -1, nearest = Infinity;
    const at = frame.positions;
    for (let i = 0; i < drawn.length; ++i) {
        const p = drawn[i], x = from.x - at[3 * p], y = from.y - at[3 * p + 1], z = from.z - at[3 * p + 2];
        const middle = -(x * along.x + y * along.y + z * along.z), radius = reachOf(frame, p, size);
        // Those that the ray passes by.
        if (x * x + y * y + z * z - middle * middle > 3.1 * radius * radius) continue;
        const far = frame.bodies ? Math.min(...solidsOf(frame, p).map(({at: [sx, sy, sz], body}) =>
            meetingBody(body, size, new Vector3(from.x - sx, from.y - sy, from.z - sz), along)))
            : meeting(frame.form, radius, x, y, z, along);
        if (far < nearest && far > 0) {
            nearest = far;
            place = p;
        }
    }
    return {place, far: nearest};
}
