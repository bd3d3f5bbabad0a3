// Morph targets: what they add to vertices, the weights that a node begins with, and those that clips drive.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"
#include "components/components.h"
#include "components/morph.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- targets ---------------------------------------------------------------------------------------------
enum { POSITIONS, NORMALS, TANGENTS, KINDS };
static const char *const names[KINDS] = {"POSITION", "NORMAL", "TANGENT"};

// Deltas as they are collected, of the vertices that any of them moves.
struct deltas {
    bool used[KINDS];    // some target has them, and they mean something
    float *dense[KINDS]; // of one target: [vertex_count][3], or null
    NG_ARRAY(uint32_t) vertices;
    NG_ARRAY(float) sparse[KINDS];
};

static ng_result read_dense(struct gltf_loader *l, const char *where, const struct gltf_value *target,
                            uint32_t vertex_count, struct deltas *d)
{
    for (int k = 0; k < KINDS; k++) {
        const struct gltf_want want = {names[k], GLTF_QUANTIZED, 1u << 3, vertex_count, false};
        if (!d->used[k] || !ng_gltf_member(target, names[k]))
            continue;
        NG_TRY(ng_gltf_read(l, ng_gltf_index(target, names[k], -1), &want, &d->dense[k], NULL));
        ng_gltf_keep_within(l, where, names[k], d->dense[k], (size_t)vertex_count * 3);
    }
    return NG_OK;
}

static bool moves(const struct deltas *d, size_t vertex)
{
    bool moved = false;
    for (int k = 0; k < KINDS; k++)
        for (size_t i = 0; d->dense[k] && i < 3; i++)
            moved |= d->dense[k][vertex * 3 + i] < 0 || d->dense[k][vertex * 3 + i] > 0;
    return moved;
}

static bool collect(struct deltas *d, uint32_t vertex_count)
{
    static const float none[3] = {0};
    for (uint32_t v = 0; v < vertex_count; v++) {
        if (!moves(d, v))
            continue;
        bool ok = ng_array_push(&d->vertices, v);
        for (int k = 0; ok && k < KINDS; k++) {
            const float *delta = d->dense[k] ? d->dense[k] + (size_t)v * 3 : none;
            ok = !d->used[k] || ng_array_reserve(&d->sparse[k], d->sparse[k].count + 3);
            for (size_t i = 0; ok && d->used[k] && i < 3; i++)
                d->sparse[k].items[d->sparse[k].count++] = delta[i];
        }
        if (!ok)
            return false;
    }
    return d->vertices.count <= UINT32_MAX / 4;
}

static void forget_dense(struct deltas *d)
{
    for (int k = 0; k < KINDS; k++) {
        free(d->dense[k]);
        d->dense[k] = NULL;
    }
}

// What is dense for a moment counts for a moment.
static ng_result read_target(struct gltf_loader *l, const char *where, const struct gltf_value *target,
                             const struct ng_geometry *g, struct deltas *d)
{
    uint64_t before = l->memory, decoded = l->decoded;
    ng_result r = read_dense(l, where, target, g->vertex_count, d);
    if (r == NG_OK && !collect(d, g->vertex_count))
        r = ng_out_of_memory(l->path);
    forget_dense(d);
    l->memory = before;
    l->decoded = decoded;
    return r;
}

static ng_result read_targets(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                              struct ng_geometry *g, struct deltas *d)
{
    const bool meaningful[KINDS] = {true, g->normals != NULL, g->normals && g->tangents};
    for (uint32_t t = 0; t < g->target_count; t++)
        for (int k = 0; k < KINDS; k++)
            d->used[k] |=
                meaningful[k] && (k == POSITIONS || ng_gltf_member(&p->targets->items[t], names[k]));
    g->target_ends = calloc(g->target_count, sizeof *g->target_ends);
    if (!g->target_ends)
        return ng_out_of_memory(l->path);
    for (uint32_t t = 0; t < g->target_count; t++) {
        NG_TRY(read_target(l, where, &p->targets->items[t], g, d));
        g->target_ends[t] = (uint32_t)d->vertices.count;
        // Split vertices (asset/geometry_targets.c) have up to three times as many, with normals.
        uint64_t size = d->vertices.count * (g->normals ? 40u : 6 * 28u);
        if (size > l->limits.max_memory - l->memory)
            return ng_gltf_budget(l, size, where);
    }
    return ng_gltf_budget(l, d->vertices.count * (g->normals ? 40u : 6 * 28u), where);
}

ng_result ng_gltf_targets(struct gltf_loader *l, const struct gltf_primitive *p, const char *where,
                          struct ng_geometry *g)
{
    struct deltas d = {0};
    struct gltf_part part;
    if (!p->targets || !p->target_count)
        return NG_OK;
    g->target_count = p->target_count;
    if (g->target_count > NG_MORPH_TARGETS) {
        ng_gltf_warn(l, &l->warned_morph, "%s: only the first %d of %u morph targets are followed", where,
                     NG_MORPH_TARGETS, p->target_count);
        g->target_count = NG_MORPH_TARGETS;
    }
    ng_gltf_part_begin(&part, "it has no morph targets");
    ng_result r = ng_gltf_part_end(&l->faults, &part, read_targets(l, p, where, g, &d));
    g->delta_vertices = d.vertices.items;
    g->delta_positions = d.sparse[POSITIONS].items;
    g->delta_normals = d.sparse[NORMALS].items;
    g->delta_tangents = d.sparse[TANGENTS].items;
    g->delta_count = (uint32_t)d.vertices.count;
    if (r == NG_OK && part.lost) {
        free(g->target_ends);
        free(g->delta_vertices);
        free(g->delta_positions);
        free(g->delta_normals);
        free(g->delta_tangents);
        g->target_ends = g->delta_vertices = NULL;
        g->delta_positions = g->delta_normals = g->delta_tangents = NULL;
        g->target_count = g->delta_count = 0;
    }
    return r;
}

// ---- weights ---------------------------------------------------------------------------------------------
ng_result ng_gltf_add_morph(struct gltf_loader *l, const char *where, uint32_t node, ng_asset geometry,
                            ng_entity e)
{
    const struct gltf_node *n = &l->doc->nodes[node];
    const struct ng_geometry *g = ng_assets_geometry(l->assets, geometry);
    const struct gltf_numbers *weights = n->weights.count ? &n->weights : &l->doc->meshes[n->mesh].weights;
    struct ng_morph morph = {{0}};
    if (!g->target_count)
        return NG_OK;
    for (uint32_t i = 0; i < weights->count && i < g->target_count; i++)
        morph.weights[i] = (float)weights->items[i];
    for (uint32_t i = 0; i < ng_morph_component.field_count; i++)
        (void)ng_field_clamp(&ng_morph_component.fields[i], morph.weights + (size_t)i * 4);
    return ng_gltf_add(l, e, where, NG_MORPH, &morph);
}

ng_result ng_gltf_shape_bounds(const struct gltf_loader *l, const struct gltf_instance *instance,
                               float low[3], float high[3])
{
    const struct ng_geometry *g = ng_assets_geometry(l->assets, instance->shape.geometry);
    const struct ng_morph *morph = ng_world_get(l->world, instance->entity, NG_MORPH);
    memcpy(low, g->bounds_min, sizeof g->bounds_min);
    memcpy(high, g->bounds_max, sizeof g->bounds_max);
    if (!morph || !g->delta_count)
        return NG_OK;
    float *points = malloc(g->vertex_count * (size_t)12);
    if (!points)
        return ng_out_of_memory(l->path);
    memcpy(points, g->positions, g->vertex_count * (size_t)12);
    for (uint32_t t = 0, i = 0; t < g->target_count; t++)
        for (; i < g->target_ends[t]; i++)
            for (size_t k = 0; k < 3; k++)
                points[g->delta_vertices[i] * (size_t)3 + k] +=
                    morph->weights[t] * g->delta_positions[i * (size_t)3 + k];
    for (size_t i = 0; i < g->vertex_count * (size_t)3; i++) {
        low[i % 3] = i < 3 ? points[i] : fminf(low[i % 3], points[i]);
        high[i % 3] = i < 3 ? points[i] : fmaxf(high[i % 3], points[i]);
    }
    free(points);
    return NG_OK;
}

// ---- clips -----------------------------------------------------------------------------------------------
static bool is_driven(const struct gltf_loader *l, const struct gltf_instance *instance, int node)
{
    return instance->node == (uint32_t)node &&
           ng_assets_geometry(l->assets, instance->shape.geometry)->target_count;
}

// Fields that hold so many weights.
static uint32_t fields_of(uint32_t targets)
{
    return ((targets < NG_MORPH_TARGETS ? targets : NG_MORPH_TARGETS) + 3) / 4;
}

uint32_t ng_gltf_weight_count(const struct gltf_loader *l, int node)
{
    if (node < 0 || (uint32_t)node >= l->doc->node_count)
        return 0;
    int mesh = l->doc->nodes[node].mesh;
    bool any = mesh >= 0 && (uint32_t)mesh < l->doc->mesh_count && l->doc->meshes[mesh].primitive_count;
    return any ? l->doc->meshes[mesh].primitives[0].target_count : 0;
}

size_t ng_gltf_weight_channels(const struct gltf_loader *l, int node)
{
    size_t count = 0;
    for (size_t i = 0; i < l->instances.count; i++)
        count += is_driven(l, &l->instances.items[i], node) ? fields_of(ng_gltf_weight_count(l, node)) : 0;
    return count;
}

// Four weights of each key, from those of all targets.
static ng_result take_weights(struct gltf_loader *l, const struct ng_channel *all, uint32_t targets,
                              uint32_t first, struct ng_channel *out)
{
    size_t rows = all->key_count * (size_t)(all->interpolation == NG_INTERPOLATION_CUBIC ? 3 : 1);
    const struct ng_field *field = &ng_morph_component.fields[first / 4];
    NG_TRY(ng_gltf_budget(l, all->key_count * sizeof(float) + rows * 16, "weights of morph targets"));
    *out = *all;
    out->component = NG_MORPH;
    out->field_offset = field->offset;
    out->width = 4;
    out->times = malloc(all->key_count * sizeof(float));
    out->values = calloc(rows, 4 * sizeof(float));
    if (!out->times || !out->values)
        return ng_out_of_memory(l->path);
    memcpy(out->times, all->times, all->key_count * sizeof(float));
    for (size_t row = 0; row < rows; row++) {
        bool tangent = all->interpolation == NG_INTERPOLATION_CUBIC && row % 3 != 1;
        for (uint32_t k = 0; k < 4 && first + k < targets; k++)
            out->values[row * 4 + k] = all->values[row * targets + first + k];
        if (!tangent)
            (void)ng_field_clamp(field, out->values + row * 4);
    }
    return NG_OK;
}

ng_result ng_gltf_split_weights(struct gltf_loader *l, int node, const struct ng_channel *all,
                                struct ng_clip *clip)
{
    uint32_t targets = ng_gltf_weight_count(l, node);
    for (size_t i = 0; i < l->instances.count; i++) {
        if (!is_driven(l, &l->instances.items[i], node))
            continue;
        for (uint32_t field = 0; field < fields_of(targets); field++) {
            struct ng_channel *out = &clip->channels[clip->channel_count++];
            NG_TRY(take_weights(l, all, targets, field * 4, out));
            out->target = l->instances.items[i].entity;
        }
    }
    return NG_OK;
}
