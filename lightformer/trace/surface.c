// Follows engine/shaders/surface.frag.glsl line by line, so that the G-buffer and the reference agree.
#include "lightformer/trace/surface.h"

#include "lightformer/trace/tracer_internal.h"
#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"

#include <string.h>

static const struct ng_image *image_of(const struct ng_snapshot *s, uint32_t index)
{
    return index == NG_NONE ? NULL : s->images[index].image;
}

// An attribute of the mesh's vertices at a point of a triangle.
static void interpolate(const struct ng_snapshot_mesh *mesh, const float *attribute, uint32_t width,
                        uint32_t triangle, const float b[2], float *out)
{
    const uint32_t *index = mesh->indices + (size_t)triangle * 3;
    const float weights[3] = {1 - b[0] - b[1], b[0], b[1]};
    for (uint32_t c = 0; c < width; c++) {
        out[c] = 0;
        for (int i = 0; i < 3; i++)
            out[c] += weights[i] * attribute[(size_t)index[i] * width + c];
    }
}

bool lf_surface_is_cut(const struct lf_tracer *tracer, uint32_t instance, uint32_t triangle,
                       const float barycentric[2])
{
    const struct ng_snapshot *s = lf_tracer_snapshot(tracer);
    const struct ng_snapshot_instance *in = &s->instances[instance];
    const struct ng_snapshot_material *m = &s->materials[in->material];
    float uv[2], rgba[4];
    if (!m->alpha_mask)
        return false;
    interpolate(&s->meshes[in->mesh], s->meshes[in->mesh].uvs, 2, triangle, barycentric, uv);
    lf_texture_at(lf_tracer_srgb(tracer), image_of(s, m->base_color_image), uv, rgba);
    return rgba[3] * m->alpha < m->alpha_cutoff;
}

// Normals go with the cofactors of the matrix, whose sign mirrors would turn inside out.
static void transform_normal(const float m[12], const float n[3], float out[3])
{
    const float *r0 = m, *r1 = m + 4, *r2 = m + 8;
    float c0[3], c1[3], c2[3];
    lf_cross(r1, r2, c0);
    lf_cross(r2, r0, c1);
    lf_cross(r0, r1, c2);
    float sign = lf_dot(r0, c0) < 0 ? -1.0f : 1.0f;
    const float v[3] = {sign * lf_dot(c0, n), sign * lf_dot(c1, n), sign * lf_dot(c2, n)};
    memcpy(out, v, sizeof v);
}

// The normal map's turn of `normal`; the bitangent from the interpolated normal and tangent (glTF 2.0,
// 3.7.2.1).
static void bend_normal(const struct lf_srgb *srgb, const struct ng_image *image, float scale,
                        const float tangent4[4], const float uv[2], float normal[3])
{
    float texel[4], tangent[3], bitangent[3];
    lf_mad(tangent4, normal, -lf_dot(normal, tangent4), tangent);
    if (!lf_normalize(tangent))
        return;
    lf_cross(normal, tangent, bitangent);
    lf_texture_at(srgb, image, uv, texel);
    float x = (texel[0] * 2 - 1) * scale, y = (texel[1] * 2 - 1) * scale * tangent4[3], z = texel[2] * 2 - 1;
    const float bent[3] = {tangent[0] * x + bitangent[0] * y + normal[0] * z,
                           tangent[1] * x + bitangent[1] * y + normal[1] * z,
                           tangent[2] * x + bitangent[2] * y + normal[2] * z};
    memcpy(normal, bent, sizeof bent);
    lf_normalize(normal);
}

static void find_shading_normal(const struct lf_tracer *tracer, const struct lf_hit *hit,
                                const struct ng_snapshot_material *m, struct lf_surface *out)
{
    const struct ng_snapshot *s = lf_tracer_snapshot(tracer);
    const struct ng_snapshot_instance *in = &s->instances[hit->instance];
    const struct ng_snapshot_mesh *mesh = &s->meshes[in->mesh];
    float n[3], tangent[4];
    interpolate(mesh, mesh->normals, 3, hit->triangle, hit->barycentric, n);
    transform_normal(in->matrix, n, n);
    if (!lf_normalize(n))
        return;
    memcpy(out->normal, n, sizeof n);
    if (m->normal_image == NG_NONE)
        return;
    interpolate(mesh, mesh->tangents, 4, hit->triangle, hit->barycentric, tangent);
    lf_transform_vector(in->matrix, tangent, tangent);
    bend_normal(lf_tracer_srgb(tracer), image_of(s, m->normal_image), m->normal_scale, tangent, out->uv,
                out->normal);
}

static bool is_textured(const struct ng_snapshot_material *m)
{
    return m->base_color_image != NG_NONE || m->metallic_roughness_image != NG_NONE ||
           m->normal_image != NG_NONE || m->emissive_image != NG_NONE;
}

// Factors times textures.
static void find_material(const struct lf_tracer *tracer, const struct ng_snapshot_material *m,
                          struct lf_surface *out)
{
    const struct ng_snapshot *s = lf_tracer_snapshot(tracer);
    const struct lf_srgb *srgb = lf_tracer_srgb(tracer);
    float base[4] = {1, 1, 1, 1}, metal_rough[4] = {1, 1, 1, 1}, emission[4] = {1, 1, 1, 1};
    if (is_textured(m)) {
        lf_texture_at(srgb, image_of(s, m->base_color_image), out->uv, base);
        lf_texture_at(srgb, image_of(s, m->metallic_roughness_image), out->uv, metal_rough);
        lf_texture_at(srgb, image_of(s, m->emissive_image), out->uv, emission);
    }
    float metallic = m->metallic * metal_rough[2];
    for (int i = 0; i < 3; i++) {
        out->albedo[i] = ng_brdf_albedo(m->base_color[i] * base[i], metallic);
        out->f0[i] = ng_brdf_f0(m->base_color[i] * base[i], metallic);
        out->emission[i] = m->emission[i] * emission[i];
    }
    out->roughness = ng_clamp(m->roughness * metal_rough[1], NG_ROUGHNESS_MIN, 1.0f);
}

void lf_surface_at(const struct lf_tracer *tracer, const struct lf_hit *hit, struct lf_surface *out)
{
    const struct ng_snapshot *s = lf_tracer_snapshot(tracer);
    const struct ng_snapshot_instance *in = &s->instances[hit->instance];
    const struct ng_snapshot_material *m = &s->materials[in->material];
    *out = (struct lf_surface){
        .light = in->light, .front = hit->front, .double_sided = (in->flags & NG_INSTANCE_DOUBLE_SIDED) != 0};
    memcpy(out->position, hit->position, sizeof out->position);
    memcpy(out->flat_normal, hit->normal, sizeof out->flat_normal);
    memcpy(out->normal, hit->normal, sizeof out->normal);
    if (lf_tracer_shape(tracer, hit->instance) == LF_SHAPE_TRIANGLES) {
        const struct ng_snapshot_mesh *mesh = &s->meshes[in->mesh];
        if (is_textured(m)) // what is not read is not waited for
            interpolate(mesh, mesh->uvs, 2, hit->triangle, hit->barycentric, out->uv);
        find_shading_normal(tracer, hit, m, out);
    }
    find_material(tracer, m, out);
    if (!hit->front) {
        lf_scale(out->flat_normal, -1, out->flat_normal);
        lf_scale(out->normal, -1, out->normal);
    }
    if (lf_surface_is_black(out) || in->light != NG_NONE)
        memset(out->emission, 0, sizeof out->emission);
}
