// Primitives into geometry: attributes decoded and checked, every topology turned into triangles, what is
// missing computed. A primitive made from the same accessors as an earlier one shares its geometry.
#include "asset/geometry.h"
#include "asset/gltf_loader_internal.h"
#include "asset/gltf_unit.h"
#include "base/hash.h"
#include "base/log.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int attribute(const struct gltf_primitive *p, const char *name)
{
    for (uint32_t i = 0; i < p->attribute_count; i++)
        if (strcmp(p->attributes[i].name, name) == 0)
            return p->attributes[i].accessor;
    return -1;
}

static bool has_attribute(const struct gltf_primitive *p, const char *name)
{
    for (uint32_t i = 0; i < p->attribute_count; i++)
        if (strcmp(p->attributes[i].name, name) == 0)
            return true;
    return false;
}

static ng_result read_attribute(struct gltf_loader *l, const struct gltf_primitive *p,
                                const struct gltf_want *want, float **out)
{
    return has_attribute(p, want->what) ? ng_gltf_read(l, attribute(p, want->what), want, out, NULL) : NG_OK;
}

// An attribute that a primitive can do without; null where it is wrong.
static ng_result try_attribute(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                               const char *instead, const struct gltf_want *want, float **out)
{
    struct gltf_part part;
    ng_gltf_part_begin(&part, instead);
    part.where = where;
    return ng_gltf_part_end(&l->faults, &part, read_attribute(l, p, want, out));
}

// What integers of an accessor stand for if they are fractions whose writer did not say so.
static float missing_scale(const struct gltf_accessor *a)
{
    if (a->normalized || a->component_type == GLTF_F32)
        return 1;
    return a->component_type == GLTF_U8 ? 1.0f / UINT8_MAX : 1.0f / UINT16_MAX;
}

static ng_result check_colors(struct gltf_loader *l, const struct gltf_accessor *a, const char *where,
                              float *colors, size_t count)
{
    if (missing_scale(a) != 1)
        NG_TRY(ng_gltf_fault(&l->faults, "they are taken for fractions",
                             "%s: integers of COLOR_0 are not normalized", where));
    for (size_t i = 0; i < count; i++)
        if (isnan(colors[i])) {
            NG_TRY(ng_gltf_fault(&l->faults, "it is 1", "%s: the COLOR_0 of vertex %zu is not finite", where,
                                 i / a->components));
            colors[i] = 1;
        }
    return NG_OK;
}

// COLOR_0, of three or four numbers from 0 to 1, as 16-bit fractions.
static ng_result read_colors(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                             struct ng_geometry *g)
{
    const struct gltf_want want = {"COLOR_0", GLTF_FLOATS | GLTF_SMALL_UNSIGNED | GLTF_ANY_NUMBER,
                                   1u << 3 | 1u << 4, g->vertex_count, false};
    float *colors = NULL;
    NG_TRY(read_attribute(l, p, &want, &colors));
    if (!colors)
        return NG_OK;
    const struct gltf_accessor *a = &l->doc->accessors[attribute(p, want.what)];
    const uint32_t width = a->components;
    const float scale = missing_scale(a);
    ng_result r = check_colors(l, a, where, colors, g->vertex_count * (size_t)width);
    if (r == NG_OK)
        r = ng_gltf_budget(l, g->vertex_count * (uint64_t)8, where);
    g->colors = r == NG_OK ? malloc(g->vertex_count * (size_t)8) : NULL;
    for (size_t i = 0; g->colors && i < g->vertex_count * (size_t)4; i++) {
        float v = i % 4 < width ? colors[i / 4 * width + i % 4] * scale : 1;
        g->colors[i] = (uint16_t)(fminf(fmaxf(v, 0), 1) * UINT16_MAX + 0.5f);
    }
    free(colors);
    return r == NG_OK && !g->colors ? ng_out_of_memory(l->path) : r;
}

static ng_result read_surface(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                              struct ng_geometry *g)
{
    const struct gltf_want position = {"POSITION", GLTF_QUANTIZED | GLTF_ANY_NUMBER, 1u << 3, 0, false};
    NG_TRY(ng_gltf_read(l, attribute(p, "POSITION"), &position, &g->positions, &g->vertex_count));
    uint32_t n = g->vertex_count;
    ng_gltf_keep_within(l, where, "POSITION", g->positions, (size_t)n * 3);
    const struct gltf_want normal = {"NORMAL", GLTF_QUANTIZED | GLTF_ANY_NUMBER, 1u << 3, n, false};
    const struct gltf_want tangent = {"TANGENT", GLTF_QUANTIZED | GLTF_ANY_NUMBER, 1u << 4, n, false};
    const struct gltf_want uv = {"TEXCOORD_0", GLTF_QUANTIZED | GLTF_ANY_NUMBER, 1u << 2, n, false};
    const struct gltf_want uv1 = {"TEXCOORD_1", GLTF_QUANTIZED | GLTF_ANY_NUMBER, 1u << 2, n, false};
    NG_TRY(try_attribute(l, p, where, "normals are computed", &normal, &g->normals));
    NG_TRY(try_attribute(l, p, where, "tangents are computed", &tangent, &g->tangents));
    NG_TRY(try_attribute(l, p, where, "its textures are not seen", &uv, &g->uvs));
    NG_TRY(try_attribute(l, p, where, "its textures are not seen", &uv1, &g->uvs1));
    struct gltf_part part;
    ng_gltf_part_begin(&part, "its colours are not seen");
    part.where = where;
    return ng_gltf_part_end(&l->faults, &part, read_colors(l, p, where, g));
}

// One set of four influences a vertex.
struct influences {
    float *weights;
    uint32_t *joints;
};

static ng_result read_influences(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                                 uint32_t n, int set, struct influences *out)
{
    char weights[16], joints[16];
    snprintf(weights, sizeof weights, "WEIGHTS_%d", set);
    snprintf(joints, sizeof joints, "JOINTS_%d", set);
    if (!has_attribute(p, joints) && !has_attribute(p, weights))
        return NG_OK;
    if (!has_attribute(p, joints) || !has_attribute(p, weights))
        return ng_gltf_error(l, "%s: %s and %s must come together", where, joints, weights);
    const struct gltf_want want_weights = {weights, GLTF_FLOATS | GLTF_SMALL_UNSIGNED | GLTF_ANY_NUMBER,
                                           1u << 4, n, false},
                           want_joints = {joints, GLTF_UNSIGNED | GLTF_ANY_NUMBER, 1u << 4, n, true};
    NG_TRY(ng_gltf_read(l, attribute(p, weights), &want_weights, &out->weights, NULL));
    NG_TRY(ng_gltf_read(l, attribute(p, joints), &want_joints, &out->joints, NULL));
    for (size_t i = 0; i < n * (size_t)4; i++)
        if (!(out->weights[i] >= 0)) {
            NG_TRY(ng_gltf_fault(&l->faults, "it is 0", "%s: %s of vertex %zu: %g is negative or no number",
                                 where, weights, i / 4, (double)out->weights[i]));
            out->weights[i] = 0;
        }
    return NG_OK;
}

// Brings the influences that there are to the front, in their order: of each joint one. How many there are.
static size_t gather_influences(float weights[4], uint32_t joints[4], float more_weights[4],
                                uint32_t more_joints[4])
{
    float w[8];
    uint32_t j[8];
    size_t count = 0;
    memcpy(w, weights, 16);
    memcpy(w + 4, more_weights, 16);
    memcpy(j, joints, 16);
    memcpy(j + 4, more_joints, 16);
    for (size_t k = 0; k < 8; k++) {
        size_t i = 0;
        while (i < count && j[i] != j[k])
            i++;
        float before = i < count ? w[i] : 0, add = w[k];
        w[k] = 0;
        if (i == count && !(add > 0))
            continue;
        w[i] = before + add;
        j[i] = j[k];
        count += i == count;
    }
    memcpy(weights, w, 16);
    memcpy(more_weights, w + 4, 16);
    memcpy(joints, j, 16);
    memcpy(more_joints, j + 4, 16);
    return count;
}

// Weights sum to 1.
static void normalize_influences(struct influences *first, struct influences *more, size_t vertex)
{
    float *w = first->weights + vertex * 4, *x = more->joints ? more->weights + vertex * 4 : NULL, sum = 0;
    for (size_t k = 0; k < 4; k++)
        sum += w[k] = fminf(w[k], 1e30f); // so that their sum is finite
    for (size_t k = 0; x && k < 4; k++)
        sum += x[k] = fminf(x[k], 1e30f);
    if (ng_gltf_is_sum_one(sum))
        return;
    for (size_t k = 0; k < 4; k++)
        w[k] = sum > 0 ? w[k] / sum : (k == 0 ? 1.0f : 0.0f);
    for (size_t k = 0; x && k < 4; k++)
        x[k] = sum > 0 ? x[k] / sum : 0;
}

static ng_result take_joints(struct gltf_loader *l, const char *where, const struct influences *in,
                             uint32_t vertex_count, uint16_t **out, uint32_t *joint_limit)
{
    if (!vertex_count)
        return NG_OK;
    NG_TRY(ng_gltf_budget(l, vertex_count * (uint64_t)8, where));
    *out = malloc(vertex_count * (size_t)4 * sizeof **out);
    if (!*out)
        return ng_out_of_memory(l->path);
    for (size_t i = 0; i < vertex_count * (size_t)4; i++) {
        uint32_t joint = in->joints[i] < UINT16_MAX ? in->joints[i] : UINT16_MAX;
        (*out)[i] = in->weights[i] > 0 ? (uint16_t)joint : 0;
        *joint_limit = (*out)[i] >= *joint_limit ? (*out)[i] + 1u : *joint_limit;
    }
    return NG_OK;
}

static void forget_influences(struct influences *in)
{
    free(in->weights);
    free(in->joints);
    *in = (struct influences){0};
}

static ng_result take_influences(struct gltf_loader *l, const char *where, struct influences *first,
                                 struct influences *more, struct ng_geometry *g, uint32_t *joint_limit)
{
    size_t most = 0;
    for (size_t i = 0; more->joints && i < g->vertex_count; i++) {
        size_t count = gather_influences(first->weights + i * 4, first->joints + i * 4, more->weights + i * 4,
                                         more->joints + i * 4);
        most = count > most ? count : most;
    }
    if (most <= 4)
        forget_influences(more);
    for (size_t i = 0; i < g->vertex_count; i++)
        normalize_influences(first, more, i);
    NG_TRY(take_joints(l, where, first, g->vertex_count, &g->joints, joint_limit));
    return more->joints ? take_joints(l, where, more, g->vertex_count, &g->joints1, joint_limit) : NG_OK;
}

// The second set is not needed where the first is right.
static ng_result try_more_influences(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                                     uint32_t n, struct influences *out)
{
    struct gltf_part part;
    ng_gltf_part_begin(&part, "only the first 4 joints of a vertex are used");
    part.where = where;
    NG_TRY(ng_gltf_part_end(&l->faults, &part, read_influences(l, p, where, n, 1, out)));
    if (part.lost)
        forget_influences(out);
    return NG_OK;
}

static ng_result read_skinning(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                               struct ng_geometry *g, uint32_t *joint_limit)
{
    struct influences first = {0}, more = {0};
    ng_result r = read_influences(l, p, where, g->vertex_count, 0, &first);
    if (r == NG_OK && first.joints)
        r = try_more_influences(l, p, where, g->vertex_count, &more);
    if (r == NG_OK && has_attribute(p, "JOINTS_2"))
        ng_gltf_warn(l, &l->warned_influences, "%s: only the first 8 joints of a vertex are used", where);
    if (r == NG_OK && first.joints)
        r = take_influences(l, where, &first, &more, g, joint_limit);
    g->weights = first.weights;
    g->weights1 = more.weights;
    free(first.joints);
    free(more.joints);
    return r;
}

// Without joints that can be used it stands unskinned.
static ng_result try_skinning(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                              struct ng_geometry *g, uint32_t *joint_limit)
{
    struct gltf_part part;
    ng_gltf_part_begin(&part, "it is not skinned");
    part.where = where;
    NG_TRY(ng_gltf_part_end(&l->faults, &part, read_skinning(l, p, where, g, joint_limit)));
    if (!part.lost)
        return NG_OK;
    free(g->weights);
    free(g->joints);
    free(g->weights1);
    free(g->joints1);
    g->weights = g->weights1 = NULL;
    g->joints = g->joints1 = NULL;
    *joint_limit = NG_GLTF_JOINTS_LOST;
    return NG_OK;
}

// The vertices in drawing order: the index accessor, or 0, 1, 2, ...
static ng_result read_order(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                            uint32_t vertex_count, uint32_t **out, uint32_t *count)
{
    if (p->indices >= 0) {
        struct gltf_want want = {"indices", GLTF_UNSIGNED, 1u << 1, 0, true};
        return ng_gltf_read(l, p->indices, &want, out, count);
    }
    NG_TRY(ng_gltf_budget(l, (uint64_t)vertex_count * 4, where));
    *count = vertex_count;
    *out = malloc((size_t)vertex_count * 4);
    if (!*out)
        return ng_out_of_memory(l->path);
    for (uint32_t i = 0; i < vertex_count; i++)
        (*out)[i] = i;
    return NG_OK;
}

// Strips and fans into triangles; the order of a strip's odd triangles is turned (glTF 2.0, 3.7.2.1).
static ng_result make_triangles(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                                struct ng_geometry *g)
{
    if (g->index_count < 3)
        return ng_gltf_error(l, "%s: %u indices make no triangle", where, g->index_count);
    if (p->mode == GLTF_TRIANGLES && g->index_count % 3 != 0)
        NG_TRY(ng_gltf_fault(&l->faults, "the last triangle is left out",
                             "%s: %u indices are not a multiple of 3", where, g->index_count));
    if (p->mode == GLTF_TRIANGLES) {
        g->index_count -= g->index_count % 3;
        return NG_OK;
    }
    size_t triangles = g->index_count - 2;
    NG_TRY(ng_gltf_budget(l, triangles * 12, where));
    uint32_t *out = malloc(triangles * 12);
    if (!out)
        return ng_out_of_memory(l->path);
    for (size_t t = 0; t < triangles; t++) {
        bool strip = p->mode == GLTF_TRIANGLE_STRIP, odd = strip && t % 2 == 1;
        out[t * 3] = g->indices[strip ? t : 0];
        out[t * 3 + 1] = g->indices[t + (odd ? 2 : 1)];
        out[t * 3 + 2] = g->indices[t + (odd ? 1 : 2)];
    }
    free(g->indices);
    g->indices = out;
    g->index_count = (uint32_t)(triangles * 3);
    return NG_OK;
}

// What ng_geometry_complete will allocate.
static uint64_t completion_size(const struct ng_geometry *g)
{
    uint64_t vertices = g->normals ? g->vertex_count : g->index_count;
    uint64_t copies = g->normals
                          ? 0
                          : 12 + 12 + (g->uvs ? 8u : 0u) + (g->uvs1 ? 8u : 0u) + (g->colors ? 8u : 0u) +
                                (g->joints ? 24u : 0u) + (g->joints1 ? 24u : 0u);
    return vertices * (copies + (g->uvs ? 0u : 8u) + (g->tangents ? 0u : 16u + 24u));
}

// The set of texture coordinates that a primitive's normal map uses.
static int normal_uv_set(const struct gltf_loader *l, const struct gltf_primitive *p)
{
    if (p->material < 0 || (uint32_t)p->material >= l->doc->material_count)
        return 0;
    return l->doc->materials[p->material].normal_texture.uv_set;
}

// NG_scene's "exact": normals and tangents are as a world had them, to the bit.
static bool is_exact(const struct gltf_primitive *p)
{
    return ng_gltf_bool(p->extension, "exact", false);
}

static ng_result read_vertices(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                               struct ng_geometry *g, struct gltf_shape *out)
{
    NG_TRY(read_surface(l, p, where, g));
    g->tangents_of_uvs1 = normal_uv_set(l, p) == 1;
    return try_skinning(l, p, where, g, &out->joint_limit);
}

// The indices first: they say of which vertices more is read. Targets and cages name vertices by the file's
// own numbers.
static ng_result read_arrays(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                             bool whole, struct ng_geometry *g, struct gltf_shape *out)
{
    int position = attribute(p, "POSITION");
    struct gltf_subset used = {0};
    if (p->indices >= 0)
        NG_TRY(read_order(l, p, where, 0, &g->indices, &g->index_count));
    if (p->indices >= 0 && !whole && position >= 0 && (uint32_t)position < l->doc->accessor_count)
        NG_TRY(ng_gltf_choose_vertices(l, g, l->doc->accessors[position].count, &used));
    l->used = used.vertices ? &used : NULL;
    ng_result r = read_vertices(l, p, where, g, out);
    l->used = NULL;
    ng_gltf_forget_vertices(&used);
    if (r == NG_OK && p->indices < 0)
        r = read_order(l, p, where, g->vertex_count, &g->indices, &g->index_count);
    return r;
}

static ng_result build(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                       struct ng_geometry *g, struct ng_cage *cage, struct gltf_shape *out)
{
    const struct gltf_value *member = ng_gltf_member(p->extension, "cage");
    NG_TRY(read_arrays(l, p, where, p->target_count || member, g, out));
    NG_TRY(make_triangles(l, p, where, g));
    NG_TRY(ng_gltf_repair_geometry(l, where, is_exact(p), g));
    NG_TRY(ng_gltf_targets(l, p, where, g));
    out->has_cage = member;
    if (member)
        NG_TRY(ng_gltf_cage(l, where, member, g, cage));
    NG_TRY(ng_gltf_budget(l, completion_size(g), where));
    if (!ng_geometry_split_map(g, cage))
        return ng_out_of_memory(l->path);
    return ng_geometry_complete(g);
}

// There is room in the list of what was added.
static ng_result add_assets(struct gltf_loader *l, const char *name, struct ng_geometry *g,
                            struct ng_cage *cage, struct gltf_shape *out)
{
    NG_TRY(ng_assets_take_geometry(l->assets, name, g, &out->geometry));
    ng_array_push(&l->added, out->geometry);
    if (!cage->face_count)
        return NG_OK;
    NG_TRY(ng_assets_take_cage(l->assets, name, cage, &out->cage));
    ng_array_push(&l->added, out->cage);
    return NG_OK;
}

// Files may have the same without compression, for those who cannot read it.
static ng_result begin_draco(struct gltf_loader *l, const char *where, const struct gltf_primitive *p)
{
    int position = attribute(p, "POSITION");
    bool has_plain =
        position >= 0 && (uint32_t)position < l->doc->accessor_count && l->doc->accessors[position].view >= 0;
    struct gltf_part part;
    if (!has_plain)
        return ng_gltf_draco_begin(l, where, p);
    ng_gltf_part_begin(&part, "its uncompressed accessors are read");
    return ng_gltf_part_end(&l->faults, &part, ng_gltf_draco_begin(l, where, p));
}

static ng_result build_shape(struct gltf_loader *l, const struct gltf_primitive *p, const char *name,
                             const char *where, struct gltf_shape *out)
{
    struct ng_geometry g = {0};
    struct ng_cage cage = {0};
    struct gltf_primitive plain = *p;
    ng_result r = begin_draco(l, where, p);
    if (l->stand_ins.count)
        plain.mode = GLTF_TRIANGLES;
    if (r == NG_OK)
        r = build(l, &plain, where, &g, &cage, out);
    ng_gltf_draco_end(l);
    if (r == NG_OK && !ng_array_reserve(&l->added, l->added.count + 2))
        r = ng_out_of_memory(l->path);
    char shown[NG_TEXT_SIZE]; // a mesh's name may be long, and be that of many
    snprintf(shown, sizeof shown, "%.*s", (int)sizeof shown - 1, name[0] ? name : where);
    if (r == NG_OK)
        r = add_assets(l, shown, &g, &cage, out);
    ng_geometry_finish(&g); // empty, unless something failed
    ng_cage_finish(&cage);
    return r;
}

static uint64_t hash_value(uint64_t h, const struct gltf_value *v)
{
    h = ng_hash_combine(h, v->kind);
    h = v->key ? ng_hash_combine(h, ng_hash_string(v->key)) : h;
    h = v->kind == GLTF_NUMBER ? ng_hash_bytes(h, &v->number, sizeof v->number) : h;
    for (uint32_t i = 0; i < v->count; i++)
        h = hash_value(h, &v->items[i]);
    return h;
}

static uint64_t shape_key(const struct gltf_loader *l, const struct gltf_primitive *p)
{
    uint64_t h =
        ng_hash_combine((uint64_t)(uint32_t)p->indices << 32 | (uint32_t)p->mode, p->attribute_count);
    h = ng_hash_combine(h, (normal_uv_set(l, p) == 1) + 2u * is_exact(p));
    for (uint32_t i = 0; i < p->attribute_count; i++) {
        h = ng_hash_combine(h, ng_hash_string(p->attributes[i].name));
        h = ng_hash_combine(h, (uint32_t)p->attributes[i].accessor);
    }
    const struct gltf_value *cage = ng_gltf_member(p->extension, "cage");
    const struct gltf_value *draco = ng_gltf_member(p->extensions, "KHR_draco_mesh_compression");
    h = p->targets ? hash_value(h, p->targets) : h;
    h = draco ? hash_value(h, draco) : h;
    return cage ? hash_value(h, cage) : h;
}

// The record of a key in an open-addressed table, or the free one where it belongs.
static struct gltf_shape *slot(struct gltf_loader *l, uint64_t key)
{
    size_t mask = l->shapes.count - 1;
    size_t i = (size_t)key & mask;
    while (l->shapes.items[i].geometry.id && l->shapes.items[i].key != key)
        i = (i + 1) & mask;
    return &l->shapes.items[i];
}

// Twice as many slots as the document has primitives, so that the table never fills.
static ng_result make_tables(struct gltf_loader *l)
{
    size_t primitives = 0, slots = 16;
    l->first_primitive = malloc((l->doc->mesh_count + (size_t)1) * sizeof *l->first_primitive);
    if (!l->first_primitive)
        return ng_out_of_memory(l->path);
    for (uint32_t i = 0; i < l->doc->mesh_count; i++) {
        l->first_primitive[i] = (uint32_t)primitives;
        primitives += l->doc->meshes[i].primitive_count;
    }
    while (slots < primitives * 2)
        slots *= 2;
    l->made = calloc(primitives + 1, sizeof *l->made);
    return l->made && ng_array_resize(&l->shapes, slots) ? NG_OK : ng_out_of_memory(l->path);
}

// The record of a primitive that has triangles; `name` is of its mesh.
static ng_result find_shape(struct gltf_loader *l, const struct gltf_primitive *p, const char *name,
                            const char *where, struct gltf_shape **out)
{
    uint64_t key = shape_key(l, p);
    struct gltf_shape *shape = slot(l, key);
    if (!shape->geometry.id) {
        shape->key = key;
        NG_TRY(build_shape(l, p, name, where, shape));
    }
    *out = shape;
    return NG_OK;
}

ng_result ng_gltf_shape(struct gltf_loader *l, uint32_t mesh, uint32_t primitive, struct gltf_shape *out)
{
    const struct gltf_mesh *m = &l->doc->meshes[mesh];
    const struct gltf_primitive *p = &m->primitives[primitive];
    char where[64];
    snprintf(where, sizeof where, "mesh %u, primitive %u", mesh, primitive);
    *out = (struct gltf_shape){0};
    if (!has_attribute(p, "POSITION")) // is to be skipped (glTF 2.0, 3.7.2.1)
        return NG_OK;
    if (p->mode < 0 || p->mode > GLTF_TRIANGLE_FAN)
        return ng_gltf_fault(&l->faults, "the primitive is left out", "%s: there is no mode %d", where,
                             p->mode);
    if (p->mode < GLTF_TRIANGLES) {
        ng_gltf_warn(l, &l->warned_mode, "%s: points and lines are skipped", where);
        return NG_OK;
    }
    if (!l->shapes.count)
        NG_TRY(make_tables(l));
    struct gltf_shape **made = &l->made[l->first_primitive[mesh] + primitive];
    if (!*made) {
        struct gltf_part part;
        ng_gltf_part_begin(&part, "the primitive is left out");
        part.where = where;
        NG_TRY(ng_gltf_part_end(&l->faults, &part, find_shape(l, p, m->name, where, made)));
        *made = part.lost ? &l->nothing : *made;
    }
    NG_REQUIRE(*made, "a primitive that was read has a shape");
    *out = **made;
    return NG_OK;
}
