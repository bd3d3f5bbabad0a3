// Direct light of one light: its direct VPLs summed with the shared BRDF, times soft shadows from its depth maps.
//
// Shadows are percentage-closer soft shadows (Fernando 2005): the mean distance of blockers in a search disk gives
// the width of the penumbra, and a disk of that width is filtered. Both disks lie on the tangent plane of the
// receiver, whose distance along each texel's own direction is known exactly, so that no slope bias is needed. Where
// that plane runs on behind a corner, the receiver's own distance is the limit: the next wall is no blocker.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/scene.h"
#include "shared/brdf.h"

layout(set = 0, binding = 0, scalar) uniform View { ng_view_data view; };
layout(set = 0, binding = 1) uniform sampler2D position_map;
layout(set = 0, binding = 2) uniform sampler2D normal_map;
layout(set = 0, binding = 3) uniform sampler2D diffuse_map;
layout(set = 0, binding = 4) uniform sampler2D specular_map;
layout(set = 0, binding = 5) uniform sampler2DArray depth_map;
layout(set = 0, binding = 7, scalar) readonly buffer Views { ng_light_view_data views[]; };
layout(set = 0, binding = 8, scalar) uniform Light { ng_light_data light; };
layout(set = 0, binding = 9, scalar) readonly buffer Vpls { ng_vpl_data vpls[]; };

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_unshadowed; // added over the lights
layout(location = 1) out vec4 out_direct;

#include "light.glsl"

const int BLOCKER_SAMPLES = 12;
const int FILTER_SAMPLES = 24;

vec3 from_octahedral(vec2 o)
{
    vec3 n = vec3(o, 1 - abs(o.x) - abs(o.y));
    float t = max(-n.z, 0.0);
    n.x += n.x >= 0 ? -t : t;
    n.y += n.y >= 0 ? -t : t;
    return normalize(n);
}

struct texel {
    float light_distance;    // along the view's rays, from the eye to what the map saw; negative: nothing, or outside
    float receiver_distance; // along the same ray to the receiver's tangent plane, at most the receiver's own
};

// What the light's maps hold in the direction of a point.
texel look(vec3 p, vec3 receiver, vec3 normal, float limit)
{
    texel none = texel(-1, 0);
    for (uint i = 0; i < light.view_count; i++) {
        ng_light_view_data v = views[i];
        vec3 q = p - v.origin;
        float z = dot(q, v.axis_z);
        float w = light.orthographic != 0 ? v.tangent : z * v.tangent;
        vec2 xy = vec2(dot(q, v.axis_x), dot(q, v.axis_y)) / w;
        if (z <= 0 || max(abs(xy.x), abs(xy.y)) > 1)
            continue;
        ivec2 at = min(ivec2((xy * 0.5 + 0.5) * light.face_size), ivec2(light.face_size) - 1);
        float depth = texelFetch(depth_map, ivec3(at, i), 0).r;
        if (depth <= 0)
            return none;
        xy = ((vec2(at) + 0.5) / light.face_size * 2 - 1) * v.tangent;
        if (light.orthographic != 0) {
            vec3 start = v.origin + xy.x * v.axis_x + xy.y * v.axis_y;
            float slope = dot(normal, v.axis_z);
            float plane = abs(slope) > 1e-3 ? dot(receiver - start, normal) / slope : z;
            return texel((1 - depth) * v.depth_range, min(plane, limit));
        }
        vec3 ray = v.axis_z + xy.x * v.axis_x + xy.y * v.axis_y;
        float slope = dot(normal, ray);
        float plane = abs(slope) > 1e-3 ? dot(receiver - v.origin, normal) / slope : z;
        float scale = length(ray);
        return texel(v.depth_range / depth * scale, min(plane * scale, limit));
    }
    return none;
}

bool blocks(texel t, float bias)
{
    return t.light_distance >= 0 && t.light_distance < t.receiver_distance - bias;
}

// Points of a disk, evenly spread (Vogel's spiral), turned by `angle`.
vec2 disk(int i, int count, float angle)
{
    float r = sqrt((float(i) + 0.5) / float(count));
    float a = float(i) * 2.39996323 + angle;
    return r * vec2(cos(a), sin(a));
}

// Jimenez's interleaved gradient noise: neighbouring pixels get well-spread turns.
float pixel_angle(vec2 pixel)
{
    return 6.2831853 * fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}

float visibility(vec3 p, vec3 normal)
{
    vec3 to_light = light.orthographic != 0 ? -views[0].axis_z : light.proxy - p;
    float distance = length(to_light);
    vec3 l = to_light / distance;
    vec3 side = normalize(abs(l.y) < 0.9 ? cross(l, vec3(0, 1, 0)) : cross(l, vec3(1, 0, 0)));
    vec3 up = cross(side, l);
    float angle = pixel_angle(gl_FragCoord.xy);

    float eye_distance = light.orthographic != 0 ? dot(p - views[0].origin, views[0].axis_z) : distance;
    float texel_size = 2 * views[0].tangent / light.face_size * (light.orthographic != 0 ? 1.0 : distance);
    float bias = texel_size * 1.5;
    float search = light.soft_radius * (light.orthographic != 0 ? eye_distance * 0.25 : 1.0);
    search = max(search, texel_size);

    float blockers = 0, sum = 0;
    for (int i = 0; i < BLOCKER_SAMPLES; i++) {
        vec2 d = disk(i, BLOCKER_SAMPLES, angle) * search;
        texel t = look(p + side * d.x + up * d.y, p, normal, eye_distance);
        if (blocks(t, bias)) {
            blockers += 1;
            sum += t.light_distance;
        }
    }
    if (blockers == 0)
        return 1;
    float blocker = sum / blockers;
    float width = light.orthographic != 0
                      ? light.soft_radius * max(eye_distance - blocker, 0)
                      : light.soft_radius * max(distance - blocker, 0) / max(blocker, 1e-3 * distance);
    width = clamp(width, texel_size * 1.5, max(2 * search, texel_size * 1.5));
    float open = 0;
    for (int i = 0; i < FILTER_SAMPLES; i++) {
        vec2 d = disk(i, FILTER_SAMPLES, angle) * width;
        open += blocks(look(p + side * d.x + up * d.y, p, normal, eye_distance), bias) ? 0.0 : 1.0;
    }
    return open / float(FILTER_SAMPLES);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(position_map, at, 0);
    if (position.w == 0) {
        out_unshadowed = out_direct = vec4(0);
        return;
    }
    vec4 normal_roughness = texelFetch(normal_map, at, 0);
    vec4 diffuse = texelFetch(diffuse_map, at, 0);
    vec4 specular = texelFetch(specular_map, at, 0);
    vec3 n = normal_roughness.xyz, p = position.xyz;
    vec3 flat_normal = from_octahedral(vec2(diffuse.w, specular.w));
    vec3 v = normalize(view.position - p);
    float n_v = max(dot(n, v), 1e-4);

    vec3 sum = vec3(0);
    for (uint i = 0; i < light.vpl_count; i++) {
        vec3 l, irradiance = vpls[i].weight;
        float roughness = normal_roughness.w;
        if (light.vpl_kind == NG_VPL_DIRECTIONAL) {
            l = -vpls[i].normal;
        } else {
            vec3 d = vpls[i].position - p;
            float square = max(dot(d, d), 1e-8);
            l = d * inversesqrt(square);
            // A VPL stands for a patch, not a point: near ones are clamped to the patch's size, and highlights are as
            // wide as the patch looks.
            irradiance /= max(square, light.vpl_radius * light.vpl_radius);
            irradiance *= light.vpl_kind == NG_VPL_AREA ? max(-dot(vpls[i].normal, l), 0.0) : light_cone(light, -l);
            float alpha = min(roughness * roughness + 0.5 * light.vpl_radius * inversesqrt(square), 1.0);
            roughness = sqrt(alpha);
        }
        float n_l = dot(n, l);
        if (n_l <= 0 || dot(flat_normal, l) <= 0)
            continue;
        vec3 h = normalize(l + v);
        float v_h = max(dot(v, h), 0.0), n_h = max(dot(n, h), 0.0);
        vec3 brdf;
        for (int c = 0; c < 3; c++)
            brdf[c] = ng_brdf(n_l, n_v, n_h, v_h, diffuse[c], specular[c], roughness);
        sum += brdf * irradiance * n_l;
    }
    out_unshadowed = vec4(sum, 0);
    out_direct = sum == vec3(0) ? vec4(0) : vec4(sum * visibility(p, flat_normal), 0);
}
