// Direct light of one light: its direct VPLs summed with the shared BRDF, times its visibility.
// Near an emitter how much of it there is comes from the emitter's surface. NG_ENVIRONMENT: of an environment.
#include "shared/scene.h"
#include "shared/brdf.h"

layout(set = 0, binding = 0, scalar) uniform View { ng_view_data view; };
layout(set = 0, binding = 1) uniform sampler2D position_map;
layout(set = 0, binding = 2) uniform sampler2D normal_map;
layout(set = 0, binding = 3) uniform sampler2D diffuse_map;
layout(set = 0, binding = 4) uniform sampler2D specular_map;
layout(set = 0, binding = 5) uniform sampler2D visibility_map;
#ifdef NG_ENVIRONMENT
layout(set = 0, binding = 6) uniform sampler2D environment_map;
#endif
layout(set = 0, binding = 8, scalar) readonly buffer Light { ng_light_data this_light; };
layout(set = 0, binding = 9, scalar) readonly buffer Vpls { ng_vpl_data vpls[]; };
#ifndef NG_ENVIRONMENT
layout(set = 0, binding = 10, scalar) readonly buffer Facets { ng_facet_data facets[]; };
#endif

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_unshadowed; // added over the lights
layout(location = 1) out vec4 out_direct;

ng_light_data light; // read once, not in each turn of a loop

#include "geometry.glsl"
#include "view.glsl"
#include "light.glsl"
#include "reflector.glsl"
#ifdef NG_ENVIRONMENT
#include "environment_light.glsl"
#else
#include "near_light.glsl"
#endif

// Visibility over the 3 x 3 pixels around, of those that lie on the receiver's tangent plane: the turns of
// visibility.frag's samples are spread evenly over such a block.
float filtered_visibility(ivec2 at, vec3 p, vec3 n)
{
    ivec2 last = textureSize(position_map, 0) - 1;
    float reach = 0.02 * eye_distance(p), sum = 0, weights = 0;
    int radius = light.soft_radius > 0 ? 1 : 0; // hard shadows stay hard
    for (int y = -radius; y <= radius; y++)
        for (int x = -radius; x <= radius; x++) {
            ivec2 q = clamp(at + ivec2(x, y), ivec2(0), last);
            vec4 other = texelFetch(position_map, q, 0);
            float w = other.w > 0 && abs(dot(other.xyz - p, n)) < 0.1 * reach ? 1.0 : 0.0;
            sum += w * texelFetch(visibility_map, q, 0).r;
            weights += w;
        }
    return weights > 0 ? sum / weights : texelFetch(visibility_map, at, 0).r;
}

#ifndef NG_ENVIRONMENT
// In radii of the patch that a VPL stands for: VPLs that are nearer than the first show one by one, than the second a little.
const float NEAR = 8, FAR = 16;
const float LEAST_FOUND = 0.2; // of the light that is there; where VPLs find less they do not tell what it looks like

// Sums over VPLs.
struct vpl_sum {
    vec3 radiance, irradiance; // reflected, and of the receiver
    float nearest;             // distance of a VPL over the radius of its patch, squared
};

// 1 to 0, by a distance in radii, squared.
float nearness(float square)
{
    return 1 - smoothstep(NEAR * NEAR, FAR * FAR, square);
}

void add_vpl(inout vpl_sum sum, reflector r, vec3 p, ng_vpl_data vpl)
{
    vec3 d = vpl.position - p;
    float square = max(dot(d, d), 1e-8);
    vec3 l = d * inversesqrt(square), irradiance = vpl.weight;
    float patch_tangent = light.vpl_radius * inversesqrt(square);
    if (light.vpl_kind == NG_VPL_AREA) {
        // A patch is no point: near ones are clamped to its size, softly.
        float patch_square = 1 / (NG_SHADER_PI * vpl.density), wide = patch_square / square;
        irradiance *= max(-dot(vpl.normal, l), 0.0) / (square * sqrt(1 + wide * wide));
        sum.nearest = min(sum.nearest, square / patch_square);
        patch_tangent *= 1 + nearness(4 * square / patch_square); // highlights of the nearest would be streaks
    } else
        irradiance *= light_cone(light, -l) / square;
    sum.irradiance += irradiance * max(dot(r.normal, l), 0.0);
    sum.radiance += reflected(r, l, irradiance, patch_tangent);
}

// Near an emitter the closed form tells how much light arrives, its VPLs what part of that is reflected.
vec3 corrected(vpl_sum sum, reflector r, vec3 p)
{
    float near = light.facet_count != 0 ? nearness(sum.nearest) : 0;
    vec3 irradiance = near_irradiance(p, r.normal, near > 0);
    vec3 missed = max(LEAST_FOUND * irradiance - sum.irradiance, vec3(0));
    vec3 radiance = sum.radiance + reflected_light(r, r.normal, missed, 1, 0);
    return near > 0 ? mix(sum.radiance, radiance * irradiance / max(sum.irradiance + missed, vec3(1e-30)), near) : sum.radiance;
}

vec3 reflected_vpls(reflector r, vec3 p)
{
    vpl_sum sum = vpl_sum(vec3(0), vec3(0), 1e30);
    if (light.vpl_kind == NG_VPL_DIRECTIONAL) {
        for (uint i = 0; i < light.vpl_count; i++)
            sum.radiance += reflected(r, -vpls[i].normal, vpls[i].weight, light.vpl_radius);
        return sum.radiance;
    }
    for (uint i = 0; i < light.vpl_count; i++)
        add_vpl(sum, r, p, vpls[i]);
    return corrected(sum, r, p);
}
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(position_map, at, 0);
    out_unshadowed = out_direct = vec4(0);
    if (position.w <= 0)
        return;
    light = this_light;
    vec3 p = position.xyz;
    reflector r = reflector_at(at, p);
#ifdef NG_ENVIRONMENT
    vec3 sum = reflected_environment(r);
#else
    vec3 sum = reflected_vpls(r, p);
#endif
    out_unshadowed = vec4(sum, 0);
    if (sum != vec3(0))
        out_direct = vec4(sum * filtered_visibility(at, p, r.flat_normal), 0);
}
