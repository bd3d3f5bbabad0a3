// Shapes: what instances share. A geometry as it is (its arrays are borrowed from the asset store), a
// geometry refined to a subdivision level (made once for all instances that are not skinned), and three of
// the engine's own: the visible surfaces of rectangle, disk and sphere lights.
#include "asset/geometry.h"
#include "base/hash.h"
#include "base/log.h"
#include "components/mesh.h"
#include "components/skin.h"
#include "components/subdivision.h"
#include "render/extract_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void free_shape(struct ng_shape **shape)
{
    struct ng_shape *s = *shape;
    *shape = NULL;
    if (!s)
        return;
    ng_refiner_destroy(&s->refiner);
    ng_cage_finish(&s->made_cage);
    free(s->memory);
    free(s->rest);
    free(s->own_indices);
    free(s->cage_joints);
    free(s->cage_weights);
    free(s->cage_joints1);
    free(s->cage_weights1);
    free(s->cage_target_ends);
    free(s->cage_delta_vertices);
    free(s->cage_deltas);
    free(s);
}

static void find_bounds(struct ng_snapshot_mesh *m)
{
    for (int i = 0; i < 3; i++) {
        m->bounds_min[i] = m->vertex_count ? INFINITY : 0;
        m->bounds_max[i] = m->vertex_count ? -INFINITY : 0;
    }
    for (size_t v = 0; v < m->vertex_count; v++)
        for (int i = 0; i < 3; i++) {
            float p = m->positions[v * 3 + (size_t)i];
            m->bounds_min[i] = p < m->bounds_min[i] ? p : m->bounds_min[i];
            m->bounds_max[i] = p > m->bounds_max[i] ? p : m->bounds_max[i];
        }
}

// ---- the engine's own ------------------------------------------------------------------------------------
// Vertices of a shape in one block: positions, normals, tangents, UVs.
static struct ng_shape *allocate_shape(uint32_t vertices, uint32_t indices)
{
    struct ng_shape *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->memory = calloc((size_t)vertices * 12, sizeof(float));
    s->own_indices = calloc(indices ? indices : 1, sizeof *s->own_indices);
    if (!s->memory || !s->own_indices) {
        free_shape(&s);
        return NULL;
    }
    size_t n = vertices;
    s->mesh = (struct ng_snapshot_mesh){.vertex_count = vertices,
                                        .index_count = indices,
                                        .positions = s->memory,
                                        .normals = s->memory + n * 3,
                                        .tangents = s->memory + n * 6,
                                        .uvs = s->memory + n * 10,
                                        .indices = s->own_indices};
    return s;
}

// Flat shapes face -Z, and their picture is upright for one whom they face (light/types/rectangle.c).
static void set_flat_vertex(struct ng_shape *s, size_t i, float x, float y)
{
    size_t n = s->mesh.vertex_count;
    float *at = s->memory;
    at[i * 3] = x;
    at[i * 3 + 1] = y;
    at[n * 3 + i * 3 + 2] = -1;
    at[n * 6 + i * 4] = -1; // u grows along -X
    at[n * 6 + i * 4 + 3] = 1;
    at[n * 10 + i * 2] = 0.5f - x;
    at[n * 10 + i * 2 + 1] = 0.5f - y;
}

static struct ng_shape *make_rectangle(void)
{
    static const uint32_t indices[6] = {0, 2, 1, 1, 2, 3};
    struct ng_shape *s = allocate_shape(4, 6);
    if (!s)
        return NULL;
    for (uint32_t i = 0; i < 4; i++)
        set_flat_vertex(s, i, i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f);
    memcpy(s->own_indices, indices, sizeof indices);
    return s;
}

static struct ng_shape *make_disk(void)
{
    enum { EDGES = 64 };
    struct ng_shape *s = allocate_shape(EDGES + 1, EDGES * 3);
    if (!s)
        return NULL;
    set_flat_vertex(s, EDGES, 0, 0);
    for (uint32_t i = 0; i < EDGES; i++) {
        float angle = 2 * NG_PI * (float)i / EDGES;
        set_flat_vertex(s, i, cosf(angle), sinf(angle));
        s->own_indices[i * 3] = EDGES;
        s->own_indices[i * 3 + 1] = (i + 1) % EDGES;
        s->own_indices[i * 3 + 2] = i;
    }
    return s;
}

static struct ng_shape *make_sphere(void)
{
    enum { AROUND = 48, DOWN = 24, ROW = AROUND + 1 };
    struct ng_shape *s = allocate_shape(ROW * (DOWN + 1), AROUND * DOWN * 6);
    if (!s)
        return NULL;
    size_t n = s->mesh.vertex_count, index = 0;
    for (uint32_t j = 0; j <= DOWN; j++)
        for (uint32_t i = 0; i <= AROUND; i++) {
            size_t v = (size_t)j * ROW + i;
            float phi = 2 * NG_PI * (float)i / AROUND, theta = NG_PI * (float)j / DOWN;
            float p[3] = {sinf(theta) * cosf(phi), cosf(theta), -sinf(theta) * sinf(phi)};
            float *tangent = s->memory + n * 6 + v * 4;
            memcpy(s->memory + v * 3, p, sizeof p);
            memcpy(s->memory + n * 3 + v * 3, p, sizeof p);
            tangent[0] = -sinf(phi);
            tangent[2] = -cosf(phi);
            tangent[3] = 1;
            s->memory[n * 10 + v * 2] = (float)i / AROUND;
            s->memory[n * 10 + v * 2 + 1] = (float)j / DOWN;
        }
    for (uint32_t j = 0; j < DOWN; j++)
        for (uint32_t i = 0; i < AROUND; i++) {
            uint32_t a = j * ROW + i, below = a + ROW;
            const uint32_t quad[6] = {a, below, a + 1, a + 1, below, below + 1};
            memcpy(s->own_indices + index, quad, sizeof quad);
            index += 6;
        }
    return s;
}

ng_result ng_extract_make_builtin(struct ng_extractor *x)
{
    struct ng_shape *(*const make[NG_SHAPE_BUILTIN])(void) = {[NG_LIGHT_SHAPE_RECTANGLE] = make_rectangle,
                                                              [NG_LIGHT_SHAPE_DISK] = make_disk,
                                                              [NG_LIGHT_SHAPE_SPHERE] = make_sphere};
    for (uint32_t i = 0; i < NG_SHAPE_BUILTIN; i++) {
        x->builtin[i] = make[i]();
        if (!x->builtin[i])
            return ng_out_of_memory("the frame's scene");
        find_bounds(&x->builtin[i]->mesh);
        x->builtin[i]->mesh.key = ++x->clock;
    }
    return NG_OK;
}

// ---- of geometries ---------------------------------------------------------------------------------------
static void borrow_geometry(struct ng_shape *s)
{
    const struct ng_geometry *g = s->source;
    s->mesh.vertex_count = g->vertex_count;
    s->mesh.index_count = g->index_count;
    s->mesh.positions = g->positions;
    s->mesh.normals = g->normals;
    s->mesh.tangents = g->tangents;
    s->mesh.uvs = g->uvs;
    s->mesh.uvs1 = g->uvs1;
    s->mesh.colors = g->colors;
    s->mesh.indices = g->indices;
    s->mesh.rest_positions = g->rest_positions;
    memcpy(s->mesh.bounds_min, g->bounds_min, sizeof g->bounds_min);
    memcpy(s->mesh.bounds_max, g->bounds_max, sizeof g->bounds_max);
}

// Joints and weights of a cage's vertices, through its vertex map.
static ng_result map_cage_set(const struct ng_shape *s, const uint16_t *joints, const float *weights,
                              uint16_t **out_joints, float **out_weights)
{
    size_t n = s->cage->vertex_count;
    if (!joints || !weights || !s->cage->vertex_map)
        return NG_OK;
    *out_joints = calloc(n, 4 * sizeof **out_joints);
    *out_weights = calloc(n, 4 * sizeof **out_weights);
    if (!*out_joints || !*out_weights)
        return ng_out_of_memory("the frame's scene");
    for (size_t i = 0; i < n; i++) {
        size_t from = s->cage->vertex_map[i];
        if (from >= s->source->vertex_count)
            continue;
        memcpy(*out_joints + i * 4, joints + from * 4, 4 * sizeof *joints);
        memcpy(*out_weights + i * 4, weights + from * 4, 4 * sizeof *weights);
    }
    return NG_OK;
}

static ng_result map_cage_joints(struct ng_shape *s)
{
    const struct ng_geometry *g = s->source;
    NG_TRY(map_cage_set(s, g->joints, g->weights, &s->cage_joints, &s->cage_weights));
    return map_cage_set(s, g->joints1, g->weights1, &s->cage_joints1, &s->cage_weights1);
}

// The vertices of a cage at each vertex of the geometry: `next` leads from one to the others; 0: no more,
// else plus 1.
struct cage_places {
    uint32_t *first, *next;
};

static bool find_places(const struct ng_shape *s, struct cage_places *out)
{
    const struct ng_cage *cage = s->cage;
    out->first = calloc(s->source->vertex_count + (size_t)1, sizeof *out->first);
    out->next = calloc(cage->vertex_count + (size_t)1, sizeof *out->next);
    if (!out->first || !out->next)
        return false;
    for (uint32_t i = cage->vertex_count; i-- > 0;) {
        uint32_t from = cage->vertex_map[i];
        if (from >= s->source->vertex_count)
            continue;
        out->next[i] = out->first[from];
        out->first[from] = i + 1;
    }
    return true;
}

// Walks the deltas of the geometry's targets as those of the cage; their number. Written if there is room.
static uint64_t each_delta(struct ng_shape *s, const struct cage_places *places)
{
    const struct ng_geometry *g = s->source;
    uint64_t count = 0;
    for (uint32_t t = 0, i = 0; t < g->target_count; t++) {
        for (; i < g->target_ends[t]; i++)
            for (uint32_t at = places->first[g->delta_vertices[i]]; at; at = places->next[at - 1], count++)
                if (s->cage_deltas) {
                    s->cage_delta_vertices[count] = at - 1;
                    memcpy(s->cage_deltas + count * 3, g->delta_positions + i * (size_t)3, 12);
                }
        if (s->cage_deltas)
            s->cage_target_ends[t] = (uint32_t)count;
    }
    return count;
}

// What targets add to a cage's vertices, through its vertex map. A cage may name one vertex very often.
static ng_result map_cage_targets(struct ng_shape *s)
{
    const struct ng_geometry *g = s->source;
    const uint64_t most = 1u << 25;
    struct cage_places places = {0};
    if (!g->target_count || !g->delta_count || !s->cage->vertex_map)
        return NG_OK;
    bool ok = find_places(s, &places);
    uint64_t count = ok ? each_delta(s, &places) : 0;
    if (ok && count <= most) {
        s->cage_target_ends = calloc(g->target_count, sizeof *s->cage_target_ends);
        s->cage_delta_vertices = malloc(count * sizeof *s->cage_delta_vertices + 1);
        s->cage_deltas = malloc(count * 3 * sizeof *s->cage_deltas + 1);
        ok = s->cage_target_ends && s->cage_delta_vertices && s->cage_deltas;
        if (ok)
            each_delta(s, &places);
    }
    free(places.first);
    free(places.next);
    return ok ? NG_OK : ng_out_of_memory("the frame's scene");
}

// Where the cage's points are at rest; null: where they are.
static const float *cage_at_rest(const struct ng_shape *s)
{
    bool made = s->cage == &s->made_cage;
    return made && !s->source->rest_positions ? NULL : s->cage->rest_positions;
}

// Positions at rest follow from the topology: they are worked out once, when the first point moves.
static ng_result refine_rest(struct ng_extractor *x, struct ng_shape *s)
{
    size_t n = s->mesh.vertex_count;
    const float *cage = cage_at_rest(s);
    if (cage && !s->rest) {
        s->rest = malloc(n * 3 * sizeof(float) + 1);
        if (!s->rest)
            return ng_out_of_memory("the frame's scene");
        struct ng_refiner_vertices rest = {
            .cage = cage, .positions = s->rest, .normals = s->memory + n * 3}; // which is written again
        ng_refiner_apply(s->refiner, x->jobs, &rest);
    }
    s->mesh.rest_positions = cage ? s->rest : NULL;
    return NG_OK;
}

// The vertices of the surface from the points of the cage.
static ng_result refine_points(struct ng_extractor *x, struct ng_shape *s)
{
    size_t n = s->mesh.vertex_count;
    if (s->cage == &s->made_cage)
        ng_cage_follow_geometry(&s->made_cage, s->source);
    NG_TRY(refine_rest(x, s));
    struct ng_refiner_vertices vertices = {.cage = s->cage->positions,
                                           .positions = s->memory,
                                           .normals = s->memory + n * 3,
                                           .tangents = s->memory + n * 6};
    ng_refiner_apply(s->refiner, x->jobs, &vertices);
    x->stats.refined++;
    find_bounds(&s->mesh);
    return NG_OK;
}

static ng_result refine(struct ng_extractor *x, struct ng_shape *s, const struct ng_subdivision *subdivision)
{
    const char *name = ng_assets_name(x->assets, s->geometry);
    char why[NG_REASON_SIZE];
    s->cage = ng_assets_cage(x->assets, s->cage_id);
    if (!s->cage) {
        NG_TRY(ng_cage_from_geometry(s->source, &s->made_cage));
        s->cage = &s->made_cage;
    }
    struct ng_refiner_params params = {
        .name = name, .level = subdivision->level, .boundary = subdivision->boundary};
    x->stats.topologies++;
    ng_result r = ng_refiner_create(s->cage, &params, why, &s->refiner);
    if (r == NG_ERROR_FORMAT || r == NG_ERROR_UNSUPPORTED)
        ng_log_warn("%s: its cage is not subdivided, its triangles are drawn: %s", name, why);
    NG_TRY(r);
    struct ng_refiner_mesh refined = ng_refiner_get_mesh(s->refiner);
    size_t n = refined.vertex_count;
    s->memory = calloc(n ? n : 1, 10 * sizeof(float));
    if (!s->memory)
        return ng_out_of_memory("the frame's scene");
    s->mesh.vertex_count = refined.vertex_count;
    s->mesh.index_count = refined.index_count;
    s->mesh.positions = s->memory;
    s->mesh.normals = s->memory + n * 3;
    s->mesh.tangents = s->memory + n * 6;
    s->mesh.uvs = refined.uvs;
    s->mesh.indices = refined.indices;
    NG_TRY(refine_points(x, s));
    NG_TRY(map_cage_targets(s));
    return map_cage_joints(s);
}

static uint32_t joints_needed(const struct ng_geometry *g)
{
    uint32_t needed = 0;
    for (size_t i = 0; g->joints && i < (size_t)g->vertex_count * 4; i++)
        needed = g->joints[i] >= needed ? g->joints[i] + 1u : needed;
    for (size_t i = 0; g->joints1 && i < (size_t)g->vertex_count * 4; i++)
        needed = g->joints1[i] >= needed ? g->joints1[i] + 1u : needed;
    return needed;
}

// What a mesh entity is made of.
struct make {
    ng_asset geometry, cage;
    const struct ng_subdivision *subdivision; // null: its triangles as they are
};

static ng_result make_shape(struct ng_extractor *x, const struct make *m, uint64_t hash,
                            struct ng_shape **out)
{
    struct ng_shape *s = calloc(1, sizeof *s);
    if (!s)
        return ng_out_of_memory("the frame's scene");
    s->hash = hash;
    s->used = true;
    s->geometry = m->geometry;
    s->cage_id = m->cage;
    s->of_geometry = ng_assets_revision(x->assets, m->geometry);
    s->of_cage = ng_assets_revision(x->assets, m->cage);
    s->source = ng_assets_geometry(x->assets, m->geometry);
    s->joints_needed = joints_needed(s->source);
    ng_result r = NG_OK;
    if (m->subdivision)
        r = refine(x, s, m->subdivision);
    if (!m->subdivision || (r != NG_OK && r != NG_ERROR_MEMORY)) {
        // A cage that cannot be refined is shown by its triangles.
        r = NG_OK;
        ng_refiner_destroy(&s->refiner);
        borrow_geometry(s);
    }
    s->mesh.key = ++x->clock;
    if (r == NG_OK && (!ng_array_push(&x->shapes, s) ||
                       !ng_index_map_set(&x->shape_of, hash, (uint32_t)x->shapes.count - 1)))
        r = ng_out_of_memory("the frame's scene");
    if (r != NG_OK) {
        if (x->shapes.count && x->shapes.items[x->shapes.count - 1] == s)
            x->shapes.count--;
        free_shape(&s);
    }
    *out = s;
    return r;
}

// A cage that is named and is none costs the subdivision.
static struct make find_parts(struct ng_extractor *x, ng_entity e, const struct ng_mesh *mesh)
{
    const struct ng_subdivision *subdivision = ng_world_get(x->world, e, NG_SUBDIVISION);
    struct make m = {.geometry = mesh->geometry, .subdivision = subdivision};
    char name[NG_TEXT_SIZE];
    if (!subdivision || !subdivision->cage.id)
        return m;
    m.cage = subdivision->cage;
    if (ng_assets_cage(x->assets, m.cage))
        return m;
    if (ng_extract_warn_once(x, e, NG_WARN_CAGE))
        ng_log_warn("mesh '%s' is not subdivided, its triangles are drawn: its cage is missing",
                    ng_extract_name(x, e, name));
    return (struct make){.geometry = mesh->geometry};
}

ng_result ng_extract_shape(struct ng_extractor *x, ng_entity e, struct ng_shape **out)
{
    const struct ng_mesh *mesh = ng_world_get(x->world, e, NG_MESH);
    *out = NULL;
    if (!mesh || !ng_assets_geometry(x->assets, mesh->geometry)) {
        char name[NG_TEXT_SIZE];
        if (ng_extract_warn_once(x, e, NG_WARN_GEOMETRY))
            ng_log_warn("mesh '%s' is not shown: its geometry is missing", ng_extract_name(x, e, name));
        return NG_OK;
    }
    const struct make m = find_parts(x, e, mesh);
    uint64_t hash = ng_hash_combine(ng_hash_combine(1, m.geometry.id), m.cage.id);
    if (m.subdivision)
        hash = ng_hash_combine(hash, (uint64_t)m.subdivision->level << 32 | m.subdivision->boundary);
    hash |= 1; // never 0
    uint32_t index = ng_index_map_get(&x->shape_of, hash);
    if (index == UINT32_MAX)
        return make_shape(x, &m, hash, out);
    *out = x->shapes.items[index];
    (*out)->used = true;
    return NG_OK;
}

// ---- edits -----------------------------------------------------------------------------------------------
static bool same_topology(const struct ng_extractor *x, const struct ng_shape *s)
{
    return ng_assets_revision(x->assets, s->geometry).topology == s->of_geometry.topology &&
           ng_assets_revision(x->assets, s->cage_id).topology == s->of_cage.topology;
}

static ng_result follow_shape(struct ng_extractor *x, struct ng_shape *s)
{
    const struct ng_asset_revision geometry = ng_assets_revision(x->assets, s->geometry),
                                   cage = ng_assets_revision(x->assets, s->cage_id);
    bool of_cage = s->refiner && s->cage != &s->made_cage; // then the geometry's points are not shown
    bool moved = of_cage ? cage.content != s->of_cage.content : geometry.content != s->of_geometry.content;
    if (!same_topology(x, s))
        return NG_OK;
    if (moved && s->refiner)
        NG_TRY(refine_points(x, s));
    else if (moved)
        borrow_geometry(s);
    if (moved)
        s->mesh.revision = ++x->clock;
    s->of_geometry = geometry;
    s->of_cage = cage;
    return NG_OK;
}

ng_result ng_extract_follow_shapes(struct ng_extractor *x)
{
    for (size_t i = 0; i < x->shapes.count; i++)
        NG_TRY(follow_shape(x, x->shapes.items[i]));
    return NG_OK;
}

void ng_extract_mark_shapes(struct ng_extractor *x)
{
    size_t kept = 0;
    ng_index_map_clear(&x->shape_of);
    for (size_t i = 0; i < x->shapes.count; i++) {
        struct ng_shape *s = x->shapes.items[i];
        s->used = false;
        // A shape whose geometry is gone, or is another, must not be found again; the old pieces that show it
        // go as well.
        if (!same_topology(x, s)) {
            free_shape(&s);
            continue;
        }
        x->shapes.items[kept] = s;
        (void)ng_index_map_set(&x->shape_of, s->hash, (uint32_t)kept++); // does not grow: it held as many
    }
    x->shapes.count = kept;
}

void ng_extract_sweep_shapes(struct ng_extractor *x)
{
    size_t kept = 0;
    ng_index_map_clear(&x->shape_of);
    for (size_t i = 0; i < x->shapes.count; i++) {
        struct ng_shape *s = x->shapes.items[i];
        if (!s->used) {
            free_shape(&s);
            continue;
        }
        x->shapes.items[kept] = s;
        (void)ng_index_map_set(&x->shape_of, s->hash, (uint32_t)kept++);
    }
    x->shapes.count = kept;
}

void ng_extract_finish_shapes(struct ng_extractor *x)
{
    for (size_t i = 0; i < x->shapes.count; i++)
        free_shape(&x->shapes.items[i]);
    for (uint32_t i = 0; i < NG_SHAPE_BUILTIN; i++)
        free_shape(&x->builtin[i]);
    ng_array_finish(&x->shapes);
    ng_index_map_finish(&x->shape_of);
}
