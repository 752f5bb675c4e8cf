// Lines and arrows between catoms.
import {BufferAttribute, InstancedBufferAttribute, InstancedBufferGeometry, Mesh, RawShaderMaterial} from "three";

import {strokeFragment, strokeVertex} from "./shaders.js";

const SHAFT = [[0, -1, 1], [0, 1, 1], [1, -1, 1], [1, 1, 1]];
const HEAD = [[1, -1, 3], [1, 1, 3], [2, 0, 0]];

function geometryOf({count, ends, colours}, arrows, dark) {
    const out = new InstancedBufferGeometry();
    // three.js draws nothing without an attribute of this name.
    out.setAttribute("position", new BufferAttribute(new Float32Array((arrows ? [...SHAFT, ...HEAD] : SHAFT).flat()), 3));
    out.setIndex(arrows ? [0, 1, 2, 1, 3, 2, 4, 5, 6] : [0, 1, 2, 1, 3, 2]);
    const begin = new Float32Array(3 * count), end = new Float32Array(3 * count), shades = new Uint8Array(colours);
    for (let i = 0; i < count; ++i) {
        begin.set(ends.subarray(6 * i, 6 * i + 3), 3 * i);
        end.set(ends.subarray(6 * i + 3, 6 * i + 6), 3 * i);
        // Dark grey on a dark ground is not seen.
        if (dark && shades[4 * i] + shades[4 * i + 1] + shades[4 * i + 2] < 240) shades.set([215, 215, 220], 4 * i);
    }
    for (const [name, array, size, normalized] of [["begin", begin, 3, false], ["end", end, 3, false], ["colour", shades, 4, true]])
        out.setAttribute(name, new InstancedBufferAttribute(array, size, normalized));
    out.maxInstancedCount = count;
    return out;
}

export class Strokes {
    constructor(scene) {
        this.meshes = [false, true].map((arrows) => {
            const uniforms = {parallel: {value: false}, pixel_at_one: {value: 0.01}, head_part: {value: arrows ? 1 : 0}};
            const material = new RawShaderMaterial({vertexShader: strokeVertex, fragmentShader: strokeFragment, uniforms, side: 2});
            const mesh = new Mesh(new InstancedBufferGeometry(), material);
            mesh.frustumCulled = false;
            mesh.visible = false;
            scene.add(mesh);
            return mesh;
        });
    }

    show({lines, arrows}, dark) {
        [lines, arrows].forEach((strokes, i) => {
            const mesh = this.meshes[i];
            mesh.geometry.dispose();
            mesh.visible = strokes.count > 0;
            if (mesh.visible) mesh.geometry = geometryOf(strokes, i === 1, dark);
        });
    }

    update(view) {
        for (const {material: {uniforms}} of this.meshes) {
            uniforms.parallel.value = view.parallel;
            uniforms.pixel_at_one.value = view.parallel ? view.pixel : 2 * view.tangent / view.pixels;
        }
    }
}
