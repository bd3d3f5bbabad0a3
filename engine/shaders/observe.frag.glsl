// Flux = intensity toward the texel * its exact solid angle (orthographic: irradiance * area)
//        * (albedo + directional specular albedo), so that metals are not black.
#include "surface.frag.glsl"

layout(set = 0, binding = 7, scalar) readonly buffer Views { ng_light_view_data views[]; };
layout(set = 0, binding = 8, scalar) readonly buffer Light { ng_light_data light; };
layout(set = 0, binding = 9, scalar) readonly buffer Vpls { ng_vpl_data vpls[]; };
layout(push_constant, scalar) uniform Push { uint layer; } push;

layout(location = 4) in vec3 in_position;
layout(location = 5) flat in uint in_layer;

layout(location = 0) out vec4 out_position; // world; w: 1 where there is a surface
layout(location = 1) out vec4 out_normal;   // towards the light
layout(location = 2) out vec4 out_flux;     // W, reflected

#include "light.glsl"

// Solid angle of the rectangle from (0, 0) to (x, y) on the plane z = 1.
float corner_angle(float x, float y)
{
    return atan(x * y, sqrt(x * x + y * y + 1));
}

float texel_angle(vec2 center, float half_size)
{
    vec2 a = center - half_size, b = center + half_size;
    return corner_angle(b.x, b.y) - corner_angle(a.x, b.y) - corner_angle(b.x, a.y) + corner_angle(a.x, a.y);
}

void main()
{
    ng_instance_data instance = instances[in_instance];
    ng_material_data m = materials[instance.material];
    surface s = surface_load(m, instance);
    ng_light_view_data v = views[in_layer];
    vec2 xy = (gl_FragCoord.xy / float(NG_RSM_SIZE) * 2 - 1) * v.tangent;
    float half_size = v.tangent / float(NG_RSM_SIZE);
    vec3 direction;
    vec3 power;
    if (light.window_count != 0) {
        direction = v.axis_z;
        power = light_intensity(light, direction) * (4 * half_size * half_size);
    } else {
        direction = normalize(v.axis_z + xy.x * v.axis_x + xy.y * v.axis_y);
        power = light_intensity(light, direction) * texel_angle(xy, half_size);
    }
    surface_settle(s, in_position, -direction);
    float cosine = max(dot(s.normal, -direction), 0.0);
    // The back of a one-sided surface blocks light and reflects none.
    bool lit = !s.unlit && (s.front || (m.flags & NG_MATERIAL_DOUBLE_SIDED) != 0);
    vec3 reflectance = vec3(0);
    for (int i = 0; i < 3; i++)
        reflectance[i] = s.diffuse[i] + ng_brdf_specular_albedo(cosine, s.f0[i], s.roughness);
    out_position = vec4(in_position, 1);
    out_normal = vec4(s.normal, 0);
    out_flux = vec4(lit ? power * min(reflectance, vec3(1)) : vec3(0), 0);
}
