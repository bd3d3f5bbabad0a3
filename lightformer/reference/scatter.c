#include "lightformer/reference/scatter.h"

#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"

#include <string.h>

#define LEAST_VIEW_COSINE 1e-4f
#define LEAST_SHARE       0.1f // of a lobe that is there at all

// A frame around a unit normal without a branch that jumps (Duff et al. 2017).
static void make_frame(const float n[3], float tangent[3], float bitangent[3])
{
    float sign = copysignf(1.0f, n[2]), a = -1.0f / (sign + n[2]), b = n[0] * n[1] * a;
    const float t[3] = {1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]};
    const float c[3] = {b, sign + n[1] * n[1] * a, -n[1]};
    memcpy(tangent, t, sizeof t);
    memcpy(bitangent, c, sizeof c);
}

static void to_local(const struct lf_scatter *s, const float d[3], float out[3])
{
    out[0] = lf_dot(s->tangent, d);
    out[1] = lf_dot(s->bitangent, d);
    out[2] = lf_dot(s->surface->normal, d);
}

// Estimated reflectance of the two lobes decides how often each is chosen.
static float specular_share(const struct lf_surface *s, float nv)
{
    float f0 = lf_mean(s->f0), specular = ng_brdf_specular_albedo(nv, f0, s->roughness);
    float diffuse = lf_mean(s->albedo) * (1 - ng_brdf_f(nv, f0));
    if (!(diffuse > 0))
        return 1;
    return ng_clamp(specular / (specular + diffuse), LEAST_SHARE, 1 - LEAST_SHARE);
}

void lf_scatter_at(const struct lf_surface *surface, const float toward[3], struct lf_scatter *out)
{
    out->surface = surface;
    make_frame(surface->normal, out->tangent, out->bitangent);
    to_local(out, toward, out->view);
    float *v = out->view;
    if (v[2] < LEAST_VIEW_COSINE) {
        float flat = sqrtf(v[0] * v[0] + v[1] * v[1]);
        float scale = flat > 0 ? sqrtf(1 - LEAST_VIEW_COSINE * LEAST_VIEW_COSINE) / flat : 0;
        v[0] = flat > 0 ? v[0] * scale : 1;
        v[1] *= scale;
        v[2] = LEAST_VIEW_COSINE;
    }
    out->specular_share = specular_share(surface, v[2]);
}

// `l`: the direction in the frame, above the surface.
static void eval_local(const struct lf_scatter *s, const float l[3], struct lf_scatter_value *out)
{
    const struct lf_surface *at = s->surface;
    const float *v = s->view, h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
    float inverse = 1 / sqrtf(lf_dot(h, h)); // both are above, so that h is not zero
    float nl = l[2], nv = v[2], nh = h[2] * inverse, vh = lf_max(lf_dot(v, h) * inverse, 0);
    float lobe = ng_brdf_lobe(nl, nv, nh, at->roughness);
    for (int i = 0; i < 3; i++)
        out->value[i] =
            nl * (ng_brdf_diffuse(nl, nv, vh, at->albedo[i], at->f0[i]) + lobe * ng_brdf_f(vh, at->f0[i]));
    out->pdf = s->specular_share * ng_brdf_sample_pdf(nv, nh, at->roughness) +
               (1 - s->specular_share) * nl / NG_SHADER_PI;
}

bool lf_scatter_eval(const struct lf_scatter *s, const float direction[3], struct lf_scatter_value *out)
{
    float l[3];
    to_local(s, direction, l);
    if (!(l[2] > 0) || !(lf_dot(s->surface->flat_normal, direction) > 0))
        return false;
    eval_local(s, l, out);
    return lf_max3(out->value) > 0;
}

bool lf_scatter_sample(const struct lf_scatter *s, const float u[2], float direction[3],
                       struct lf_scatter_value *out)
{
    // What is left of u[0] after the choice of a lobe is uniform again.
    float share = s->specular_share, rest = u[0] < share ? u[0] / share : (u[0] - share) / (1 - share);
    struct ng_local_direction v = {s->view[0], s->view[1], s->view[2]}, d;
    if (u[0] < share)
        d = ng_brdf_reflect(v, ng_brdf_sample_half(v, s->surface->roughness, rest, u[1]));
    else
        d = ng_brdf_sample_cosine(rest, u[1]);
    const float l[3] = {d.x, d.y, d.z}; // unit, as the frame is
    for (int i = 0; i < 3; i++)
        direction[i] = s->tangent[i] * l[0] + s->bitangent[i] * l[1] + s->surface->normal[i] * l[2];
    if (!(l[2] > 0) || !(lf_dot(s->surface->flat_normal, direction) > 0))
        return false;
    eval_local(s, l, out);
    return lf_max3(out->value) > 0 && out->pdf > 0;
}
