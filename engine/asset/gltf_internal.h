// A glTF document as plain C.
//
// gltf_scan.cc has checked that the JSON is JSON, neither too deep nor too large, of a version that is
// supported, and that its properties have the right types; gltf_parse.cc makes the document. Indices are the
// file's (-1: absent) and may be out of range.
#ifndef NG_ASSET_GLTF_INTERNAL_H
#define NG_ASSET_GLTF_INTERNAL_H

#include "asset/gltf.h"
#include "base/arena.h"
#include "base/extern_c.h"

#include <stddef.h>

NG_EXTERN_C_BEGIN

// JSON of an extension.
enum gltf_kind { GLTF_BOOL, GLTF_NUMBER, GLTF_STRING, GLTF_ARRAY, GLTF_OBJECT };
struct gltf_value {
    enum gltf_kind kind;
    const char *key; // as a member of an object; else null
    bool boolean;
    double number;
    const char *string;
    uint32_t count; // of an array or object
    const struct gltf_value *items;
};

struct gltf_numbers {
    const double *items;
    uint32_t count;
};

struct gltf_buffer {
    const unsigned char *data;
    size_t size;
};

struct gltf_view {
    int buffer;
    size_t offset, length, stride; // stride 0: tightly packed
};

enum { GLTF_I8 = 5120, GLTF_U8, GLTF_I16, GLTF_U16, GLTF_U32 = 5125, GLTF_F32 };

struct gltf_accessor {
    int view;
    size_t offset, count;
    int component_type;
    uint32_t components; // 1 to 16
    bool normalized, sparse;
    int sparse_count, sparse_index_type;
    int sparse_index_view, sparse_index_offset, sparse_value_view, sparse_value_offset;
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
    const struct gltf_value *extension; // NG_scene, or null
};

struct gltf_mesh {
    const char *name;
    const struct gltf_primitive *primitives;
    uint32_t primitive_count;
};

struct gltf_node {
    const char *name;
    int mesh, skin, camera, light;
    struct gltf_numbers matrix, translation, rotation, scale;
    const int *children;
    uint32_t child_count;
    const struct gltf_value *extension;
};

struct gltf_texture_use {
    int texture, uv_set;
};

struct gltf_material {
    const char *name, *alpha_mode;
    struct gltf_numbers base_color, emissive; // 4 and 3, checked by the parser
    double metallic, roughness, alpha_cutoff, normal_scale, emissive_strength;
    bool double_sided;
    struct gltf_texture_use base_color_texture, metallic_roughness_texture, normal_texture, emissive_texture;
    const struct gltf_value *extension;
};

struct gltf_texture {
    int image, sampler;
};

struct gltf_sampler {
    int wrap_s, wrap_t;
};

struct gltf_image {
    const char *name, *uri;    // uri: a file, not yet decoded; "" if none
    int view;                  // or a buffer view,
    const unsigned char *data; // or the content of a data: URI
    size_t size;
};

struct gltf_camera {
    bool perspective;
    double fov_y, near_plane;
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
    struct ng_arena arena;
    void *model;   // tinygltf's; strings and buffers are borrowed from it
    uint64_t hash; // of the bytes of the document and its buffers, in the order they are read
    int scene;
    uint32_t buffer_count, view_count, accessor_count, mesh_count, node_count, material_count, texture_count;
    uint32_t sampler_count, image_count, camera_count, light_count, skin_count, animation_count, scene_count;
    uint32_t required_count;
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
    const char *const *required; // extensionsRequired
};

// What the JSON has of that which tinygltf checks itself.
struct gltf_counts {
    size_t buffers, views, accessors;
};

// Checks the JSON of a file.
NG_NODISCARD ng_result ng_gltf_scan(const char *path, const char *text, size_t size,
                                    struct gltf_counts *counts);
// Reads and parses a file; buffers are read too, images are not.
NG_NODISCARD ng_result ng_gltf_parse(const char *path, const struct ng_gltf_params *params,
                                     struct gltf_document **out);
void ng_gltf_document_destroy(struct gltf_document **doc);

// The path of a file that the document names: in the document's directory or below. False (and `*why` says
// why) if it is not one that may be opened. The second form takes the name percent-encoded, as it stands in
// the file.
bool ng_gltf_file_path(const char *document, const char *name, char *out, size_t size, const char **why);
bool ng_gltf_uri_path(const char *document, const char *uri, char *out, size_t size, const char **why);

NG_EXTERN_C_END

#endif
