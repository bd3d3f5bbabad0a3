// Follows engine/shaders/surface.frag.glsl line by line, so that the G-buffer and the reference agree.
#include "lightformer/trace/surface.h"

#include "lightformer/trace/tracer_internal.h"
#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"
#include "shaders/shared/scene.h"

#include <cglm/cglm.h>
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

// A texture of the material at a hit; white where it has none.
static void read_texture(const struct lf_tracer *tracer, const struct lf_instance *in,
                         enum ng_material_texture texture, const struct lf_hit *hit, float rgba[4])
{
    const struct ng_snapshot_mesh *mesh = in->mesh;
    const struct ng_snapshot_texture *t = &in->material->textures[texture];
    float uv[2] = {0, 0}, place[2];
    if (t->image != NG_NONE) // what is not read is not waited for
        interpolate(mesh, t->uv_set && mesh->uvs1 ? mesh->uvs1 : mesh->uvs, 2, hit->triangle,
                    hit->barycentric, uv);
    ng_snapshot_texture_uv(t, uv, place);
    lf_texture_at(lf_tracer_srgb(tracer), image_of(lf_tracer_snapshot(tracer), t->image), place, rgba);
}

// Base colour and alpha: texel times the colours of the vertices.
static void find_base(const struct lf_tracer *tracer, const struct lf_instance *in, const struct lf_hit *hit,
                      float rgba[4])
{
    const uint32_t *index = in->mesh->indices + (size_t)hit->triangle * 3;
    const float b[3] = {1 - hit->barycentric[0] - hit->barycentric[1], hit->barycentric[0],
                        hit->barycentric[1]};
    read_texture(tracer, in, NG_TEXTURE_BASE_COLOR, hit, rgba);
    for (size_t c = 0; c < 4 && in->mesh->colors; c++) {
        float sum = 0;
        for (int i = 0; i < 3; i++)
            sum += b[i] * (float)in->mesh->colors[(size_t)index[i] * 4 + c];
        rgba[c] *= sum / UINT16_MAX;
    }
}

float lf_surface_alpha(const struct lf_tracer *tracer, uint32_t instance, uint32_t triangle,
                       const float barycentric[2])
{
    const struct lf_instance *in = lf_tracer_instance(tracer, instance);
    const struct lf_hit hit = {.triangle = triangle, .barycentric = {barycentric[0], barycentric[1]}};
    float rgba[4];
    find_base(tracer, in, &hit, rgba);
    return rgba[3] * in->material->alpha;
}

// The normal map's turn of `normal`; the bitangent from the interpolated normal and tangent (glTF 2.0,
// 3.7.2.1).
static void bend_normal(const float texel[4], float scale, const float tangent4[4], float normal[3])
{
    float tangent[3], bitangent[3];
    lf_mad(tangent4, normal, -lf_dot(normal, tangent4), tangent);
    if (!lf_normalize(tangent))
        return;
    lf_cross(normal, tangent, bitangent);
    float x = (texel[0] * 2 - 1) * scale, y = (texel[1] * 2 - 1) * scale * tangent4[3], z = texel[2] * 2 - 1;
    const float bent[3] = {tangent[0] * x + bitangent[0] * y + normal[0] * z,
                           tangent[1] * x + bitangent[1] * y + normal[1] * z,
                           tangent[2] * x + bitangent[2] * y + normal[2] * z};
    memcpy(normal, bent, sizeof bent);
    lf_normalize(normal);
}

// Mirrors turn around the bitangent that is made of the transformed normal and tangent.
static void transform_tangent(const float matrix[12], float tangent4[4])
{
    float across[3];
    lf_cross(matrix + 4, matrix + 8, across);
    lf_transform_vector(matrix, tangent4, tangent4);
    if (lf_dot(matrix, across) < 0)
        tangent4[3] = -tangent4[3];
}

static void find_shading_normal(const struct lf_tracer *tracer, const struct lf_instance *in,
                                const struct lf_hit *hit, struct lf_surface *out)
{
    const struct ng_snapshot *s = lf_tracer_snapshot(tracer);
    const struct ng_snapshot_material *m = in->material;
    const float *to_world = in->normal_matrix;
    float own[3], tangent[4], texel[4];
    interpolate(in->mesh, in->mesh->normals, 3, hit->triangle, hit->barycentric, own);
    float n[3] = {lf_dot(to_world, own), lf_dot(to_world + 3, own), lf_dot(to_world + 6, own)};
    if (!lf_normalize(n))
        return;
    memcpy(out->normal, n, sizeof n);
    if (m->textures[NG_TEXTURE_NORMAL].image == NG_NONE)
        return;
    interpolate(in->mesh, in->mesh->tangents, 4, hit->triangle, hit->barycentric, tangent);
    transform_tangent(s->instances[hit->instance].matrix, tangent);
    read_texture(tracer, in, NG_TEXTURE_NORMAL, hit, texel);
    bend_normal(texel, m->normal_scale, tangent, out->normal);
}

// Factors times texels.
static void find_look(const struct ng_snapshot_material *m, float texels[NG_TEXTURE_COUNT][4],
                      struct lf_look *out)
{
    const float *base = texels[NG_TEXTURE_BASE_COLOR], *metal_rough = texels[NG_TEXTURE_METALLIC_ROUGHNESS];
    float metallic = m->metallic * metal_rough[2], specular = m->specular * texels[NG_TEXTURE_SPECULAR][3];
    for (int i = 0; i < 3; i++) {
        float color = m->base_color[i] * base[i];
        float dielectric =
            ng_brdf_dielectric(m->specular_color[i] * texels[NG_TEXTURE_SPECULAR_COLOR][i], specular);
        out->albedo[i] = m->unlit ? 0 : ng_brdf_albedo(color, metallic);
        out->f0[i] = m->unlit ? 0 : ng_brdf_f0(dielectric, color, metallic);
        out->emission[i] = m->unlit ? color : m->emission[i] * texels[NG_TEXTURE_EMISSIVE][i];
    }
    out->roughness = ng_clamp(m->roughness * metal_rough[1], NG_ROUGHNESS_MIN, 1.0f);
}

static void find_textured_look(const struct lf_tracer *tracer, const struct lf_instance *in,
                               const struct lf_hit *hit, struct lf_look *out)
{
    float texels[NG_TEXTURE_COUNT][4];
    find_base(tracer, in, hit, texels[NG_TEXTURE_BASE_COLOR]);
    for (int i = 0; i < NG_TEXTURE_COUNT; i++)
        if (i != NG_TEXTURE_BASE_COLOR && i != NG_TEXTURE_NORMAL)
            read_texture(tracer, in, (enum ng_material_texture)i, hit, texels[i]);
    find_look(in->material, texels, out);
}

static void set_look(const struct lf_look *look, struct lf_surface *out)
{
    for (int i = 0; i < 3; i++) {
        out->albedo[i] = look->albedo[i];
        out->f0[i] = look->f0[i];
        out->emission[i] = look->emission[i];
    }
    out->roughness = look->roughness;
}

// Normals go with the cofactors of the matrix, whose sign mirrors would turn inside out.
static void find_normal_matrix(const float m[12], float out[9])
{
    float c[3][3]; // columns
    lf_cross(m + 4, m + 8, c[0]);
    lf_cross(m + 8, m, c[1]);
    lf_cross(m, m + 4, c[2]);
    float sign = lf_dot(m, c[0]) < 0 ? -1.0f : 1.0f;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            out[row * 3 + column] = sign * c[row][column];
}

void lf_instance_read(const struct ng_snapshot *snapshot, uint32_t index, struct lf_instance *out)
{
    float white[NG_TEXTURE_COUNT][4];
    const struct ng_snapshot_instance *in = &snapshot->instances[index];
    const struct ng_snapshot_material *m = &snapshot->materials[in->material];
    out->mesh = &snapshot->meshes[in->mesh];
    out->material = m;
    out->flags = in->flags;
    out->light = in->light;
    out->place = in->light == NG_NONE ? NG_NONE : snapshot->lights[in->light].place;
    out->textured = out->mesh->colors;
    for (int i = 0; i < NG_TEXTURE_COUNT; i++) {
        out->textured |= m->textures[i].image != NG_NONE;
        for (int c = 0; c < 4; c++)
            white[i][c] = 1;
    }
    find_normal_matrix(in->matrix, out->normal_matrix);
    find_look(m, white, &out->plain);
}

// As surface_settle in engine/shaders/surface.frag.glsl. A triangle without an area has no normal.
static void settle_normals(struct lf_surface *s)
{
    if (!(lf_dot(s->flat_normal, s->flat_normal) > 0.5f))
        memcpy(s->flat_normal, s->normal, sizeof s->normal);
    if (!(lf_dot(s->flat_normal, s->normal) > NG_NORMAL_CONTRADICTION))
        memcpy(s->normal, s->flat_normal, sizeof s->normal);
}

static void turn_over(struct lf_surface *s)
{
    for (int i = 0; i < 3; i++) {
        s->flat_normal[i] = -s->flat_normal[i];
        s->normal[i] = -s->normal[i];
    }
}

// A point of an exact shape in the shape's own space. The shape is not flat: its light would be dark.
static void find_own_position(const struct ng_snapshot_instance *in, const float position[3], float out[3])
{
    mat4 to_world, to_own;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++)
            to_world[column][row] = in->matrix[row * 4 + column];
    to_world[0][3] = to_world[1][3] = to_world[2][3] = 0;
    to_world[3][3] = 1;
    glm_mat4_inv(to_world, to_own);
    glm_mat4_mulv3(to_own, (float *)position, 1, out);
}

void lf_surface_previous(const struct lf_tracer *tracer, const struct lf_hit *hit, float out[3])
{
    const struct ng_snapshot_instance *in = &lf_tracer_snapshot(tracer)->instances[hit->instance];
    const struct lf_instance *seen = lf_tracer_instance(tracer, hit->instance);
    const struct ng_snapshot_mesh *mesh = seen->mesh;
    float own[3];
    if (seen->shape == LF_SHAPE_TRIANGLES)
        interpolate(mesh, mesh->previous_positions ? mesh->previous_positions : mesh->positions, 3,
                    hit->triangle, hit->barycentric, own);
    else
        find_own_position(in, hit->position, own);
    lf_transform_point(in->previous_matrix, own, out);
}

bool lf_surface_may_shine(const struct lf_tracer *tracer, const struct lf_hit *hit)
{
    const struct lf_instance *in = lf_tracer_instance(tracer, hit->instance);
    // Texels are factors of it.
    return !in->material->unlit && (in->light != NG_NONE || lf_max3(in->plain.emission) > 0);
}

void lf_surface_prefetch(const struct lf_tracer *tracer, const struct lf_hit *hit, int stage)
{
    const struct lf_instance *in = lf_tracer_instance(tracer, hit->instance);
    if (in->shape != LF_SHAPE_TRIANGLES)
        return;
    const uint32_t *index = in->mesh->indices + (size_t)hit->triangle * 3;
    if (stage == 0)
        __builtin_prefetch(index);
    for (int i = 0; stage == 1 && i < 3; i++) {
        __builtin_prefetch(in->mesh->normals + (size_t)index[i] * 3);
        if (in->textured)
            __builtin_prefetch(in->mesh->uvs + (size_t)index[i] * 2);
    }
}

void lf_surface_at(const struct lf_tracer *tracer, const struct lf_hit *hit, struct lf_surface *out)
{
    const struct lf_instance *in = lf_tracer_instance(tracer, hit->instance);
    struct lf_look textured;
    out->light = in->light;
    out->front = hit->front;
    out->double_sided = (in->flags & NG_INSTANCE_DOUBLE_SIDED) != 0;
    out->unlit = in->material->unlit;
    for (int i = 0; i < 3; i++) {
        out->position[i] = hit->position[i];
        out->flat_normal[i] = out->normal[i] = hit->normal[i];
    }
    bool look_up = in->textured && in->shape == LF_SHAPE_TRIANGLES; // what is not read is not waited for
    if (in->shape == LF_SHAPE_TRIANGLES)
        find_shading_normal(tracer, in, hit, out);
    if (look_up)
        find_textured_look(tracer, in, hit, &textured);
    set_look(look_up ? &textured : &in->plain, out);
    settle_normals(out);
    if (!hit->front)
        turn_over(out);
    if (in->light != NG_NONE || lf_surface_is_backless(out))
        out->emission[0] = out->emission[1] = out->emission[2] = 0;
}

void lf_surface_seen_at(const struct lf_tracer *tracer, const struct lf_hit *hit, const float direction[3],
                        struct lf_surface *out)
{
    lf_surface_at(tracer, hit, out);
    const float *n = out->normal, *flat = out->flat_normal;
    float lift = ng_brdf_lift(lf_dot(n, flat), -lf_dot(direction, flat), -lf_dot(direction, n),
                              ng_brdf_specular_part(lf_max3(out->albedo), lf_max3(out->f0)));
    if (!(lift > 0))
        return;
    lf_mad(n, flat, lift, out->normal);
    lf_normalize(out->normal);
}
