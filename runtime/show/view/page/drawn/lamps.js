// Lamps that stand somewhere: balls that are as bright from all sides.
import {InstancedMesh, Matrix4, MeshBasicMaterial, Quaternion, SphereGeometry, Vector3} from "three";

// As render::kLamp.
export const LAMP = "#ffc61a";

export class Lamps {
    constructor(scene) {
        this.scene = scene;
        this.ball = new SphereGeometry(1, 24, 16);
        this.paint = new MeshBasicMaterial({color: LAMP});
        this.mesh = null;
    }

    show({lamps}) {
        // The version of three that pages come with cannot give back what belongs to the balls together, so as many are used again.
        if (!this.mesh || this.mesh.count !== lamps.length) this.make(lamps.length);
        if (!this.mesh) return;
        lamps.forEach(([x, y, z, radius], i) => this.mesh.setMatrixAt(i,
            new Matrix4().compose(new Vector3(x, y, z), new Quaternion(), new Vector3(radius, radius, radius))));
        this.mesh.instanceMatrix.needsUpdate = true;
    }

    make(count) {
        if (this.mesh) this.scene.remove(this.mesh);
        this.mesh = null;
        if (count === 0) return;
        this.mesh = new InstancedMesh(this.ball, this.paint, count);
        this.mesh.frustumCulled = false;
        this.scene.add(this.mesh);
    }
}
