// The state of one save, and what its parts (one topic a file) offer each other.
//
// Every entity gets a place in the document first: an object of one of its lists, the one it was loaded from
// or a new one. Then each is written: only what differs from what the origin had.
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

// Where an entity stands in the document; GLTF_MADE: nowhere.
struct gltf_saved {
    ng_entity entity;
    enum gltf_role role;
    int index; // of the node (of a primitive, too), material or animation
    uint32_t primitive;
    const struct gltf_kept *kept; // null: new
};

// A geometry, with its cage, that is in the document already.
struct gltf_written {
    ng_asset geometry, cage;
    struct cJSON *primitive; // ours: what a primitive says of them
};

// A mesh of one primitive that was made for new nodes.
struct gltf_made_mesh {
    ng_asset geometry, cage;
    int material, mesh;
};

struct gltf_index_of {
    ng_asset asset;
    int index;
};

// A field that a playing clip writes to.
struct gltf_driven {
    ng_entity entity;
    ng_component component;
    uint32_t offset;
};

struct gltf_saver {
    const char *path;
    bool binary;
    const struct ng_world *world;
    const struct ng_assets *assets;
    ng_entity root;
    const struct ng_gltf_origin *origin;
    struct ng_gltf_writer w;
    // Loading makes more of a file in which nothing is NG_scene's (emitters, exposure, which clips play).
    // Once something is, that has to be written.
    bool explicit;
    bool lost_made;                     // what loading makes of such a file was taken away
    NG_ARRAY(struct gltf_saved) places; // by the entity's index
    NG_ARRAY(struct gltf_driven) driven;
    NG_ARRAY(struct gltf_written) written;
    NG_ARRAY(struct gltf_made_mesh) meshes;
    NG_ARRAY(struct gltf_index_of) textures, skins; // that were found or made
    NG_ARRAY(uint32_t) accessor_uses, view_uses;    // gltf_save_slots.c
    bool slots_known, released_view;
    NG_ARRAY(uint32_t) mesh_users; // nodes that have a mesh
    NG_ARRAY(struct gltf_beside) beside;
    NG_ARRAY(void *) owned; // bytes that `beside` borrows
    int copies_of;          // the node whose copies were looked at last: whether they stay
    bool copies_known, copies_stay;
    ng_entity plain_of; // the same of primitives
    bool plain;
    size_t new_pictures;            // beside
    const struct cJSON *primitives; // of a mesh, and the one that was looked at last
    uint32_t primitive_index;
    struct cJSON *primitive;
    bool warned_entity, warned_channel;
};

// ---- gltf_save.c -----------------------------------------------------------------------------------------
// Null if the entity is not saved.
const struct gltf_saved *ng_gltf_saved(const struct gltf_saver *s, ng_entity e);
// The object of a place: of a node, material, animation, primitive or scene. Null if it has none.
struct cJSON *ng_gltf_saved_json(struct gltf_saver *s, const struct gltf_saved *p);
// A primitive of a mesh; null if it has no such.
struct cJSON *ng_gltf_primitive_at(struct gltf_saver *s, const struct cJSON *mesh, uint32_t index);

// ---- gltf_save_fields.c ----------------------------------------------------------------------------------
// The shortest decimal that is this float again.
double ng_gltf_decimal(float value);
void ng_gltf_json_floats(struct ng_gltf_writer *w, struct cJSON *object, const char *key, const float *values,
                         size_t count);
// Deletes a member, if it is there.
void ng_gltf_json_remove(struct cJSON *object, const char *key);
void ng_gltf_json_remove_extension(struct cJSON *object, const char *name);
const struct cJSON *ng_gltf_json_get(const struct cJSON *object, const char *key);
// -1 if there is no such member, or it is no index.
int ng_gltf_json_index(const struct cJSON *object, const char *key);

// Whether a field differs from what was kept; one that is driven never does.
bool ng_gltf_field_changed(struct gltf_saver *s, const struct gltf_saved *p, ng_component component,
                           const struct ng_field *field);
// Writes what differs of a component into NG_scene of `json`. Fields of the set `standard` (bits in the
// table's order) have a place of their own in the document: they are taken out of NG_scene where they differ.
// With a set that is not 0 the component is there without NG_scene; NG_GLTF_IMPLIED is no field's bit.
#define NG_GLTF_IMPLIED ((uint64_t)1 << 63)
void ng_gltf_save_component(struct gltf_saver *s, const struct gltf_saved *p, struct cJSON *json,
                            ng_component component, uint64_t standard);
// The same for all components but those of a set, names and derived ones.
void ng_gltf_save_others(struct gltf_saver *s, const struct gltf_saved *p, struct cJSON *json, uint64_t but);
void ng_gltf_save_name(struct gltf_saver *s, const struct gltf_saved *p, struct cJSON *json);
// The bit of a field.
uint64_t ng_gltf_field_bit(const struct gltf_saver *s, ng_component component, const char *name);
// Scales a vector of at most 8 numbers a little, so that loading, which makes it of unit length (or sum),
// gives this one again. False if no scale does; `out` is then the vector itself.
bool ng_gltf_before_normalizing(void (*normalize)(float *), unsigned width, const float *value, float *out);

// ---- gltf_save_image.c, gltf_save_material.c -------------------------------------------------------------
// A texture of this image.
int ng_gltf_save_texture(struct gltf_saver *s, ng_asset asset);
void ng_gltf_save_picture(struct gltf_saver *s, struct cJSON *field, ng_asset asset);
void ng_gltf_save_material(struct gltf_saver *s, const struct gltf_saved *p);

// ---- gltf_save_mesh.c ------------------------------------------------------------------------------------
// Writes what was edited of the origin's geometries and cages, wherever they are used.
void ng_gltf_save_edited_shapes(struct gltf_saver *s);
// The mesh of a node and of its primitives, and its skin.
void ng_gltf_save_mesh(struct gltf_saver *s, const struct gltf_saved *p);

// ---- gltf_save_node.c, gltf_save_skin.c, gltf_save_animation.c -------------------------------------------
void ng_gltf_save_node(struct gltf_saver *s, const struct gltf_saved *p);
int ng_gltf_save_skin(struct gltf_saver *s, ng_asset id);
void ng_gltf_save_animation(struct gltf_saver *s, const struct gltf_saved *p);

// ---- gltf_save_slots.c -----------------------------------------------------------------------------------
// What refers to accessors and views is about to be written anew: those that nothing else needs become free.
void ng_gltf_release_primitive(struct gltf_saver *s, const struct cJSON *primitive);
void ng_gltf_release_animation(struct gltf_saver *s, const struct cJSON *animation);
void ng_gltf_release_view(struct gltf_saver *s, int view);
// The bytes that the buffer of added data begins with, without those that became free; `*size` of them.
// Owned by the saver.
const unsigned char *ng_gltf_save_compact(struct gltf_saver *s, const unsigned char *old, size_t *size);

// ---- gltf_save_files.c -----------------------------------------------------------------------------------
// Says where data that are added will stand: in the first buffer, if it can take them.
void ng_gltf_save_choose_buffer(struct gltf_saver *s);
// Puts a file beside the document, whose name becomes the object's "uri". `data` is borrowed.
void ng_gltf_save_beside(struct gltf_saver *s, struct cJSON *object, const char *ending, const void *data,
                         size_t size);
// Writes the document and what is beside it.
NG_NODISCARD ng_result ng_gltf_save_write(struct gltf_saver *s);

#endif
