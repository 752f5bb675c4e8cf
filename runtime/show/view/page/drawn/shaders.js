// What the graphics processor does: a triangle is put in front of each catom, and each of its pixels sends a ray at the catom's true form.
// Units: within a catom its diameter. The light is that of runtime/show/render/paint.cpp, but for shadows: neighbours darken instead.
import {BODY} from "../block.js";

// Bodies have rays of their own, along their own axes.
export const catomVertex = (form) => `#version 300 es
${form === BODY ? "#define BODY" : ""}
precision highp float;
uniform mat4 viewMatrix, projectionMatrix;
uniform bool parallel;
uniform float reach, size;
in vec4 position;  // Of the middle; and the diameter.
in vec4 colour, cover;
out vec3 from, along;  // The ray, from the catom's middle, along the axes of the world.
out vec3 seen;         // The same along the axes of the view.
flat out vec3 paint;
flat out vec4 covered;
flat out float across;
#ifdef BODY
in vec4 core, turn;
flat out vec4 kernel, turned;
#endif
const vec2 corners[3] = vec2[3](vec2(-1.7321, -1.0), vec2(1.7321, -1.0), vec2(0.0, 2.0));
void main() {
    vec2 corner = corners[gl_VertexID % 3];
    vec3 middle = (viewMatrix * vec4(position.xyz, 1.0)).xyz;
    mat3 back = transpose(mat3(viewMatrix));
    across = position.w * size;
    float radius = across * reach;
#ifdef BODY
    across = size;
    radius = size * (length(core.xyz) + core.w);
    kernel = core;
    turned = turn;
#endif
    if (parallel) {
        seen = middle + vec3(corner * radius, 0.0);
        from = back * (seen - middle) / across;
        along = back * vec3(0.0, 0.0, -1.0) / across;
    } else {
        float far = length(middle);
        vec3 towards = middle / far, u = normalize(cross(towards, vec3(0.0, 1.0, 0.0))), v = cross(u, towards);
        float wide = radius * inversesqrt(max(0.01, 1.0 - radius * radius / (far * far)));
        seen = middle + wide * (corner.x * u + corner.y * v);
        from = back * -middle / across;
        along = back * seen / across;
    }
    paint = pow(colour.rgb, vec3(2.2));
    covered = cover;
    gl_Position = projectionMatrix * vec4(seen, 1.0);
}`;

// Where the ray meets the form: the nearest and the farthest place, as multiples of `along`; false: nowhere.
const forms = [`
bool meets(out vec2 t, out vec3 normal) {
    float square = dot(along, along), middle = -dot(from, along) / square;
    vec3 nearest = from + middle * along;
    float rest = 0.25 - dot(nearest, nearest);
    if (rest < 0.0) return false;
    t = middle + vec2(-1.0, 1.0) * sqrt(rest / square);
    normal = 2.0 * (from + t.x * along);
    return true;
}
float outlined(vec3 at, vec3 normal) {
    return mix(0.72, 1.0, smoothstep(0.0, 0.4, dot(normal, -normalize(along))));
}`, `
bool meets(out vec2 t, out vec3 normal) {
    vec3 inverse = 1.0 / along, a = (-0.5 - from) * inverse, b = (0.5 - from) * inverse;
    vec3 enters = min(a, b), leaves = max(a, b);
    t = vec2(max(max(enters.x, enters.y), enters.z), min(min(leaves.x, leaves.y), leaves.z));
    if (t.x > t.y) return false;
    // Edges are a little round.
    vec3 at = 2.0 * (from + t.x * along);
    normal = normalize(sign(at) * pow(abs(at), vec3(24.0)));
    return true;
}
float outlined(vec3 at, vec3 normal) {
    vec3 a = 2.0 * abs(at);
    float second = max(min(a.x, a.y), min(max(a.x, a.y), a.z));
    return 1.0 - 0.38 * smoothstep(0.9, 1.0, second);
}`, `
bool meets(out vec2 t, out vec3 normal) {
    float square = dot(along.xy, along.xy), high = 0.15;
    vec2 flat_ = (vec2(-high, high) - from.z) / along.z;
    vec2 slab = vec2(min(flat_.x, flat_.y), max(flat_.x, flat_.y)), round_ = vec2(-1e9, 1e9);
    float middle = -dot(from.xy, along.xy) / max(square, 1e-12);
    vec2 nearest = from.xy + middle * along.xy;
    float rest = 0.2401 - dot(nearest, nearest);
    if (rest < 0.0) return false;
    if (square > 1e-12) round_ = middle + vec2(-1.0, 1.0) * sqrt(rest / square);
    t = vec2(max(slab.x, round_.x), min(slab.y, round_.y));
    if (t.x > t.y) return false;
    normal = slab.x > round_.x ? vec3(0.0, 0.0, -sign(along.z)) : vec3(normalize((from + t.x * along).xy), 0.0);
    return true;
}
float outlined(vec3 at, vec3 normal) { return 1.0 - 0.35 * smoothstep(0.45, 0.49, length(at.xy)); }`, `
const vec2 sides[3] = vec2[3](vec2(1.0, 0.0), vec2(0.5, 0.8660254), vec2(-0.5, 0.8660254));
bool meets(out vec2 t, out vec3 normal) {
    float high = 0.15;
    vec2 slab = (vec2(-high, high) - from.z) / along.z;
    t = vec2(min(slab.x, slab.y), max(slab.x, slab.y));
    normal = vec3(0.0, 0.0, -sign(along.z));
    for (int i = 0; i < 3; ++i) {
        float o = dot(from.xy, sides[i]), d = dot(along.xy, sides[i]);
        vec2 s = (vec2(-0.5, 0.5) - o) / (abs(d) < 1e-9 ? 1e-9 : d);
        float enters = min(s.x, s.y);
        if (enters > t.x) {
            t.x = enters;
            normal = vec3(-sign(d) * sides[i], 0.0);
        }
        t.y = min(t.y, max(s.x, s.y));
    }
    return t.x <= t.y;
}
float outlined(vec3 at, vec3 normal) {
    float far = 0.0;
    for (int i = 0; i < 3; ++i) far = max(far, abs(dot(at.xy, sides[i])));
    return 1.0 - 0.4 * smoothstep(0.44, 0.5, far);
}`, `
// A box whose edges are round: as far as the distance to it says, again and again.
const float round_ = 0.13;
vec3 beyond(vec3 at) { return max(abs(at) - (0.5 - round_), 0.0); }
bool meets(out vec2 t, out vec3 normal) {
    vec3 inverse = 1.0 / along, a = (-0.5 - from) * inverse, b = (0.5 - from) * inverse;
    vec3 enters = min(a, b), leaves = max(a, b);
    t = vec2(max(max(enters.x, enters.y), enters.z), min(min(leaves.x, leaves.y), leaves.z));
    float length_ = length(along), gap = 1.0;
    for (int i = 0; i < 24 && t.x <= t.y; ++i) {
        gap = length(beyond(from + t.x * along)) - round_;
        if (gap < 0.001) break;
        t.x += gap / length_;
    }
    if (t.x > t.y || gap >= 0.01) return false;
    vec3 at = from + t.x * along;
    normal = normalize(sign(at) * (beyond(at) + 1e-6));
    return true;
}
float outlined(vec3 at, vec3 normal) {
    vec3 bend = beyond(at);
    return 1.0 - 0.3 * smoothstep(0.0, 0.13, length(bend) - max(max(bend.x, bend.y), bend.z));
}`, `
// A box, a cylinder or a line, its edges rounded, turned about its middle. A cylinder has its radius as x, and no y.
flat in vec4 kernel, turned;
vec3 spun(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
vec3 own(vec3 v) { return spun(vec4(-turned.xyz, turned.w), v); }
bool isCylinder() { return kernel.x > 0.0 && kernel.y == 0.0; }
vec3 beyond(vec3 at) {
    vec3 bend = max(abs(at) - kernel.xyz, 0.0);
    float away = length(at.xy);
    return isCylinder() ? vec3(abs(at.xy) * (max(away - kernel.x, 0.0) / max(away, 1e-9)), bend.z) : bend;
}
// How far out of the outer faces: a cylinder has its side, as x, and its caps.
vec3 outside(vec3 at) {
    vec3 side = abs(at) - kernel.xyz - kernel.w;
    return isCylinder() ? vec3(length(at.xy) - kernel.x - kernel.w, -1e3, side.z) : side;
}
bool meets(out vec2 t, out vec3 normal) {
    bool cylinder = isCylinder();
    vec3 begin = own(from), way = own(along), outer = (cylinder ? kernel.xxz : kernel.xyz) + kernel.w;
    vec3 inverse = 1.0 / way, a = (-outer - begin) * inverse, b = (outer - begin) * inverse;
    vec3 enters = min(a, b), leaves = max(a, b);
    t = vec2(max(max(enters.x, enters.y), enters.z), min(min(leaves.x, leaves.y), leaves.z));
    if (cylinder) {
        float square = max(dot(way.xy, way.xy), 1e-12), middle = -dot(begin.xy, way.xy) / square;
        vec2 nearest = begin.xy + middle * way.xy;
        float rest = outer.x * outer.x - dot(nearest, nearest);
        if (rest < 0.0) return false;
        float wide = sqrt(rest / square);
        t = vec2(max(enters.z, middle - wide), min(leaves.z, middle + wide));
    }
    float length_ = length(way), gap = 0.0, small = 0.002 * max(max(outer.x, outer.y), outer.z);
    for (int i = 0; i < 32 && t.x <= t.y; ++i) {
        gap = length(beyond(begin + t.x * way)) - kernel.w;
        if (gap < 0.5 * small) break;
        t.x += gap / length_;
    }
    if (t.x > t.y || gap >= 4.0 * small) return false;
    vec3 at = begin + t.x * way, bend = beyond(at), side = outside(at);
    float most = max(max(side.x, side.y), side.z);
    vec3 straight = vec3(greaterThanEqual(side, vec3(most)));
    if (cylinder && straight.x > 0.0) straight = vec3(abs(at.xy) / max(length(at.xy), 1e-9), 0.0);
    normal = spun(turned, normalize(sign(at) * (length(bend) > 0.5 * kernel.w && kernel.w > 0.0 ? bend : straight)));
    return true;
}
float outlined(vec3 at, vec3 normal) {
    float rim = mix(0.72, 1.0, smoothstep(0.0, 0.4, dot(normal, -normalize(along))));
    if (kernel.x <= 0.0) return rim;
    vec3 near_ = outside(own(at));
    float most = max(max(near_.x, near_.y), near_.z), least = min(min(near_.x, near_.y), near_.z);
    float second = near_.x + near_.y + near_.z - most - least;
    float wide = 0.06 * (min(min(kernel.x, isCylinder() ? kernel.x : kernel.y), kernel.z) + kernel.w);
    return 1.0 - 0.38 * smoothstep(-2.0 * wide, 0.0, second);
}`];

// How far the forms reach from their middles.
export const reaches = [0.5, 0.867, 0.53, 0.6, 0.78, 1];

const head = `#version 300 es
precision highp float;
uniform mat4 projectionMatrix;
uniform bool parallel;
in vec3 from, along, seen;
flat in vec3 paint;
flat in vec4 covered;
flat in float across;
out vec4 pixel;
void put_depth(float t) {
    float z = parallel ? seen.z - t : seen.z * t;
    vec2 clip = z * projectionMatrix[2].zw + projectionMatrix[3].zw;
    gl_FragDepth = 0.5 * clip.x / clip.y + 0.5;
}`;

export const catomFragment = (form) => `${head}
uniform vec3 sun;
${forms[form]}
void main() {
    vec2 t;
    vec3 normal;
    if (!meets(t, normal)) discard;
    if (t.x < 0.0 && !parallel) discard;
    vec3 at = from + t.x * along;
    // Half of each neighbour's light: its share of the sky, as a cosine.
    float blocked = covered.w + dot(normal, covered.xyz);
    float open = 1.0 - 0.72 * smoothstep(0.45, 1.05, blocked);
    float sky = 0.72 + 0.28 * normal.z;
    float light = 0.74 * sky * open + 0.46 * max(0.0, dot(normal, sun)) * mix(0.6, 1.0, open);
    pixel = vec4(pow(min(vec3(1.0), paint * light * outlined(at, normal)), vec3(1.0 / 2.2)), 1.0);
    put_depth(t.x);
}`;

// Around what is selected: the back of a larger form; and where something is in front of it, faintly.
export const haloFragment = (form) => `${head}
uniform vec3 accent;
uniform float strength;
${forms[form]}
void main() {
    vec2 t;
    vec3 normal;
    if (!meets(t, normal)) discard;
    pixel = vec4(accent, strength);
    put_depth(t.y);
}`;

// Strokes are ribbons that face the eye, from `position` to `end`: of 6 corners lines, of 9 arrows with heads.
export const strokeVertex = `#version 300 es
precision highp float;
uniform mat4 viewMatrix, projectionMatrix;
uniform bool parallel;
uniform float pixel_at_one;
uniform int corners;
in vec3 position, end;
in vec4 colour;
out vec3 paint;
out float side;
// How far along it is (0, 1: where the head begins, 2: the tip), its side, and its width.
const vec3 shape[9] = vec3[9](vec3(0.0, -1.0, 1.0), vec3(0.0, 1.0, 1.0), vec3(1.0, -1.0, 1.0),
    vec3(0.0, 1.0, 1.0), vec3(1.0, 1.0, 1.0), vec3(1.0, -1.0, 1.0), vec3(1.0, -1.0, 3.0), vec3(1.0, 1.0, 3.0), vec3(2.0, 0.0, 0.0));
void main() {
    vec3 corner = shape[gl_VertexID % corners];
    vec3 a = (viewMatrix * vec4(position, 1.0)).xyz, b = (viewMatrix * vec4(end, 1.0)).xyz;
    float far = length(b - a), tip = corners == 9 ? min(0.32, 0.5 * far) : 0.0;
    vec3 way = (b - a) / max(far, 1e-6);
    vec3 at = corner.x < 0.5 ? a : corner.x < 1.5 ? b - tip * way : b;
    vec3 eye = parallel ? vec3(0.0, 0.0, -1.0) : at;
    vec3 aside = cross(way, eye);
    float size = length(aside);
    aside = size > 1e-6 ? aside / size : vec3(1.0, 0.0, 0.0);
    float wide = max(0.05, 0.8 * pixel_at_one * (parallel ? 1.0 : -at.z)) * corner.z;
    gl_Position = projectionMatrix * vec4(at + corner.y * wide * aside, 1.0);
    paint = colour.rgb;
    side = corner.y;
}`;

export const strokeFragment = `#version 300 es
precision highp float;
in vec3 paint;
in float side;
out vec4 pixel;
void main() { pixel = vec4(paint * (0.72 + 0.28 * sqrt(max(0.0, 1.0 - side * side))), 1.0); }`;

// What stands in the way of bodies: triangles, lit from both sides.
export const solidVertex = `#version 300 es
precision highp float;
uniform mat4 viewMatrix, projectionMatrix;
in vec3 position;
out vec3 at;
void main() {
    at = position;
    gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
}`;

export const solidFragment = `#version 300 es
precision highp float;
uniform vec3 sun, forward, paint;
in vec3 at;
out vec4 pixel;
void main() {
    vec3 normal = normalize(cross(dFdx(at), dFdy(at)));
    if (dot(normal, forward) > 0.0) normal = -normal;
    float light = 0.74 * (0.72 + 0.28 * normal.z) + 0.4 * max(0.0, dot(normal, sun));
    pixel = vec4(pow(min(vec3(1.0), pow(paint, vec3(2.2)) * light), vec3(1.0 / 2.2)), 1.0);
}`;
