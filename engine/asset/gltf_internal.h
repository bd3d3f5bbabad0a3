// A glTF document as plain C.
//
// gltf_json.cc makes values of the JSON, and sees that it is neither too deep nor too large and that what
// glTF names has the right type; gltf_normal.c writes of the values a text in which tinygltf finds nothing
// wrong, gltf_tinygltf.cc has it read that into the document's tables, and gltf_document.c adds to them what
// tinygltf does not take; gltf_buffer.c finds the bytes. Indices are the file's (-1: absent) and may be out
// of range.
#ifndef NG_ASSET_GLTF_INTERNAL_H
#define NG_ASSET_GLTF_INTERNAL_H

#include "asset/gltf.h"
#include "base/arena.h"
#include "base/array.h"
#include "base/extern_c.h"
#include "base/log.h"

#include <stdarg.h>
#include <stddef.h>

NG_EXTERN_C_BEGIN

// ---- faults ----------------------------------------------------------------------------------------------
struct gltf_fault {
    const void *kind;
    const char *instead; // what is done about it; null: it is no fault, but something that is not followed
    uint32_t count;
    char text[1024]; // of the first: "PATH: thing: reason"
};
struct gltf_faults {
    const char *path;
    bool strict;   // a fault fails the load
    bool followed; // from a fault that is in the list, the part that is open cannot be made
    NG_ARRAY(struct gltf_fault) list;
};

// Notes a fault, of the kind that is made with this format: "thing: reason". `instead` is a literal. NG_OK,
// or NG_ERROR_FORMAT where the load is strict.
NG_NODISCARD ng_result ng_gltf_fault(struct gltf_faults *f, const char *instead, const char *fmt, ...)
    NG_PRINTF(3, 4);
// The same of a kind that is something else than the format.
NG_NODISCARD ng_result ng_gltf_fault_of_kind(struct gltf_faults *f, const void *kind, const char *instead,
                                             const char *fmt, ...) NG_PRINTF(4, 5);

NG_NODISCARD ng_result ng_gltf_fault_va(struct gltf_faults *f, const void *kind, const char *instead,
                                        const char *fmt, va_list args) __attribute__((format(printf, 4, 0)));

// A part that a load can do without. Between begin and end errors are not logged; the end makes a fault of
// the first, sets `lost` and gives NG_OK, unless the load is strict or memory is short.
struct gltf_part {
    struct ng_log_catch caught;
    const char *instead;
    const char *where; // named in the message if it is not yet; null unless set after begin
    bool lost;
};
void ng_gltf_part_begin(struct gltf_part *part, const char *instead);
NG_NODISCARD ng_result ng_gltf_part_end(struct gltf_faults *f, struct gltf_part *part, ng_result r);

// Fails the innermost part without another fault: what is wrong is in the list. Of a load that is not strict.
NG_NODISCARD ng_result ng_gltf_follows(struct gltf_faults *f);

// One warning for each kind after a load that succeeded; the error of a strict one that did not.
void ng_gltf_faults_say(const struct gltf_faults *f, ng_result r);
void ng_gltf_faults_finish(struct gltf_faults *f);

// ---- the document ----------------------------------------------------------------------------------------
// A value of the JSON. Where the standard names a property, it is of that type or GLTF_NULL.
enum gltf_kind { GLTF_NULL, GLTF_BOOL, GLTF_NUMBER, GLTF_STRING, GLTF_ARRAY, GLTF_OBJECT };
struct gltf_value {
    enum gltf_kind kind;
    uint32_t count;  // of an array or object
    const char *key; // as a member of an object; else null
    union {
        bool boolean;
        double number;
        const char *string;
        const struct gltf_value *items; // of an array or object
    };
};

struct gltf_numbers {
    const double *items;
    uint32_t count;
};

// Everywhere: `extension` is NG_scene, `extensions` the object of all; null if there is none.
struct gltf_buffer {
    const unsigned char *data; // null: none
    size_t size;
    bool lost; // it could not be read
};

struct gltf_view {
    int buffer;
    size_t offset, length, stride; // stride 0: tightly packed
    const struct gltf_value *extensions;
};

enum { GLTF_I8 = 5120, GLTF_U8, GLTF_I16, GLTF_U16, GLTF_I32, GLTF_U32, GLTF_F32, GLTF_F64 = 5130 };

struct gltf_accessor {
    int view;
    size_t offset, count;
    int component_type;
    uint32_t components; // 1 to 16; 0: of no type that the standard has
    bool normalized, sparse;
    int sparse_index_type, sparse_index_view, sparse_value_view;
    size_t sparse_count, sparse_index_offset, sparse_value_offset;
};

struct gltf_attribute {
    const char *name;
    int accessor;
};

enum { GLTF_TRIANGLES = 4, GLTF_TRIANGLE_STRIP, GLTF_TRIANGLE_FAN };

struct gltf_primitive {
    const struct gltf_attribute *attributes;
    uint32_t attribute_count, target_count; // morph targets
    int indices, material, mode;
    const struct gltf_value *targets; // an array of objects, or null
    const struct gltf_value *extension, *extensions;
};

struct gltf_mesh {
    const char *name;
    const struct gltf_primitive *primitives;
    uint32_t primitive_count;
    struct gltf_numbers weights;
};

struct gltf_node {
    const char *name;
    int mesh, skin, camera, light;
    struct gltf_numbers matrix, translation, rotation, scale, weights;
    const int *children;
    uint32_t child_count;
    const struct gltf_value *extension, *extensions;
};

struct gltf_texture_use {
    int texture, uv_set;
    const struct gltf_value *extensions;
};

struct gltf_material {
    const char *name, *alpha_mode;
    struct gltf_numbers base_color, emissive; // 4 and 3
    double metallic, roughness, alpha_cutoff, normal_scale, emissive_strength;
    bool double_sided, occlusion; // has an occlusionTexture
    struct gltf_texture_use base_color_texture, metallic_roughness_texture, normal_texture, emissive_texture;
    const struct gltf_value *extension, *extensions;
};

struct gltf_texture {
    int image, sampler;
    int webp; // an image, of EXT_texture_webp
    const struct gltf_value *extensions;
};

struct gltf_sampler {
    int wrap_s, wrap_t, mag_filter, min_filter; // filters: 0 where the file says nothing
};

struct gltf_image {
    const char *name, *uri; // uri: a file, not yet decoded, or a data: URI; "" if none
    int view;               // or a buffer view
    bool webp;              // says that it is one
};

struct gltf_camera {
    bool perspective, orthographic;
    double fov_y, near_plane;
    double x_mag, y_mag; // orthographic: half the size of what is seen
};

struct gltf_light {
    const char *name, *type;
    struct gltf_numbers color;
    double intensity, inner_angle, outer_angle;
};

struct gltf_skin {
    const char *name;
    int inverse_bind, skeleton; // skeleton: a node
    const int *joints;
    uint32_t joint_count;
};

struct gltf_channel {
    int sampler, node;
    const char *path;
};

struct gltf_keys {
    int input, output;
    const char *interpolation;
};

struct gltf_animation {
    const char *name;
    const struct gltf_channel *channels;
    uint32_t channel_count;
    const struct gltf_keys *samplers;
    uint32_t sampler_count;
    const struct gltf_value *extension;
};

struct gltf_scene {
    const char *name;
    const int *nodes;
    uint32_t node_count;
    const struct gltf_value *extension;
};

struct gltf_document {
    struct ng_arena arena;  // strings, values and tables
    NG_ARRAY(void *) files; // from malloc: the file itself, and those of its buffers
    const struct gltf_value *root;
    size_t file_size, json_offset, json_size; // of the first of `files`; its JSON within
    uint64_t bytes;                           // of the document and its buffers
    uint64_t hash; // of the bytes of the document and its buffers, in the order they are read
    int scene;
    uint32_t buffer_count, view_count, accessor_count, mesh_count, node_count, material_count, texture_count;
    uint32_t sampler_count, image_count, camera_count, light_count, skin_count, animation_count, scene_count;
    const struct gltf_buffer *buffers;
    const struct gltf_view *views;
    const struct gltf_accessor *accessors;
    const struct gltf_mesh *meshes;
    const struct gltf_node *nodes;
    const struct gltf_material *materials;
    const struct gltf_texture *textures;
    const struct gltf_sampler *samplers;
    const struct gltf_image *images;
    const struct gltf_camera *cameras;
    const struct gltf_light *lights;
    const struct gltf_skin *skins;
    const struct gltf_animation *animations;
    const struct gltf_scene *scenes;
    const struct gltf_value *extensions;
};

// ---- gltf_json.cc, gltf_value.c --------------------------------------------------------------------------
// The JSON as a tree of values in the arena. Properties of the wrong type are faults and become GLTF_NULL; in
// a strict load too, so that the caller can look for a better reason first.
NG_NODISCARD ng_result ng_gltf_json(struct gltf_faults *faults, const char *text, size_t size,
                                    struct ng_arena *arena, const struct gltf_value **root);
// A copy, from malloc, in which what JSON does not have is put right: NaN and Infinity are null, bytes that
// are no UTF-8 are characters of Latin-1. A zero byte follows. Null when out of memory.
char *ng_gltf_plain_json(const char *text, size_t size, size_t *out_size);
// Null if `object` (may be null, or none) has no such member.
const struct gltf_value *ng_gltf_member(const struct gltf_value *object, const char *key);
// Members of a type; `missing` if there is none.
double ng_gltf_number(const struct gltf_value *object, const char *key, double missing);
int ng_gltf_index(const struct gltf_value *object, const char *key, int missing);
const char *ng_gltf_text(const struct gltf_value *object, const char *key, const char *missing);
bool ng_gltf_bool(const struct gltf_value *object, const char *key, bool missing);
// A texture that a member names; texture -1 if there is none.
struct gltf_texture_use ng_gltf_texture_use(const struct gltf_value *v, const char *key);
// A member that is an array, or null.
const struct gltf_value *ng_gltf_array(const struct gltf_value *object, const char *key);
// The length of an array (or null) of numbers; 0 if one of its items is none.
uint32_t ng_gltf_number_count(const struct gltf_value *list);
// The components of an accessor's type; 0: the standard has no such type.
uint32_t ng_gltf_type_width(const char *type);
// The shortest JSON that reads back as the same number, finite; a whole one without a point or an exponent.
// Returns its length; no zero follows it.
#define NG_GLTF_NUMBER_SIZE 32
size_t ng_gltf_number_text(double v, char out[NG_GLTF_NUMBER_SIZE]);

// ---- gltf_normal.c, gltf_tinygltf.cc ---------------------------------------------------------------------
// The lists that tinygltf reads; those within the items of another are one list over all of them.
enum gltf_list {
    GLTF_VIEWS,
    GLTF_ACCESSORS,
    GLTF_MESHES,
    GLTF_PRIMITIVES,
    GLTF_NODES,
    GLTF_MATERIALS,
    GLTF_TEXTURES,
    GLTF_SAMPLERS,
    GLTF_CAMERAS,
    GLTF_LIGHTS,
    GLTF_SKINS,
    GLTF_ANIMATIONS,
    GLTF_CHANNELS,
    GLTF_KEYS,
    GLTF_SCENES,
    GLTF_LIST_COUNT
};
size_t ng_gltf_list_count(const struct gltf_value *root, enum gltf_list list);

// What the engine uses of a list, as tinygltf takes it, some items at a time.
struct gltf_normal {
    char *items; // the JSON of a document that has these items only, without a zero at its end
    size_t count, capacity;
    uint32_t item_count;
    enum gltf_list list;
    const struct gltf_value *outer; // the list, or that whose items have it
    uint32_t next, next_within;     // what is read next
};
void ng_gltf_normal_begin(struct gltf_normal *n, const struct gltf_value *root, enum gltf_list list);
// Makes the text of the next items. False when out of memory. Finished as an array.
bool ng_gltf_normal_next(struct gltf_normal *n);
// Fills the tables, but for buffers and images, by tinygltf. They may take `limit` bytes.
// There are as many items in each as in the file. Fields that extensions define are as if there were none.
NG_NODISCARD ng_result ng_gltf_tables(const char *path, uint64_t limit, struct gltf_document *doc);

// ---- gltf_document.c, gltf_buffer.c ----------------------------------------------------------------------
// Reads and parses a file; buffers are read too, images are not.
NG_NODISCARD ng_result ng_gltf_parse(const char *path, const struct ng_gltf_params *params,
                                     struct gltf_faults *faults, struct gltf_document **out);
void ng_gltf_document_destroy(struct gltf_document **doc);
// Extensions that are followed, or may be ignored since others only refine them.
bool ng_gltf_knows_extension(const char *name);

// The parts of a file: its JSON, and the bytes of the first buffer of a GLB (null: it has none).
struct gltf_container {
    const char *json;
    size_t json_size;
    const unsigned char *bytes;
    size_t byte_count;
};
NG_NODISCARD ng_result ng_gltf_open(struct gltf_faults *faults, const unsigned char *data, size_t size,
                                    struct gltf_container *out);
NG_NODISCARD ng_result ng_gltf_buffers(struct gltf_faults *faults, const struct ng_gltf_params *params,
                                       const struct gltf_container *container, struct gltf_document *doc);
// The bytes of a data: URI in base64; from malloc. `what` has it, for messages: "buffer 0".
NG_NODISCARD ng_result ng_gltf_data_uri(struct gltf_faults *faults, const char *what, const char *uri,
                                        uint64_t limit, unsigned char **data, size_t *size);
bool ng_gltf_is_data_uri(const char *uri);

// The path of a file that the document names, percent-encoded: in the document's directory or below. False
// (and
// `*why` says why) if it is not one that may be opened.
bool ng_gltf_uri_path(const char *document, const char *uri, char *out, size_t size, const char **why);

NG_EXTERN_C_END

#endif
