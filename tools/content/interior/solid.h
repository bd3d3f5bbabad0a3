// Hard parts of furniture as triangles: rounded boxes, turned and extruded outlines, bent tubes, sheets.
//
// Lengths are in metres, and so are texture coordinates; v runs along the grain, which is along the longest
// side. Everything is put where `place` says. Sticky like glb.h: `failed` once memory is out.
#ifndef CONTENT_SOLID_H
#define CONTENT_SOLID_H

#include "base/array.h"
#include "place.h"

#include <stdbool.h>
#include <stdint.h>

struct solid_vertex {
    struct vec3 position, normal;
    double u, v;
};

struct solid {
    NG_ARRAY(struct solid_vertex) vertices;
    NG_ARRAY(uint32_t) indices;
    uint32_t boards; // drawn so far: each has other grain
    bool failed;
};

void solid_finish(struct solid *s);

uint32_t solid_vertex(struct solid *s, const struct place *p, struct vec3 position, struct vec3 normal,
                      double u, double v);
void solid_quad(struct solid *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d);

// A box of full size w, h, d around the place's origin, its edges rounded.
void solid_box(struct solid *s, struct place p, double w, double h, double d, double rounding);

// A point of an outline, where it turns with the given radius; 0: a sharp edge.
struct solid_corner {
    double x, y, radius;
};

// The outline (x: radius, y: height; upwards on the outside) turned about Y.
void solid_turn(struct solid *s, struct place p, const struct solid_corner *outline, size_t count,
                uint32_t sides);
// A cylinder that stands on the place's origin, its rims rounded.
void solid_cylinder(struct solid *s, struct place p, double radius, double height, double rounding,
                    uint32_t sides);
// A closed convex outline, counter-clockwise, drawn out along Z from -d/2 to d/2.
void solid_extrude(struct solid *s, struct place p, const struct solid_corner *outline, size_t count,
                   double d);
// A moulding around the rectangle of w by h in XY: x of the outline goes outwards from the rectangle, y
// towards +Z; the outline runs from the inner back over the front to the outer back.
void solid_frame(struct solid *s, struct place p, double w, double h, const struct solid_corner *outline,
                 size_t count);

// A bend of a tube, with the radius of the bend.
struct solid_bend {
    double x, y, z, radius;
};

// A round tube along a way, `thick` at its start and `thin` at its end (radii). Its ends are closed and flat.
void solid_tube(struct solid *s, struct place p, const struct solid_bend *way, size_t count, double thick,
                double thin, uint32_t sides);
// The straight one, from a to b.
void solid_rod(struct solid *s, struct place p, struct vec3 a, struct vec3 b, double thick, double thin);

// A surface of two parameters from 0 to 1, seen with u to the right and v up; texture coordinates are u times
// `width`, v times `height`.
typedef struct vec3 (*solid_surface)(double u, double v, const void *user);
void solid_sheet(struct solid *s, struct place p, solid_surface surface, const void *user, uint32_t columns,
                 uint32_t rows, double width, double height);

// From 0 to 1, the same on every machine.
double solid_random(uint64_t seed, uint64_t i);

#endif
