// Follows engine/shaders/surface.frag.glsl line by line, so that the G-buffer and the reference agree.
#include "lightformer/trace/surface.h"

#include "lightformer/trace/tracer_internal.h"
#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"
#include "shaders/shared/scene.h"

#include <cglm/cglm.h>
#include <string.h>

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

// A place whose texels are wanted.
struct place {
    const struct lf_tracer *tracer;
    const struct lf_instance *in;
    const struct lf_hit *hit;
    const struct lf_footprint *footprint; // null: at level 0
};

// By how much an attribute of two numbers changes where barycentric coordinates do.
static void differentiate(const struct ng_snapshot_mesh *mesh, const float *attribute, uint32_t triangle,
                          const float barycentric[2], float out[2])
{
    const uint32_t *index = mesh->indices + (size_t)triangle * 3;
    const float *a = attribute + (size_t)index[0] * 2, *b = attribute + (size_t)index[1] * 2,
                *c = attribute + (size_t)index[2] * 2;
    for (int i = 0; i < 2; i++)
        out[i] = barycentric[0] * (b[i] - a[i]) + barycentric[1] * (c[i] - a[i]);
}

// The same of texture coordinates on the image.
static void turn_step(const struct ng_snapshot_texture *t, float uv[2])
{
    const float *c = t->coordinates, u = uv[0], v = uv[1];
    if (!t->transformed)
        return;
    uv[0] = c[0] * u + c[1] * v;
    uv[1] = c[3] * u + c[4] * v;
}

// A texture of the material at a hit; white where it has none. Returns the level.
static float read_texture(const struct place *p, enum ng_material_texture texture, float rgba[4])
{
    const struct ng_snapshot_mesh *mesh = p->in->mesh;
    const struct ng_snapshot_texture *t = &p->in->material->textures[texture];
    const struct lf_srgb *srgb = lf_tracer_srgb(p->tracer);
    if (t->image == NG_NONE) { // what is not read is not waited for
        for (int c = 0; c < 4; c++)
            rgba[c] = 1;
        return 0;
    }
    const float *uvs = t->uv_set && mesh->uvs1 ? mesh->uvs1 : mesh->uvs;
    const struct ng_image *image = lf_tracer_snapshot(p->tracer)->images[t->image].image;
    float uv[2], at[2], dx[2], dy[2];
    interpolate(mesh, uvs, 2, p->hit->triangle, p->hit->barycentric, uv);
    ng_snapshot_texture_uv(t, uv, at);
    if (!p->footprint) {
        lf_texture_at(srgb, image, at, rgba);
        return 0;
    }
    differentiate(mesh, uvs, p->hit->triangle, p->footprint->right, dx);
    differentiate(mesh, uvs, p->hit->triangle, p->footprint->down, dy);
    turn_step(t, dx);
    turn_step(t, dy);
    return lf_texture_seen(srgb, image, at, dx, dy, rgba);
}

// The colour of the vertices there; false, and white, where they have none.
static bool find_color(const struct place *p, float rgba[4])
{
    const struct ng_snapshot_mesh *mesh = p->in->mesh;
    const uint32_t *index = mesh->indices + (size_t)p->hit->triangle * 3;
    const float *at = p->hit->barycentric, b[3] = {1 - at[0] - at[1], at[0], at[1]};
    for (size_t c = 0; c < 4; c++) {
        rgba[c] = mesh->colors ? 0 : 1;
        for (int i = 0; i < 3 && mesh->colors; i++)
            rgba[c] += b[i] * (float)mesh->colors[(size_t)index[i] * 4 + c];
        rgba[c] /= mesh->colors ? UINT16_MAX : 1;
    }
    return mesh->colors;
}

// Base colour: texel times the colours of the vertices.
static void find_base(const struct place *p, float rgba[4])
{
    float color[4];
    read_texture(p, NG_TEXTURE_BASE_COLOR, rgba);
    if (find_color(p, color))
        for (int c = 0; c < 3; c++)
            rgba[c] *= color[c];
}

struct lf_alpha lf_surface_alpha(const struct lf_tracer *tracer, const struct lf_hit *hit,
                                 const struct lf_footprint *footprint)
{
    const struct lf_instance *in = lf_tracer_instance(tracer, hit->instance);
    const struct place place = {tracer, in, hit, footprint};
    float rgba[4], color[4];
    struct lf_alpha alpha = {.level = read_texture(&place, NG_TEXTURE_BASE_COLOR, rgba)};
    find_color(&place, color);
    alpha.texel = rgba[3];
    alpha.factor = in->material->alpha * color[3];
    return alpha;
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

// Of the vertices, of any length; with the normal map, if there is one, of length 1.
static void find_shading_normal(const struct place *p, float normal[3])
{
    const struct ng_snapshot *s = lf_tracer_snapshot(p->tracer);
    const struct lf_instance *in = p->in;
    const struct lf_hit *hit = p->hit;
    const struct ng_snapshot_material *m = in->material;
    const float *to_world = in->normal_matrix;
    float own[3], tangent[4], texel[4];
    interpolate(in->mesh, in->mesh->normals, 3, hit->triangle, hit->barycentric, own);
    for (size_t i = 0; i < 3; i++)
        normal[i] = lf_dot(to_world + 3 * i, own);
    if (m->textures[NG_TEXTURE_NORMAL].image == NG_NONE || !lf_normalize(normal))
        return;
    interpolate(in->mesh, in->mesh->tangents, 4, hit->triangle, hit->barycentric, tangent);
    transform_tangent(s->instances[hit->instance].matrix, tangent);
    read_texture(p, NG_TEXTURE_NORMAL, texel);
    bend_normal(texel, m->normal_scale, tangent, normal);
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

static void find_textured_look(const struct place *p, struct lf_look *out)
{
    float texels[NG_TEXTURE_COUNT][4];
    find_base(p, texels[NG_TEXTURE_BASE_COLOR]);
    for (int i = 0; i < NG_TEXTURE_COUNT; i++)
        if (i != NG_TEXTURE_BASE_COLOR && i != NG_TEXTURE_NORMAL)
            read_texture(p, (enum ng_material_texture)i, texels[i]);
    find_look(p->in->material, texels, out);
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
static void settle_normals(bool unit, struct lf_surface *s)
{
    if (!unit && !lf_normalize(s->normal))
        memcpy(s->normal, s->flat_normal, sizeof s->normal);
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

// All but its normals, which are of the front and not settled.
static void find_surface(const struct place *p, struct lf_surface *out)
{
    const struct lf_instance *in = p->in;
    const struct lf_hit *hit = p->hit;
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
        find_shading_normal(p, out->normal);
    if (look_up)
        find_textured_look(p, &textured);
    set_look(look_up ? &textured : &in->plain, out);
}

static void set_dark(struct lf_surface *s)
{
    s->emission[0] = s->emission[1] = s->emission[2] = 0;
}

void lf_surface_at(const struct lf_tracer *tracer, const struct lf_hit *hit, struct lf_surface *out)
{
    const struct place place = {tracer, lf_tracer_instance(tracer, hit->instance), hit, NULL};
    bool unit = place.in->shape != LF_SHAPE_TRIANGLES ||
                place.in->material->textures[NG_TEXTURE_NORMAL].image != NG_NONE;
    find_surface(&place, out);
    settle_normals(unit, out);
    if (!hit->front)
        turn_over(out);
    if (out->light != NG_NONE || lf_surface_is_backless(out))
        set_dark(out);
}

// Reflections lead out of the surface (ng_brdf_lift).
static void lift(const float direction[3], struct lf_surface *s)
{
    const float *n = s->normal, *flat = s->flat_normal;
    float part = ng_brdf_lift(lf_dot(n, flat), -lf_dot(direction, flat), -lf_dot(direction, n),
                              ng_brdf_specular_part(lf_max3(s->albedo), lf_max3(s->f0)));
    if (!(part > 0))
        return;
    lf_mad(n, flat, part, s->normal);
    lf_normalize(s->normal);
}

void lf_surface_seen_at(const struct lf_tracer *tracer, const struct lf_hit *hit, const float direction[3],
                        struct lf_surface *out)
{
    lf_surface_at(tracer, hit, out);
    lift(direction, out);
}

// ---- As a pixel sees it ----------------------------------------------------------------------------------

// Of a triangle's place in the world, an edge.
static void find_edge(const struct lf_instance *in, const float matrix[12], const uint32_t index[3], int end,
                      float out[3])
{
    const float *from = in->mesh->positions + (size_t)index[0] * 3,
                *to = in->mesh->positions + (size_t)index[end] * 3;
    float own[3];
    lf_mad(to, from, -1, own);
    lf_transform_vector(matrix, own, out);
}

void lf_footprint_find(const struct lf_tracer *tracer, const struct lf_hit *hit, const float right[3],
                       const float down[3], struct lf_footprint *out)
{
    const struct lf_instance *in = lf_tracer_instance(tracer, hit->instance);
    const float *matrix = lf_tracer_snapshot(tracer)->instances[hit->instance].matrix;
    const uint32_t *index = in->mesh->indices + (size_t)hit->triangle * 3;
    float a[3], b[3], normal[3], along_a[3], along_b[3];
    find_edge(in, matrix, index, 1, a);
    find_edge(in, matrix, index, 2, b);
    // What the edges have to be multiplied by to give a step in their plane: by the reciprocal basis.
    lf_cross(a, b, normal);
    float square = lf_dot(normal, normal), scale = square > 0 ? 1 / square : 0;
    lf_cross(b, normal, along_a);
    lf_cross(normal, a, along_b);
    out->right[0] = lf_dot(along_a, right) * scale;
    out->right[1] = lf_dot(along_b, right) * scale;
    out->down[0] = lf_dot(along_a, down) * scale;
    out->down[1] = lf_dot(along_b, down) * scale;
}

bool lf_surface_is_textured(const struct lf_tracer *tracer, const struct lf_hit *hit)
{
    const struct lf_instance *in = lf_tracer_instance(tracer, hit->instance);
    return in->textured && in->shape == LF_SHAPE_TRIANGLES;
}

void lf_surface_unsettled(const struct lf_tracer *tracer, const struct lf_hit *hit,
                          const struct lf_footprint *footprint, struct lf_surface *out)
{
    const struct place place = {tracer, lf_tracer_instance(tracer, hit->instance), hit, footprint};
    find_surface(&place, out);
    if (lf_surface_is_backless(out))
        set_dark(out);
}
