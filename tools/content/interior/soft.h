// Upholstery, cushions and bedding as cages of Catmull-Clark surfaces, with texture coordinates in metres.
#ifndef CONTENT_SOFT_H
#define CONTENT_SOFT_H

#include "../cage.h"

// Moves a point of a box. `at` is where it is, `unit` the same from -1 to 1.
typedef struct vec3 (*soft_shape)(struct vec3 at, struct vec3 unit, const void *user);

// A box around the origin, of cells along each axis.
struct soft {
    double size[3];
    double edge;       // rounding: the first and last cell are so wide
    uint32_t cells[3]; // 1: the edges alone, from 3 on with cells of rounding
    double seam;       // sharpness of the box's edges; 0: none
    soft_shape shape;  // null: none
    const void *user;
};

void soft_box(struct cage *c, const struct soft *s);

// A shape: the square of XZ becomes a disk; `user` may point to the bulge in its middle.
struct vec3 soft_round(struct vec3 at, struct vec3 unit, const void *user);

// Stuffed: its top and bottom rise by `bulge` in their middle, its sides by a part of it.
void soft_cushion(struct cage *c, double w, double h, double d, double edge, double bulge, double seam);
// A throw pillow, lying: thick in its middle, flat at its seam, with pointed corners.
void soft_pillow(struct cage *c, double w, double h, double d, uint64_t seed);
// A cover of thickness t that lies on a body of w by d and hangs down by `drop` on both sides and at the
// front.
struct soft_cover {
    double w, d, drop, front, t, folds;
    uint64_t seed;
};
void soft_cover(struct cage *c, const struct soft_cover *cover);

#endif
