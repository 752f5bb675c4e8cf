// From where the stage is seen: angles as of runtime/show/render/camera.h, what is in the middle, and how far it reaches from there
// upwards.
import {Matrix4, PerspectiveCamera, Vector3} from "three";

const radians = (degrees) => degrees * Math.PI / 180;

export class View {
    constructor() {
        this.azimuth = -60;
        this.elevation = 25;
        this.angle = 25;  // 0: parallel rays.
        this.target = new Vector3();
        this.height = 10;
        this.radius = 10;  // Of what there is to see, around `middle`.
        this.middle = new Vector3();
        this.camera = new PerspectiveCamera();
        this.camera.matrixAutoUpdate = false;
        this.width = 1;
        this.pixels = 1;
        this.update();
    }

    resize(width, height) {
        this.width = width;
        this.pixels = height;
        this.update();
    }

    get parallel() { return this.angle === 0; }
    get tangent() { return Math.tan(radians(this.angle) / 2); }
    // Of the eye from the target.
    get distance() { return this.parallel ? this.radius * 3 + this.height : this.height / this.tangent; }

    update() {
        const turn = radians(this.azimuth), tilt = radians(this.elevation);
        this.forward = new Vector3(-Math.cos(turn) * Math.cos(tilt), -Math.sin(turn) * Math.cos(tilt), -Math.sin(tilt));
        this.right = new Vector3(-Math.sin(turn), Math.cos(turn), 0);
        this.up = new Vector3().crossVectors(this.right, this.forward);
        // All that there is lies between the planes.
        const away = this.target.distanceTo(this.middle) + this.radius;
        if (this.parallel) this.back = Math.max(this.distance, away + 1);
        else this.back = this.distance;
        this.eye = this.target.clone().addScaledVector(this.forward, -this.back);
        const depth = this.middle.clone().sub(this.eye).dot(this.forward);
        const near = Math.max(depth - this.radius, this.parallel ? 0.01 : Math.min(this.back * 0.02, 1)),
            far = Math.max(depth + this.radius, 2 * near);
        const aspect = this.width / this.pixels;
        const {camera} = this;
        camera.matrix.makeBasis(this.right, this.up, this.forward.clone().negate()).setPosition(this.eye);
        camera.matrixWorld.copy(camera.matrix);
        camera.matrixWorldInverse.getInverse(camera.matrix);
        if (this.parallel) camera.projectionMatrix.makeOrthographic(-this.height * aspect, this.height * aspect, this.height,
            -this.height, near, far);
        else {
            const top = near * this.tangent;
            camera.projectionMatrix.makePerspective(-top * aspect, top * aspect, top, -top, near, far);
        }
        camera.projectionMatrixInverse.getInverse(camera.projectionMatrix);
        this.whole = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    }

    // Diameters to a pixel, where the target is.
    get pixel() { return 2 * this.height / this.pixels; }

    orbit(dx, dy) {
        this.azimuth -= 0.4 * dx;
        this.elevation = Math.min(90, Math.max(-90, this.elevation + 0.4 * dy));
        this.update();
    }

    pan(dx, dy) {
        this.target.addScaledVector(this.right, -dx * this.pixel).addScaledVector(this.up, dy * this.pixel);
        this.update();
    }

    // Towards what is at a place of the picture.
    zoom(factor, x, y) {
        const before = this.pixel;
        this.height = Math.min(Math.max(this.height / factor, 0.2), 1e5);
        const moved = before - this.pixel;
        this.target.addScaledVector(this.right, (x - this.width / 2) * moved).addScaledVector(this.up, -(y - this.pixels / 2) * moved);
        this.update();
    }

    // Everything within these bounds is seen; `free` are the parts of the picture left and right that other things cover.
    fit(bounds, flat) {
        if (!bounds) bounds = {low: [-5, -5, -5], high: [5, 5, 5]};
        this.note(bounds);
        this.target.copy(this.middle);
        const aspect = this.width / this.pixels;
        let width = 0, height = 0;
        const at = new Vector3();
        for (let corner = 0; corner < 8; ++corner) {
            at.set(...[0, 1, 2].map((axis) => (corner >> axis & 1 ? bounds.high : bounds.low)[axis])).sub(this.middle);
            const depth = this.parallel || flat ? 0 : -at.dot(this.forward) * this.tangent;
            width = Math.max(width, Math.abs(at.dot(this.right)) + Math.max(0, depth * aspect));
            height = Math.max(height, Math.abs(at.dot(this.up)) + Math.max(0, depth));
        }
        this.height = 1.12 * Math.max(height + 0.8, (width + 0.8) / aspect);
        this.update();
    }

    // How far there is something to see.
    note({low, high}) {
        this.middle.set(...low.map((x, i) => (x + high[i]) / 2));
        this.radius = Math.hypot(...low.map((x, i) => (high[i] - x) / 2)) + 1.5;
        this.update();
    }

    // In pixels from the upper left corner; `depth` is how far it is along the view.
    project(x, y, z) {
        const dx = x - this.eye.x, dy = y - this.eye.y, dz = z - this.eye.z;
        const along = (v) => dx * v.x + dy * v.y + dz * v.z;
        const depth = along(this.forward), half = this.parallel ? this.height : this.tangent * depth;
        return {x: this.width / 2 + along(this.right) / half * this.pixels / 2,
            y: this.pixels / 2 - along(this.up) / half * this.pixels / 2, depth};
    }

    // Through a pixel; `along` has length 1.
    ray(x, y) {
        const u = (x - this.width / 2) * 2 / this.pixels, v = 1 - 2 * y / this.pixels;
        const aside = this.right.clone().multiplyScalar(u).addScaledVector(this.up, v);
        if (this.parallel) return {from: this.eye.clone().addScaledVector(aside, this.height), along: this.forward.clone()};
        return {from: this.eye.clone(), along: this.forward.clone().addScaledVector(aside, this.tangent).normalize()};
    }

    // As the server's pictures want it.
    words() {
        return {azimuth: this.azimuth, elevation: this.elevation, angle: this.angle, target: this.target.toArray(), height: this.height};
    }
}
