// Gathers first and prints then, as a table or as JSON from the same figures.
#include "info_scene.h"
#include "json.h"
#include "opening.h"
#include "scene_file.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/array.h"
#include "base/log.h"
#include "base/printable.h"
#include "components/animation.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/name.h"
#include "scene/query.h"
#include "scene/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What a load says is not followed, or is not as it should be.
struct warnings {
    NG_ARRAY(char *) list;
};

// Prints what is logged, as the log does itself, and keeps warnings.
static void keep_warning(void *user, enum ng_log_level level, const char *text)
{
    static const char *const prefix[] = {"debug: ", "", "warning: ", "error: "};
    struct warnings *warnings = user;
    if (level == NG_LOG_DEBUG)
        return;
    fprintf(stderr, "%s%s\n", prefix[level], text);
    size_t size = strlen(text) + 1;
    char *copy = level == NG_LOG_WARN ? malloc(size) : NULL;
    if (!copy)
        return;
    memcpy(copy, text, size);
    if (!ng_array_push(&warnings->list, copy))
        free(copy);
}

// How many entities have a component; 0 where memory is short, which was logged.
static uint64_t count_component(struct ng_world *world, ng_component component)
{
    struct ng_query_desc desc = {.terms = {{component, NG_TERM_WITH, false}}, .term_count = 1};
    struct ng_query *query;
    if (ng_query_create(world, &desc, &query) != NG_OK)
        return 0;
    uint64_t n = ng_query_count(query);
    ng_query_destroy(&query);
    return n;
}

// Something of a scene that has a name, and whether its file has it.
struct thing {
    const char *name;
    ng_entity entity;
    ng_component component;
    bool made;
};

// Calls `each` with all entities that have a component of a set, in the order of the file.
static void each_thing(const struct ng_world *world, const struct ng_gltf_scene *s,
                       bool (*wanted)(ng_component component),
                       void (*each)(void *user, const struct ng_world *world, const struct thing *thing),
                       void *user)
{
    for (ng_entity e = s->root; !ng_entity_is_null(e); e = ng_world_next_below(world, s->root, e))
        for (ng_component c = 0; c < NG_COMPONENT_COUNT; c++) {
            if (!wanted(c) || !ng_world_has(world, e, c))
                continue;
            const struct ng_name *name = ng_world_get(world, e, NG_NAME);
            bool camera = s->camera_made && ng_entity_same(e, s->camera);
            bool lamp = c == NG_LIGHT_MESH && s->emitter_count && s->foreign;
            struct thing thing = {name ? name->text : "", e, c, camera || lamp || ng_entity_same(e, s->sky)};
            each(user, world, &thing);
        }
}

static bool is_camera(ng_component component)
{
    return component == NG_CAMERA;
}

static bool is_animation(ng_component component)
{
    return component == NG_ANIMATION;
}

// What a list of things is printed with.
struct listing {
    const struct ng_assets *assets;
    struct json *json;
    uint32_t printed;
};

#define MOST_LIGHTS 20 // that are printed one by one

static void print_camera(void *user, const struct ng_world *world, const struct thing *t)
{
    const struct ng_camera *camera = ng_world_get(world, t->entity, NG_CAMERA);
    NG_UNUSED(user);
    char height[48];
    if (camera->projection == NG_PROJECTION_ORTHOGRAPHIC)
        snprintf(height, sizeof height, "orthographic, %g m", (double)camera->height);
    else
        snprintf(height, sizeof height, "%.1f degrees", (double)camera->fov_y * 180 / 3.14159265358979);
    ng_print_line(stdout, "  camera \"%s\"%s, %s high, %s", t->name, t->made ? " (made)" : "", height,
                  camera->auto_exposure ? "exposed by a light meter" : "of fixed exposure");
}

static void print_light(void *user, const struct ng_world *world, const struct thing *t)
{
    struct listing *listing = user;
    if (listing->printed++ < MOST_LIGHTS)
        ng_print_line(stdout, "  light \"%s\"%s, %s", t->name, t->made ? " (made)" : "",
                      ng_world_component(world, t->component)->name);
}

// A camera as it is seen with an exposure that was asked for.
struct exposed {
    struct ng_world *world;
    struct ng_exposure exposure;
};

static void expose_camera(void *user, const struct ng_world *world, const struct thing *t)
{
    const struct exposed *e = user;
    struct ng_camera *camera = ng_world_edit(e->world, t->entity, NG_CAMERA);
    NG_UNUSED(world);
    if (camera && e->exposure.mode != NG_EXPOSURE_CAMERA)
        camera->auto_exposure = e->exposure.mode == NG_EXPOSURE_AUTO;
}

static float length_of(const struct ng_assets *assets, const struct ng_animation *animation)
{
    const struct ng_clip *clip = ng_assets_clip(assets, animation->clip);
    return clip ? clip->duration : 0;
}

static void print_clip(void *user, const struct ng_world *world, const struct thing *t)
{
    const struct listing *listing = user;
    const struct ng_animation *animation = ng_world_get(world, t->entity, NG_ANIMATION);
    ng_print_line(stdout, "  clip \"%s\", %.2f s%s", t->name, (double)length_of(listing->assets, animation),
                  animation->playing ? "" : ", does not play unless --clip names it");
}

static void write_camera(void *user, const struct ng_world *world, const struct thing *t)
{
    const struct listing *listing = user;
    NG_UNUSED(world);
    json_text(listing->json, NULL, t->name);
}

static void write_light(void *user, const struct ng_world *world, const struct thing *t)
{
    const struct listing *listing = user;
    json_object(listing->json, NULL);
    json_text(listing->json, "name", t->name);
    json_text(listing->json, "type", ng_world_component(world, t->component)->name);
    json_bool(listing->json, "made", t->made);
    json_end(listing->json);
}

static void write_clip(void *user, const struct ng_world *world, const struct thing *t)
{
    const struct listing *listing = user;
    const struct ng_animation *animation = ng_world_get(world, t->entity, NG_ANIMATION);
    json_object(listing->json, NULL);
    json_text(listing->json, "name", t->name);
    json_number(listing->json, "duration_s", (double)length_of(listing->assets, animation));
    json_bool(listing->json, "plays", animation->playing);
    json_end(listing->json);
}

static void print_scene(const char *path, struct ng_world *world, const struct ng_assets *assets,
                        const struct ng_gltf_scene *s, const struct warnings *warnings)
{
    struct listing listing = {.assets = assets};
    NG_UNUSED(warnings); // they were said
    ng_print_line(stdout, "%s", path);
    printf("  %u entities, %u materials, %u lights, %u skins, %u images, %.1f MiB\n", s->entity_count,
           s->material_count, s->light_count, s->skin_count, s->image_count,
           (double)ng_assets_memory(assets) / (1 << 20));
    printf("  %u primitives of %llu triangles before subdivision\n", s->primitive_count,
           (unsigned long long)s->triangle_count);
    printf("  %.4g x %.4g x %.4g m wide, high and deep\n", (double)(s->bounds_max[0] - s->bounds_min[0]),
           (double)(s->bounds_max[1] - s->bounds_min[1]), (double)(s->bounds_max[2] - s->bounds_min[2]));
    printf("  %u animations, the longest of %.2f s\n", s->clip_count, (double)s->duration);
    each_thing(world, s, is_animation, print_clip, &listing);
    each_thing(world, s, is_camera, print_camera, &listing);
    each_thing(world, s, ng_component_is_light, print_light, &listing);
    if (listing.printed > MOST_LIGHTS)
        printf("  and %u lights more\n", listing.printed - MOST_LIGHTS);
    for (uint32_t i = 0; i < ng_world_component_count(world); i++) {
        uint64_t n = count_component(world, i);
        if (n)
            printf("  %6llu x %s\n", (unsigned long long)n, ng_world_component(world, i)->name);
    }
}

static void write_vector(struct json *j, const char *key, const float value[3])
{
    json_array(j, key);
    for (int i = 0; i < 3; i++)
        json_number(j, NULL, (double)value[i]);
    json_end(j);
}

static void write_scene(const char *path, struct ng_world *world, const struct ng_assets *assets,
                        const struct ng_gltf_scene *s, const struct warnings *warnings)
{
    struct json j = {.out = stdout};
    struct listing listing = {assets, &j, 0};
    json_object(&j, NULL);
    json_text(&j, "scene", path);
    json_number(&j, "entities", s->entity_count);
    json_number(&j, "primitives", s->primitive_count);
    json_number(&j, "triangles", (double)s->triangle_count);
    json_number(&j, "materials", s->material_count);
    json_number(&j, "lights", s->light_count);
    json_number(&j, "skins", s->skin_count);
    json_number(&j, "images", s->image_count);
    json_number(&j, "animations", s->clip_count);
    json_number(&j, "duration_s", (double)s->duration);
    json_number(&j, "assets_mib", (double)ng_assets_memory(assets) / (1 << 20));
    write_vector(&j, "bounds_min_m", s->bounds_min);
    write_vector(&j, "bounds_max_m", s->bounds_max);
    json_array(&j, "clips");
    each_thing(world, s, is_animation, write_clip, &listing);
    json_end(&j);
    json_array(&j, "cameras");
    each_thing(world, s, is_camera, write_camera, &listing);
    json_end(&j);
    json_bool(&j, "camera_made", s->camera_made);
    json_array(&j, "light_list");
    each_thing(world, s, ng_component_is_light, write_light, &listing);
    json_end(&j);
    json_object(&j, "components");
    for (uint32_t i = 0; i < ng_world_component_count(world); i++)
        json_number(&j, ng_world_component(world, i)->name, (double)count_component(world, i));
    json_end(&j);
    json_array(&j, "warnings");
    for (size_t i = 0; i < warnings->list.count; i++)
        json_text(&j, NULL, warnings->list.items[i]);
    json_end(&j);
    json_end(&j);
}

ng_result info_scene(const char *path, bool json, const struct opening *opening)
{
    struct ng_world *world = NULL;
    struct ng_assets *assets = NULL;
    struct ng_gltf_scene scene;
    struct warnings warnings = {0};
    const struct ng_gltf_params params = {.default_light = !opening->no_default_light,
                                          .emissive_lights = (enum ng_gltf_emitters)opening->emissive_lights,
                                          .clip = opening->clip,
                                          .strict = opening->loading.strict,
                                          .max_memory = loading_memory(&opening->loading)};
    NG_TRY(scene_file_check(path));
    ng_result result = ng_world_create(NULL, &world);
    if (result == NG_OK)
        result = ng_components_register(world);
    if (result == NG_OK)
        result = ng_assets_create(&assets);
    ng_log_set_sink(keep_warning, &warnings);
    if (result == NG_OK)
        result = ng_gltf_load(path, world, assets, &params, &scene);
    ng_log_set_sink(NULL, NULL);
    struct exposed exposed = {world, opening_exposure(opening)};
    if (result == NG_OK)
        each_thing(world, &scene, is_camera, expose_camera, &exposed);
    if (result == NG_OK)
        (json ? write_scene : print_scene)(path, world, assets, &scene, &warnings);
    for (size_t i = 0; i < warnings.list.count; i++)
        free(warnings.list.items[i]);
    ng_array_finish(&warnings.list);
    ng_assets_destroy(&assets);
    ng_world_destroy(&world);
    return result;
}
