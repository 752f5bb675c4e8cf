// Lines and arrows between catoms.
import {BufferGeometry, Mesh, RawShaderMaterial} from "three";

import {cornersOf} from "./corners.js";
import {strokeFragment, strokeVertex} from "./shaders.js";

// Of a line two triangles; of an arrow also its head.
const LINE_CORNERS = 6, ARROW_CORNERS = 9;

const isDarkGrey = (red, green, blue) => red + green + blue < 240 && Math.max(red, green, blue) - Math.min(red, green, blue) < 30;

function geometryOf({count, ends, colours}, corners, dark) {
    const begin = new Float32Array(3 * count), end = new Float32Array(3 * count), shades = new Uint8Array(colours);
    for (let i = 0; i < count; ++i) {
        begin.set(ends.subarray(6 * i, 6 * i + 3), 3 * i);
        end.set(ends.subarray(6 * i + 3, 6 * i + 6), 3 * i);
        // Dark grey on a dark ground is not seen; other colours mean something.
        if (dark && isDarkGrey(shades[4 * i], shades[4 * i + 1], shades[4 * i + 2])) shades.set([215, 215, 220], 4 * i);
    }
    return cornersOf(corners, {position: [begin, 3, false], end: [end, 3, false], colour: [shades, 4, true]});
}

export class Strokes {
    constructor(scene) {
        this.meshes = [LINE_CORNERS, ARROW_CORNERS].map((corners) => {
            const uniforms = {parallel: {value: false}, pixel_at_one: {value: 0.01}, corners: {value: corners}};
            const material = new RawShaderMaterial({vertexShader: strokeVertex, fragmentShader: strokeFragment, uniforms, side: 2});
            const mesh = new Mesh(new BufferGeometry(), material);
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
            if (mesh.visible) mesh.geometry = geometryOf(strokes, mesh.material.uniforms.corners.value, dark);
        });
    }

    update(view) {
        for (const {material: {uniforms}} of this.meshes) {
            uniforms.parallel.value = view.parallel;
            uniforms.pixel_at_one.value = view.parallel ? view.pixel : 2 * view.tangent / view.pixels;
        }
    }
}
