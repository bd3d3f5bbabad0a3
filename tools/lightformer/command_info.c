// lightformer info: what is in a scene, which devices there are, what components have.
//
// Each of the three gathers first and prints then, as a table or as JSON from the same figures.
#include "commands.h"
#include "json.h"
#include "scene_file.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/printable.h"
#include "base/result.h"
#include "components/components.h"
#include "components/name.h"
#include "gpu/device.h"
#include "scene/query.h"
#include "scene/world.h"

#include <stdlib.h>
#include <string.h>

struct info {
    const char *what;
    bool json;
};

static const struct cli_option options[] = {
    CLI_ARGUMENT(struct info, what, "SCENE|device|components",
                 "a glTF file; or the graphics devices; or the field table of each component"),
    CLI_JSON(struct info),
};

// ---- Components

static void print_range(const struct ng_field *f, char *out, size_t size)
{
    out[0] = 0;
    if (f->min != 0 || f->max != 0)
        snprintf(out, size, "%g to %g", (double)f->min, (double)f->max);
}

static void print_component(const struct ng_component_desc *c)
{
    printf("%s (%u bytes%s): %s\n", c->name, c->size, c->flags & NG_COMPONENT_DERIVED ? ", derived" : "",
           c->doc);
    for (uint32_t i = 0; i < c->field_count; i++) {
        const struct ng_field *f = &c->fields[i];
        char range[64];
        print_range(f, range, sizeof range);
        printf("  %-20s %-7s %-10s %-16s %s", f->name, ng_field_type_name(f->type), f->unit, range, f->doc);
        for (const char *const *choice = f->choices; choice && *choice; choice++)
            printf("%s%s", choice == f->choices ? ": " : ", ", *choice);
        putchar('\n');
    }
}

static void write_component(struct json *j, const struct ng_component_desc *c)
{
    json_object(j, NULL);
    json_text(j, "name", c->name);
    json_text(j, "doc", c->doc);
    json_number(j, "size", c->size);
    json_bool(j, "derived", c->flags & NG_COMPONENT_DERIVED);
    json_array(j, "fields");
    for (uint32_t i = 0; i < c->field_count; i++) {
        const struct ng_field *f = &c->fields[i];
        json_object(j, NULL);
        json_text(j, "name", f->name);
        json_text(j, "type", ng_field_type_name(f->type));
        json_text(j, "unit", f->unit);
        if (f->min != 0 || f->max != 0) {
            json_number(j, "min", (double)f->min);
            json_number(j, "max", (double)f->max);
        }
        if (f->choices) {
            json_array(j, "choices");
            for (const char *const *choice = f->choices; *choice; choice++)
                json_text(j, NULL, *choice);
            json_end(j);
        }
        json_text(j, "doc", f->doc);
        json_end(j);
    }
    json_end(j);
    json_end(j);
}

static ng_result create_world(struct ng_world **out)
{
    NG_TRY(ng_world_create(NULL, out));
    ng_result result = ng_components_register(*out);
    if (result != NG_OK)
        ng_world_destroy(out);
    return result;
}

static ng_result info_components(bool json)
{
    struct ng_world *world;
    NG_TRY(create_world(&world));
    struct json j = {.out = stdout};
    if (json)
        json_array(&j, NULL);
    for (uint32_t i = 0; i < ng_world_component_count(world); i++) {
        if (json)
            write_component(&j, ng_world_component(world, i));
        else
            print_component(ng_world_component(world, i));
    }
    if (json)
        json_end(&j);
    ng_world_destroy(&world);
    return NG_OK;
}

// ---- Devices

static void print_device(const struct ng_gpu_info *d)
{
    printf("%u  %s\n", d->index, d->name);
    printf("   %s, Vulkan %u.%u.%u, %s\n", d->type, VK_API_VERSION_MAJOR(d->api_version),
           VK_API_VERSION_MINOR(d->api_version), VK_API_VERSION_PATCH(d->api_version), d->driver);
    printf("   memory: %.0f MiB of its own, %.0f MiB of the host\n", (double)d->device_memory / (1 << 20),
           (double)d->host_memory / (1 << 20));
    if (!d->usable)
        printf("   not usable: it lacks %s\n", d->missing);
}

static void write_device(struct json *j, const struct ng_gpu_info *d)
{
    char version[32];
    snprintf(version, sizeof version, "%u.%u.%u", VK_API_VERSION_MAJOR(d->api_version),
             VK_API_VERSION_MINOR(d->api_version), VK_API_VERSION_PATCH(d->api_version));
    json_object(j, NULL);
    json_number(j, "index", d->index);
    json_text(j, "name", d->name);
    json_text(j, "type", d->type);
    json_text(j, "driver", d->driver);
    json_text(j, "vulkan", version);
    json_number(j, "device_memory_mib", (double)d->device_memory / (1 << 20));
    json_number(j, "host_memory_mib", (double)d->host_memory / (1 << 20));
    json_bool(j, "usable", d->usable);
    json_text(j, "missing", d->usable ? NULL : d->missing);
    json_end(j);
}

static ng_result info_devices(bool json)
{
    struct ng_gpu_info *devices;
    uint32_t count;
    NG_TRY(ng_gpu_list(&devices, &count));
    struct json j = {.out = stdout};
    if (json)
        json_array(&j, NULL);
    for (uint32_t i = 0; i < count; i++) {
        if (json)
            write_device(&j, &devices[i]);
        else
            print_device(&devices[i]);
    }
    if (json)
        json_end(&j);
    free(devices);
    return NG_OK;
}

// ---- Scenes

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

// Calls `each` with the name of every camera: what --camera takes.
static void each_camera(const struct ng_world *world, ng_entity root,
                        void (*each)(void *user, const char *name), void *user)
{
    for (ng_entity e = root; !ng_entity_is_null(e); e = ng_world_next_below(world, root, e)) {
        const struct ng_name *name = ng_world_get(world, e, NG_NAME);
        if (ng_world_has(world, e, NG_CAMERA))
            each(user, name ? name->text : "");
    }
}

static void print_camera(void *user, const char *name)
{
    NG_UNUSED(user);
    ng_print_line(stdout, "  camera \"%s\"", name);
}

static void write_camera(void *user, const char *name)
{
    json_text(user, NULL, name);
}

static void print_scene(const char *path, struct ng_world *world, const struct ng_assets *assets,
                        const struct ng_gltf_scene *s)
{
    ng_print_line(stdout, "%s", path);
    printf("  %u entities, %u materials, %u lights, %u skins, %u images, %.1f MiB\n", s->entity_count,
           s->material_count, s->light_count, s->skin_count, s->image_count,
           (double)ng_assets_memory(assets) / (1 << 20));
    printf("  %u primitives of %llu triangles before subdivision\n", s->primitive_count,
           (unsigned long long)s->triangle_count);
    printf("  %u animations, the longest of %.2f s\n", s->clip_count, (double)s->duration);
    each_camera(world, s->root, print_camera, NULL);
    for (uint32_t i = 0; i < ng_world_component_count(world); i++) {
        uint64_t n = count_component(world, i);
        if (n)
            printf("  %6llu x %s\n", (unsigned long long)n, ng_world_component(world, i)->name);
    }
}

static void write_scene(const char *path, struct ng_world *world, const struct ng_assets *assets,
                        const struct ng_gltf_scene *s)
{
    struct json j = {.out = stdout};
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
    json_array(&j, "cameras");
    each_camera(world, s->root, write_camera, &j);
    json_end(&j);
    json_object(&j, "components");
    for (uint32_t i = 0; i < ng_world_component_count(world); i++)
        json_number(&j, ng_world_component(world, i)->name, (double)count_component(world, i));
    json_end(&j);
    json_end(&j);
}

static ng_result info_scene(const char *path, bool json)
{
    struct ng_world *world = NULL;
    struct ng_assets *assets = NULL;
    struct ng_gltf_scene scene;
    NG_TRY(scene_file_check(path));
    ng_result result = create_world(&world);
    if (result == NG_OK)
        result = ng_assets_create(&assets);
    if (result == NG_OK)
        result = ng_gltf_load(path, world, assets, NULL, &scene);
    if (result == NG_OK)
        (json ? write_scene : print_scene)(path, world, assets, &scene);
    ng_assets_destroy(&assets);
    ng_world_destroy(&world);
    return result;
}

static int run(const void *args)
{
    const struct info *info = args;
    ng_result result;
    if (strcmp(info->what, "components") == 0)
        result = info_components(info->json);
    else if (strcmp(info->what, "device") == 0)
        result = info_devices(info->json);
    else
        result = info_scene(info->what, info->json);
    return result == NG_OK ? CLI_DONE : CLI_FAILED;
}

const struct cli_command cli_info_command = {
    .name = "info",
    .summary = "Says what is in a scene, which devices there are, or what components have.",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct info),
    .run = run,
};
