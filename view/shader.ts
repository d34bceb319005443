// SPDX-License-Identifier: Apache-2.0
// shader.ts - the forward model as render/lobe.h, render/shade.c, render/draw.c and render/texture.c define it, in GLSL
// ES 3.00.

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
uniform int texelsPerEdge, columns, side;
uniform float sigma;
uniform vec3 specularRgb; // k_S times the lights' colour
uniform vec3 cameraObj;
uniform vec3 holeRgb;
uniform bool filled; // texels that no photograph saw have a colour
uniform mat3 lightFromObj;
uniform vec2 show; // diffuse, specular
uniform bool wire; // edges of triangles
uniform sampler2D nodes, triangles; // bvh.ts
uniform int nNodes;
uniform float offset; // by which secondary rays start off the surface, metres
uniform float leastShadowed; // terms below this, before k_S, are not worth a shadow ray; huge: no shadows
uniform bool mirrors; // the surroundings
uniform mat3 worldFromObj;
uniform mat3 boardFromObj;
uniform vec3 boardOrigin; // of the object
uniform vec3 ambient[9];
uniform sampler2D board; // sRGB, over boardWhite; interpolated in linear light
uniform vec4 boardPlace; // centre of pixel (0, 0), pixel size in metres (0: no board), white
uniform vec3 tableRgb;
uniform float f0;
uniform sampler2D offsets; // of normals, in the order of triangles and of their texels
uniform int offsetsPerEdge; // texels; 0: no normal map
uniform bool lit; // the texture is an albedo
uniform vec3 irradiance[9];
uniform int nSuns;
uniform vec4 suns[24]; // direction, inverse distance
uniform vec3 sunRgb[24];
uniform sampler2D lamps; // lamps.ts
uniform int nLamps;
uniform vec3 lampOrigin; // from the object's origin, in the lights' frame, negative: x = lightFromObj p + lampOrigin
uniform vec3 lampLobe; // tail, Schlick's factor, strength
uniform int nGloss;
uniform float glossWidth;
uniform vec4 gloss[32]; // root of a colour, share
out vec4 colour;

const float MIN_FACING = 0.01;
const float LOBE_MIN_COS = 0.2;

ivec2 texelAt(int triangle, ivec2 ij) {
    int block = triangle / 2;
    ivec2 origin = ivec2(block % columns * texelsPerEdge, block / columns * (texelsPerEdge + 1));
    return origin + (triangle % 2 == 1 ? ivec2(texelsPerEdge - 1, texelsPerEdge) - ij : ij);
}

// The three lattice points (columns) about a place of a triangle, and their weights.
void cellAt(int last, vec2 place, out ivec2 at[3], out vec3 weight) {
    vec2 ab = clamp(place, 0.0, 1.0) * float(last);
    ivec2 ij = clamp(ivec2(ab), ivec2(0), ivec2(last - 1));
    if (ij.x + ij.y > last - 1) {
        if (ij.x > 0) ij.x = last - 1 - ij.y;
        else ij.y = last - 1 - ij.x;
    }
    vec2 f = ab - vec2(ij);
    if (f.x + f.y <= 1.0 || ij.x + ij.y == last - 1) {
        f /= max(f.x + f.y, 1.0);
        at = ivec2[3](ij, ij + ivec2(1, 0), ij + ivec2(0, 1));
        weight = vec3(1.0 - f.x - f.y, f);
    } else {
        at = ivec2[3](ij + ivec2(1, 1), ij + ivec2(0, 1), ij + ivec2(1, 0));
        weight = vec3(f.x + f.y - 1.0, 1.0 - f);
    }
}

// Linear on the small triangles of the lattice; texels that no photograph saw have no part in it.
vec3 diffuseAt(int triangle, vec2 place, vec3 holeRgb) {
    ivec2 at[3];
    vec3 weight;
    cellAt(texelsPerEdge - 1, place, at, weight);
    ivec2 t0 = texelAt(triangle, at[0]), t1 = texelAt(triangle, at[1]), t2 = texelAt(triangle, at[2]);
    vec3 all = weight;
    weight *= vec3(texelFetch(seen, t0, 0).r, texelFetch(seen, t1, 0).r, texelFetch(seen, t2, 0).r);
    float sum = weight.x + weight.y + weight.z;
    if (!(sum > 0.0)) {
        if (!filled || holeRgb.r > 0.0) return holeRgb;
        weight = all;
        sum = 1.0;
    }
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

vec4 entry(sampler2D table, int i) {
    return texelFetch(table, ivec2(i & 1023, i >> 10), 0);
}

// The mesh's unit normal at a place, bent by the normal map (render/normal_map.h).
vec3 bentAt(int triangle, vec2 place, vec3 n) {
    if (offsetsPerEdge == 0) return n;
    ivec2 at[3];
    vec3 weight;
    cellAt(offsetsPerEdge - 1, place, at, weight);
    int first = triangle * (offsetsPerEdge * (offsetsPerEdge + 1) / 2);
    for (int k = 0; k < 3; k++)
        n += weight[k] * entry(offsets, first + at[k].y * offsetsPerEdge - at[k].y * (at[k].y - 1) / 2 + at[k].x).xyz;
    return normalize(n);
}

// Number and place of the triangle that a ray meets first (or at all); -1: none.
int meets(vec3 from, vec3 along, bool first, out vec2 at, out float nearest, out vec3 flatN) {
    vec3 per = 1.0 / along;
    int found = -1;
    nearest = 1e30;
    flatN = vec3(0.0);
    at = vec2(0.0);
    for (int i = 0; i < nNodes;) {
        vec4 low = entry(nodes, 2 * i), high = entry(nodes, 2 * i + 1);
        vec3 a = (low.xyz - from) * per, b = (high.xyz - from) * per;
        vec3 enter = min(a, b), leave = max(a, b);
        float begin = max(max(enter.x, enter.y), enter.z), end = min(min(leave.x, leave.y), leave.z);
        if (!(begin <= end * 1.00001) || end < 0.0 || begin > nearest) {
            i = int(low.w);
            continue;
        }
        i++;
        if (high.w < 0.0) continue;
        int leaf = int(high.w), last = leaf / 8 + leaf % 8;
        for (int k = leaf / 8; k < last; k++) {
            vec4 corner = entry(triangles, 3 * k);
            vec3 e1 = entry(triangles, 3 * k + 1).xyz, e2 = entry(triangles, 3 * k + 2).xyz;
            vec3 p = cross(along, e2), t = from - corner.xyz, q = cross(t, e1);
            float per_det = 1.0 / dot(e1, p); // 0: the comparisons below fail
            float u = dot(t, p) * per_det, v = dot(along, q) * per_det, s = dot(e2, q) * per_det;
            if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && s > 0.0 && s < nearest) {
                nearest = s;
                found = int(corner.w);
                at = vec2(u, v);
                flatN = cross(e1, e2);
                if (!first) return found;
            }
        }
    }
    flatN = found < 0 ? flatN : normalize(flatN);
    return found;
}

bool blocked(vec3 nO, vec3 pO, vec3 towards) {
    vec2 at;
    float far;
    vec3 flatN;
    return meets(pO + offset * nO, towards, false, at, far, flatN) >= 0;
}

// Spherical harmonics to order 2.
vec3 harmonicsAt(vec3 e[9], vec3 d) {
    vec3 sum = 0.28209479 * e[0] + 0.48860251 * (d.y * e[1] + d.z * e[2] + d.x * e[3]) +
        1.09254843 * (d.x * d.y * e[4] + d.y * d.z * e[5] + d.x * d.z * e[7]) +
        0.31539157 * (3.0 * d.z * d.z - 1.0) * e[6] + 0.54627422 * (d.x * d.x - d.y * d.y) * e[8];
    return max(sum, vec3(0.0));
}

// Light on the texture of an object that turned (render/irradiance.h); 1 where it did not.
vec3 irradianceAt(vec3 pO, vec3 nO) {
    if (!lit) return vec3(1.0);
    vec3 n = lightFromObj * nO, x = lightFromObj * pO + lampOrigin, sum = harmonicsAt(irradiance, n);
    for (int i = 0; i < nSuns; i++) {
        vec3 to = suns[i].xyz - suns[i].w * x, l = normalize(to);
        float cosine = dot(n, l) / dot(to, to);
        if (cosine > 0.0 && !blocked(nO, pO, l * lightFromObj)) sum += cosine * sunRgb[i];
    }
    return sum;
}

vec3 boardAt(vec2 p) {
    vec2 size = vec2(textureSize(board, 0)), at = (p - boardPlace.xy) / boardPlace.z;
    if (!(boardPlace.z > 0.0) || any(lessThan(at, vec2(0.0))) || any(greaterThan(at, size - 1.0))) return tableRgb;
    return boardPlace.w * textureLod(board, (at + 0.5) / size, 0.0).rgb;
}

// A Gaussian's spread (render/surroundings.c).
const vec2 spread[16] = vec2[16](
    vec2(0.251987, 0.000000), vec2(-0.327179, 0.299723), vec2(0.050962, -0.580690), vec2(0.427521, 0.557625),
    vec2(-0.800278, -0.141558), vec2(0.774431, -0.492629), vec2(-0.265075, 0.986067), vec2(-0.518402, -0.998151),
    vec2(1.156308, 0.422282), vec2(-1.240681, 0.512135), vec2(0.619407, -1.323637), vec2(0.476700, 1.519796),
    vec2(-1.508461, -0.874184), vec2(1.881868, -0.413723), vec2(-1.251385, 1.779967), vec2(-0.338339, -2.610938));

vec3 planeAt(vec3 p, vec3 d) {
    float t = -p.z / d.z;
    return t > 0.0 ? boardAt(p.xy + t * d.xy) : tableRgb;
}

// The plane as a rough surface mirrors it.
vec3 spreadAt(vec3 p, vec3 d) {
    vec3 a = normalize(cross(d, abs(d.x) < 0.7 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0))), b = cross(d, a), sum = vec3(0.0);
    float n = 0.0;
    for (int k = 0; k < 16; k++) {
        vec2 by = 2.0 * sigma * spread[k];
        vec3 r = d + by.x * a + by.y * b;
        if (r.z >= 0.0) continue;
        sum += planeAt(p, r);
        n += 1.0;
    }
    return n > 0.0 ? sum / n : planeAt(p, d);
}

// Radiance in the mirror direction: the object's own texture where it stands in the way, else the surroundings. The light on
// what an object that turned mirrors of itself is taken as on flat triangles.
vec3 mirroredAt(vec3 nO, vec3 vO) {
    vec3 from = pObj + offset * nO, r = 2.0 * dot(nO, vO) * nO - vO, flatN;
    float far;
    vec2 at;
    int hit = meets(from, r, true, at, far, flatN);
    if (hit >= 0) return diffuseAt(hit, at, vec3(0.0)) * irradianceAt(from + far * r, flatN);
    vec3 d = worldFromObj * r;
    if (d.z >= 0.0) return harmonicsAt(ambient, d);
    return spreadAt(boardFromObj * pObj + boardOrigin, boardFromObj * r);
}

// Eq. (7) without k_S, of lights that the mesh does not hide.
float lobeAt(vec3 nO, vec3 vO) {
    vec3 n = lightFromObj * nO;
    vec3 v = lightFromObj * vO;
    vec3 mirror = 2.0 * dot(n, v) * n - v;
    int cell = side > 0 ? cellOf(mirror) : 0;
    int perRow = max(side, 1);
    vec2 range = texelFetch(cellRange, ivec2(cell % perRow, cell / perRow), 0).xy;
    float perAlpha2 = 0.721347520 / (sigma * sigma);
    float sum = 0.0;
    for (int i = int(range.x), end = int(range.y); i < end; i++) {
        vec4 l = entry(lights, i);
        if (dot(n, l.xyz) <= 0.0) continue;
        vec3 e = n - normalize(l.xyz + v);
        float term = l.w * exp2(-alpha2(0.5 * dot(e, e)) * perAlpha2);
        if (term > leastShadowed && blocked(nO, pObj, l.xyz * lightFromObj)) continue;
        sum += term;
    }
    return sum / max(dot(n, v), LOBE_MIN_COS);
}

// A point's or a lamp's response; a2: alpha^2 (v.h)^2.
float lampTerm(vec3 n, vec3 v, vec3 to, out float a2) {
    vec3 l = normalize(to), sum = l + v, e = n - normalize(sum);
    float alphas = alpha2(0.5 * dot(e, e)), s2 = sigma * sigma, vh2 = 0.25 * dot(sum, sum);
    a2 = alphas * vh2;
    if (dot(n, l) <= 0.0) return 0.0;
    float wide = 1.0 / (1.0 + alphas / (4.0 * s2));
    float lobe = (1.0 - lampLobe.x) * exp2(-alphas * 0.721347520 / s2) + lampLobe.x * wide * wide;
    return lobe * (1.0 + lampLobe.y * pow(max(1.0 - sqrt(vh2), 0.0), 5.0)) / dot(to, to);
}

// Lamps (render/lamp.h) that the mesh does not hide.
vec3 lampsAt(vec3 nO, vec3 vO) {
    vec3 n = lightFromObj * nO, v = lightFromObj * vO, x = lightFromObj * pObj + lampOrigin, sum = vec3(0.0);
    float perCos = lampLobe.z / max(dot(n, v), LOBE_MIN_COS), a2, ignored;
    for (int i = 0; i < nLamps; i++) {
        vec4 lamp = entry(lamps, 3 * i), points = entry(lamps, 3 * i + 2);
        vec3 rgb = entry(lamps, 3 * i + 1).rgb, to = lamp.xyz - lamp.w * x;
        float response = lampTerm(n, v, to, a2);
        if (points.y > 1.0 && a2 < points.z) {
            response = 0.0;
            for (int k = int(points.x), end = k + int(points.y); k < end; k++)
                response += lampTerm(n, v, entry(lamps, k).xyz - lamp.w * x, ignored);
            response /= points.y;
        }
        response *= perCos;
        if (!(response * (rgb.r + rgb.g + rgb.b) > 2e-4)) continue;
        if (leastShadowed < 1e29 && blocked(nO, pObj, normalize(to) * lightFromObj)) continue;
        sum += response * rgb;
    }
    return sum;
}

// render/gloss.h
float glossAt(vec3 rgb) {
    float least = 1e30, sum = 0.0, all = 0.0;
    vec3 root = sqrt(max(rgb, vec3(0.0)));
    for (int i = 0; i < nGloss; i++) least = min(least, dot(root - gloss[i].xyz, root - gloss[i].xyz));
    for (int i = 0; i < nGloss; i++) {
        vec3 d = root - gloss[i].xyz;
        float weight = exp(-0.5 * (dot(d, d) - least) / (glossWidth * glossWidth));
        sum += weight * gloss[i].w;
        all += weight;
    }
    return nGloss > 0 ? sum / all : 1.0;
}

vec3 specularAt(vec3 nO) {
    vec3 vO = normalize(cameraObj - pObj);
    float facing = dot(nO, vO);
    if (facing < MIN_FACING) {
        // The inside of an open mesh does not shine; at an outline the normal is bent towards the camera.
        if (!gl_FrontFacing) return vec3(0.0);
        vec3 across = nO - facing * vO;
        float len = length(across);
        if (!(len > 0.0)) return vec3(0.0);
        nO = sqrt(1.0 - MIN_FACING * MIN_FACING) * (across / len) + MIN_FACING * vO;
    }
    vec3 sum = lobeAt(nO, vO) * specularRgb + lampsAt(nO, vO);
    if (mirrors) sum += (f0 + (1.0 - f0) * pow(1.0 - clamp(dot(nO, vO), 0.0, 1.0), 5.0)) * mirroredAt(nO, vO);
    return nGloss > 0 ? glossAt(diffuseAt(triangle, place, vec3(0.0))) * sum : sum;
}

void main() {
    vec3 sum = vec3(0.0);
    vec3 nO = bentAt(triangle, place, normalize(nObj));
    if (show.x > 0.0) sum += diffuseAt(triangle, place, holeRgb) * irradianceAt(pObj, nO);
    if (show.y > 0.0) sum += specularAt(nO);
    if (wire) {
        vec3 b = vec3(1.0 - place.x - place.y, place), step = max(fwidth(b), 1e-9), d = b / step;
        float across = 1.0 / max(step.x, max(step.y, step.z)); // pixels of the triangle: small ones would hide the object
        if (min(d.x, min(d.y, d.z)) < 0.8) sum = mix(sum, vec3(0.1, 0.6, 1.0), clamp(across / 10.0, 0.1, 0.8));
    }
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
