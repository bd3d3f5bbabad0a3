// Polygon meshes under construction: cages of Catmull-Clark surfaces, and plain meshes.
//
// A turned shape is a stack of rings (cage_ring), joined (cage_bridge) and closed (cage_cap); everything else
// is points and faces. Faces are counter-clockwise from outside. Sticky like glb.h: `failed` once memory is
// out.
#ifndef CONTENT_CAGE_H
#define CONTENT_CAGE_H

#include "base/array.h"
#include "vec.h"

#include <stdbool.h>
#include <stdint.h>

struct cage_crease {
    uint32_t a, b;
    double sharpness; // 0 smooth to 10 infinitely sharp
};

struct cage_corner {
    uint32_t point;
    double sharpness;
};

struct cage_uv {
    double u, v;
};

struct cage {
    NG_ARRAY(struct vec3) points;
    NG_ARRAY(uint32_t) sizes;     // of the faces
    NG_ARRAY(uint32_t) indices;   // of all faces, one after the other
    NG_ARRAY(struct cage_uv) uvs; // one an index, or none
    NG_ARRAY(struct cage_crease) creases;
    NG_ARRAY(struct cage_corner) corners;
    bool failed;
};

void cage_finish(struct cage *c);

uint32_t cage_point(struct cage *c, struct vec3 p);
void cage_quad(struct cage *c, uint32_t p0, uint32_t p1, uint32_t p2, uint32_t p3);
void cage_face(struct cage *c, const uint32_t *points, uint32_t count);
void cage_add_crease(struct cage *c, uint32_t a, uint32_t b, double sharpness);
void cage_add_corner(struct cage *c, uint32_t point, double sharpness);

// ---- rings: `sides` consecutive points around the Y axis, from +Z towards +X ----

// A ring whose limit curve (a closed cubic B-spline) has the given radius. Returns its first point.
uint32_t cage_ring(struct cage *c, uint32_t sides, double radius, double y);
// Quads between a ring and the next one above it (or outside, looking down).
void cage_bridge(struct cage *c, uint32_t sides, uint32_t lower, uint32_t upper);
// Closes a ring with sides / 2 quads around a centre point that looks up (or down).
void cage_cap(struct cage *c, uint32_t sides, uint32_t ring, struct vec3 center, bool up);
void cage_crease_ring(struct cage *c, uint32_t sides, uint32_t ring, double sharpness);

// A ring of a turned profile.
struct cage_profile {
    double radius, y, sharpness;
};

// Rings upwards, each bridged to the last, from `below` (an open ring) or, if CAGE_NO_RING, from a closed
// bottom. Returns the last ring, open.
#define CAGE_NO_RING UINT32_MAX
uint32_t cage_turn(struct cage *c, uint32_t sides, uint32_t below, const struct cage_profile *profile,
                   uint32_t count);

// ---- solids ----

// A box with corners min and max, its twelve edges creased.
uint32_t cage_box(struct cage *c, struct vec3 min, struct vec3 max, double sharpness);

// ---- the whole ----

void cage_scale(struct cage *c, double s);
// Triangles of all faces (fans): fills 3 * cage_triangle_count indices.
uint32_t cage_triangle_count(const struct cage *c);
void cage_triangles(const struct cage *c, uint32_t *out);
// Smooth unit normals, one a point, weighted by area.
void cage_normals(const struct cage *c, struct vec3 *out);
// Triangles after `level` Catmull-Clark refinements: each corner of a face becomes 4^(level-1) quads.
uint64_t cage_refined_triangles(const struct cage *c, uint32_t level);

#endif
