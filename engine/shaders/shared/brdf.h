// The one BRDF of the project, as scalar functions of cosines, F0 and roughness: GLSL, C and the tests
// include this text. Definition: "Radiometry" in engine/README.md.
//
//   f = (1 - F(v.h)) * albedo / pi  +  D(h) * V(n.l, n.v) * F(v.h)        for n.l > 0 and n.v > 0, else 0
//
// D: GGX (Walter et al. 2007, eq. 33), alpha = roughness^2. V: height-correlated Smith masking-shadowing over
// 4 n.l n.v (Heitz 2014, eq. 99). F: Schlick 1994. Colours: call once a channel.
//
// The specular part alone never reflects more than it receives. The sum may, as glTF's does: a smooth
// dielectric of white albedo seen at a grazing angle reflects up to 1.9 (its diffuse term looks at v.h, not
// at n.v); over a hemisphere of uniform light, at most 1.05.
#ifndef NG_SHADERS_SHARED_BRDF_H
#define NG_SHADERS_SHARED_BRDF_H

#include "glsl_compat.h"

#define NG_ROUGHNESS_MIN        0.045f // below this alpha, fp32 highlights alias and overflow
// Cosine between a shading normal and its triangle's from which they contradict each other, as where a coarse
// mesh rounds an edge. There the triangle is right: all light that such a shading normal asks for is behind
// it.
#define NG_NORMAL_CONTRADICTION 0.1f
#define NG_LEAST_MIRROR         0.01f // cosine between a reflected ray and the geometric normal

NG_SHADER_FN float ng_brdf_alpha(float roughness)
{
    float r = ng_clamp(roughness, NG_ROUGHNESS_MIN, 1.0f);
    return r * r;
}

// Diffuse albedo and F0 of one channel of a metallic-roughness material (glTF 2.0, appendix B).
NG_SHADER_FN float ng_brdf_albedo(float base, float metallic)
{
    return base * (1.0f - metallic);
}
// `dielectric`: the F0 of what is no metal, 0.04 for an index of refraction of 1.5.
NG_SHADER_FN float ng_brdf_f0(float dielectric, float base, float metallic)
{
    return ng_mix(dielectric, base, metallic);
}
// The same of KHR_materials_specular, whose colour holds what the index of refraction makes of it.
NG_SHADER_FN float ng_brdf_dielectric(float specular_color, float specular)
{
    return ng_min(specular_color, 1.0f) * specular;
}

// Density of half vectors per steradian: its integral times n.h over the hemisphere is 1.
NG_SHADER_FN float ng_brdf_d(float nh, float alpha)
{
    float a2 = alpha * alpha;
    // 1 - nh^2 loses its digits near the peak of smooth surfaces; (1 - nh)(1 + nh) keeps them.
    float d = (1.0f - nh) * (1.0f + nh) + nh * nh * a2;
    return a2 / (NG_SHADER_PI * d * d);
}

// 2 n.x / (1 + Lambda) without the 2 n.x: the common part of G1 and V.
NG_SHADER_FN float ng_brdf_smith(float nx, float alpha)
{
    float a2 = alpha * alpha;
    return ng_sqrt(nx * nx * (1.0f - a2) + a2);
}

// Masking of one direction, Smith G1.
NG_SHADER_FN float ng_brdf_g1(float nx, float alpha)
{
    return 2.0f * nx / (nx + ng_brdf_smith(nx, alpha));
}

// G2 / (4 n.l n.v), where ng_brdf_smith of n.v is known: for sums over many directions of light.
NG_SHADER_FN float ng_brdf_v_known(float nl, float nv, float smith_nv, float alpha)
{
    return 0.5f / (nl * smith_nv + nv * ng_brdf_smith(nl, alpha));
}
NG_SHADER_FN float ng_brdf_v(float nl, float nv, float alpha)
{
    return ng_brdf_v_known(nl, nv, ng_brdf_smith(nv, alpha), alpha);
}

NG_SHADER_FN float ng_brdf_f(float vh, float f0)
{
    float m = ng_clamp(1.0f - vh, 0.0f, 1.0f);
    float m2 = m * m;
    return f0 + (1.0f - f0) * (m2 * m2 * m);
}

// The parts of f, without the cosine of the receiver, per steradian. Zero where a direction is below the
// surface.
NG_SHADER_FN float ng_brdf_diffuse(float nl, float nv, float vh, float albedo, float f0)
{
    return nl > 0.0f && nv > 0.0f ? (1.0f - ng_brdf_f(vh, f0)) * albedo / NG_SHADER_PI : 0.0f;
}
// What the channels of the specular part share: D V. Times ng_brdf_f it is the specular part.
NG_SHADER_FN float ng_brdf_lobe(float nl, float nv, float nh, float roughness)
{
    float alpha = ng_brdf_alpha(roughness);
    return nl > 0.0f && nv > 0.0f ? ng_brdf_d(nh, alpha) * ng_brdf_v(nl, nv, alpha) : 0.0f;
}
NG_SHADER_FN float ng_brdf_specular(float nl, float nv, float nh, float vh, float f0, float roughness)
{
    return ng_brdf_lobe(nl, nv, nh, roughness) * ng_brdf_f(vh, f0);
}
NG_SHADER_FN float ng_brdf(float nl, float nv, float nh, float vh, float albedo, float f0, float roughness)
{
    return ng_brdf_diffuse(nl, nv, vh, albedo, f0) + ng_brdf_specular(nl, nv, nh, vh, f0, roughness);
}

// Directional specular albedo: the part of light from a direction with cosine nv that the specular term
// reflects anywhere. Least-squares fit, by this project, to the integral: error at most 0.08, 0.02 in the
// root mean square. F = F0 + (1 - F0) m^5 makes it F0 * total + (1 - F0) * grazing.
NG_SHADER_FN float ng_brdf_specular_albedo(float nv, float f0, float roughness)
{
    float r = ng_clamp(roughness, NG_ROUGHNESS_MIN, 1.0f);
    float m = ng_clamp(1.0f - nv, 0.0f, 1.0f);
    float m2 = m * m, m4 = m2 * m2, m5 = m4 * m, m8 = m4 * m4, m20 = m8 * m8 * m4;
    float total = 0.9807f + r * (0.4193f - r * 1.1643f) + m * (0.0824f - r * (1.0278f - r * 1.3671f)) +
                  m8 * (-0.1372f + r * (0.7845f - r * 0.3039f));
    float grazing =
        m5 * (1.2515f - r * (2.5516f - r * 1.3459f)) + m20 * (-0.2446f + r * (0.1984f + r * 0.0909f));
    return ng_clamp(f0 * total + (1.0f - f0) * grazing, 0.0f, 1.0f);
}

// How much of the geometric normal g to add to the shading normal n, so that a mirror seen from v shows what
// is around it. Normal maps and vertex normals at silhouettes may turn n so far that the reflected ray leads
// into the surface: all that the lobe asks for is behind it then, and a metal would be black. So n turns
// towards g until that ray leads out, as Cycles has it ("ensure valid specular reflection"); where it does
// already, this is 0. Cosines: of n and g, of v and g (positive), of n and v. Normalize the sum.
//
// In the plane of n and g, with g upwards and n to the right, the viewer is at (vx, vg). The reflected ray,
// as long there, shall be at height `least`; half way between both is n. Diffuse light needs none of this:
// `specular` is the specular part's share of what the surface reflects.
NG_SHADER_FN float ng_brdf_lift(float ng, float vg, float nv, float specular)
{
    float up = ng_max(vg, 1e-6f),
          least = ng_min(0.9f * up, NG_LEAST_MIRROR); // steeper than v itself it need not be
    float sine = ng_sqrt(ng_max((1.0f - ng) * (1.0f + ng), 1e-12f));
    float vx = (nv - ng * up) / sine, rest = (up - least) * (up + least);
    float root = ng_sqrt(vx * vx + rest);
    float x = vx < 0.0f ? rest / (root - vx) : vx + root;
    float lift = (up + least) * sine / x - ng;
    float part = specular / ng_sqrt(ng_max(1.0f + lift * (2.0f * ng + lift), 1e-12f));
    return 2.0f * nv * ng - up < least ? lift * part / (1.0f - specular + part) : 0.0f;
}
// The largest channels of the surface's diffuse albedo and F0 make that share.
NG_SHADER_FN float ng_brdf_specular_part(float albedo, float f0)
{
    return f0 / ng_max(albedo + f0, 1e-6f);
}

// A unit vector in the frame of the surface, z along its normal.
struct ng_local_direction {
    float x, y, z;
};

// A half vector visible from v (v.z > 0), from u in [0, 1)^2: spherical caps (Dupuy and Benyoub 2023). Cosine
// and sine are those of 2 pi u1: who uses the same numbers at many surfaces computes them once.
NG_SHADER_FN NG_STRUCT(ng_local_direction)
    ng_brdf_half(NG_STRUCT(ng_local_direction) v, float roughness, float cosine, float sine, float u2)
{
    float alpha = ng_brdf_alpha(roughness);
    // Stretch v to the configuration of roughness 1, sample the cap of directions it can reflect to,
    // unstretch.
    float wx = v.x * alpha, wy = v.y * alpha;
    float inverse = 1.0f / ng_sqrt(wx * wx + wy * wy + v.z * v.z);
    wx *= inverse;
    wy *= inverse;
    float wz = v.z * inverse;
    float z = (1.0f - u2) * (1.0f + wz) - wz;
    float s = ng_sqrt(ng_clamp(1.0f - z * z, 0.0f, 1.0f));
    NG_STRUCT(ng_local_direction) h;
    h.x = (s * cosine + wx) * alpha;
    h.y = (s * sine + wy) * alpha;
    h.z = ng_max(z + wz, 0.0f);
    inverse = 1.0f / ng_sqrt(ng_max(h.x * h.x + h.y * h.y + h.z * h.z, 1e-30f));
    h.x *= inverse;
    h.y *= inverse;
    h.z *= inverse;
    return h;
}
NG_SHADER_FN NG_STRUCT(ng_local_direction)
    ng_brdf_sample_half(NG_STRUCT(ng_local_direction) v, float roughness, float u1, float u2)
{
    float phi = 2.0f * NG_SHADER_PI * u1;
    return ng_brdf_half(v, roughness, ng_cos(phi), ng_sin(phi), u2);
}

// The reflection of v about h; may be below the surface (z <= 0): such a sample is worth zero.
NG_SHADER_FN NG_STRUCT(ng_local_direction)
    ng_brdf_reflect(NG_STRUCT(ng_local_direction) v, NG_STRUCT(ng_local_direction) h)
{
    float twice = 2.0f * (v.x * h.x + v.y * h.y + v.z * h.z);
    NG_STRUCT(ng_local_direction) l;
    l.x = twice * h.x - v.x;
    l.y = twice * h.y - v.y;
    l.z = twice * h.z - v.z;
    return l;
}

// Density per steradian of the reflected direction so sampled. f * n.l / pdf = F * G2 / G1.
NG_SHADER_FN float ng_brdf_sample_pdf(float nv, float nh, float roughness)
{
    float alpha = ng_brdf_alpha(roughness);
    // G1 D v.h / n.v is the density of h; reflecting about h divides by 4 v.h; G1 / n.v is written out so
    // that it stays finite at grazing angles.
    return ng_brdf_d(nh, alpha) * 0.5f / (nv + ng_brdf_smith(nv, alpha));
}

// A cosine-weighted direction, for the diffuse part; density n.l / pi. Cosine and sine are those of 2 pi u1.
NG_SHADER_FN NG_STRUCT(ng_local_direction) ng_brdf_cosine(float cosine, float sine, float u2)
{
    float s = ng_sqrt(u2);
    NG_STRUCT(ng_local_direction) l;
    l.x = s * cosine;
    l.y = s * sine;
    l.z = ng_sqrt(ng_max(1.0f - u2, 0.0f));
    return l;
}
NG_SHADER_FN NG_STRUCT(ng_local_direction) ng_brdf_sample_cosine(float u1, float u2)
{
    float phi = 2.0f * NG_SHADER_PI * u1;
    return ng_brdf_cosine(ng_cos(phi), ng_sin(phi), u2);
}

#endif
