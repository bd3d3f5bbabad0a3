// How much of one light reaches each pixel: soft shadows from its depth maps.
//
// Percentage-closer soft shadows (Fernando 2005): the distance of blockers tells how wide the penumbra is, and the light
// is filtered over that width. Samples lie on the emitter: the one at offset o, seen past a blocker at distance b of D,
// is looked up at receiver + o (D - b) / b. So an emitter that is flat shadows like a flat one; and what is found outside
// of the cone from the receiver to the emitter, the next wall of a corner say, is no blocker. What the map holds is
// compared with the distance to the receiver's tangent plane along the texel's own ray, which needs no slope bias.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/scene.h"

layout(set = 0, binding = 1) uniform sampler2D position_map;
layout(set = 0, binding = 3) uniform sampler2D diffuse_map;
layout(set = 0, binding = 4) uniform sampler2D specular_map;
layout(set = 0, binding = 5) uniform sampler2DArray depth_map;
layout(set = 0, binding = 8, scalar) readonly buffer Light { ng_light_data this_light; };

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out float out_visibility;

ng_light_data light; // read once, not in each turn of a loop

#include "geometry.glsl"
#include "spiral.glsl"

const int BLOCKER_SAMPLES = 16;
const int FILTER_SAMPLES = 24;
const float CONE_SLACK = 2.0; // the cone is wider by this factor: blockers are not where the mean of them is

// The receiver, in the light's frame.
struct receiver {
    vec3 position, normal;
    float plane; // dot(position, normal)
    float distance; // from the eye of the map, along its rays
    float bias;
    bool faces_light; // else only the light's rim reaches it, if its own front does not hide it
};

vec3 to_light_frame(vec3 v)
{
    return vec3(dot(v, light.look), dot(v, light.right), dot(v, light.up));
}

// Distance of the blocker that the map holds in the direction of p, or 0 if nothing blocks there.
float blocker_in_cube(vec3 p, receiver r)
{
    vec3 a = abs(p), n = r.normal;
    uint face = 0;
    if (a.y > a.x || a.z > a.x) {
        face = a.y >= a.z ? 1 : 2;
        p = face == 1 ? p.yzx : p.zxy;
        n = face == 1 ? n.yzx : n.zxy;
    }
    float side = p.x < 0 ? -1 : 1;
    uint layer = (light.layers >> (4 * (face + (p.x < 0 ? 3 : 0)))) & 15;
    vec2 xy = vec2(p.y * side, -p.z) / (abs(p.x) * light.tangent);
    if (layer == 0 || max(abs(xy.x), abs(xy.y)) > 1)
        return 0;
    vec2 at = min(floor((xy * 0.5 + 0.5) * light.face_size), light.face_size - 1);
    float depth = texelFetch(depth_map, ivec3(at, layer - 1), 0).r;
    xy = ((at + 0.5) / light.face_size * 2 - 1) * light.tangent;
    vec3 ray = vec3(side, side * xy.x, -xy.y);
    float slope = dot(n, ray), scale = length(ray);
    float expected = r.faces_light && abs(slope) > 1e-4 ? r.plane / slope * scale : r.distance;
    float found = depth > 0 ? light.depth_range / depth * scale : 1e30;
    return found < min(expected, r.distance) - r.bias ? found : 0;
}

float blocker_in_windows(vec3 p, receiver r)
{
    for (uint i = 0; i < light.window_count; i++) {
        vec4 w = this_light.windows[i];
        vec2 xy = vec2(p.y - w.x, w.y - p.z) / w.z;
        if (max(abs(xy.x), abs(xy.y)) > 1)
            continue;
        vec2 at = min(floor((xy * 0.5 + 0.5) * light.face_size), light.face_size - 1);
        float depth = texelFetch(depth_map, ivec3(at, i), 0).r;
        xy = ((at + 0.5) / light.face_size * 2 - 1) * w.z;
        vec2 start = vec2(w.x + xy.x, w.y - xy.y);
        float expected = r.faces_light && abs(r.normal.x) > 1e-4
                             ? (r.plane - dot(start, r.normal.yz)) / r.normal.x - w.w
                             : r.distance;
        float found = depth > 0 ? (1 - depth) * light.depth_range : 1e30;
        return found < min(expected, r.distance) - r.bias ? found : 0;
    }
    return 0;
}

float blocker(vec3 p, receiver r)
{
    return light.window_count != 0 ? blocker_in_windows(p, r) : blocker_in_cube(p, r);
}

// Jimenez's interleaved gradient noise: the turns of any 3 x 3 pixels are spread evenly, and direct.frag filters those.
vec2 first_turn(vec2 pixel)
{
    float angle = 6.2831853 * fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
    return vec2(cos(angle), sin(angle));
}

// How far from the receiver, measured in the map at its distance, a blocker at distance b hides a part of the light.
float reach(float b, receiver r)
{
    float gap = max(r.distance - b, 0);
    return light.soft_radius * (light.window_count != 0 ? gap : gap / b);
}

float visibility(receiver r, float texel)
{
    bool infinite = light.window_count != 0;
    vec3 l = infinite ? vec3(-1, 0, 0) : -normalize(r.position);
    vec3 side = normalize(abs(l.z) < 0.9 ? cross(l, vec3(0, 0, 1)) : cross(l, vec3(0, 1, 0)));
    vec3 up = cross(side, l);
    vec2 start = first_turn(gl_FragCoord.xy), turn = start;

    float search = light.soft_radius * (infinite ? r.distance * 0.25 : 1.0);
    float count = 0, nearest = 0;
    for (int i = 0; i < BLOCKER_SAMPLES; i++, turn = next_turn(turn)) {
        float radius = (float(i) + 0.5) / float(BLOCKER_SAMPLES); // dense within: near blockers are seen there
        vec3 o = (side * turn.x + up * turn.y) * radius;
        vec3 soft = o - light.soft_normal * dot(light.soft_normal, o);
        float b = blocker(r.position + soft * search + o * texel, r);
        if (b > 0 && radius * search <= CONE_SLACK * reach(b, r) + texel) {
            count += 1;
            nearest = max(nearest, b);
        }
    }
    if (count == 0)
        return 1;
    // The blocker nearest to the receiver decides: a mean would let light into the umbra at the foot of things.
    float width = min(reach(nearest, r), search);
    float open = 0;
    turn = start;
    for (int i = 0; i < FILTER_SAMPLES; i++, turn = next_turn(turn)) {
        float radius = sqrt((float(i) + 0.5) / float(FILTER_SAMPLES));
        vec3 o = (side * turn.x + up * turn.y) * radius;
        vec3 soft = o - light.soft_normal * dot(light.soft_normal, o);
        float b = blocker(r.position + soft * width + o * texel, r);
        open += b > 0 && radius * width <= CONE_SLACK * reach(b, r) + texel ? 0.0 : 1.0;
    }
    return open / float(FILTER_SAMPLES);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(position_map, at, 0);
    out_visibility = 1;
    if (position.w <= 0)
        return;
    light = this_light;
    receiver r;
    r.position = to_light_frame(position.xyz - light.proxy);
    r.normal = to_light_frame(flat_normal(texelFetch(diffuse_map, at, 0).w, texelFetch(specular_map, at, 0).w));
    r.plane = dot(r.position, r.normal);
    bool infinite = light.window_count != 0;
    r.faces_light = infinite ? r.normal.x < 0 : r.plane < 0;
    r.distance = infinite ? r.position.x - light.windows[0].w : length(r.position);
    float texel = infinite ? 2 * light.windows[0].z / light.face_size
                           : 2 * light.tangent * r.distance / light.face_size;
    r.bias = 2 * texel;
    out_visibility = visibility(r, texel);
}
