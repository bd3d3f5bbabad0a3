// Light of a direct VPL, whatever the type of its light. Included by the passes that sum over VPLs.

// What the cone of a spot light leaves in a direction (KHR_lights_punctual); 1 for every other light.
float light_cone(ng_light_data light, vec3 direction)
{
    float a = clamp(dot(light.look, direction) * light.cone_scale + light.cone_offset, 0.0, 1.0);
    return a * a;
}

// Intensity that leaves the light's proxy in a direction: W/sr. Orthographic: irradiance across the view, W/m2.
vec3 light_intensity(ng_light_data light, vec3 direction)
{
    vec3 sum = vec3(0);
    for (uint i = 0; i < light.vpl_count; i++) {
        float c = light.vpl_kind == NG_VPL_POINT ? 1.0 : max(dot(vpls[i].normal, direction), 0.0);
        sum += vpls[i].weight * c;
    }
    return sum * light_cone(light, direction);
}
