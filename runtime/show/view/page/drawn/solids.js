// What bodies that are no spheres consist of: themselves, or the solids of their compound.
import {Quaternion, Vector3} from "three";

// Of the body at a place of a frame: the middles of its solids, and half the edges of their cores, their roundings, and how they are turned
// (8 numbers).
export function solidsOf(frame, place) {
    const own = frame.bodies.subarray(8 * place, 8 * place + 8), middle = frame.positions.subarray(3 * place, 3 * place + 3);
    const solids = own[3] < 0 ? frame.compounds[-own[3] - 1] : null;
    if (!solids) return [{at: middle, body: own}];
    const turn = new Quaternion(...own.subarray(4));
    return solids.map(([cx, cy, cz, rounding, x, y, z, ...turned]) => {
        const way = new Vector3(x, y, z).applyQuaternion(turn), whole = turn.clone().multiply(new Quaternion(...turned));
        return {at: [middle[0] + way.x, middle[1] + way.y, middle[2] + way.z],
            body: [cx, cy, cz, rounding, whole.x, whole.y, whole.z, whole.w]};
    });
}

// How far the body at a place reaches from its middle, at most.
export function reachOfBody(frame, place) {
    const [x, y, z, rounding] = frame.bodies.subarray(8 * place, 8 * place + 4);
    return rounding < 0 ? x : Math.hypot(x, y, z) + rounding;
}
