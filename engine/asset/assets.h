// The store of everything that components refer to by ng_asset: plain CPU data, loaded or generated.
//
// The store owns what is added to it; pointers from ng_assets_* stay valid until the asset is removed or the
// store destroyed. Not thread-safe for adding; reading from several threads is.
#ifndef NG_ASSET_ASSETS_H
#define NG_ASSET_ASSETS_H

#include "anim/clip.h"
#include "anim/skeleton.h"
#include "base/extern_c.h"
#include "base/result.h"
#include "scene/entity.h"

#include <stddef.h>

NG_EXTERN_C_BEGIN

// A Catmull-Clark control cage. Its vertices are its own; `vertex_map` ties them to those of the geometry's
// triangulated fallback, which is where a skinned cage finds its joints and weights.
struct ng_cage {
    uint32_t vertex_count, face_count, index_count, crease_count, corner_count;
    float *positions;        // [vertex_count][3]
    uint32_t *face_sizes;    // [face_count], each at least 3
    uint32_t *face_indices;  // [index_count], the sum of face_sizes
    float *face_uvs;         // [index_count][2], face-varying, or null
    uint32_t *crease_edges;  // [crease_count][2] vertices
    float *crease_sharpness; // [crease_count], 0 to 10 (10: infinitely sharp)
    uint32_t *corners;       // [corner_count] vertices
    float *corner_sharpness; // [corner_count]
    uint32_t *vertex_map;    // [vertex_count] vertices of the geometry, or null
};

// Triangles with per-vertex attributes: what a mesh component refers to.
struct ng_geometry {
    uint32_t vertex_count, index_count;
    float *positions;  // [vertex_count][3], metres
    float *normals;    // [vertex_count][3], unit
    float *tangents;   // [vertex_count][4]; w, +-1: the bitangent is w * cross(normal, tangent)
    float *uvs;        // [vertex_count][2]; zeros if the file had none
    uint16_t *joints;  // [vertex_count][4], or null
    float *weights;    // [vertex_count][4], sum 1; or null
    uint32_t *indices; // [index_count], a multiple of 3; counter-clockwise is the front
    float bounds_min[3], bounds_max[3];
    struct ng_cage *cage; // or null; without faces: the file's was refused, so the triangles stand alone
};

enum ng_pixel_format { NG_PIXEL_RGBA8, NG_PIXEL_RGBA8_SRGB, NG_PIXEL_RGBA32F };

// An image with its mip chain: level 0 first, row 0 at the top, levels tightly packed one after the other.
struct ng_image {
    uint32_t width, height, levels;
    enum ng_pixel_format format;
    bool repeat_u, repeat_v; // else clamp to edge
    void *pixels;
    size_t size; // bytes of all levels
};

enum ng_asset_kind { NG_ASSET_GEOMETRY = 1, NG_ASSET_IMAGE, NG_ASSET_SKELETON, NG_ASSET_CLIP };

struct ng_assets;

NG_NODISCARD ng_result ng_assets_create(struct ng_assets **out);
void ng_assets_destroy(struct ng_assets **assets);

// Take: the store moves the struct in and owns every pointer in it (all from malloc), also when it fails.
// `name` is for messages and the editor.
NG_NODISCARD ng_result ng_assets_take_geometry(struct ng_assets *a, const char *name, struct ng_geometry *g,
                                               ng_asset *out);
NG_NODISCARD ng_result ng_assets_take_image(struct ng_assets *a, const char *name, struct ng_image *image,
                                            ng_asset *out);
NG_NODISCARD ng_result ng_assets_take_skeleton(struct ng_assets *a, const char *name, struct ng_skeleton *s,
                                               ng_asset *out);
NG_NODISCARD ng_result ng_assets_take_clip(struct ng_assets *a, const char *name, struct ng_clip *clip,
                                           ng_asset *out);

// Null if the id is stale or of another kind.
const struct ng_geometry *ng_assets_geometry(const struct ng_assets *a, ng_asset id);
const struct ng_image *ng_assets_image(const struct ng_assets *a, ng_asset id);
const struct ng_skeleton *ng_assets_skeleton(const struct ng_assets *a, ng_asset id);
const struct ng_clip *ng_assets_clip(const struct ng_assets *a, ng_asset id);
const char *ng_assets_name(const struct ng_assets *a, ng_asset id);

// Destroys an asset; false if the id is stale. Whatever refers to it finds null from then on.
bool ng_assets_remove(struct ng_assets *a, ng_asset id);

// All assets of a kind, in the order of adding: start with {0}; returns {0} at the end.
ng_asset ng_assets_next(const struct ng_assets *a, enum ng_asset_kind kind, ng_asset previous);
size_t ng_assets_memory(const struct ng_assets *a); // bytes held
// Another number whenever an asset was added or removed.
uint64_t ng_assets_revision(const struct ng_assets *a);

NG_EXTERN_C_END

#endif
