// The map of an environment light, as components/light_environment.h has it: its centre looks along -Z, x grows to the
// right of it, row 0 is +Y.
layout(push_constant, scalar) uniform Push {
    vec4 world_to_map[3]; // rotation
    vec3 radiance;        // factor on the map
} push;

// In the map's own frame.
vec3 environment_direction(vec3 d)
{
    return vec3(dot(push.world_to_map[0].xyz, d), dot(push.world_to_map[1].xyz, d), dot(push.world_to_map[2].xyz, d));
}

vec2 environment_uv(vec3 own)
{
    return vec2(0.5 + atan(own.x, -own.z) * 0.15915494, acos(clamp(own.y, -1.0, 1.0)) * 0.31830989);
}
