// A load in the order of dependence: nodes and materials first (they are referred to), then what hangs on the
// nodes, then animations, then what the file left out. Everything made is below one root entity or in
// the list of added assets, so that a failure takes all of it back.
#include "asset/gltf_origin_internal.h"
#include "asset/image_internal.h"
#include "base/file.h"
#include "base/log.h"
#include "base/system.h"
#include "components/components.h"
#include "components/placement.h"
#include "components/transform.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ng_gltf_log_error(const struct gltf_loader *l, const char *fmt, ...)
{
    char text[1024];
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    ng_log_error("%s: %s", l->path, text);
}

void ng_gltf_warn(struct gltf_loader *l, bool *kind, const char *fmt, ...)
{
    *kind = true;
    va_list args;
    va_start(args, fmt);
    // Not even a strict load fails by this; short of memory it is not said.
    (void)!ng_gltf_fault_va(&l->faults, kind, NULL, fmt, args);
    va_end(args);
}

void ng_gltf_keep_within(struct gltf_loader *l, const char *where, const char *what, float *values,
                         size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (fabsf(values[i]) > NG_TRANSFORM_MAX) {
            ng_gltf_warn(l, &l->warned_range, "%s: %s: %g is beyond %g and is moved there", where, what,
                         (double)values[i], (double)NG_TRANSFORM_MAX);
            values[i] = ng_keep_within(values[i], NG_TRANSFORM_MAX);
        }
}

static uint64_t left_of(uint64_t limit, uint64_t used)
{
    return limit > used ? limit - used : 0;
}

ng_result ng_gltf_budget(struct gltf_loader *l, uint64_t bytes, const char *what)
{
    uint64_t left = left_of(l->limits.max_memory, l->memory), of_kind = left_of(l->max_decoded, l->decoded);
    if (bytes > left || bytes > of_kind) {
        bool own = of_kind < left;
        ng_log_error("%s: %s needs %llu bytes, more than the %llu that are left of the scene's limit of "
                     "%llu" NG_GLTF_RAISE,
                     l->path, what, (unsigned long long)bytes, (unsigned long long)(own ? of_kind : left),
                     (unsigned long long)(own ? l->max_decoded : l->limits.max_memory));
        return NG_ERROR_MEMORY;
    }
    l->memory += bytes;
    l->decoded += bytes;
    return NG_OK;
}

// Without scenes all nodes that have no parent are the scene (null).
static ng_result find_scene(struct gltf_loader *l, const struct gltf_scene **out)
{
    const struct gltf_document *d = l->doc;
    int index = d->scene < 0 ? 0 : d->scene;
    if (d->scene >= 0 && (uint32_t)d->scene >= d->scene_count) {
        NG_TRY(ng_gltf_fault(&l->faults, d->scene_count ? "the first is loaded" : "all nodes are loaded",
                             "scene %d is not one of %u", index, d->scene_count));
        index = 0;
    }
    *out = d->scene_count ? &d->scenes[index] : NULL;
    return NG_OK;
}

static ng_result make_root(struct gltf_loader *l, const struct gltf_scene *scene)
{
    const char *name = scene && scene->name[0] ? scene->name : ng_path_name(l->path);
    NG_TRY(ng_gltf_entity(l, l->limits.parent, name, "scene", 0, &l->out.root));
    return ng_gltf_add(l, l->out.root, "scene", NG_TRANSFORM, ng_transform_component.defaults);
}

static bool allocate_tables(struct gltf_loader *l)
{
    const struct gltf_document *d = l->doc;
    l->parents = malloc((d->node_count + (size_t)1) * sizeof *l->parents);
    l->order = malloc((d->node_count + (size_t)1) * sizeof *l->order);
    l->ordered = calloc(d->node_count + (size_t)1, sizeof *l->ordered);
    l->placed = calloc(d->node_count + (size_t)1, sizeof *l->placed);
    l->skin_placed = calloc(d->skin_count + (size_t)1, sizeof *l->skin_placed);
    l->nodes = calloc(d->node_count + (size_t)1, sizeof *l->nodes);
    l->materials = calloc(d->material_count + (size_t)1, sizeof *l->materials);
    l->animations = calloc(d->animation_count + (size_t)1, sizeof *l->animations);
    l->skins = calloc(d->skin_count + (size_t)1, sizeof *l->skins);
    l->joint_of = calloc(d->node_count + (size_t)1, sizeof *l->joint_of);
    l->views = calloc(d->view_count + (size_t)1, sizeof *l->views);
    l->first_image = calloc(d->image_count + (size_t)1, sizeof *l->first_image);
    l->image_lost = calloc(d->image_count + (size_t)1, sizeof *l->image_lost);
    return l->parents && l->order && l->ordered && l->placed && l->skin_placed && l->nodes && l->materials &&
           l->animations && l->skins && l->joint_of && l->first_image && l->image_lost && l->views;
}

static ng_result load(struct gltf_loader *l)
{
    const struct gltf_scene *scene;
    NG_TRY(find_scene(l, &scene));
    if (!allocate_tables(l))
        return ng_out_of_memory(l->path);
    NG_TRY(ng_gltf_meshopt(l));
    NG_TRY(make_root(l, scene));
    NG_TRY(ng_gltf_nodes(l, scene));
    NG_TRY(ng_gltf_materials(l));
    NG_TRY(ng_gltf_attachments(l));
    NG_TRY(ng_gltf_components(l, l->out.root, "scene", scene ? scene->extension : NULL, NULL));
    NG_TRY(ng_gltf_animations(l));
    if (!l->limits.part) {
        NG_TRY(ng_gltf_scale_and_camera(l));
        NG_TRY(ng_gltf_sky(l));
    }
    NG_TRY(ng_gltf_emitters(l));
    if (!l->limits.part)
        ng_gltf_say_made(l);
    return NG_OK;
}

// Tells the caller of pictures that no material may use; of other files it hears when they are read.
static void name_pictures(const struct gltf_loader *l)
{
    char path[4096];
    const char *why;
    for (uint32_t i = 0; l->limits.file && i < l->doc->image_count; i++)
        if (l->doc->images[i].uri[0] && !ng_gltf_is_data_uri(l->doc->images[i].uri) &&
            ng_gltf_uri_path(l->path, l->doc->images[i].uri, path, sizeof path, &why))
            l->limits.file(l->limits.user, path);
}

static void take_back(struct gltf_loader *l)
{
    if (!ng_entity_is_null(l->out.root) && ng_entity_destroy(l->world, l->out.root) != NG_OK)
        ng_log_error("%s: what was loaded so far could not be removed", l->path);
    for (size_t i = l->added.count; i-- > 0;)
        ng_assets_remove(l->assets, l->added.items[i]);
}

static void finish(struct gltf_loader *l)
{
    free(l->parents);
    free(l->order);
    free(l->ordered);
    free(l->placed);
    free(l->skin_placed);
    free(l->nodes);
    free(l->materials);
    free(l->animations);
    free(l->skins);
    free(l->joint_of);
    free(l->made);
    free(l->first_primitive);
    free(l->first_image);
    free(l->image_lost);
    for (uint32_t i = 0; l->views && i < l->doc->view_count; i++)
        free(l->views[i].data);
    free(l->views);
    ng_array_finish(&l->stand_ins);
    ng_array_finish(&l->images);
    ng_array_finish(&l->shapes);
    ng_array_finish(&l->instances);
    ng_array_finish(&l->clips);
    ng_array_finish(&l->added);
    ng_array_finish(&l->pictures);
}

// Half of what the process may still take: what is drawn takes as much again.
static uint64_t share_of_memory(void)
{
    const uint64_t unknown = (uint64_t)2 << 30;
    uint64_t available = ng_system_available_memory();
    return (available == UINT64_MAX ? unknown : available) / 2;
}

static struct ng_gltf_params with_defaults(const struct ng_gltf_params *params)
{
    struct ng_gltf_params p = params ? *params : (struct ng_gltf_params){0};
    p.max_memory = p.max_memory ? p.max_memory : share_of_memory();
    p.max_file_size = p.max_file_size ? p.max_file_size : p.max_memory;
    p.max_image_memory = p.max_image_memory ? p.max_image_memory : p.max_memory;
    p.max_entities = p.max_entities ? p.max_entities : 1u << 18;
    p.max_joints = p.max_joints ? p.max_joints : 4096;
    p.max_image_side = p.max_image_side ? p.max_image_side : 16384;
    return p;
}

// A file may repeat itself: a thousand primitives of one accessor. Unless the caller has set a limit, what is
// not a picture may take so much more than the file does.
static uint64_t decoded_limit(const struct gltf_loader *l)
{
    const uint64_t any = (uint64_t)192 << 20, times = 64;
    uint64_t size = l->doc->bytes;
    if (l->limited || size > left_of(l->limits.max_memory, any) / times)
        return l->limits.max_memory;
    return any + times * size;
}

// The document is there until the end: strings and values are borrowed from it.
static ng_result load_file(struct gltf_loader *l)
{
    struct gltf_document *doc;
    NG_TRY(ng_gltf_parse(l->path, &l->limits, &l->faults, &doc));
    l->doc = doc;
    l->out.hash = doc->hash;
    l->max_decoded = decoded_limit(l);
    l->out.foreign = ng_gltf_is_foreign(doc);
    name_pictures(l);
    ng_result r = load(l);
    if (r == NG_OK && l->limits.keep)
        r = ng_gltf_keep(l, &doc);
    if (r != NG_OK)
        take_back(l);
    finish(l);
    ng_gltf_document_destroy(&doc);
    return r;
}

ng_result ng_gltf_load(const char *path, struct ng_world *world, struct ng_assets *assets,
                       const struct ng_gltf_params *params, struct ng_gltf_scene *out)
{
    *out = (struct ng_gltf_scene){0};
    NG_REQUIRE(path && world && assets, "path, world and assets must be given");
    struct gltf_loader l = {.path = path, .world = world, .assets = assets, .limits = with_defaults(params)};
    l.limited = params && params->max_memory;
    l.faults = (struct gltf_faults){.path = path, .strict = l.limits.strict};
    ng_result r = load_file(&l);
    if (r == NG_OK)
        *out = l.out;
    ng_gltf_faults_say(&l.faults, r);
    ng_gltf_faults_finish(&l.faults);
    return r;
}
