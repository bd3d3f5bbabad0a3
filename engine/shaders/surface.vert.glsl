// Vertex stage of the passes that shade surfaces: transforms a vertex and hands its attributes on.
// NG_TEXTURED adds what textures need, tangents and texture coordinates; NG_FULL, with it, the second texture
// coordinates and the colours of vertices.
#include "shared/scene.h"

layout(set = 0, binding = 0, scalar) uniform View { ng_view_data view; };
layout(set = 0, binding = 1, scalar) readonly buffer Instances { ng_instance_data instances[]; };

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
#ifdef NG_TEXTURED
layout(location = 2) in vec4 in_tangent;
layout(location = 3) in vec2 in_uv;
layout(location = 2) out vec4 out_tangent;
#ifdef NG_FULL
layout(location = 4) in vec2 in_uv1;
layout(location = 5) in vec4 in_color;
layout(location = 6) out vec2 out_uvs[NG_MATERIAL_TEXTURES]; // by the texture's slot
layout(location = 12) out vec4 out_color;
#include "texture_uv.glsl"
#else
layout(location = 3) out vec2 out_uv;
#endif
#endif

layout(location = 0) out vec3 out_normal;
layout(location = 1) flat out uint out_instance;

vec3 transform_point(vec4 m[3], vec3 p)
{
    return vec3(dot(m[0], vec4(p, 1)), dot(m[1], vec4(p, 1)), dot(m[2], vec4(p, 1)));
}

// Normals go with the cofactors of the matrix: right for any scale, and for mirrors (the sign of the determinant
// keeps them outside).
vec3 transform_normal(vec4 m[3], vec3 n)
{
    vec3 r0 = m[0].xyz, r1 = m[1].xyz, r2 = m[2].xyz;
    vec3 c0 = cross(r1, r2);
    vec3 v = vec3(dot(c0, n), dot(cross(r2, r0), n), dot(cross(r0, r1), n));
    return dot(r0, c0) < 0 ? -v : v;
}

#ifdef NG_TEXTURED
// Mirrors turn around the bitangent that is made of the transformed normal and tangent. Not by the instance's flag:
// mirrored skins have turned theirs already.
vec4 transform_tangent(vec4 m[3], vec4 t)
{
    bool mirrors = dot(m[0].xyz, cross(m[1].xyz, m[2].xyz)) < 0;
    return vec4(transform_point(m, t.xyz) - transform_point(m, vec3(0)), mirrors ? -t.w : t.w);
}

void write_surface(vec4 m[3])
{
    out_tangent = transform_tangent(m, in_tangent);
#ifdef NG_FULL
    uint material = instances[gl_InstanceIndex].material;
    for (uint slot = 0; slot < NG_MATERIAL_TEXTURES; slot++)
        out_uvs[slot] = texture_uv(material, slot);
    out_color = in_color;
#else
    out_uv = in_uv;
#endif
}
#endif
