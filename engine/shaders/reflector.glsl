// A pixel of the G-buffer as what reflects the light of direct VPLs. Included where its maps are bound.
struct reflector {
    vec3 normal, flat_normal, to_eye; // of unit length
    vec3 diffuse, f0;
    float alpha, n_v;
};

reflector reflector_at(ivec2 at, vec3 position)
{
    vec4 normal_roughness = texelFetch(normal_map, at, 0);
    vec4 diffuse = texelFetch(diffuse_map, at, 0);
    vec4 specular = texelFetch(specular_map, at, 0);
    reflector r;
    r.normal = normal_roughness.xyz;
    r.flat_normal = flat_normal(diffuse.w, specular.w);
    r.to_eye = normalize(to_eye(position));
    r.diffuse = diffuse.xyz;
    r.f0 = specular.xyz;
    r.alpha = normal_roughness.w * normal_roughness.w;
    r.n_v = max(dot(r.normal, r.to_eye), 1e-4);
    return r;
}

// Radiance to the eye of light from the direction l, as if the specular lobe had this roughness; so much of it.
vec3 reflected_light(reflector r, vec3 l, vec3 irradiance, float roughness, float specular)
{
    float n_l = dot(r.normal, l);
    if (n_l <= 0)
        return vec3(0);
    vec3 h = normalize(l + r.to_eye), sum;
    float v_h = max(dot(r.to_eye, h), 0.0), n_h = max(dot(r.normal, h), 0.0);
    float lobe = ng_brdf_lobe(n_l, r.n_v, n_h, roughness) * specular;
    for (int c = 0; c < 3; c++)
        sum[c] = (ng_brdf_diffuse(n_l, r.n_v, v_h, r.diffuse[c], r.f0[c]) + lobe * ng_brdf_f(v_h, r.f0[c])) *
                 irradiance[c] * n_l;
    return sum;
}

// The same of a VPL. Highlights are at least as wide as the patch looks that the VPL stands for, or they would show the
// VPLs one by one.
vec3 reflected(reflector r, vec3 l, vec3 irradiance, float patch_tangent)
{
    if (dot(r.flat_normal, l) <= 0)
        return vec3(0);
    return reflected_light(r, l, irradiance, sqrt(min(r.alpha + 0.5 * patch_tangent, 1.0)), 1);
}
