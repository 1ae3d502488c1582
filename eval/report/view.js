// SPDX-License-Identifier: Apache-2.0
// The view of a report's page: Gaussians and surfaces of some frames, drawn with WebGL 2. Nothing is fetched: view.c
// has written the frames into the page.
//
// Cameras are those of the rest of palmar: x right, y down, z forward, metres; a pixel is sampled at just its column
// and row, which to WebGL is half a pixel further.
"use strict";
(() => {
const view = document.getElementById("view"), find = (selector) => view.querySelector(selector);
const canvas = find("canvas"), slider = find(".frame");
const frames = JSON.parse(document.getElementById("view-frames").textContent);
const gl = canvas.getContext("webgl2", { alpha: false, antialias: false });
if (!gl || !frames.length)
    return;                                             // the still pictures stay

const parts = [".hand", ".object"].map(find);

// ---- what the page holds ------------------------------------------------------------------------------------------

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const words = (text) => new Uint16Array(bytes(text).buffer);
const place = (range, word, at, k) => range.low[k] + range.step * word[at + k];

// R diag(scale)^2 R^T of a rotation w x y z: xx xy xz yy yz zz
function covariance(q, scale, out, at) {
    const [w, x, y, z] = q;
    const R = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
               2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
               2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
    for (let r = 0, i = at; r < 3; r++)
        for (let c = r; c < 3; c++, i++)
            for (let k = 0; k < 3; k++)
                out[i] += R[3 * r + k] * R[3 * c + k] * scale[k] * scale[k];
}

// A Gaussian in numbers as the shader takes them: place, covariance, red green blue opacity
const FLOATS = 13, WORDS = 12;
function unpackSplats(frame) {
    const word = words(frame.splats), n = word.length / WORDS, out = new Float32Array(n * FLOATS);
    for (let i = 0; i < n; i++) {
        const from = WORDS * i, to = FLOATS * i, q = [], scale = [];
        for (let k = 0; k < 3; k++) {
            out[to + k] = place(frame.place, word, from, k);
            scale.push(Math.exp(place(frame.size, word, from + 3, k)));
        }
        for (let k = 0; k < 4; k++)
            q.push(word[from + 6 + k] / 32767.5 - 1);
        covariance(q, scale, out, to + 3);
        for (let k = 0; k < 4; k++)
            out[to + 9 + k] = (word[from + 10 + (k >> 1)] >> (k & 1 ? 0 : 8) & 255) / 255;
    }
    return out;
}

const splats = (frame) => frame.unpacked ??= unpackSplats(frame);

// ---- the camera ---------------------------------------------------------------------------------------------------

// Turned about the middle of what the frame shows, which stays where it is on the screen; zoom is of the focal length.
const camera = { yaw: 0, pitch: 0, zoom: 1 };

function middle(frame) {
    const all = splats(frame), n = all.length / FLOATS, sum = [0, 0, 0];
    for (let i = 0; i < n; i++)
        for (let k = 0; k < 3; k++)
            sum[k] += all[FLOATS * i + k] / n;
    return sum;
}

// The rotation by rows, and focal lengths and principal point in pixels of the canvas
function look(frame) {
    const cy = Math.cos(camera.yaw), sy = Math.sin(camera.yaw);
    const cp = Math.cos(camera.pitch), sp = Math.sin(camera.pitch);
    const pivot = frame.middle ??= middle(frame), scale = canvas.width / frame.width;
    const focal = [0, 1].map((k) => frame.camera[k] * scale);
    const centre = [0, 1].map((k) => (frame.camera[2 + k] + 0.5) * scale - 0.5);
    for (let k = 0; k < 2; k++)
        centre[k] += focal[k] * (1 - camera.zoom) * pivot[k] / pivot[2];
    return { pivot, turn: [cy, 0, sy, sp * sy, cp, -sp * cy, -cp * sy, sp, cp * cy],
             lens: [...focal.map((f) => f * camera.zoom), ...centre] };
}

// ---- programs -----------------------------------------------------------------------------------------------------

const TURNED = `#version 300 es
precision highp float;
uniform mat3 turn;
uniform vec3 pivot;
uniform vec4 lens;
uniform vec2 size;
vec3 turned(vec3 x) { return turn * (x - pivot) + pivot; }
`;

// A rectangle around the ellipse in which alpha is at least 1/255      [Zwicker et al. 2001; as lt_splat_raster]
const SPLAT = TURNED + `
in vec2 corner;
in vec3 centre, upper, lower;
in vec4 colour;
out vec2 offset;
flat out vec3 conic;
flat out vec4 paint;
void main() {
    vec3 x = turned(centre);
    mat3 S = turn * mat3(upper, vec3(upper.y, lower.xy), vec3(upper.z, lower.yz)) * transpose(turn);
    vec2 border = 0.15 * size / lens.xy;
    vec2 slant = clamp(x.xy / x.z, -lens.zw / lens.xy - border, (size - lens.zw) / lens.xy + border);
    vec3 jx = lens.x / x.z * vec3(1, 0, -slant.x), jy = lens.y / x.z * vec3(0, 1, -slant.y);
    float a = dot(jx, S * jx) + 0.3, b = dot(jx, S * jy), c = dot(jy, S * jy) + 0.3;
    offset = corner * sqrt(max(0.0, 2.0 * log(255.0 * colour.a)) * vec2(a, c));
    conic = vec3(c, -b, a) / (a * c - b * b);
    paint = colour;
    vec2 at = lens.xy * x.xy / x.z + lens.zw + 0.5 + offset;
    gl_Position = vec4(2.0 * at.x / size.x - 1.0, 1.0 - 2.0 * at.y / size.y, 0, 1);
}`;

const SPLAT_PIXEL = `#version 300 es
precision highp float;
in vec2 offset;
flat in vec3 conic;
flat in vec4 paint;
out vec4 pixel;
void main() {
    float sigma = 0.5 * (conic.x * offset.x * offset.x + conic.z * offset.y * offset.y) + conic.y * offset.x * offset.y;
    float alpha = min(0.99, paint.a * exp(-sigma));
    if (alpha < 1.0 / 255.0)
        discard;
    pixel = vec4(paint.rgb * alpha, alpha);
}`;

// Vertices have their light in their colours; a little more from the camera shows their shape.
const SURFACE = TURNED + `
in vec3 centre, colour;
out vec3 seen, paint;
void main() {
    vec3 x = seen = turned(centre);
    vec2 at = 2.0 * (lens.xy * x.xy + (lens.zw + 0.5) * x.z) / size - x.z;
    paint = colour;
    gl_Position = vec4(at.x, -at.y, 1.01 * x.z - 0.2, x.z);
}`;

const SURFACE_PIXEL = `#version 300 es
precision highp float;
in vec3 seen, paint;
out vec4 pixel;
void main() {
    vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
    pixel = vec4(paint * (0.55 + 0.45 * abs(dot(normal, normalize(seen)))), 1);
}`;

function program(vertex, fragment, names) {
    const p = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        gl.attachShader(p, shader);
    }
    names.forEach((name, i) => gl.bindAttribLocation(p, i, name));
    gl.linkProgram(p);
    if (!gl.getProgramParameter(p, gl.LINK_STATUS))
        throw Error(gl.getProgramInfoLog(p));
    return p;
}

const splatProgram = program(SPLAT, SPLAT_PIXEL, ["corner", "centre", "upper", "lower", "colour"]);
const surfaceProgram = program(SURFACE, SURFACE_PIXEL, ["centre", "colour"]);

function use(p, l) {
    gl.useProgram(p);
    gl.uniformMatrix3fv(gl.getUniformLocation(p, "turn"), true, l.turn);
    gl.uniform3fv(gl.getUniformLocation(p, "pivot"), l.pivot);
    gl.uniform4fv(gl.getUniformLocation(p, "lens"), l.lens);
    gl.uniform2f(gl.getUniformLocation(p, "size"), canvas.width, canvas.height);
}

function attribute(i, components, floats, from, each) {
    gl.enableVertexAttribArray(i);
    gl.vertexAttribPointer(i, components, gl.FLOAT, false, 4 * floats, 4 * from);
    gl.vertexAttribDivisor(i, each);
}

// ---- Gaussians ----------------------------------------------------------------------------------------------------

const splatArrays = gl.createVertexArray(), sorted = gl.createBuffer();
gl.bindVertexArray(splatArrays);
gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), gl.STATIC_DRAW);
attribute(0, 2, 2, 0, 0);
gl.bindBuffer(gl.ARRAY_BUFFER, sorted);
[3, 3, 3, 4].forEach((components, i) => attribute(1 + i, components, FLOATS, 3 * i, 1));

// Those of the parts that are shown, from far to near
function sort(frame, l) {
    const all = splats(frame), from = parts[0].checked ? 0 : frame.n[0];
    const to = parts[1].checked ? all.length / FLOATS : frame.n[0], depth = new Float32Array(all.length / FLOATS);
    const order = [];
    for (let i = from; i < to; i++) {
        depth[i] = l.pivot[2];
        for (let k = 0; k < 3; k++)
            depth[i] += l.turn[6 + k] * (all[FLOATS * i + k] - l.pivot[k]);
        if (depth[i] > frame.near)
            order.push(i);
    }
    order.sort((a, b) => depth[b] - depth[a] || b - a);
    const out = new Float32Array(order.length * FLOATS);
    order.forEach((i, at) => out.set(all.subarray(FLOATS * i, FLOATS * (i + 1)), FLOATS * at));
    return out;
}

function drawSplats(frame, l) {
    const drawn = sort(frame, l);
    use(splatProgram, l);
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(splatArrays);
    gl.bindBuffer(gl.ARRAY_BUFFER, sorted);
    gl.bufferData(gl.ARRAY_BUFFER, drawn, gl.DYNAMIC_DRAW);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, drawn.length / FLOATS);
}

// ---- surfaces -----------------------------------------------------------------------------------------------------

function unpackSurface(mesh) {
    const word = words(mesh.vertex), vertex = new Float32Array(6 * mesh.vertices), wide = mesh.vertices > 65536;
    for (let i = 0; i < mesh.vertices; i++)
        for (let k = 0; k < 3; k++) {
            vertex[6 * i + k] = place(mesh.place, word, 5 * i, k);
            vertex[6 * i + 3 + k] = (word[5 * i + 3 + (k >> 1)] >> (k & 1 ? 0 : 8) & 255) / 255;
        }
    const face = wide ? new Uint32Array(bytes(mesh.face).buffer) : words(mesh.face), arrays = gl.createVertexArray();
    gl.bindVertexArray(arrays);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, vertex, gl.STATIC_DRAW);
    attribute(0, 3, 6, 0, 0);
    attribute(1, 3, 6, 3, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, face, gl.STATIC_DRAW);
    return { arrays, indices: face.length, type: wide ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT };
}

function drawSurfaces(frame, l) {
    use(surfaceProgram, l);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    frame.mesh.forEach((mesh, part) => {
        if (!mesh || !parts[part].checked)
            return;
        const surface = mesh.unpacked ??= unpackSurface(mesh);
        gl.bindVertexArray(surface.arrays);
        gl.drawElements(gl.TRIANGLES, surface.indices, surface.type, 0);
    });
}

// ---- the page -----------------------------------------------------------------------------------------------------

const hasSurface = (frame) => frame.mesh.some((mesh) => mesh);
const surfaces = frames.filter(hasSurface).map((frame) => frame.name);

// What no frame has needs no switch.
parts.forEach((part, i) => part.parentNode.hidden = !frames.some((frame) => frame.n[i]));
find(".surface").parentNode.hidden = !surfaces.length;

function draw() {
    const frame = frames[slider.value], surface = find(".surface").checked && hasSurface(frame);
    canvas.width = Math.round(canvas.clientWidth * devicePixelRatio);
    canvas.height = Math.round(canvas.width * frame.height / frame.width);
    const l = look(frame), white = frame.white ? 1 : 0;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(white, white, white, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    (surface ? drawSurfaces : drawSplats)(frame, l);
    view.querySelectorAll("figure").forEach((figure, i) => figure.hidden = i !== Number(slider.value));
    find(".surface").disabled = !hasSurface(frame);
    const seen = frame.parts.map((name, part) => [name, frame.n[part]]).filter(([, n]) => n);
    find(".note").textContent = seen.map(([name, n]) => `${name}: ${n} Gaussians`).join(", ") + "." +
        (hasSurface(frame) || !surfaces.length ? "" : ` Surfaces are those of ${surfaces.join(", ")}.`);
}

let waiting = false;
function redraw() {
    if (waiting)
        return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
}

function turn(yaw, pitch) {
    camera.yaw += yaw;
    camera.pitch = Math.max(-1.5, Math.min(1.5, camera.pitch + pitch));
    redraw();
}

function zoom(by) {
    camera.zoom = Math.max(0.2, Math.min(20, camera.zoom * by));
    redraw();
}

function home() {
    Object.assign(camera, { yaw: 0, pitch: 0, zoom: 1 });
    redraw();
}

// One pointer turns, two zoom.
const pointers = new Map();
const apart = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
};
canvas.addEventListener("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
});
canvas.addEventListener("pointermove", (e) => {
    const was = pointers.get(e.pointerId);
    if (!was)
        return;
    const before = pointers.size === 2 ? apart() : 0;
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
    if (pointers.size === 2)
        zoom(apart() / Math.max(1, before));
    else if (pointers.size === 1)
        turn(0.01 * (e.clientX - was.x), -0.01 * (e.clientY - was.y));
});
["pointerup", "pointercancel"].forEach((end) => canvas.addEventListener(end, (e) => pointers.delete(e.pointerId)));
canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    zoom(Math.exp(-0.001 * e.deltaY));
}, { passive: false });

const keys = {
    ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, 0.1),
    ArrowDown: () => turn(0, -0.1), "+": () => zoom(1.1), "=": () => zoom(1.1), "-": () => zoom(1 / 1.1), Home: home,
};
canvas.addEventListener("keydown", (e) => {
    if (!keys[e.key])
        return;
    e.preventDefault();
    keys[e.key]();
});

view.querySelectorAll("input").forEach((input) => input.addEventListener("input", redraw));
find(".home").addEventListener("click", home);
addEventListener("resize", redraw);
slider.max = frames.length - 1;
find(".still").hidden = true;
[canvas, ...view.querySelectorAll(".controls")].forEach((element) => element.hidden = false);
draw();
})();
