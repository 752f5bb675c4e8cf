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
        if (this.mesh) {
            this.scene.remove(this.mesh);
            this.mesh.dispose();
        }
        this.mesh = null;
        if (lamps.length === 0) return;
        this.mesh = new InstancedMesh(this.ball, this.paint, lamps.length);
        this.mesh.frustumCulled = false;
        lamps.forEach(([x, y, z, radius], i) => this.mesh.setMatrixAt(i,
            new Matrix4().compose(new Vector3(x, y, z), new Quaternion(), new Vector3(radius, radius, radius))));
        this.scene.add(this.mesh);
    }
}
