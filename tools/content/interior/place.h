// Where a part of a piece of furniture is: a rotation and a translation, built up from left to right.
//
//     place_turn(place_at(0.4, 0.7, 0), 'y', 0.5)    turned by half a radian about its own Y, standing at
//     (0.4, 0.7, 0)
#ifndef CONTENT_PLACE_H
#define CONTENT_PLACE_H

#include "../vec.h"

struct place {
    struct vec3 x, y, z; // the part's axes
    struct vec3 at;      // its origin
};

static inline struct place place_at(double x, double y, double z)
{
    return (struct place){{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {x, y, z}};
}

static inline struct vec3 place_direction(const struct place *p, struct vec3 v)
{
    return vec3_add(vec3_add(vec3_scale(p->x, v.x), vec3_scale(p->y, v.y)), vec3_scale(p->z, v.z));
}

static inline struct vec3 place_point(const struct place *p, struct vec3 v)
{
    return vec3_add(p->at, place_direction(p, v));
}

// Turned by an angle in radians about one of the part's own axes, 'x', 'y' or 'z'.
struct place place_turn(struct place p, char axis, double angle);
// Moved along the part's own axes.
struct place place_move(struct place p, double x, double y, double z);
// The rotation as a quaternion x, y, z, w.
void place_quaternion(const struct place *p, double out[4]);

#endif
