// A tracer that followed a scene through random edits says of every ray what a new tracer of the same
// snapshot says, byte for byte: also where surfaces lie in the same place, which only the order in Embree's
// structures tells apart. test_trace_edits [STEPS [SEED]].
#include "scene.h"

#include "base/rng.h"
#include "components/light_disk.h"
#include "components/light_mesh.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/name.h"
#include "components/transform.h"
#include "render/extract.h"
#include "scene/history.h"
#include "scene/system.h"
#include "scene/world.h"

#include <math.h>

#define NOTHING ((ng_component)-1)

enum { RAYS = 2000, MOST_ENTITIES = 512 };

static uint32_t steps = 60;
static uint64_t seed = 4;

struct walk {
    struct scene scene; // its tracer follows
    uint64_t memory_limit;
    struct ng_rng rng;
    double time;
    ng_entity entities[MOST_ENTITIES]; // alive
    uint32_t entity_count;
    const char *what;
    uint64_t built, hits, twins, shared; // over all steps
};

// ---- Edits -----------------------------------------------------------------------------------------------

static void list_entities(struct walk *w)
{
    struct ng_world *world = w->scene.world;
    ng_entity none = {0};
    w->entity_count = 0;
    for (ng_entity e = ng_world_first_child(world, none);
         !ng_entity_is_null(e) && w->entity_count < MOST_ENTITIES; e = ng_world_next_below(world, none, e))
        w->entities[w->entity_count++] = e;
}

// A random entity that has the component, or null.
static ng_entity pick(struct walk *w, ng_component component)
{
    ng_entity picked = {0};
    for (uint32_t i = 0, found = 0; i < w->entity_count; i++) {
        ng_entity e = w->entities[i];
        bool has = component == NOTHING ? !ng_world_components(w->scene.world, e)
                                        : ng_world_has(w->scene.world, e, component);
        if (has && ng_rng_below(&w->rng, ++found) == 0)
            picked = e;
    }
    return picked;
}

// Entities without a surface, between others.
static void crowd(struct walk *w)
{
    for (uint32_t i = ng_rng_below(&w->rng, 200); w->entity_count < MOST_ENTITIES / 2 && i > 0; i--)
        ng_entity_create(w->scene.world);
}

// A copy in the same place.
static void duplicate(struct walk *w)
{
    struct ng_world *world = w->scene.world;
    ng_entity from = pick(w, NG_MESH);
    const struct ng_transform *t = ng_world_get(world, from, NG_TRANSFORM);
    if (!t)
        return;
    const struct ng_transform place = *t;
    const struct ng_mesh mesh = *(const struct ng_mesh *)ng_world_get(world, from, NG_MESH);
    ng_entity e = ng_rng_below(&w->rng, 2) ? pick(w, NOTHING) : (ng_entity){0};
    if (ng_entity_is_null(e))
        e = ng_entity_create(world);
    OK(ng_world_add(world, e, NG_TRANSFORM, &place));
    OK(ng_world_add(world, e, NG_MESH, &mesh));
    OK(ng_world_set_parent(world, e, ng_world_parent(world, from), (ng_entity){0}));
}

static void destroy(struct walk *w)
{
    ng_entity e = pick(w, ng_rng_below(&w->rng, 4) ? NG_MESH : NG_TRANSFORM);
    if (!ng_entity_is_null(e) && !ng_entity_same(e, w->scene.camera))
        OK(ng_entity_destroy(w->scene.world, e));
}

// To a few places and turns, so that things meet; sometimes flat, a point, mirrored, anywhere.
static void move(struct walk *w)
{
    static const float scales[] = {1, 1, 1, -1, 0.5f, 0};
    ng_entity e = pick(w, NG_TRANSFORM);
    struct ng_transform *t = ng_entity_is_null(e) ? NULL : ng_world_edit(w->scene.world, e, NG_TRANSFORM);
    if (!t || ng_entity_same(e, w->scene.camera))
        return;
    uint32_t way = ng_rng_below(&w->rng, 4), axis = ng_rng_below(&w->rng, 3);
    float scale = scales[ng_rng_below(&w->rng, NG_COUNT(scales))], turn = way == 1 ? 0.5f : 0;
    for (int k = 0; k < 3; k++)
        t->translation[k] = way == 3 ? ng_rng_range(&w->rng, -1, 1) : (float)ng_rng_below(&w->rng, 2);
    if (way < 2)
        memcpy(t->rotation, (const float[4]){turn, turn, turn, way == 1 ? 0.5f : 1}, sizeof t->rotation);
    for (uint32_t k = 0; way == 2 && k < 3; k++)
        if (scale != 0 || k != axis || ng_rng_below(&w->rng, 2))
            t->scale[k] = scale;
}

// A joint, or a whole branch, becomes a point, or what it was before.
static void collapse(struct walk *w)
{
    ng_entity e = pick(w, NG_TRANSFORM);
    if (ng_entity_is_null(e) || ng_entity_same(e, w->scene.camera))
        return;
    struct ng_transform *t = ng_world_edit(w->scene.world, e, NG_TRANSFORM);
    float scale = fabsf(t->scale[0]) > 0 ? 0 : 1;
    for (int k = 0; k < 3; k++)
        t->scale[k] = scale;
}

static void reparent(struct walk *w)
{
    struct ng_world *world = w->scene.world;
    ng_entity e = pick(w, NG_MESH), parent = pick(w, NG_TRANSFORM);
    for (ng_entity up = parent; !ng_entity_is_null(up); up = ng_world_parent(world, up))
        if (ng_entity_same(up, e))
            return;
    if (!ng_entity_is_null(e))
        OK(ng_world_set_parent(world, e, parent, (ng_entity){0}));
}

static void swap_mesh(struct walk *w)
{
    ng_entity e = pick(w, NG_MESH), other = pick(w, NG_MESH);
    if (ng_entity_is_null(e))
        return;
    ng_asset geometry = ((const struct ng_mesh *)ng_world_get(w->scene.world, other, NG_MESH))->geometry;
    ((struct ng_mesh *)ng_world_edit(w->scene.world, e, NG_MESH))->geometry = geometry;
}

static void hide(struct walk *w)
{
    ng_entity e = pick(w, NG_MESH);
    struct ng_mesh *mesh = ng_entity_is_null(e) ? NULL : ng_world_edit(w->scene.world, e, NG_MESH);
    if (mesh)
        mesh->visible = !mesh->visible;
}

static void change_material(struct walk *w)
{
    ng_entity e = pick(w, NG_MATERIAL);
    struct ng_material *m = ng_entity_is_null(e) ? NULL : ng_world_edit(w->scene.world, e, NG_MATERIAL);
    if (!m)
        return;
    m->double_sided = ng_rng_below(&w->rng, 2);
    m->alpha_mode = ng_rng_below(&w->rng, 3);
    m->alpha = ng_rng_below(&w->rng, 2) ? 0.1f : 1; // nothing, or all
    m->roughness = ng_rng_float(&w->rng);
}

// Some of them on what is a mesh already, and several on one.
static void toggle_light(struct walk *w)
{
    static const struct ng_light_sphere ball = {
        .on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f};
    static const struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f};
    static const struct ng_light_rectangle panel = {
        .on = true, .color = {1, 1, 1}, .radiance = 1, .size = {1, 1}};
    static const struct ng_light_mesh mesh = {.on = true, .color = {1, 1, 1}, .scale = 1};
    const struct {
        ng_component component;
        const void *value;
    } lights[] = {{NG_LIGHT_SPHERE, &ball},
                  {NG_LIGHT_DISK, &disk},
                  {NG_LIGHT_RECTANGLE, &panel},
                  {NG_LIGHT_MESH, &mesh}};
    struct ng_world *world = w->scene.world;
    uint32_t i = ng_rng_below(&w->rng, NG_COUNT(lights));
    ng_entity e = pick(w, lights[i].component);
    if (!ng_entity_is_null(e) && ng_rng_below(&w->rng, 2)) {
        OK(ng_world_remove(world, e, lights[i].component));
        return;
    }
    e = pick(w, lights[i].component == NG_LIGHT_MESH ? NG_MESH : NG_TRANSFORM);
    if (!ng_entity_is_null(e) && !ng_entity_same(e, w->scene.camera))
        OK(ng_world_add(world, e, lights[i].component, lights[i].value));
}

static void glow(struct walk *w)
{
    ng_entity e = pick(w, NG_MATERIAL);
    if (ng_entity_is_null(e))
        return;
    struct ng_material *m = ng_world_edit(w->scene.world, e, NG_MATERIAL);
    m->emissive_strength = 1;
    m->emissive[0] = m->emissive[0] > 0 ? 0.0f : 1.0f;
}

static const struct {
    const char *name;
    void (*run)(struct walk *w);
} edits[] = {{"duplicate", duplicate}, {"duplicate", duplicate}, {"duplicate", duplicate},
             {"destroy", destroy},     {"destroy", destroy},     {"move", move},
             {"move", move},           {"collapse", collapse},   {"reparent", reparent},
             {"swap mesh", swap_mesh}, {"hide", hide},           {"material", change_material},
             {"light", toggle_light},  {"light", toggle_light},  {"glow", glow},
             {"crowd", crowd}};

static void edit(struct walk *w)
{
    struct ng_world *world = w->scene.world;
    uint32_t way = ng_rng_below(&w->rng, 8), i = ng_rng_below(&w->rng, NG_COUNT(edits));
    w->time += ng_rng_below(&w->rng, 6) ? 0 : 0.17;
    list_entities(w);
    w->what = way < 2 ? "undo or redo" : edits[i].name;
    if (way < 2 && (way ? ng_world_redo_label : ng_world_undo_label)(world)) {
        OK((way ? ng_world_redo : ng_world_undo)(world));
        return;
    }
    OK(ng_world_begin(world, edits[i].name));
    edits[i].run(w);
    OK(ng_world_commit(world));
}

// ---- Rays ------------------------------------------------------------------------------------------------

// A point of a surface, in the world; false: there is none.
static bool find_point(struct walk *w, float out[3])
{
    const struct ng_snapshot *s = w->scene.snapshot;
    if (!s->instance_count)
        return false;
    const struct ng_snapshot_instance *in = &s->instances[ng_rng_below(&w->rng, s->instance_count)];
    const struct ng_snapshot_mesh *mesh = &s->meshes[in->mesh];
    const uint32_t *index = mesh->indices + (size_t)ng_rng_below(&w->rng, mesh->index_count / 3) * 3;
    float b = ng_rng_float(&w->rng), c = ng_rng_float(&w->rng), own[3];
    const float weights[3] = {1 - b * (1 - c) - c, b * (1 - c), c};
    for (size_t k = 0; k < 3; k++) {
        own[k] = 0;
        for (size_t i = 0; i < 3; i++)
            own[k] += weights[i] * mesh->positions[(size_t)index[i] * 3 + k];
    }
    for (int k = 0; k < 3; k++)
        out[k] = in->matrix[k * 4] * own[0] + in->matrix[k * 4 + 1] * own[1] +
                 in->matrix[k * 4 + 2] * own[2] + in->matrix[k * 4 + 3];
    return true;
}

// Most of them at some surface.
static struct lf_ray any_ray(struct walk *w)
{
    struct lf_ray ray = {.far = INFINITY};
    float target[3], length = 0;
    if (!ng_rng_below(&w->rng, 8) || !find_point(w, target))
        for (int k = 0; k < 3; k++)
            target[k] = ng_rng_range(&w->rng, -1, 2);
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = ng_rng_range(&w->rng, -3, 4);
        ray.direction[k] = target[k] - ray.origin[k];
        length += ray.direction[k] * ray.direction[k];
    }
    for (int k = 0; k < 3; k++)
        ray.direction[k] /= sqrtf(length);
    return ray;
}

// All that a tracer says of a ray, without a byte that is not set.
struct answer {
    struct lf_hit hits[2], emitters[8], packet[LF_PACKET], many[LF_PACKET];
    float far[LF_PACKET];
    bool met[2], occluded, shadowed, many_met[LF_PACKET], many_occluded[LF_PACKET], packet_met[LF_PACKET],
        packet_occluded[LF_PACKET];
    uint32_t emitter_count;
};

static void visit(void *user, const struct lf_hit *hit)
{
    struct answer *a = user;
    if (a->emitter_count < NG_COUNT(a->emitters)) {
        struct lf_hit *to = &a->emitters[a->emitter_count++];
        memcpy(to, hit, offsetof(struct lf_hit, front));
        to->front = hit->front;
    }
}

static void ask_packet(const struct lf_tracer *t, const struct lf_ray *rays, uint32_t light,
                       struct answer *out)
{
    struct lf_packet p = {.passes = light};
    for (int i = 0; i < LF_PACKET; i++) {
        for (int k = 0; k < 3; k++) {
            p.origin[k][i] = rays[i].origin[k];
            p.direction[k][i] = rays[i].direction[k];
        }
        p.far[i] = rays[i].far;
    }
    struct lf_packet any = p;
    lf_trace_packet(t, &p, out->packet);
    lf_trace_packet_occluded(t, &any);
    memcpy(out->far, p.far, sizeof p.far);
    memcpy(out->packet_met, p.met, sizeof p.met);
    memcpy(out->packet_occluded, any.met, sizeof any.met);
}

// One of LF_PACKET rays in every way, and all of them side by side.
static void ask(const struct lf_tracer *t, const struct lf_ray *rays, uint32_t light, struct answer *out)
{
    memset(out, 0, sizeof *out);
    for (int kind = 0; kind < 2; kind++)
        out->met[kind] = lf_trace_closest(t, rays, (enum lf_ray_kind)kind, &out->hits[kind]);
    out->occluded = lf_trace_occluded(t, rays);
    out->shadowed = lf_trace_shadowed(t, rays, light);
    lf_trace_emitters(t, rays, visit, out);
    lf_trace_closest_many(t, rays, LF_PACKET, out->many_met, out->many);
    lf_trace_occluded_many(t, rays, LF_PACKET, out->many_occluded);
    ask_packet(t, rays, light, out);
}

// How many instances lie exactly where another does.
static uint32_t count_twins(const struct ng_snapshot *s)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const struct ng_snapshot_instance *a = &s->instances[i], *b = NULL;
        for (uint32_t k = 0; k < i && !b; k++)
            if (s->instances[k].mesh == a->mesh &&
                memcmp((const void *)s->instances[k].matrix, (const void *)a->matrix, sizeof a->matrix) == 0)
                b = &s->instances[k];
        count += b != NULL;
    }
    return count;
}

static void compare(struct walk *w, const struct lf_tracer *fresh)
{
    const struct ng_snapshot *s = w->scene.snapshot;
    static struct answer a, b;
    for (int i = 0; i < RAYS; i += LF_PACKET) {
        struct lf_ray rays[LF_PACKET + LF_PACKET];
        for (int k = 0; k < LF_PACKET; k++)
            rays[k] = rays[LF_PACKET + k] = any_ray(w);
        uint32_t light = s->light_count ? ng_rng_below(&w->rng, s->light_count) : NG_NONE;
        for (int k = 0; k < LF_PACKET; k++) {
            ask(w->scene.tracer, rays + k, light, &a);
            ask(fresh, rays + k, light, &b);
            if (memcmp((const void *)&a, (const void *)&b, sizeof a) != 0)
                fail_msg("seed %u, %s: a ray meets instance %u, triangle %u at %.9g, in a new tracer %u, %u "
                         "at %.9g",
                         (unsigned)seed, w->what, a.hits[0].instance, a.hits[0].triangle,
                         (double)a.hits[0].distance, b.hits[0].instance, b.hits[0].triangle,
                         (double)b.hits[0].distance);
            w->hits += a.met[0];
        }
    }
}

static void compare_tracers(struct walk *w, const struct lf_tracer *fresh)
{
    struct lf_tracer_stats kept = lf_tracer_stats_of(w->scene.tracer), made = lf_tracer_stats_of(fresh);
    assert_int_equal(kept.instances, made.instances);
    assert_int_equal(kept.triangles, made.triangles);
    assert_int_equal(kept.shared, made.shared);
    w->built += kept.built;
    w->shared += kept.shared;
    w->twins += count_twins(w->scene.snapshot);
    compare(w, fresh);
}

static void look(struct walk *w)
{
    struct scene *s = &w->scene;
    struct lf_tracer *fresh;
    struct ng_extract_params p = {.world = s->world, .assets = s->assets, .jobs = s->jobs, .time = w->time};
    OK(ng_world_run(s->world, w->time));
    OK(ng_extract(s->extractor, &p, &s->snapshot));
    OK(lf_tracer_create(&fresh));
    lf_tracer_limit_memory(fresh, w->memory_limit);
    ng_result kept = lf_tracer_update(s->tracer, s->snapshot), made = lf_tracer_update(fresh, s->snapshot);
    assert_true(w->memory_limit || (kept == NG_OK && made == NG_OK));
    if (kept == NG_OK && made == NG_OK)
        compare_tracers(w, fresh);
    lf_tracer_destroy(&fresh);
}

static void ignore(void *user, enum ng_log_level level, const char *text)
{
    NG_UNUSED(user);
    NG_UNUSED(level);
    NG_UNUSED(text);
}

// `short_of_memory`: so that meshes are shared when there are some more of them.
static void walk(struct walk *w, const char *path, bool short_of_memory)
{
    ng_log_set_sink(ignore, NULL); // edits break things, which is said there
    *w = (struct walk){.rng = ng_rng_make(seed, 3), .what = "nothing"};
    scene_load(&w->scene, 1, path);
    look(w);
    if (short_of_memory)
        w->memory_limit = lf_tracer_stats_of(w->scene.tracer).triangles * 400;
    lf_tracer_limit_memory(w->scene.tracer, w->memory_limit);
    for (uint32_t i = 0; i < steps; i++) {
        edit(w);
        look(w);
    }
    scene_close(&w->scene);
    ng_log_set_sink(NULL, NULL);
    printf("%s: %u built, %u hits, %u twins, %u shared\n", path, (unsigned)w->built, (unsigned)w->hits,
           (unsigned)w->twins, (unsigned)w->shared);
    assert_true(w->hits > (uint64_t)steps * RAYS / 20 && w->twins > 0);
}

static void test_edits_leave_what_a_new_tracer_has(void **state)
{
    NG_UNUSED(state);
    static const char *const paths[] = {"content/unit/character.glb", "content/unit/light_mesh.glb",
                                        "content/unit/hierarchy.glb", "content/unit/alpha_mask.glb",
                                        "content/unit/subdivision.glb"};
    static struct walk w;
    for (size_t i = 0; i < NG_COUNT(paths); i++)
        walk(&w, paths[i], false);
}

static void test_edits_leave_what_a_new_tracer_has_where_meshes_are_shared(void **state)
{
    NG_UNUSED(state);
    static struct walk w;
    walk(&w, "content/unit/light_mesh.glb", true);
    assert_true(w.shared > 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_edits_leave_what_a_new_tracer_has),
        cmocka_unit_test(test_edits_leave_what_a_new_tracer_has_where_meshes_are_shared),
    };
    steps = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : steps;
    seed = argc > 2 ? strtoul(argv[2], NULL, 10) : seed;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
