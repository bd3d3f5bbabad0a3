// The state of one save, and what its parts (one topic a file) offer each other.
#ifndef NG_ASSET_GLTF_SAVE_INTERNAL_H
#define NG_ASSET_GLTF_SAVE_INTERNAL_H

#include "asset/gltf_origin_internal.h"
#include "asset/gltf_save.h"
#include "asset/gltf_writer.h"

struct cJSON;

// A file beside the document, to be written before it.
struct gltf_beside {
    char *path;
    const void *data; // borrowed
    size_t size;
};

struct gltf_saver {
    const char *path;
    bool binary;
    const struct ng_world *world;
    const struct ng_assets *assets;
    ng_entity root;
    const struct ng_gltf_origin *origin;
    struct ng_gltf_writer w;
    NG_ARRAY(struct gltf_beside) beside;
    NG_ARRAY(void *) owned; // bytes that `beside` borrows
};

// ---- gltf_save_files.c -----------------------------------------------------------------------------------
// Says where data that are added will stand: in the first buffer, if it can take them.
void ng_gltf_save_choose_buffer(struct gltf_saver *s);
// Writes the document and what is beside it.
NG_NODISCARD ng_result ng_gltf_save_write(struct gltf_saver *s);

#endif
