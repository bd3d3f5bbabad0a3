// Everything of shaders/shared/brdf.h at once, for a random view, sample and surface; compiled as GLSL and as
// C.
#include "shared/brdf.h"

struct brdf_probe_in {
    float u1, u2, nv, roughness, f0, albedo;
};
struct brdf_probe_out {
    float hx, hy, hz, lx, ly, lz, cosine_x, cosine_z, f, pdf, specular_albedo, g1, lift;
};

NG_SHADER_FN NG_STRUCT(brdf_probe_out) brdf_probe(NG_STRUCT(brdf_probe_in) x)
{
    NG_STRUCT(ng_local_direction) v, h, l, c;
    v.x = ng_sqrt(1.0f - x.nv * x.nv);
    v.y = 0.0f;
    v.z = x.nv;
    h = ng_brdf_sample_half(v, x.roughness, x.u1, x.u2);
    l = ng_brdf_reflect(v, h);
    c = ng_brdf_sample_cosine(x.u1, x.u2);
    NG_STRUCT(brdf_probe_out) o;
    o.hx = h.x;
    o.hy = h.y;
    o.hz = h.z;
    o.lx = l.x;
    o.ly = l.y;
    o.lz = l.z;
    o.cosine_x = c.x;
    o.cosine_z = c.z;
    o.f = ng_brdf(l.z, v.z, h.z, v.x * h.x + v.z * h.z, x.albedo, x.f0, x.roughness);
    o.pdf = ng_brdf_sample_pdf(v.z, h.z, x.roughness);
    o.specular_albedo = ng_brdf_specular_albedo(x.nv, x.f0, x.roughness);
    o.g1 = ng_brdf_g1(x.nv, ng_brdf_alpha(x.roughness));
    o.lift = ng_brdf_lift(x.u1, x.nv, x.u2, x.f0);
    return o;
}
