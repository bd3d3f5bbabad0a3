// What an asset is made of, whatever its kind: freed, counted, copied and exchanged by one table of arrays.
#ifndef NG_ASSET_CONTENT_INTERNAL_H
#define NG_ASSET_CONTENT_INTERNAL_H

#include "asset/assets.h"

union ng_content {
    struct ng_geometry geometry;
    struct ng_cage cage;
    struct ng_image image;
    struct ng_skeleton skeleton;
    struct ng_clip clip;
};

// Parts of geometries and cages; the rest of a content has no part of its own.
enum ng_content_part { NG_PART_TOPOLOGY, NG_PART_POINTS, NG_PART_REST };

void ng_content_finish(enum ng_asset_kind kind, union ng_content *c);
size_t ng_content_size(enum ng_asset_kind kind, const union ng_content *c); // bytes of all arrays
// Whether all is the same, bit for bit; rest points and revisions do not count.
bool ng_content_equal(enum ng_asset_kind kind, const union ng_content *a, const union ng_content *b);
// A copy with arrays of its own; false when out of memory, and nothing was made.
bool ng_content_copy(enum ng_asset_kind kind, const union ng_content *from, union ng_content *to);
// Puts copies of the points (positions, normals, tangents) in their place and the originals into `original`,
// which gets nothing else. False when out of memory, and nothing was made.
bool ng_content_fork_points(enum ng_asset_kind kind, union ng_content *c, union ng_content *original);
// Copies of the points become those at rest. False when out of memory, and nothing was made.
bool ng_content_make_rest(enum ng_asset_kind kind, union ng_content *c);
// Exchanges one part of two contents of one kind, the bounds with the points.
void ng_content_swap(enum ng_asset_kind kind, enum ng_content_part part, union ng_content *a,
                     union ng_content *b);
// Frees one part.
void ng_content_drop(enum ng_asset_kind kind, enum ng_content_part part, union ng_content *c);

#endif
