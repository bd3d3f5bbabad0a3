// Direct light of an environment. Most of its highlights come from its map: VPLs are too few for them, each would be a
// spot. Its brightest places they know best. So both share the highlights, by the balance heuristic.
#include "environment.glsl"
#include "spiral.glsl"

// Directions that the BRDF chooses: of a rough surface more than of a mirror, where all find one place of the map.
const float LEAST_SAMPLES = 16, MOST_SAMPLES = 48, SAMPLES_BY_ALPHA = 200;
const float WIDEN = -0.5; // levels: what is seen in the lobe stays in it

float samples_of(reflector r)
{
    return floor(min(LEAST_SAMPLES + SAMPLES_BY_ALPHA * r.alpha, MOST_SAMPLES));
}

// How much of what arrives around l, from within an angle of this tangent, passes the geometric horizon: all from above
// it, and less and less from below, so that the light of a VPL or a sample does not leave a facet at once.
float above(reflector r, vec3 l, float tangent)
{
    return clamp(1 + dot(r.flat_normal, l) / max(tangent, 1e-4), 0.0, 1.0);
}

// Radiance from around l, in the mean over a solid angle.
vec3 environment(vec3 l, float solid_angle)
{
    vec3 own = environment_direction(l);
    vec2 size = textureSize(environment_map, 0);
    float texel = 2 * NG_SHADER_PI * NG_SHADER_PI / (size.x * size.y) * sqrt(max(1 - own.y * own.y, 1e-4));
    float level = max(0.5 * log2(solid_angle / texel) + WIDEN, 0.0);
    return textureLod(environment_map, environment_uv(own), level).rgb * push.radiance;
}

// Without a branch (Duff et al. 2017). The same few samples in it serve all pixels.
mat3 frame_around(vec3 n)
{
    float s = n.z >= 0 ? 1 : -1, a = -1 / (s + n.z), b = n.x * n.y * a;
    return mat3(vec3(1 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

float mean_of_vpls()
{
    vec3 sum = vec3(0);
    for (uint i = 0; i < light.vpl_count; i++)
        sum += vpls[i].weight;
    return dot(sum, vec3(1.0 / 3)) / max(float(light.vpl_count), 1.0);
}

// What directions that the BRDF chooses find, each around it (Krivanek and Colbert 2008, "Real-time shading with filtered
// importance sampling").
vec3 reflected_map(reflector r)
{
    mat3 frame = frame_around(r.normal);
    ng_local_direction v;
    v.x = dot(r.to_eye, frame[0]);
    v.y = dot(r.to_eye, frame[1]);
    v.z = r.n_v;
    float count = samples_of(r), roughness = sqrt(r.alpha);
    float vpl = max(mean_of_vpls(), 1e-30); // all weigh about as much, so that radiance over this is their density
    vec2 turn = vec2(1, 0);
    vec3 sum = vec3(0);
    for (float i = 0.5; i < count; i++, turn = next_turn(turn)) {
        ng_local_direction h = ng_brdf_half(v, roughness, turn.x, turn.y, i / count);
        ng_local_direction l = ng_brdf_reflect(v, h);
        float density = count * ng_brdf_sample_pdf(v.z, h.z, roughness), solid_angle = 1 / density;
        vec3 direction = frame * vec3(l.x, l.y, l.z);
        float weight = ng_brdf_lobe(l.z, v.z, h.z, roughness) * l.z *
                       above(r, direction, sqrt(solid_angle / NG_SHADER_PI));
        float v_h = max(v.x * h.x + v.y * h.y + v.z * h.z, 0.0);
        if (!(weight > 0))
            continue;
        vec3 radiance = environment(direction, solid_angle);
        weight /= density + dot(radiance, vec3(1.0 / 3)) / vpl;
        for (int c = 0; c < 3; c++)
            sum[c] += weight * ng_brdf_f(v_h, r.f0[c]) * radiance[c];
    }
    return sum;
}

// Of a VPL what it is not alone to find.
vec3 reflected_vpl(reflector r, uint i)
{
    vec3 l = -vpls[i].normal;
    float n_h = max(dot(r.normal, normalize(l + r.to_eye)), 0.0), roughness = sqrt(r.alpha);
    float density = vpls[i].density, chosen = samples_of(r) * ng_brdf_sample_pdf(r.n_v, n_h, roughness);
    return reflected_light(r, l, vpls[i].weight * above(r, l, light.vpl_radius), roughness, density / (density + chosen));
}

vec3 reflected_environment(reflector r)
{
    vec3 sum = reflected_map(r);
    for (uint i = 0; i < light.vpl_count; i++)
        sum += reflected_vpl(r, i);
    return sum;
}
