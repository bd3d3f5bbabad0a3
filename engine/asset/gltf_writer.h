// Building a glTF 2.0 document: a tree of JSON that grows with each call, and one buffer of binary data, each
// accessor with a buffer view of its own. Saving (gltf_save.h) and tools/content are built on it.
//
// The writer is sticky: after the first failure (only memory can fail) calls do nothing, and its last ones
// say so. Null objects are ignored. Objects and lists are borrowed from the tree; they are cJSON's.
// Source: glTF 2.0 specification (Khronos), sections 3.6 (data) and 4.4 (GLB).
#ifndef NG_ASSET_GLTF_WRITER_H
#define NG_ASSET_GLTF_WRITER_H

#include "base/array.h"
#include "base/extern_c.h"

#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct cJSON;

// The document's lists: "accessors", ...; lights are those of KHR_lights_punctual.
enum ng_gltf_list {
    NG_GLTF_ACCESSORS,
    NG_GLTF_ANIMATIONS,
    NG_GLTF_BUFFERS,
    NG_GLTF_VIEWS,
    NG_GLTF_CAMERAS,
    NG_GLTF_IMAGES,
    NG_GLTF_LIGHTS,
    NG_GLTF_MATERIALS,
    NG_GLTF_MESHES,
    NG_GLTF_NODES,
    NG_GLTF_SAMPLERS,
    NG_GLTF_SCENES,
    NG_GLTF_SKINS,
    NG_GLTF_TEXTURES,
    NG_GLTF_LIST_COUNT
};

enum ng_gltf_component_type { NG_GLTF_U8 = 5121, NG_GLTF_U16 = 5123, NG_GLTF_U32 = 5125, NG_GLTF_F32 = 5126 };

// What a buffer view is for; other kinds have no name in glTF.
enum ng_gltf_target { NG_GLTF_NO_TARGET, NG_GLTF_VERTICES = 34962, NG_GLTF_INDICES = 34963 };

struct ng_gltf_bytes {
    unsigned char *items;
    size_t count, capacity;
};
// False when out of memory.
bool ng_gltf_bytes_append(struct ng_gltf_bytes *b, const void *data, size_t size);

struct ng_gltf_writer {
    struct cJSON *root;
    struct ng_gltf_bytes data; // of the views that were added
    int buffer;                // that they are in
    size_t data_offset;        // where in that buffer `data` begins
    bool failed;               // out of memory
    // The objects of each list, found once: index -> object.
    NG_ARRAY(struct cJSON *) lists[NG_GLTF_LIST_COUNT];
    // Places in lists that have become free, to be used before a list grows; indices.
    NG_ARRAY(int) free_views;
    NG_ARRAY(int) free_accessors;
};

// `root` is taken; null: a new document. Releases nothing on failure but remembers it.
void ng_gltf_writer_init(struct ng_gltf_writer *w, struct cJSON *root);
void ng_gltf_writer_finish(struct ng_gltf_writer *w);
// A GLB of the tree and the data as its only buffer, appended to `out`. False when out of memory or failed.
bool ng_gltf_writer_glb(struct ng_gltf_writer *w, struct ng_gltf_bytes *out);
// Puts a GLB's header and a chunk; the header's length is set at the end.
bool ng_gltf_put_header(struct ng_gltf_bytes *out);
bool ng_gltf_put_chunk(struct ng_gltf_bytes *out, uint32_t type, const void *data, size_t size);
void ng_gltf_put_length(struct ng_gltf_bytes *out);
#define NG_GLTF_CHUNK_JSON 0x4e4f534au
#define NG_GLTF_CHUNK_BIN  0x004e4942u

// ---- JSON ------------------------------------------------------------------------------------------------
// A member, made if it is not there; `list`: an array, else an object.
struct cJSON *ng_gltf_json_object(struct ng_gltf_writer *w, struct cJSON *object, const char *key);
struct cJSON *ng_gltf_json_list(struct ng_gltf_writer *w, struct cJSON *object, const char *key);
// A new object at the end of an array that is in no list of the document.
struct cJSON *ng_gltf_json_append(struct ng_gltf_writer *w, struct cJSON *array);
// Set a member, in its old place if it is there.
void ng_gltf_json_number(struct ng_gltf_writer *w, struct cJSON *object, const char *key, double value);
void ng_gltf_json_bool(struct ng_gltf_writer *w, struct cJSON *object, const char *key, bool value);
// A null text is left out.
void ng_gltf_json_text(struct ng_gltf_writer *w, struct cJSON *object, const char *key, const char *value);
void ng_gltf_json_numbers(struct ng_gltf_writer *w, struct cJSON *object, const char *key,
                          const double *values, size_t count);
// An extension of an object, named in extensionsUsed from then on.
struct cJSON *ng_gltf_json_extension(struct ng_gltf_writer *w, struct cJSON *object, const char *name);
// The entry of a component in an object's NG_scene (README.md).
struct cJSON *ng_gltf_json_component(struct ng_gltf_writer *w, struct cJSON *object, const char *name);

// A new object in a list of the document; its index.
int ng_gltf_append(struct ng_gltf_writer *w, enum ng_gltf_list list, struct cJSON **out);
// Null if there is none of this index.
struct cJSON *ng_gltf_at(const struct ng_gltf_writer *w, enum ng_gltf_list list, int index);

// ---- data ------------------------------------------------------------------------------------------------
// All give the index of what they add.
int ng_gltf_add_view(struct ng_gltf_writer *w, const void *data, size_t size, enum ng_gltf_target target);
// width: 1 to 4, or 16. `out` (may be null) is the accessor's object.
int ng_gltf_add_accessor(struct ng_gltf_writer *w, const void *data, size_t count, unsigned width,
                         enum ng_gltf_component_type type, enum ng_gltf_target target, struct cJSON **out);
// `bounds` adds min and max, which positions and key times must have.
int ng_gltf_add_floats(struct ng_gltf_writer *w, const float *values, size_t count, unsigned width,
                       enum ng_gltf_target target, bool bounds);
// Unsigned integers of `bytes` (1, 2, 4) each; 0: the fewest that hold them all without the highest value,
// which restarts primitives.
int ng_gltf_add_integers(struct ng_gltf_writer *w, const uint32_t *values, size_t count, unsigned width,
                         unsigned bytes, enum ng_gltf_target target, struct cJSON **out);

NG_EXTERN_C_END

#endif
