// lightformer info: what is in a scene, which devices there are, what components have.
//
// Each of the three gathers first and prints then, as a table or as JSON from the same figures.
#include "commands.h"
#include "info_catalogue.h"
#include "info_scene.h"
#include "json.h"
#include "opening.h"

#include "asset/catalogue.h"
#include "base/printable.h"
#include "base/result.h"
#include "components/components.h"
#include "gpu/device.h"
#include "scene/world.h"

#include <stdlib.h>
#include <string.h>

struct info {
    const char *what;
    bool json;
    struct opening opening;
};

static const struct cli_option options[] = {
    CLI_ARGUMENT(struct info, what, "SCENE|device|components",
                 "a scene's file or a furniture catalogue; or the graphics devices; or the field table of "
                 "each component"),
    CLI_JSON(struct info),
    CLI_OPENING(struct info),
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

static int run(const void *args)
{
    const struct info *info = args;
    ng_result result;
    if (!opening_check(&info->opening, "info"))
        return CLI_USAGE;
    if (strcmp(info->what, "components") == 0)
        result = info_components(info->json);
    else if (strcmp(info->what, "device") == 0)
        result = info_devices(info->json);
    else
        result = ng_catalogue_is(info->what) ? info_catalogue(info->what, info->json)
                                             : info_scene(info->what, info->json, &info->opening);
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
