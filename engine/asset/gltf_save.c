#include "asset/gltf_save_internal.h"

#include "base/file.h"
#include "base/log.h"

#include <cjson/cJSON.h>

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static bool ends_in(const char *path, const char *extension)
{
    const char *end = ng_path_extension(path);
    for (; *end && tolower((unsigned char)*end) == *extension; end++)
        extension++;
    return *end == *extension;
}

bool ng_gltf_save_knows(const char *path)
{
    return ends_in(path, "glb") || ends_in(path, "gltf");
}

static ng_result start(struct gltf_saver *s)
{
    cJSON *root = s->origin ? cJSON_Duplicate(s->origin->json, true) : NULL;
    if (s->origin && !root)
        return ng_out_of_memory(s->path);
    ng_gltf_writer_init(&s->w, root);
    ng_gltf_save_choose_buffer(s);
    return s->w.failed ? ng_out_of_memory(s->path) : NG_OK;
}

static void finish(struct gltf_saver *s)
{
    ng_gltf_writer_finish(&s->w);
    for (size_t i = 0; i < s->beside.count; i++)
        free(s->beside.items[i].path);
    for (size_t i = 0; i < s->owned.count; i++)
        free(s->owned.items[i]);
    ng_array_finish(&s->beside);
    ng_array_finish(&s->owned);
}

ng_result ng_gltf_save(const char *path, const struct ng_gltf_save_params *p)
{
    NG_REQUIRE(path && p->world && p->assets, "path, world and assets must be given");
    struct gltf_saver s = {.path = path,
                           .binary = ends_in(path, "glb"),
                           .world = p->world,
                           .assets = p->assets,
                           .root = p->root,
                           .origin = p->origin};
    if (!ng_gltf_save_knows(path)) {
        ng_log_error("%s: a scene is saved as .glb or .gltf", path);
        return NG_ERROR_USAGE;
    }
    ng_result r = start(&s);
    if (r == NG_OK)
        r = ng_gltf_save_write(&s);
    finish(&s);
    return r;
}
