// Fragment side of surface.vert.glsl: a surface's material at a point, from factors and textures.
#include "shared/scene.h"
#include "shared/brdf.h"

layout(set = 0, binding = 1, scalar) readonly buffer Instances { ng_instance_data instances[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Materials { ng_material_data materials[]; };

layout(location = 0) in vec3 in_normal;
layout(location = 1) flat in uint in_instance;
#ifdef NG_TEXTURED
layout(set = 1, binding = 0) uniform sampler2D base_color_map;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_map;
layout(set = 1, binding = 2) uniform sampler2D normal_map;
layout(set = 1, binding = 3) uniform sampler2D emissive_map;
layout(set = 1, binding = 4) uniform sampler2D specular_weight_map;
layout(set = 1, binding = 5) uniform sampler2D specular_color_map;
#include "cut.glsl"
layout(location = 2) in vec4 in_tangent;
#ifdef NG_FULL
layout(location = 6) in vec2 in_uvs[NG_MATERIAL_TEXTURES]; // by the texture's slot
layout(location = 12) in vec4 in_color;
#define TEXTURE_UV(slot) in_uvs[slot]
#else
layout(location = 3) in vec2 in_uv;
#define TEXTURE_UV(slot) in_uv
#endif
#endif

struct surface {
    vec3 normal;   // shading normal, towards the side that is seen
    vec3 diffuse;  // albedo of the diffuse lobe
    vec3 f0;
    vec3 emission; // radiance towards the front; nothing behind a one-sided surface
    float roughness;
    bool front; // the side that the triangle's order calls front, mirrored placements considered
    bool unlit; // reflects nothing
};

surface surface_load(ng_material_data m, ng_instance_data instance)
{
    vec3 base = m.base_color, emission = m.emission, specular_color = m.specular_color;
    float metallic = m.metallic, roughness = m.roughness, specular = m.specular;
    vec3 normal = normalize(in_normal);
    bool front = gl_FrontFacing != ((instance.flags & NG_INSTANCE_MIRRORED) != 0);
    bool unlit = (m.flags & NG_MATERIAL_UNLIT) != 0;
#ifdef NG_TEXTURED
    vec2 uv = TEXTURE_UV(NG_SLOT_BASE_COLOR);
    vec4 color = texture(base_color_map, uv);
    float alpha = m.alpha;
    base *= color.rgb;
#ifdef NG_FULL
    base *= in_color.rgb;
    alpha *= in_color.a;
#endif
    if (is_cut(m, instance, front, color.a, textureQueryLod(base_color_map, uv).x, alpha))
        discard;
    vec4 metal_rough = texture(metallic_roughness_map, TEXTURE_UV(NG_SLOT_METALLIC_ROUGHNESS));
    metallic *= metal_rough.b;
    roughness *= metal_rough.g;
    emission *= texture(emissive_map, TEXTURE_UV(NG_SLOT_EMISSIVE)).rgb;
    if ((m.flags & NG_MATERIAL_SPECULAR_MAPS) != 0) {
        specular *= texture(specular_weight_map, TEXTURE_UV(NG_SLOT_SPECULAR)).a;
        specular_color *= texture(specular_color_map, TEXTURE_UV(NG_SLOT_SPECULAR_COLOR)).rgb;
    }
    if ((m.flags & NG_MATERIAL_NORMAL_MAP) != 0) {
        // The bitangent from the interpolated normal and tangent, as the glTF specification asks (3.7.2.1).
        vec3 tangent = in_tangent.xyz - normal * dot(normal, in_tangent.xyz);
        float size = dot(tangent, tangent);
        if (size > 0) {
            tangent *= inversesqrt(size);
            vec3 bitangent = cross(normal, tangent) * in_tangent.w;
            vec3 t = texture(normal_map, TEXTURE_UV(NG_SLOT_NORMAL)).xyz * 2 - 1;
            t.xy *= m.normal_scale;
            normal = normalize(tangent * t.x + bitangent * t.y + normal * t.z);
        }
    }
#endif
    if (unlit)
        emission = base;
    if (!front) {
        normal = -normal;
        if ((m.flags & NG_MATERIAL_DOUBLE_SIDED) == 0)
            emission = vec3(0);
    }
    surface s;
    s.normal = normal;
    for (int i = 0; i < 3; i++) {
        s.diffuse[i] = unlit ? 0 : ng_brdf_albedo(base[i], metallic);
        s.f0[i] = unlit ? 0 : ng_brdf_f0(ng_brdf_dielectric(specular_color[i], specular), base[i], metallic);
    }
    s.emission = emission;
    s.roughness = clamp(roughness, NG_ROUGHNESS_MIN, 1.0);
    s.front = front;
    s.unlit = unlit;
    return s;
}

// Of the shading normal and the triangle's, which is returned, the one that is right (NG_NORMAL_CONTRADICTION).
// `to_eye` points to the side that is seen.
vec3 surface_settle(inout surface s, vec3 position, vec3 to_eye)
{
    vec3 flat_normal = normalize(cross(dFdx(position), dFdy(position)));
    if (dot(flat_normal, to_eye) < 0)
        flat_normal = -flat_normal;
    if (!(dot(flat_normal, flat_normal) > 0.5)) // slivers seen edge-on have no usable derivatives
        flat_normal = s.normal;
    if (!(dot(flat_normal, s.normal) > NG_NORMAL_CONTRADICTION))
        s.normal = flat_normal;
    return flat_normal;
}

// As whoever looks from the direction `v`, unit, sees its reflections (ng_brdf_lift).
void surface_lift(inout surface s, vec3 flat_normal, vec3 v)
{
    float albedo = max(max(s.diffuse.r, s.diffuse.g), s.diffuse.b), f0 = max(max(s.f0.r, s.f0.g), s.f0.b);
    float lift = ng_brdf_lift(dot(s.normal, flat_normal), dot(v, flat_normal), dot(s.normal, v),
                              ng_brdf_specular_part(albedo, f0));
    if (lift > 0)
        s.normal = normalize(s.normal + flat_normal * lift);
}
