// Direct light of one light: its direct VPLs summed with the shared BRDF, times its visibility.
// NG_ENVIRONMENT: of an environment.
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

vec3 reflected_vpls(reflector r, vec3 p)
{
    vec3 sum = vec3(0);
    for (uint i = 0; i < light.vpl_count; i++) {
        vec3 l, irradiance = vpls[i].weight;
        float patch_tangent = light.vpl_radius; // under which the receiver sees the patch that the VPL stands for
        if (light.vpl_kind == NG_VPL_DIRECTIONAL) {
            l = -vpls[i].normal;
        } else {
            vec3 d = vpls[i].position - p;
            float square = max(dot(d, d), 1e-8);
            l = d * inversesqrt(square);
            patch_tangent *= inversesqrt(square);
            // A patch is no point: near ones are clamped to their size.
            irradiance /= max(square, light.vpl_radius * light.vpl_radius);
            irradiance *= light.vpl_kind == NG_VPL_AREA ? max(-dot(vpls[i].normal, l), 0.0) : light_cone(light, -l);
        }
        sum += reflected(r, l, irradiance, patch_tangent);
    }
    return sum;
}

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
