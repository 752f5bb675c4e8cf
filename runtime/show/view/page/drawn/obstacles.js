// What stands in the way of bodies, and the floor.
import {BufferAttribute, BufferGeometry, Mesh, RawShaderMaterial, Vector3} from "three";

import {setSun} from "./catoms.js";
import {solidFragment, solidVertex} from "./shaders.js";

export class Obstacles {
    constructor(scene) {
        const uniforms = {sun: {value: new Vector3(0, 0, 1)}, forward: {value: new Vector3(0, 0, 1)}, paint: {value: new Vector3()}};
        const material = new RawShaderMaterial({vertexShader: solidVertex, fragmentShader: solidFragment, uniforms, side: 2});
        this.mesh = new Mesh(new BufferGeometry(), material);
        this.mesh.frustumCulled = false;
        this.mesh.visible = false;
        scene.add(this.mesh);
    }

    show({triangles}, dark) {
        this.mesh.geometry.dispose();
        this.mesh.visible = triangles.length > 0;
        if (!this.mesh.visible) return;
        this.mesh.geometry = new BufferGeometry();
        this.mesh.geometry.setAttribute("position", new BufferAttribute(triangles, 3));
        this.mesh.material.uniforms.paint.value.set(...(dark ? [0.3, 0.3, 0.3] : [0.8, 0.78, 0.75]));
    }

    update(view) {
        const {uniforms} = this.mesh.material;
        setSun(uniforms.sun.value, view);
        uniforms.forward.value.copy(view.forward);
    }
}
