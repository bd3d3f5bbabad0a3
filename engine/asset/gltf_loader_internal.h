// The state of one glTF load, and what its parts (one topic a file) offer each other.
#ifndef NG_ASSET_GLTF_LOADER_INTERNAL_H
#define NG_ASSET_GLTF_LOADER_INTERNAL_H

#include "anim/clips.h"
#include "asset/assets.h"
#include "asset/gltf_internal.h"
#include "asset/image.h"
#include "base/array.h"
#include "components/material.h"
#include "components/transform.h"
#include "scene/world.h"

// A primitive made into geometry; the same primitive again gives the same record.
struct gltf_shape {
    uint64_t key; // hash of everything that the geometry is made from
    ng_asset geometry;
    ng_asset cage;                     // null: it has none, or it was refused
    bool has_cage;                     // refused or not
    uint32_t joint_limit;              // largest joint index used, plus 1; 0: not skinned; or
#define NG_GLTF_JOINTS_LOST UINT32_MAX // what skins it is wrong
};

// Bytes that were decoded, from malloc.
struct gltf_bytes {
    unsigned char *data; // null: as the file has them
    size_t size;
};

// What is read instead of an accessor's buffer view: its elements, tightly packed.
struct gltf_stand_in {
    uint32_t accessor;
    struct gltf_bytes bytes;
};

// How a picture is used.
struct gltf_image_use {
    bool srgb;
    struct ng_sampling sampling;
};

// An image of the document, as it is used.
struct gltf_loaded {
    struct gltf_image_use use;
    int source; // of the document's images
    ng_asset image;
    uint32_t next; // of the same image, plus 1; 0: none
};
struct gltf_images {
    struct gltf_loaded *items;
    size_t count, capacity;
};

struct gltf_instance {
    uint32_t node, primitive;  // of its mesh
    int skin;                  // -1: none
    struct ng_transform place; // of a copy, below the node
    ng_entity entity;
    struct gltf_shape shape;
};

// A picture that was decoded, by its bytes.
struct gltf_picture {
    uint64_t hash;
    size_t size;
    struct gltf_image_use use;
    ng_asset image;
};

// Vertices that a primitive uses, of more that it shares with others.
struct gltf_subset {
    uint32_t *vertices; // [count], increasing; null: all are used
    uint32_t count, of;
};

// How a node is in the scene.
enum gltf_place {
    GLTF_OUT,
    GLTF_SEEN,  // no, and it was looked at
    GLTF_ABOVE, // with its transform alone, for what is below it or for a skin
    GLTF_IN
};

struct gltf_loader {
    const char *path;
    const struct gltf_document *doc;
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_params limits; // defaults filled in
    bool limited;                 // the caller has set max_memory
    uint64_t memory;              // of limits.max_memory
    uint64_t decoded;             // of that, all but pictures
    uint64_t max_decoded;         // which may have so much
    struct gltf_faults faults;
    struct ng_gltf_scene out;

    uint32_t *parents; // [node_count], NG_GLTF_NO_NODE for roots
    uint32_t *order;   // nodes of the scene, parents first
    uint32_t order_count;
    bool *ordered;         // [node_count]: is in the order
    unsigned char *placed; // [node_count], enum gltf_place
    bool *skin_placed;     // [skin_count]: its joints are in the order
    ng_entity *nodes;      // [node_count], null: not in the scene
    ng_entity *materials;  // [material_count]
    ng_entity *animations; // [animation_count]
    ng_asset *skins;       // [skin_count]
    uint32_t *joint_of;    // [node_count]: 1 + the last skin that listed it
    struct gltf_images images;
    uint32_t *first_image; // [image_count]: the last of `images`, plus 1; 0: none
    NG_ARRAY(struct gltf_picture) pictures;
    bool *image_lost;                   // [image_count]: could not be read
    NG_ARRAY(struct gltf_shape) shapes; // hash table, a power of two; geometry 0: free
    struct gltf_shape **made;       // [primitives of all meshes]: what became of each; null: not asked for
    const struct gltf_subset *used; // what is read of accessors of vertices; null: all
    struct gltf_shape nothing;      // what became of one that was lost
    uint32_t *first_primitive;      // [mesh_count]: of a mesh in `made`
    struct gltf_bytes *views;       // [view_count]: of those that were compressed
    NG_ARRAY(struct gltf_stand_in) stand_ins; // of the primitive that is being made
    NG_ARRAY(struct gltf_instance) instances;
    NG_ARRAY(struct ng_clip_player) clips; // in the order of the file
    NG_ARRAY(ng_asset) added;              // to take back on failure
    bool warned_uv, warned_morph, warned_weights, warned_influences, warned_mode;
    bool warned_camera, warned_range, warned_far, warned_keys, warned_emitters, warned_cage, warned_source;
    bool warned_occlusion;
};

#define NG_GLTF_NO_NODE   UINT32_MAX
#define NG_GLTF_MAX_DEPTH 1024      // of the node hierarchy
#define NG_GLTF_MAX_ZEROS (4 << 20) // numbers of an accessor that has no bytes in the file

// ---- messages: "PATH: message"; each gives the result to return ------------------------------------------
void ng_gltf_log_error(const struct gltf_loader *l, const char *fmt, ...) NG_PRINTF(2, 3);
#define ng_gltf_error(...)       (ng_gltf_log_error(__VA_ARGS__), NG_ERROR_FORMAT)
#define ng_gltf_unsupported(...) (ng_gltf_log_error(__VA_ARGS__), NG_ERROR_UNSUPPORTED)
// Notes what is not followed, though it is no fault: one warning for each kind, which one of the
// flags names and then holds true.
void ng_gltf_warn(struct gltf_loader *l, bool *kind, const char *fmt, ...) NG_PRINTF(3, 4);
// Moves numbers to -NG_TRANSFORM_MAX .. NG_TRANSFORM_MAX, with one warning a file; NaN stays.
void ng_gltf_keep_within(struct gltf_loader *l, const char *where, const char *what, float *values,
                         size_t count);
// Counts bytes that are about to be allocated against the limit.
NG_NODISCARD ng_result ng_gltf_budget(struct gltf_loader *l, uint64_t bytes, const char *what);

// ---- gltf_accessor.c -------------------------------------------------------------------------------------
#define GLTF_TYPE(t) (1u << ((t)-GLTF_I8))
enum {
    GLTF_FLOATS = GLTF_TYPE(GLTF_F32),
    GLTF_UNSIGNED = GLTF_TYPE(GLTF_U8) | GLTF_TYPE(GLTF_U16) | GLTF_TYPE(GLTF_U32),
    GLTF_SMALL_UNSIGNED = GLTF_TYPE(GLTF_U8) | GLTF_TYPE(GLTF_U16),
    GLTF_ANY = GLTF_UNSIGNED | GLTF_FLOATS | GLTF_TYPE(GLTF_I8) | GLTF_TYPE(GLTF_I16) | GLTF_TYPE(GLTF_I32),
    GLTF_ANY_NUMBER = 1u << 30, // what is none comes as NaN or UINT32_MAX; else it is an error
    GLTF_QUANTIZED = GLTF_FLOATS | GLTF_SMALL_UNSIGNED | GLTF_TYPE(GLTF_I8) | GLTF_TYPE(GLTF_I16),
};

struct gltf_want {
    const char *what; // for messages: "POSITION"
    uint32_t types; // set of GLTF_TYPE; where integers are wanted, others are taken if they hold such numbers
    uint32_t shapes; // set of 1 << components
    uint32_t count;  // elements it must have; 0: any, at least 1
    bool integers;   // out is uint32_t, else float (all finite, unless GLTF_ANY_NUMBER is in the types)
};

// Decodes an accessor into `*out` (float ** or uint32_t **, from malloc), [count][components].
NG_NODISCARD ng_result ng_gltf_read(struct gltf_loader *l, int accessor, const struct gltf_want *want,
                                    void *out, uint32_t *count);
// The bytes of a buffer view, borrowed.
NG_NODISCARD ng_result ng_gltf_view_bytes(struct gltf_loader *l, int view, const unsigned char **data,
                                          size_t *size);

// ---- gltf_extension.c ------------------------------------------------------------------------------------
// A member that is a whole number; `missing` where there is none.
NG_NODISCARD ng_result ng_gltf_index_member(const struct gltf_loader *l, const struct gltf_value *object,
                                            const char *where, const char *key, int missing, int *out);
// Gives an entity a component, of which every field is moved within the range that its table has.
NG_NODISCARD ng_result ng_gltf_add(struct gltf_loader *l, ng_entity e, const char *where,
                                   ng_component component, const void *value);
// A new entity with a name ("FALLBACK INDEX" if the file has none) below `parent`.
NG_NODISCARD ng_result ng_gltf_entity(struct gltf_loader *l, ng_entity parent, const char *name,
                                      const char *fallback, uint32_t index, ng_entity *out);
// The "components" of an NG_scene extension (may be null). `special`: another member that may be there.
NG_NODISCARD ng_result ng_gltf_components(struct gltf_loader *l, ng_entity e, const char *where,
                                          const struct gltf_value *extension, const char *special);

// ---- gltf_image.c, gltf_material.c -----------------------------------------------------------------------
// The image of a texture, loaded when it is first asked for.
NG_NODISCARD ng_result ng_gltf_texture(struct gltf_loader *l, const char *where, int texture, bool srgb,
                                       ng_asset *out);
// What a sampler says; a mode that the standard does not have is the default. Filters of 0: none is named.
struct ng_sampling ng_gltf_sampling(int wrap_s, int wrap_t, int mag_filter, int min_filter);
// Gives the store an image that was made from others. Takes it, also on failure.
NG_NODISCARD ng_result ng_gltf_keep_image(struct gltf_loader *l, const char *name, struct ng_image *image,
                                          ng_asset *out);
// What an image may take: what the scene has left. `text` is for messages, and must live as long as `params`.
void ng_gltf_limit_image(const struct gltf_loader *l, struct ng_image_params *params, char text[128]);

NG_NODISCARD ng_result ng_gltf_materials(struct gltf_loader *l);
// Where what a material says of one of its textures goes in struct ng_material.
struct gltf_slot {
    ng_asset *image;
    uint32_t *uv_set;
    struct ng_texture_transform *transform;
};
#define GLTF_SLOT(material, name)                                                                            \
    (&(struct gltf_slot){&(material)->name##_texture, &(material)->name##_uv_set,                            \
                         &(material)->name##_transform})
NG_NODISCARD ng_result ng_gltf_use_texture(struct gltf_loader *l, const char *where,
                                           const struct gltf_texture_use *use, bool srgb,
                                           const struct gltf_slot *slot);
// A member that is an array of so many numbers; without it `out` stays.
void ng_gltf_numbers(const struct gltf_value *object, const char *key, uint32_t count, float *out);

// ---- gltf_glossiness.c -----------------------------------------------------------------------------------
// KHR_materials_pbrSpecularGlossiness, made into what `out` says otherwise.
NG_NODISCARD ng_result ng_gltf_glossiness(struct gltf_loader *l, const char *where,
                                          const struct gltf_value *extension, struct ng_material *out);
// A picture file beside the document.
NG_NODISCARD ng_result ng_gltf_picture(struct gltf_loader *l, const char *where, const char *uri,
                                       ng_asset *out);

// ---- gltf_mesh.c, gltf_cage.c ----------------------------------------------------------------------------
NG_NODISCARD ng_result ng_gltf_shape(struct gltf_loader *l, uint32_t mesh, uint32_t primitive,
                                     struct gltf_shape *out);
// Reads NG_scene's "cage"; without faces: it was wrong and is refused. `g` is as the file has it, before
// vertices are split. The caller finishes `out`, also on failure.
NG_NODISCARD ng_result ng_gltf_cage(struct gltf_loader *l, const char *where, const struct gltf_value *cage,
                                    const struct ng_geometry *g, struct ng_cage *out);

// ---- gltf_repair.c ---------------------------------------------------------------------------------------
// What vertices have after reading: triangles without a place are left out, normals and tangents made unit
// vectors and computed where they are none. Indices may be out of range; all numbers may be NaN. `exact`:
// vectors that are of unit length but for rounding stay as they are.
NG_NODISCARD ng_result ng_gltf_repair_geometry(struct gltf_loader *l, const char *where, bool exact,
                                               struct ng_geometry *g);
// Makes times increase, and values finite; rotations of unit length.
NG_NODISCARD ng_result ng_gltf_repair_keys(struct gltf_loader *l, const char *where, struct ng_channel *c);

// ---- gltf_subset.c ---------------------------------------------------------------------------------------
// Where a primitive's indices use few of its vertices, chooses those and makes the indices theirs; else the
// set is empty. The caller forgets it.
NG_NODISCARD ng_result ng_gltf_choose_vertices(struct gltf_loader *l, struct ng_geometry *g,
                                               size_t vertex_count, struct gltf_subset *out);
void ng_gltf_forget_vertices(struct gltf_subset *subset);

// ---- gltf_skin.c, gltf_animation.c -----------------------------------------------------------------------
// The skeleton of a skin, made when it is first asked for; its joints must be nodes of the scene.
NG_NODISCARD ng_result ng_gltf_skin(struct gltf_loader *l, int skin, ng_asset *out);
NG_NODISCARD ng_result ng_gltf_animations(struct gltf_loader *l);

// ---- gltf_meshopt.c, gltf_draco.c ------------------------------------------------------------------------
// Decodes the buffer views that are compressed.
NG_NODISCARD ng_result ng_gltf_meshopt(struct gltf_loader *l);
// Until the end the accessors of a primitive read what its compressed mesh has, if it has one.
NG_NODISCARD ng_result ng_gltf_draco_begin(struct gltf_loader *l, const char *where,
                                           const struct gltf_primitive *p);
void ng_gltf_draco_end(struct gltf_loader *l);

// ---- gltf_morph.c ----------------------------------------------------------------------------------------
// Reads the morph targets of a primitive, whose vertices are as the file has them.
NG_NODISCARD ng_result ng_gltf_targets(struct gltf_loader *l, const struct gltf_primitive *p,
                                       const char *where, struct ng_geometry *g);
// Gives an entity with a geometry that has targets the weights that its node or mesh says.
NG_NODISCARD ng_result ng_gltf_add_morph(struct gltf_loader *l, const char *where, uint32_t node,
                                         ng_asset geometry, ng_entity e);
// The box of an instance's geometry with these weights, in object space.
NG_NODISCARD ng_result ng_gltf_shape_bounds(const struct gltf_loader *l, const struct gltf_instance *instance,
                                            float low[3], float high[3]);
// How many weights a key has for a node's mesh; 0: it has no targets.
uint32_t ng_gltf_weight_count(const struct gltf_loader *l, int node);
// Channels that drive the weights of everything that a node shows, four each: how many, and from one that has
// them all (its width) into the clip, which has room.
size_t ng_gltf_weight_channels(const struct gltf_loader *l, int node);
NG_NODISCARD ng_result ng_gltf_split_weights(struct gltf_loader *l, int node, const struct ng_channel *all,
                                             struct ng_clip *clip);

// ---- gltf_instancing.c -----------------------------------------------------------------------------------
// Where the copies of a node's mesh stand, below the node; from malloc, also on failure. Null: it has none.
NG_NODISCARD ng_result ng_gltf_copies(struct gltf_loader *l, const char *where, const struct gltf_node *node,
                                      struct ng_transform **out, uint32_t *count);

// ---- gltf_node.c, gltf_pose.c, gltf_scale.c, gltf_sky.c --------------------------------------------------
// Checks the hierarchy and makes an entity with a transform for each node of the scene.
NG_NODISCARD ng_result ng_gltf_nodes(struct gltf_loader *l, const struct gltf_scene *scene);
// What hangs on the nodes: meshes, cameras, lights, extensions.
NG_NODISCARD ng_result ng_gltf_attachments(struct gltf_loader *l);
void ng_gltf_local_matrix(const struct ng_transform *transform, float out[16]);
// [node_count][16], column-major, where the nodes of the scene are at time 0; the caller frees it. Null: no
// memory.
float (*ng_gltf_pose(const struct gltf_loader *l))[16];
// Scene scale and camera where the file has none.
NG_NODISCARD ng_result ng_gltf_scale_and_camera(struct gltf_loader *l);
// Whether a file has anything of NG_scene.
bool ng_gltf_is_foreign(const struct gltf_document *doc);
// Exposure and background of a camera of such a file.
struct ng_camera;
void ng_gltf_expose(const struct gltf_loader *l, struct ng_camera *camera);
// Emissive meshes that become lights, and a light where the file has none.
NG_NODISCARD ng_result ng_gltf_emitters(struct gltf_loader *l);
NG_NODISCARD ng_result ng_gltf_sky(struct gltf_loader *l);
// Says what the scene is seen by, if that is not what its file says.
void ng_gltf_say_made(const struct gltf_loader *l);

#endif
