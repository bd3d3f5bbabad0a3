// A random editor, and those who remember: after each step whatever is drawn by an extractor, a renderer and
// a live path tracer that followed the steps before equals, bit for bit, what new ones draw. Where nothing
// that they show has changed, the path tracer does not begin anew, and nothing is encoded again. Some frames
// of those who remember are given up in the middle, as when somebody goes on editing.
//
// Arguments: nothing, or [steps a scene [first seed [scene [steps a walk, 0: all of them]]]].
#include "neural_test.h"

#include "base/hash.h"
#include "components/mesh.h"
#include "components/subdivision.h"
#include "editor.h"
#include "lightformer/progressive/progressive.h"
#include "networks.h"
#include "render/extract.h"
#include "scene/system.h"

enum { EDITS = 3 }; // in a step, at most

static uint32_t given_up; // frames
// Arguments.
static uint32_t steps = 24;
static uint64_t first_seed = 1;
static const char *only = "";
static uint32_t run = 24; // steps after which a scene is loaded anew, since edits wear it out

// ---- Those who draw --------------------------------------------------------------------------------------

struct artist {
    struct ng_extractor *extractor;
    const struct ng_snapshot *snapshot;
    struct method method;
    struct lf_progressive *progressive;
};

struct walk {
    struct room room;       // its scene, device, weights and size
    enum lf_rsm_source rsm; // of the neural method
    struct editor editor;
    struct artist kept, fresh;
    double time;
    uint64_t shown;  // hash of what this step shows
    char what[1024]; // scene, seed, step and its edits
};

static void artist_open(const struct walk *w, struct artist *a)
{
    const struct lf_neural_params neural = {.rsm = w->rsm};
    const struct lf_progressive_params params = {.jobs = w->room.scene.jobs, .samples = 1};
    *a = (struct artist){0};
    OK(ng_extractor_create(&a->extractor));
    method_open(&w->room, &neural, &a->method);
    OK(lf_progressive_create(&params, &a->progressive));
    OK(lf_progressive_join(a->progressive, ng_renderer_composer(a->method.renderer)));
}

static void artist_close(struct artist *a)
{
    lf_progressive_destroy(&a->progressive);
    method_close(&a->method);
    ng_extractor_destroy(&a->extractor);
}

static void artist_look(const struct walk *w, struct artist *a)
{
    const struct ng_extract_params params = {.world = w->room.scene.world,
                                             .assets = w->room.scene.assets,
                                             .jobs = w->room.scene.jobs,
                                             .time = w->time};
    OK(ng_extract(a->extractor, &params, &a->snapshot));
}

// All layers that a method has, but for motion, which is that since the last step.
static const char *const raster[] = {"unshadowed", "direct", "emission",  "albedo", "specular",
                                     "position",   "normal", "roughness", "depth",  "entity"};
static const char *const radiance[] = {"unshadowed", "direct", "indirect"};
// Its G-buffer is not the rasterizer's where the device is a CPU (lightformer/raycast).
static const char *const neural[] = {"unshadowed", "direct", "indirect",  "emission", "albedo", "specular",
                                     "position",   "normal", "roughness", "depth",    "entity"};

static const struct view {
    const char *method;
    const char *const *layers;
    uint32_t layer_count;
} views[] = {{"raster", raster, NG_COUNT(raster)},
             {LF_NEURAL_METHOD, neural, NG_COUNT(neural)},
             {"reference", radiance, NG_COUNT(radiance)}};

// Null `left`: to the end; else the frame is given up when it has been asked about so often.
static bool is_given_up(void *left)
{
    return (*(uint32_t *)left)-- == 0;
}

static ng_result draw_some(const struct walk *w, struct artist *a, const struct view *view, uint32_t *left)
{
    const struct ng_render_params params = {.snapshot = a->snapshot,
                                            .width = w->room.width,
                                            .height = w->room.height,
                                            .method = view->method,
                                            .layers = view->layers,
                                            .layer_count = view->layer_count,
                                            .abandon = left ? is_given_up : NULL,
                                            .abandon_user = left};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(w->room.gpu, &cmd));
    ng_result drawn = ng_renderer_frame(a->method.renderer, &cmd, &params);
    OK(ng_frame_end(w->room.gpu, &cmd));
    return drawn;
}

static ng_result draw(const struct walk *w, struct artist *a, const struct view *view)
{
    return draw_some(w, a, view, NULL);
}

// After the preview the path tracer needs one frame more; false: it was at rest from the start.
static bool draw_to_the_end(const struct walk *w, struct artist *a)
{
    const struct view *view = &views[NG_COUNT(views) - 1];
    OK(draw(w, a, view));
    if (lf_progressive_stats_of(a->progressive).resting)
        return false;
    while (!lf_progressive_stats_of(a->progressive).resting)
        OK(draw(w, a, view));
    return true;
}

// Numbers of a layer, whatever they are.
static const char *numbers_of(struct artist *a, const char *name, struct ng_layer *out)
{
    OK(ng_renderer_layer(a->method.renderer, name, out));
    return out->info->uint ? (const char *)out->ids : (const char *)out->pixels;
}

static double number_at(const char *numbers, uint32_t i)
{
    float value;
    memcpy(&value, numbers + (size_t)i * sizeof value, sizeof value);
    return (double)value;
}

static void compare_layer(struct walk *w, const char *method, const char *name)
{
    struct ng_layer x, y;
    const char *kept = numbers_of(&w->kept, name, &x), *fresh = numbers_of(&w->fresh, name, &y);
    uint32_t wrong = 0, first = 0, count = x.width * x.height * x.channels;
    for (uint32_t i = 0; i < count; i++)
        if (memcmp(kept + (size_t)i * 4, fresh + (size_t)i * 4, 4) != 0 && !wrong++)
            first = i;
    if (wrong)
        fail_msg("%s: %s/%s differs in %u of %u numbers, first at (%u, %u): %.9g, and %.9g anew", w->what,
                 method, name, wrong, count, first / x.channels % x.width, first / x.channels / x.width,
                 number_at(kept, first), number_at(fresh, first));
}

static void compare(struct walk *w, const struct view *view)
{
    for (uint32_t i = 0; i < view->layer_count; i++)
        compare_layer(w, view->method, view->layers[i]);
}

// ---- What is shown ---------------------------------------------------------------------------------------

static uint64_t hash_image(const struct ng_image *image)
{
    const struct ng_sampling *s = &image->sampling;
    const uint32_t words[] = {image->width, image->height, image->format, s->wrap_u,
                              s->wrap_v,    s->magnify,    s->minify,     s->mips};
    return ng_hash_bytes(ng_hash_bytes(0, words, sizeof words), image->pixels, image->size);
}

static uint64_t hash_material(const struct ng_snapshot *s, const struct ng_snapshot_material *m)
{
    const uint64_t words[] = {m->entity.id, m->double_sided, m->alpha_mode, m->unlit};
    const float numbers[] = {m->metallic, m->roughness,    m->normal_scale,
                             m->alpha,    m->alpha_cutoff, m->specular};
    uint64_t hash = ng_hash_bytes(0, words, sizeof words);
    hash = ng_hash_bytes(hash, m->base_color, sizeof m->base_color);
    hash = ng_hash_bytes(hash, m->emission, sizeof m->emission);
    hash = ng_hash_bytes(hash, numbers, sizeof numbers);
    hash = ng_hash_bytes(hash, m->specular_color, sizeof m->specular_color);
    for (size_t i = 0; i < NG_TEXTURE_COUNT; i++) {
        const struct ng_snapshot_texture *t = &m->textures[i];
        const struct ng_snapshot_image *image = t->image == NG_NONE ? NULL : &s->images[t->image];
        hash = ng_hash_combine(hash, image ? image->key : 0);
        hash = ng_hash_combine(hash, image ? hash_image(image->image) : 0);
        hash = ng_hash_combine(hash, t->uv_set);
        hash = ng_hash_bytes(hash, t->coordinates, sizeof t->coordinates);
    }
    return hash;
}

static uint64_t hash_mesh(const struct ng_snapshot_mesh *m)
{
    uint64_t hash = ng_hash_bytes(0, m->positions, m->vertex_count * 3 * sizeof(float));
    hash = ng_hash_bytes(hash, m->normals, m->vertex_count * 3 * sizeof(float));
    hash = ng_hash_bytes(hash, m->tangents, m->vertex_count * 4 * sizeof(float));
    hash = ng_hash_bytes(hash, m->uvs, m->vertex_count * 2 * sizeof(float));
    if (m->uvs1)
        hash = ng_hash_bytes(hash, m->uvs1, m->vertex_count * 2 * sizeof(float));
    if (m->colors)
        hash = ng_hash_bytes(hash, m->colors, m->vertex_count * 4 * sizeof *m->colors);
    return ng_hash_bytes(hash, m->indices, m->index_count * sizeof *m->indices);
}

static uint64_t hash_instance(const struct walk *w, const struct ng_snapshot *s, uint32_t index)
{
    const struct ng_snapshot_instance *in = &s->instances[index];
    const struct ng_mesh *mesh = ng_world_get(w->room.scene.world, in->entity, NG_MESH);
    const struct ng_subdivision *refined = ng_world_get(w->room.scene.world, in->entity, NG_SUBDIVISION);
    const struct ng_assets *assets = w->room.scene.assets;
    const uint64_t words[] = {in->entity.id, mesh ? mesh->geometry.id : 0,
                              mesh ? ng_assets_revision(assets, mesh->geometry).topology : 0,
                              refined ? 1 + refined->boundary : 0, refined ? refined->cage.id : 0,
                              refined ? ng_assets_revision(assets, refined->cage).topology : 0,
                              // What is refined is made again, though the surface may come out the same.
                              refined && mesh ? ng_assets_revision(assets, mesh->geometry).content : 0,
                              refined ? ng_assets_revision(assets, refined->cage).content : 0, in->light,
                              in->flags & ~(uint32_t)NG_INSTANCE_MOVED, hash_mesh(&s->meshes[in->mesh]),
                              hash_material(s, &s->materials[in->material])};
    uint64_t hash = ng_hash_bytes(0, words, sizeof words);
    return ng_hash_bytes(hash, in->matrix, sizeof in->matrix);
}

static uint64_t hash_light(const struct walk *w, const struct ng_snapshot_light *l)
{
    const struct ng_light_source *u = &l->source;
    ng_asset image = u->type->image ? u->type->image(u) : (ng_asset){0};
    const struct ng_image *texels = ng_assets_image(w->room.scene.assets, image);
    const uint64_t words[] = {l->entity.id, u->type->component, texels ? image.id : 0,
                              texels ? hash_image(texels) : 0};
    uint64_t hash = ng_hash_bytes(0, words, sizeof words);
    hash = ng_hash_bytes(hash, u->params, sizeof u->params);
    hash = ng_hash_bytes(hash, u->emission, sizeof u->emission);
    return ng_hash_bytes(hash, u->matrix, sizeof u->matrix);
}

// Of all that a path tracer looks at, by content: what extractions count and remember is left out.
static uint64_t hash_shown(const struct walk *w)
{
    const struct ng_snapshot *s = w->fresh.snapshot;
    const float numbers[] = {s->camera.fov_y,    s->camera.height,   s->camera.near_plane, s->scene_radius,
                             s->scene_center[0], s->scene_center[1], s->scene_center[2]};
    const uint32_t size[] = {w->room.width, w->room.height};
    uint64_t hash = ng_hash_bytes(0, size, sizeof size);
    hash = ng_hash_bytes(hash, numbers, sizeof numbers);
    hash = ng_hash_bytes(hash, s->camera.view, sizeof s->camera.view);
    for (uint32_t i = 0; i < s->instance_count; i++)
        hash = ng_hash_combine(hash, hash_instance(w, s, i));
    for (uint32_t i = 0; i < s->light_count; i++)
        hash = ng_hash_combine(hash, hash_light(w, &s->lights[i]));
    return hash;
}

// ---- Walks -----------------------------------------------------------------------------------------------

static char last_error[512];

static void keep_error(void *user, enum ng_log_level level, const char *text)
{
    NG_UNUSED(user);
    if (level == NG_LOG_ERROR)
        snprintf(last_error, sizeof last_error, "%s", text);
}

static void step(struct walk *w)
{
    for (uint32_t i = 0, n = 1 + ng_rng_below(&w->editor.rng, EDITS); i < n; i++) {
        editor_edit(&w->editor);
        size_t used = strlen(w->what);
        snprintf(w->what + used, sizeof w->what - used, "; %s", w->editor.what);
    }
    if (ng_rng_below(&w->editor.rng, 12) == 0)
        w->time += 0.4;
    if (ng_rng_below(&w->editor.rng, 12) == 0) {
        w->room.width = 1 + ng_rng_below(&w->editor.rng, 24);
        w->room.height = 1 + ng_rng_below(&w->editor.rng, 20);
    }
}

// Edits that nobody sees, since the next ones come before the picture of them is there.
static void step_in_vain(struct walk *w)
{
    uint32_t left = ng_rng_below(&w->editor.rng, 30);
    bool whole = true;
    step(w);
    OK(ng_world_run(w->room.scene.world, w->time));
    artist_look(w, &w->kept);
    for (size_t i = 0; i < NG_COUNT(views) && whole; i++)
        whole = draw_some(w, &w->kept, &views[i], &left) != NG_ABANDONED;
    given_up += !whole;
}

// Draws with those who remember and with new ones; whether the former began something anew.
static bool look(struct walk *w)
{
    const struct lf_encoder_counters before = lf_neural_counters_of(w->kept.method.neural).encoder;
    for (size_t i = 0; i + 1 < NG_COUNT(views); i++) {
        ng_result drawn = draw(w, &w->kept, &views[i]);
        ng_result anew = draw(w, &w->fresh, &views[i]);
        if (anew != drawn)
            fail_msg("%s: %s gave result %d, and %d anew; last error: %s", w->what, views[i].method,
                     (int)drawn, (int)anew, last_error);
        if (drawn == NG_OK)
            compare(w, &views[i]);
    }
    bool began = draw_to_the_end(w, &w->kept);
    draw_to_the_end(w, &w->fresh);
    compare(w, &views[NG_COUNT(views) - 1]);
    const struct lf_encoder_counters after = lf_neural_counters_of(w->kept.method.neural).encoder;
    return began || memcmp(&before, &after, sizeof before) != 0;
}

static void walk(struct walk *w, const char *path, uint64_t seed, uint32_t count)
{
    scene_load(&w->room.scene, 2, path);
    editor_begin(&w->editor, w->room.scene.world, w->room.scene.assets, seed);
    artist_open(w, &w->kept);
    w->shown = 0;
    for (uint32_t i = 0; i <= count; i++) {
        uint64_t before = w->shown;
        snprintf(w->what, sizeof w->what, "%s, seed %u, step %u", path, (unsigned)seed, i);
        bool in_vain = i && ng_rng_below(&w->editor.rng, 3) == 0;
        if (in_vain)
            step_in_vain(w);
        if (i)
            step(w);
        OK(ng_world_run(w->room.scene.world, w->time));
        artist_open(w, &w->fresh);
        artist_look(w, &w->kept);
        artist_look(w, &w->fresh);
        w->shown = hash_shown(w);
        if (look(w) && w->shown == before && !in_vain)
            fail_msg("%s: something was begun anew for nothing", w->what);
        artist_close(&w->fresh);
    }
    artist_close(&w->kept);
    scene_close(&w->room.scene);
}

// Edits break things, which is said in the log; what is said is not the matter here.
static void what_is_remembered_is_what_is_there(void **state)
{
    const char *path = *state;
    struct walk w = {.room = {.width = 20, .height = 16}};
    if (!strstr(path, only))
        skip();
    ng_log_set_sink(keep_error, NULL);
    test_path(w.room.weights, sizeof w.room.weights, "test.weights.safetensors");
    w.room.gpu = gpu_test_begin();
    for (uint32_t done = 0; done < steps; done += run) {
        uint64_t seed = first_seed + done / run;
        if (seed % 4) // a network that knows the powers depends on them in more places
            network_write_random(w.room.weights, seed);
        else
            network_write_absolute(w.room.weights, seed);
        w.rsm = seed % 3 ? LF_RSM_RAYS : LF_RSM_MAPS;
        walk(&w, path, seed, steps - done < run ? steps - done : run);
    }
    ng_log_set_sink(NULL, NULL);
    gpu_test_end(w.room.gpu);
}

int main(int argc, char **argv)
{
    static const char *const scenes[] = {
        "content/unit/materials.glb",         "content/unit/alpha_mask.glb",
        "content/unit/light_mesh.glb",        "content/unit/light_rectangle_textured.glb",
        "content/unit/light_environment.glb", "content/unit/light_sphere.glb",
        "content/unit/character.glb",         "content/unit/subdivision.glb",
        "tests/files/geometry/figure.gltf"};
    struct CMUnitTest tests[NG_COUNT(scenes)];
    steps = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : steps;
    first_seed = argc > 2 ? strtoul(argv[2], NULL, 10) : first_seed;
    only = argc > 3 ? argv[3] : only;
    run = argc > 4 ? (uint32_t)strtoul(argv[4], NULL, 10) : run;
    run = run ? run : steps;
    for (size_t i = 0; i < NG_COUNT(scenes); i++)
        tests[i] = (struct CMUnitTest){.name = scenes[i],
                                       .test_func = what_is_remembered_is_what_is_there,
                                       .initial_state = (void *)scenes[i]};
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    print_message("%u frames were given up\n", given_up);
    return failed;
}
