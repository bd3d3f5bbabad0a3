// The store of everything that components refer to by ng_asset: plain CPU data, loaded or generated.
//
// The store owns what is added to it; pointers from ng_assets_* stay valid until the asset is edited,
// replaced or removed (by undo, too), or the store destroyed. Not thread-safe for changes; reading from
// several threads is. A snapshot (render/snapshot.h) borrows from the store: what was extracted before a
// change is void.
//
// Changes within a transaction of the world (ng_assets_set_history, scene/history.h) can be taken back: what
// is taken goes, what is removed comes back under its id, edited content is again what it was. Others are not
// recorded, as everywhere.
#ifndef NG_ASSET_ASSETS_H
#define NG_ASSET_ASSETS_H

#include "anim/clip.h"
#include "anim/skeleton.h"
#include "base/extern_c.h"
#include "base/result.h"
#include "scene/entity.h"

#include <stddef.h>

NG_EXTERN_C_BEGIN

// A Catmull-Clark control cage: what a subdivision component refers to. Its vertices are its own;
// `vertex_map` ties them to those of the mesh's geometry, its triangulated fallback, which is where a skinned
// cage finds its joints and weights.
struct ng_cage {
    uint32_t vertex_count, face_count, index_count, crease_count, corner_count;
    float *positions;        // [vertex_count][3]
    float *rest_positions;   // as of struct ng_geometry
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
    float *positions; // [vertex_count][3], metres
    float *normals;   // [vertex_count][3], unit
    float *tangents;  // [vertex_count][4]; w, +-1: the bitangent is w * cross(normal, tangent)
    float *uvs;       // [vertex_count][2]; zeros if the file had none
    float *uvs1;      // [vertex_count][2], a second set, which materials may ask for; or null
    uint16_t *
        colors; // [vertex_count][4], linear R, G, B and alpha, 65,535 is 1; multiply the base colour; or null
    uint16_t *joints; // [vertex_count][4], or null
    float *weights;   // [vertex_count][4], sum 1; or null
    // Four more of each vertex, where some have more than four; the sum of all eight weights is 1. Or null.
    uint16_t *joints1;
    float *weights1;
    uint32_t *indices; // [index_count], a multiple of 3; counter-clockwise is the front
    // Morph targets (components/morph.h): what each, at a weight of 1, adds to the vertices that it moves.
    // Deltas of target t are those from target_ends[t - 1] (0 for the first) to target_ends[t].
    uint32_t target_count, delta_count;
    uint32_t *target_ends;    // [target_count], or null
    uint32_t *delta_vertices; // [delta_count], increasing within a target; or null
    float *delta_positions;   // [delta_count][3], metres; or null
    float *delta_normals;     // [delta_count][3], or null: normals stay
    float *delta_tangents;    // [delta_count][3], or null: tangents stay
    // Points as they were before the first of them was edited, since the content was taken or replaced; null:
    // none was. The store makes and keeps them: structures that are built around points at rest, and refitted
    // to where they are, are the same ones whatever way the points went.
    float *rest_positions, *rest_normals, *rest_tangents;
    // Computed tangents follow uvs1: where the normal map uses that set.
    bool tangents_of_uvs1;
    float bounds_min[3], bounds_max[3];
};

enum ng_pixel_format { NG_PIXEL_RGBA8, NG_PIXEL_RGBA8_SRGB, NG_PIXEL_RGBA32F };

enum ng_wrap { NG_WRAP_CLAMP, NG_WRAP_REPEAT, NG_WRAP_MIRROR };
enum ng_filter { NG_FILTER_LINEAR, NG_FILTER_NEAREST };
enum ng_mip_filter { NG_MIP_LINEAR, NG_MIP_NEAREST, NG_MIP_NONE }; // between levels; none: level 0 alone

// How an image is looked up. Zeros: clamped, and smooth in all ways.
struct ng_sampling {
    enum ng_wrap wrap_u, wrap_v;
    enum ng_filter magnify, minify;
    enum ng_mip_filter mips;
};

// An image with its mip chain: level 0 first, row 0 at the top, levels tightly packed one after the other.
struct ng_image {
    uint32_t width, height, levels;
    enum ng_pixel_format format;
    struct ng_sampling sampling;
    void *pixels;
    size_t size; // bytes of all levels
};

enum ng_asset_kind { NG_ASSET_GEOMETRY = 1, NG_ASSET_CAGE, NG_ASSET_IMAGE, NG_ASSET_SKELETON, NG_ASSET_CLIP };

struct ng_assets;
struct ng_world;

NG_NODISCARD ng_result ng_assets_create(struct ng_assets **out);
void ng_assets_destroy(struct ng_assets **assets);
// Has transactions of a world record what is done to assets; null: of none. The world must be there whenever
// assets are changed; which of the two is destroyed first does not matter. ng_scene_systems_add does it.
void ng_assets_set_history(struct ng_assets *a, struct ng_world *world);

// Take: the store moves the struct in and owns every pointer in it (all from malloc), also when it fails.
// `name` is for messages and the editor.
NG_NODISCARD ng_result ng_assets_take_geometry(struct ng_assets *a, const char *name, struct ng_geometry *g,
                                               ng_asset *out);
NG_NODISCARD ng_result ng_assets_take_cage(struct ng_assets *a, const char *name, struct ng_cage *cage,
                                           ng_asset *out);
NG_NODISCARD ng_result ng_assets_take_image(struct ng_assets *a, const char *name, struct ng_image *image,
                                            ng_asset *out);
NG_NODISCARD ng_result ng_assets_take_skeleton(struct ng_assets *a, const char *name, struct ng_skeleton *s,
                                               ng_asset *out);
NG_NODISCARD ng_result ng_assets_take_clip(struct ng_assets *a, const char *name, struct ng_clip *clip,
                                           ng_asset *out);

// Null if the id is stale or of another kind.
const struct ng_geometry *ng_assets_geometry(const struct ng_assets *a, ng_asset id);
const struct ng_cage *ng_assets_cage(const struct ng_assets *a, ng_asset id);
const struct ng_image *ng_assets_image(const struct ng_assets *a, ng_asset id);
const struct ng_skeleton *ng_assets_skeleton(const struct ng_assets *a, ng_asset id);
const struct ng_clip *ng_assets_clip(const struct ng_assets *a, ng_asset id);
const char *ng_assets_name(const struct ng_assets *a, ng_asset id);

// Destroys an asset; false if the id is stale, or (logged) there is no memory to record it. Whatever refers
// to it finds null from then on.
bool ng_assets_remove(struct ng_assets *a, ng_asset id);

// ---- edits -----------------------------------------------------------------------------------------------
// In place, where sizes stay: ask for what is to be written, write, tell.
//
//     float *points = ng_assets_edit_points(assets, cage);
//     points[3 * vertex] += 0.1f;
//     NG_TRY(ng_assets_changed(assets, cage));
//
// Nobody sees the change before it is told, and nothing may read the asset in between. The pointer ends with
// that; ask again for the next change. The first edit of an asset in a transaction copies the old content for
// undo; later ones of that transaction copy nothing, so a drag is one transaction and one copy.
//
// Null, silently, if the id is stale or of another kind; null (logged) when out of memory: nothing has
// changed.

// [vertex_count][3] of a geometry or a cage. Topology and all that follows from it stays.
float *ng_assets_edit_points(struct ng_assets *a, ng_asset id);
// Level 0 of an image, in its format.
void *ng_assets_edit_texels(struct ng_assets *a, ng_asset id);
// Times and values of a clip's keys; counts stay, times still increase.
struct ng_clip *ng_assets_edit_clip(struct ng_assets *a, ng_asset id);
// Ends an edit: finds what follows from what was written (a geometry's normals, tangents and bounds, an
// image's other levels, a clip's duration). Out of memory: not told yet; tell again, or cancel the
// transaction.
//
// Normals turn with the triangles around them, relative to what both were at rest: where nothing moved they
// are as the file had them, and vertices that were one smooth point stay one.
NG_NODISCARD ng_result ng_assets_changed(struct ng_assets *a, ng_asset id);

// Other content under the same id, whatever its size: moved in as when it is taken, freed when that fails.
// The old content moves to the open transaction, or is freed. NOT_FOUND, logged: the id is stale or of
// another kind. Skeletons never change.
NG_NODISCARD ng_result ng_assets_replace_geometry(struct ng_assets *a, ng_asset id, struct ng_geometry *g);
NG_NODISCARD ng_result ng_assets_replace_cage(struct ng_assets *a, ng_asset id, struct ng_cage *cage);
NG_NODISCARD ng_result ng_assets_replace_image(struct ng_assets *a, ng_asset id, struct ng_image *image);
NG_NODISCARD ng_result ng_assets_replace_clip(struct ng_assets *a, ng_asset id, struct ng_clip *clip);

// ---- revisions -------------------------------------------------------------------------------------------
// The same numbers mean the same content at the same addresses: undo gives an asset its old ones back.
struct ng_asset_revision {
    uint64_t content;  // another one whenever anything is different
    uint64_t topology; // another one whenever more than points, texels or keys is
};
// Of an asset; zeros if the id is stale.
struct ng_asset_revision ng_assets_revision(const struct ng_assets *a, ng_asset id);
// Of the store: another number after any change (undo, too); `topology` whenever an asset came, went or got
// another topology.
struct ng_asset_revision ng_assets_latest(const struct ng_assets *a);

// All assets of a kind, in the order of adding: start with {0}; returns {0} at the end.
ng_asset ng_assets_next(const struct ng_assets *a, enum ng_asset_kind kind, ng_asset previous);
size_t ng_assets_memory(const struct ng_assets *a); // bytes held, without what transactions hold

NG_EXTERN_C_END

#endif
