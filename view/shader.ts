// SPDX-License-Identifier: Apache-2.0
// shader.ts - the forward model as render/lobe.h, render/draw.c and render/texture.c define it, in GLSL ES 3.00.

export const vertexShader = `
precision highp float;
precision highp int;
in vec3 position;
in vec3 normal;
uniform mat4 clipFromObj;
flat out int triangle;
out vec2 place; // barycentric weights of corners 1 and 2
out vec3 pObj;
out vec3 nObj;

void main() {
    int corner = gl_VertexID % 3;
    triangle = gl_VertexID / 3;
    place = vec2(corner == 1, corner == 2);
    pObj = position;
    nObj = normal;
    gl_Position = clipFromObj * vec4(position, 1.0);
}
`;

export const fragmentShader = `
precision highp float;
precision highp int;
precision highp sampler2D;
flat in int triangle;
in vec2 place;
in vec3 pObj;
in vec3 nObj;
uniform sampler2D atlas; // sRGB, decoded when read
uniform sampler2D seen;
uniform sampler2D cellRange;
uniform sampler2D lights; // direction and weight
uniform int texelsPerEdge, columns, side, lightsWidth;
uniform float sigma;
uniform vec3 specularRgb; // k_S times the lights' colour
uniform vec3 cameraObj;
uniform vec3 holeRgb;
uniform mat3 lightFromObj;
uniform vec2 show; // diffuse, specular
out vec4 colour;

const float MIN_FACING = 0.01;
const float LOBE_MIN_COS = 0.2;

ivec2 texelAt(ivec2 ij) {
    int block = triangle / 2;
    ivec2 origin = ivec2(block % columns * texelsPerEdge, block / columns * (texelsPerEdge + 1));
    return origin + (triangle % 2 == 1 ? ivec2(texelsPerEdge - 1, texelsPerEdge) - ij : ij);
}

// Linear on the small triangles of the lattice; texels that no photograph saw have no part in it.
vec3 diffuseAt() {
    int last = texelsPerEdge - 1;
    vec2 ab = clamp(place, 0.0, 1.0) * float(last);
    ivec2 ij = clamp(ivec2(ab), ivec2(0), ivec2(last - 1));
    if (ij.x + ij.y > last - 1) {
        if (ij.x > 0) ij.x = last - 1 - ij.y;
        else ij.y = last - 1 - ij.x;
    }
    vec2 f = ab - vec2(ij);
    ivec2 t0, t1, t2;
    vec3 weight;
    if (f.x + f.y <= 1.0 || ij.x + ij.y == last - 1) {
        f /= max(f.x + f.y, 1.0);
        t0 = ij;
        t1 = ij + ivec2(1, 0);
        t2 = ij + ivec2(0, 1);
        weight = vec3(1.0 - f.x - f.y, f);
    } else {
        t0 = ij + ivec2(1, 1);
        t1 = ij + ivec2(0, 1);
        t2 = ij + ivec2(1, 0);
        weight = vec3(f.x + f.y - 1.0, 1.0 - f);
    }
    t0 = texelAt(t0);
    t1 = texelAt(t1);
    t2 = texelAt(t2);
    weight *= vec3(texelFetch(seen, t0, 0).r, texelFetch(seen, t1, 0).r, texelFetch(seen, t2, 0).r);
    float sum = weight.x + weight.y + weight.z;
    if (!(sum > 0.0)) return holeRgb;
    return (weight.x * texelFetch(atlas, t0, 0).rgb + weight.y * texelFetch(atlas, t1, 0).rgb +
            weight.z * texelFetch(atlas, t2, 0).rgb) / sum;
}

int cellOf(vec3 d) {
    vec2 p = d.xy / (abs(d.x) + abs(d.y) + abs(d.z));
    if (d.z < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
    ivec2 cell = clamp(ivec2((0.5 * p + 0.5) * float(side)), ivec2(0), ivec2(side - 1));
    return cell.y * side + cell.x;
}

// alpha^2 = acos(1 - x)^2
float alpha2(float x) {
    float p = 9.217112091e-3;
    p = p * x - 1.05966902e-2;
    p = p * x + 2.171258428e-2;
    p = p * x + 2.409557386e-2;
    p = p * x + 8.969094345e-2;
    p = p * x + 3.3328031e-1;
    p = p * x + 2.000000567;
    return p * x;
}

// Eq. (7) without k_S.
float specularAt() {
    vec3 vO = normalize(cameraObj - pObj);
    vec3 nO = normalize(nObj);
    float facing = dot(nO, vO);
    if (facing < MIN_FACING) {
        // The inside of an open mesh does not shine; at an outline the normal is bent towards the camera.
        if (!gl_FrontFacing) return 0.0;
        vec3 across = nO - facing * vO;
        float len = length(across);
        if (!(len > 0.0)) return 0.0;
        nO = sqrt(1.0 - MIN_FACING * MIN_FACING) * (across / len) + MIN_FACING * vO;
    }
    vec3 n = lightFromObj * nO;
    vec3 v = lightFromObj * vO;
    vec3 mirror = 2.0 * dot(n, v) * n - v;
    int cell = side > 0 ? cellOf(mirror) : 0;
    int perRow = max(side, 1);
    vec2 range = texelFetch(cellRange, ivec2(cell % perRow, cell / perRow), 0).xy;
    float perAlpha2 = 0.721347520 / (sigma * sigma);
    float sum = 0.0;
    for (int i = int(range.x), end = int(range.y); i < end; i++) {
        vec4 l = texelFetch(lights, ivec2(i % lightsWidth, i / lightsWidth), 0);
        if (dot(n, l.xyz) <= 0.0) continue;
        vec3 e = n - normalize(l.xyz + v);
        sum += l.w * exp2(-alpha2(0.5 * dot(e, e)) * perAlpha2);
    }
    return sum / max(dot(n, v), LOBE_MIN_COS);
}

void main() {
    vec3 sum = vec3(0.0);
    if (show.x > 0.0) sum += diffuseAt();
    if (show.y > 0.0) sum += specularAt() * specularRgb;
    colour = vec4(min(sum, vec3(1000.0)), 1.0); // half floats end at 65504; white is 1
}
`;

// A triangle that covers the picture.
export const coverShader = `
precision highp float;
in vec3 position;
void main() {
    gl_Position = vec4(position.xy, 0.0, 1.0);
}
`;

// Adds a share of one sampling to the sum of them.
export const addShader = `
precision highp float;
precision highp sampler2D;
uniform sampler2D source;
uniform float share;
out vec4 colour;
void main() {
    colour = share * texelFetch(source, ivec2(gl_FragCoord.xy), 0);
}
`;

// Linear light over the background, coded as sRGB.
export const encodeShader = `
precision highp float;
precision highp sampler2D;
uniform sampler2D source;
uniform vec2 scale; // of the source over the canvas
uniform vec3 backgroundRgb;
out vec4 colour;
void main() {
    vec4 c = texelFetch(source, ivec2(gl_FragCoord.xy * scale), 0);
    vec3 lin = clamp(c.rgb + (1.0 - c.a) * backgroundRgb, 0.0, 1.0);
    vec3 low = 12.92 * lin, high = 1.055 * pow(lin, vec3(1.0 / 2.4)) - 0.055;
    colour = vec4(mix(high, low, vec3(lessThanEqual(lin, vec3(0.0031308)))), 1.0);
}
`;
