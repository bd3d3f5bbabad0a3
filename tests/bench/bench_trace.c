// What it costs to follow edits of a scene with rays: bench_trace [SCENE [EMPTY [SPHERES]]]. EMPTY entities
// without a surface and SPHERES of 250,000 triangles are added to it first. Prints JSON:
//   full_ms, bytes, rays_a_second   building everything in a new tracer; one thread, any directions
//   refit, add, duplicate, delete, undo   updates after one edit as a part of full_ms: two objects moved; an
//                                   object placed elsewhere, and in the same place; one destroyed, and given
//                                   back
//   nothing                         an update without an edit
// Medians of rounds. The edited objects are copies of the mesh of median size.
#include "app/stage.h"
#include "asset/geometry.h"
#include "base/log.h"
#include "base/rng.h"
#include "base/system.h"
#include "components/components.h"
#include "components/mesh.h"
#include "components/transform.h"
#include "lightformer/trace/tracer.h"
#include "scene/history.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define ROUNDS 9
#define RAYS   (1u << 18)

enum { FULL, NOTHING, REFIT, ADD, DUPLICATE, DELETE, UNDO, COUNT };
static const char *const names[COUNT] = {"full", "nothing", "refit", "add", "duplicate", "delete", "undo"};

struct bench {
    struct ng_stage *stage;
    struct lf_tracer *tracer;
    ng_entity object, other;
    double ms[COUNT][ROUNDS];
};

static int compare_numbers(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values)
{
    qsort(values, ROUNDS, sizeof *values, compare_numbers);
    return values[ROUNDS / 2];
}

// ---- The scene -------------------------------------------------------------------------------------------

static ng_result add_copy(struct bench *b, const struct ng_mesh *mesh, const struct ng_transform *place,
                          ng_entity *out)
{
    *out = ng_entity_create(b->stage->world);
    NG_TRY(ng_world_add(b->stage->world, *out, NG_TRANSFORM, place));
    return ng_world_add(b->stage->world, *out, NG_MESH, mesh);
}

static ng_result make_sphere(struct bench *b, ng_asset *out)
{
    enum { AROUND = 500, DOWN = 250, ROW = AROUND + 1 };
    const double pi = 3.14159265358979;
    struct ng_geometry g = {.vertex_count = ROW * (DOWN + 1), .index_count = AROUND * DOWN * 6};
    g.positions = calloc(g.vertex_count, 3 * sizeof(float));
    g.normals = calloc(g.vertex_count, 3 * sizeof(float));
    g.indices = calloc(g.index_count, sizeof *g.indices);
    if (!g.positions || !g.normals || !g.indices) {
        ng_geometry_finish(&g);
        return ng_out_of_memory("a sphere");
    }
    for (uint32_t i = 0; i < g.vertex_count; i++) {
        uint32_t row = i / ROW;
        double phi = 2 * pi * (i % ROW) / AROUND, theta = pi * row / DOWN;
        const double n[3] = {sin(theta) * cos(phi), cos(theta), -sin(theta) * sin(phi)};
        for (size_t k = 0; k < 3; k++)
            g.positions[i * 3 + k] = g.normals[i * 3 + k] = (float)n[k];
    }
    for (uint32_t i = 0; i < AROUND * DOWN; i++) {
        uint32_t a = i / AROUND * ROW + i % AROUND, c = a + ROW;
        const uint32_t two[6] = {a, c, a + 1, a + 1, c, c + 1};
        for (size_t k = 0; k < 6; k++)
            g.indices[i * 6 + k] = two[k];
    }
    ng_result r = ng_geometry_complete(&g);
    if (r == NG_OK)
        r = ng_assets_take_geometry(b->stage->assets, "sphere", &g, out);
    return r;
}

static ng_result add_spheres(struct bench *b, uint32_t count)
{
    struct ng_mesh mesh = {.visible = true};
    if (!count)
        return NG_OK;
    NG_TRY(make_sphere(b, &mesh.geometry));
    for (uint32_t i = 0; i < count; i++) {
        ng_entity e;
        uint32_t row = i / 8;
        const struct ng_transform place = {.translation = {(float)(i % 8) * 1.5f, (float)row * 1.5f, -3},
                                           .rotation = {0, 0, 0, 1},
                                           .scale = {1, 1, 1}};
        NG_TRY(add_copy(b, &mesh, &place, &e));
    }
    return NG_OK;
}

static ng_result follow(struct bench *b, struct lf_tracer *tracer, double *ms)
{
    NG_TRY(ng_stage_seek(b->stage, 0, NULL));
    NG_TRY(lf_tracer_update(tracer, b->stage->snapshot));
    *ms = lf_tracer_stats_of(tracer).update_ms;
    return NG_OK;
}

struct candidate {
    ng_entity entity;
    uint32_t triangles;
};

static int compare_candidates(const void *a, const void *b)
{
    uint32_t x = ((const struct candidate *)a)->triangles, y = ((const struct candidate *)b)->triangles;
    return (x > y) - (x < y);
}

// Edits are made on copies: animations place the others.
static ng_result copy_objects(struct bench *b)
{
    struct ng_world *world = b->stage->world;
    const struct ng_transform place =
        *(const struct ng_transform *)ng_world_get(world, b->object, NG_TRANSFORM);
    const struct ng_mesh mesh = *(const struct ng_mesh *)ng_world_get(world, b->object, NG_MESH);
    double first;
    NG_TRY(add_copy(b, &mesh, &place, &b->object));
    NG_TRY(add_copy(b, &mesh, &place, &b->other));
    return follow(b, b->tracer, &first);
}

static ng_result choose_objects(struct bench *b)
{
    const struct ng_snapshot *s = b->stage->snapshot;
    struct candidate *all = calloc(s->instance_count + 1, sizeof *all);
    uint32_t count = 0;
    if (!all)
        return ng_out_of_memory("a benchmark");
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (s->instances[i].light == NG_NONE &&
            ng_world_has(b->stage->world, s->instances[i].entity, NG_TRANSFORM))
            all[count++] =
                (struct candidate){s->instances[i].entity, s->meshes[s->instances[i].mesh].index_count / 3};
    qsort(all, count, sizeof *all, compare_candidates);
    b->object = b->other = all[count / 2].entity; // none, where there are none
    printf("\"object\": %u, ", all[count / 2].triangles);
    free(all);
    return count ? copy_objects(b) : NG_ERROR_NOT_FOUND;
}

// ---- Edits -----------------------------------------------------------------------------------------------

static void push(struct bench *b, ng_entity e, float by)
{
    struct ng_transform *t = ng_world_edit(b->stage->world, e, NG_TRANSFORM);
    t->translation[0] += by;
}

static ng_result edit_a_copy(struct bench *b, float away, double *ms)
{
    struct ng_world *world = b->stage->world;
    struct ng_transform place = *(const struct ng_transform *)ng_world_get(world, b->object, NG_TRANSFORM);
    const struct ng_mesh mesh = *(const struct ng_mesh *)ng_world_get(world, b->object, NG_MESH);
    ng_entity e;
    double gone;
    place.translation[0] += away;
    NG_TRY(add_copy(b, &mesh, &place, &e));
    NG_TRY(follow(b, b->tracer, ms));
    NG_TRY(ng_entity_destroy(world, e));
    return follow(b, b->tracer, &gone);
}

static ng_result build_anew(struct bench *b, double *ms)
{
    struct lf_tracer *fresh;
    NG_TRY(lf_tracer_create(&fresh));
    ng_result result = follow(b, fresh, ms);
    lf_tracer_destroy(&fresh);
    return result;
}

static ng_result measure_round(struct bench *b, int round)
{
    struct ng_world *world = b->stage->world;
    NG_TRY(build_anew(b, &b->ms[FULL][round]));
    NG_TRY(follow(b, b->tracer, &b->ms[NOTHING][round]));
    push(b, b->object, 0.01f);
    push(b, b->other, 0.01f);
    NG_TRY(follow(b, b->tracer, &b->ms[REFIT][round]));
    NG_TRY(edit_a_copy(b, 0.5f, &b->ms[ADD][round]));
    NG_TRY(edit_a_copy(b, 0, &b->ms[DUPLICATE][round]));
    NG_TRY(ng_world_begin(world, "delete"));
    NG_TRY(ng_entity_destroy(world, b->object));
    NG_TRY(ng_world_commit(world));
    NG_TRY(follow(b, b->tracer, &b->ms[DELETE][round]));
    NG_TRY(ng_world_undo(world));
    return follow(b, b->tracer, &b->ms[UNDO][round]);
}

static ng_result measure_rays(struct bench *b)
{
    const struct ng_snapshot *s = b->stage->snapshot;
    struct lf_ray *rays = calloc(RAYS, sizeof *rays);
    struct ng_rng rng = ng_rng_make(1, 2);
    if (!rays)
        return ng_out_of_memory("a benchmark");
    for (uint32_t i = 0; i < RAYS; i++) {
        float length = 0;
        for (int k = 0; k < 3; k++) {
            rays[i].origin[k] = s->scene_center[k] + ng_rng_range(&rng, -0.5f, 0.5f) * s->scene_radius;
            rays[i].direction[k] = ng_rng_range(&rng, -1, 1);
            length += rays[i].direction[k] * rays[i].direction[k];
        }
        for (int k = 0; k < 3; k++)
            rays[i].direction[k] /= sqrtf(length);
        rays[i].far = INFINITY;
    }
    uint64_t begin = ng_clock_ns();
    uint32_t met = lf_trace_bare(b->tracer, rays, RAYS);
    printf("\"rays_a_second\": %.3g, \"met\": %.2f, ", RAYS / ((double)(ng_clock_ns() - begin) * 1e-9),
           (double)met / RAYS);
    free(rays);
    return NG_OK;
}

static ng_result run(struct bench *b, const char *scene, uint32_t empty, uint32_t spheres)
{
    double first;
    NG_TRY(ng_stage_create(&(struct ng_stage_params){.scene = scene, .no_device = true}, &b->stage));
    for (uint32_t i = 0; i < empty; i++)
        if (ng_entity_is_null(ng_entity_create(b->stage->world)))
            return ng_out_of_memory("a benchmark");
    NG_TRY(add_spheres(b, spheres));
    NG_TRY(lf_tracer_create(&b->tracer));
    NG_TRY(follow(b, b->tracer, &first));
    struct lf_tracer_stats stats = lf_tracer_stats_of(b->tracer);
    printf("{\"instances\": %u, \"triangles\": %llu, \"bytes\": %llu, ", stats.instances,
           (unsigned long long)stats.triangles, (unsigned long long)stats.bytes);
    NG_TRY(choose_objects(b));
    NG_TRY(measure_rays(b));
    for (int round = 0; round < ROUNDS; round++)
        NG_TRY(measure_round(b, round));
    double full = median(b->ms[FULL]);
    printf("\"full_ms\": %.2f", full);
    for (int i = FULL + 1; i < COUNT; i++)
        printf(", \"%s\": %.4f", names[i], median(b->ms[i]) / full);
    printf("}\n");
    return NG_OK;
}

int main(int argc, char **argv)
{
    struct bench b = {0};
    ng_result result = run(&b, argc > 1 ? argv[1] : "content/chess/chess.glb",
                           argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 0,
                           argc > 3 ? (uint32_t)strtoul(argv[3], NULL, 10) : 0);
    lf_tracer_destroy(&b.tracer);
    ng_stage_destroy(&b.stage);
    return result == NG_OK ? 0 : 1;
}
