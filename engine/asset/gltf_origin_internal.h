// What is kept of a file that was loaded, for saving to start from.
//
// Nothing in it follows the world: it says what the file was. Saving compares the world with it, and changes
// a copy of the document where they differ.
#ifndef NG_ASSET_GLTF_ORIGIN_INTERNAL_H
#define NG_ASSET_GLTF_ORIGIN_INTERNAL_H

#include "asset/gltf_loader_internal.h"

struct cJSON;

// What an entity stands for in the file.
enum gltf_role {
    GLTF_MADE, // nothing: loading made it
    GLTF_ROOT, // the scene
    GLTF_NODE,
    GLTF_PRIMITIVE, // of a mesh that has several
    GLTF_COPY,      // of a node's mesh (EXT_mesh_gpu_instancing), and what is below one
    GLTF_MATERIAL,
    GLTF_ANIMATION,
};

struct gltf_kept {
    ng_entity entity, parent, first_child, next_sibling;
    enum gltf_role role;
    int index;           // of the node (of a primitive or copy, too), material or animation
    uint32_t primitive;  // of the node's mesh
    uint64_t components; // it had, without derived ones
    size_t values;       // of these, in the order of their ids: where they begin in `values`
};

struct gltf_kept_asset {
    ng_asset asset;
    uint64_t revision;
};

// A picture file that the document names.
struct gltf_kept_picture {
    char *uri; // as it stands there
    void *data;
    size_t size;
};

struct ng_gltf_origin {
    struct gltf_document *doc; // ours
    struct cJSON *json;
    char *path;
    bool foreign;                            // nothing in it is NG_scene's
    NG_ARRAY(struct gltf_kept) entities;     // by entity
    NG_ARRAY(struct gltf_kept_asset) assets; // by asset
    NG_ARRAY(unsigned char) values;
    NG_ARRAY(struct gltf_kept_picture) pictures;
    struct gltf_shape *shapes; // [primitives of all meshes]; geometry null: not loaded
    uint32_t *first_primitive; // [mesh_count]: of a mesh in `shapes`
    struct gltf_images images; // as the loader's
    ng_asset *skins;           // [skin_count]
};

// Makes l->out.origin, which takes the document (`*doc` becomes null).
NG_NODISCARD ng_result ng_gltf_keep(struct gltf_loader *l, struct gltf_document **doc);

// These take a null origin, which knows nothing.
const struct gltf_kept *ng_gltf_kept(const struct ng_gltf_origin *o, ng_entity e);
// A component that an entity had; null if none.
const void *ng_gltf_kept_value(const struct ng_gltf_origin *o, const struct ng_world *world,
                               const struct gltf_kept *kept, ng_component component);
// Whether an asset came from the file and is still what it was.
bool ng_gltf_kept_asset(const struct ng_gltf_origin *o, const struct ng_assets *assets, ng_asset asset);
const struct gltf_kept_picture *ng_gltf_kept_picture(const struct ng_gltf_origin *o, const char *uri);

// ---- gltf_origin_json.c ----------------------------------------------------------------------------------
// The JSON of a file that was loaded, which a zero byte follows, as a tree. Extras, unknown extensions and
// numbers that are no doubles are cJSON_Raw, the text that they were. Null: out of memory, more values than
// these, or no JSON.
struct cJSON *ng_gltf_origin_json(const char *text, size_t size, size_t max_values);
// Whether two trees are equal, in the order of members too.
bool ng_gltf_json_same(const struct cJSON *a, const struct cJSON *b);

#endif
