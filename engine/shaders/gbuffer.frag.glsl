#include "surface.frag.glsl"

layout(set = 0, binding = 0, scalar) uniform View { ng_view_data view; };
#include "view.glsl"

layout(location = 0) out vec4 out_position;  // world; w: 1 where there is a surface, -1 if it reflects nothing
layout(location = 1) out vec4 out_normal;    // shading normal; w: roughness
layout(location = 2) out vec4 out_diffuse;   // w: x of the octahedral geometric normal
layout(location = 3) out vec4 out_specular;  // F0; w: y of the octahedral geometric normal
layout(location = 4) out vec4 out_emission;  // w: 1 on lamps
layout(location = 5) out vec2 out_motion;    // pixels, now - before, x right, y down
layout(location = 6) out uint out_entity;

#ifdef NG_MOVING
layout(location = 4) in vec3 in_previous;
#endif

// The point that this fragment shows: its pixel's ray, as far as its depth says.
vec3 position_from_depth()
{
    vec2 ndc = gl_FragCoord.xy / view.size * 2 - 1 + view.shift;
    if (view.range > 0)
        return view.position + ndc.x * view.right + ndc.y * view.down +
               view.forward * (view.near_plane + (1 - gl_FragCoord.z) * view.range);
    vec3 ray = view.forward + ndc.x * view.right + ndc.y * view.down;
    return view.position + ray * (view.near_plane / gl_FragCoord.z);
}

vec2 to_pixel(mat4 m, vec3 p)
{
    vec4 clip = m * vec4(p, 1);
    return (clip.xy / clip.w * 0.5 + 0.5) * view.size;
}

vec2 octahedral(vec3 n)
{
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 s = vec2(n.x >= 0 ? 1 : -1, n.y >= 0 ? 1 : -1);
    return n.z >= 0 ? n.xy : (1 - abs(n.yx)) * s;
}

void main()
{
    ng_instance_data instance = instances[in_instance];
    surface s = surface_load(materials[instance.material], instance);
    vec3 position = position_from_depth();
    vec3 flat_normal = surface_settle(s, position, to_eye(position));
    surface_lift(s, flat_normal, normalize(to_eye(position)));
    vec2 o = octahedral(flat_normal);
    out_position = vec4(position, s.unlit ? -1 : 1);
    out_normal = vec4(s.normal, s.roughness);
    out_diffuse = vec4(s.diffuse, o.x);
    out_specular = vec4(s.f0, o.y);
    out_emission = vec4(min(s.emission, NG_RADIANCE_MAX), (instance.flags & NG_INSTANCE_LAMP) != 0 ? 1 : 0);
#ifdef NG_MOVING
    vec3 previous = in_previous;
#else
    vec3 previous = position;
#endif
    out_motion = gl_FragCoord.xy - to_pixel(view.previous_view_projection, previous);
    out_entity = instance.entity;
}
