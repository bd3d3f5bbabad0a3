// How much of a sky reaches each pixel, of what it would reflect of all of it.
//
// A sky shines from everywhere, so one depth map tells nothing of it: a wall beside a window hides other directions than
// the ceiling does. Every direct VPL, or the first of them, has a map of its own here. A second look, beside the first, blends the edges of
// neighbouring directions. It may look past a wall, so what it adds is at most what the first looks have found: where
// those find nothing, as in a closed room, it is dark.
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
layout(set = 0, binding = 7, scalar) readonly buffer Views { ng_light_view_data sky[]; };
layout(set = 0, binding = 8, scalar) readonly buffer Light { ng_light_data light; };
layout(set = 0, binding = 9, scalar) readonly buffer Vpls { ng_vpl_data vpls[]; };

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out float out_visibility;

#include "geometry.glsl"
#include "view.glsl"
#include "reflector.glsl"

const float BIAS = 0.25; // texels
const float LEAST_WIDTH = 1; // of a highlight, tangent: as wide as several directions are apart, or each would be a spot
const float SOFTNESS = 0.2; // tangent of the half angle over which edges are blended

float size; // of a map, texels
float radius; // half of its width and of its depth, metres

// How far before the receiver the map of a direction holds something, metres; 0: nothing is there. `p` and `n` are its
// place and normal in that map's axes, from the middle of the scene. What the map holds is compared with the receiver's
// tangent plane at that texel.
float gap_at(int i, vec3 p, vec3 n, vec2 at)
{
    float depth = texelFetch(depth_map, ivec3(clamp(at, vec2(0), vec2(size - 1)), i), 0).r;
    vec2 offset = ((at + 0.5) / size * 2 - 1) * radius - p.xy;
    float plane = p.z - dot(n.xy, offset) / min(n.z, -1e-3);
    float found = depth > 0 ? (1 - 2 * depth) * radius : 1e30;
    return found < min(plane, p.z) - BIAS * 2 * radius / size ? p.z - found : 0;
}

vec2 texel_of(vec2 p)
{
    return (p / radius * 0.5 + 0.5) * size;
}

// The same of the four texels around, so that nothing shines in between two walls that meet.
float gap_around(int i, vec3 p, vec3 n)
{
    vec2 at = floor(texel_of(p.xy) - 0.5);
    return max(max(gap_at(i, p, n, at), gap_at(i, p, n, at + vec2(1, 0))),
               max(gap_at(i, p, n, at + vec2(0, 1)), gap_at(i, p, n, at + vec2(1, 1))));
}

// The axes of the map that looks along z (ng_light_gpu_sky_view): reading them costs more than to find them.
mat3 axes_of(vec3 z)
{
    vec3 x = normalize(abs(z.y) < 0.9 ? vec3(-z.z, 0, z.x) : vec3(z.y, -z.x, 0));
    return mat3(x, cross(z, x), z);
}

// Jimenez's interleaved gradient noise, as in visibility.frag.
float noise(vec2 pixel)
{
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(position_map, at, 0);
    out_visibility = 1;
    if (position.w <= 0)
        return;
    const vec2 golden = vec2(-0.73736888, 0.67549029);
    reflector r = reflector_at(at, position.xyz);
    radius = sky[0].tangent;
    size = float(textureSize(depth_map, 0).x);
    vec3 middle = sky[0].origin + sky[0].axis_z * radius, from_middle = position.xyz - middle;
    float start = noise(gl_FragCoord.xy);
    vec2 turn = vec2(cos(6.2831853 * start), sin(6.2831853 * start));
    float all = 0, open = 0, lost = 0, gained = 0, gaps = 0, blocked = 0;
    int count = textureSize(depth_map, 0).z;
    for (int i = 0; i < count; i++) {
        vec3 sum = reflected(r, -vpls[i].normal, vpls[i].weight, max(light.vpl_radius, LEAST_WIDTH));
        float weight = sum.r + sum.g + sum.b;
        turn = vec2(turn.x * golden.x - turn.y * golden.y, turn.x * golden.y + turn.y * golden.x);
        if (weight <= 0)
            continue;
        all += weight;
        mat3 axes = axes_of(vpls[i].normal);
        vec3 p = from_middle * axes, n = r.flat_normal * axes;
        float g = gap_around(i, p, n);
        blocked += g > 0 ? 1 : 0;
        gaps += g;
        float reach = g > 0 ? g : gaps / max(blocked, 1);
        float spread = sqrt(fract(start + 0.61803399 * float(i)));
        bool hidden = reach > 0 && gap_at(i, p, n, floor(texel_of(p.xy + turn * (spread * SOFTNESS * reach)))) > 0;
        open += g > 0 ? 0 : weight;
        lost += g <= 0 && hidden ? weight : 0;
        gained += g > 0 && !hidden ? weight : 0;
    }
    out_visibility = all > 0 ? (open - lost + min(gained, open)) / all : 1;
}
