// Solids as fields: smooth unions of ellipsoids and of cones with round ends, symmetric about the plane x = 0
// unless they are told not to be.
//
// A field is negative inside. It is near the distance outside, which is all that marching along a ray and
// stepping onto the surface need. Smooth minimum: Quilez, "Smooth minimum" (polynomial, of the second
// degree).
#ifndef CONTENT_PEOPLE_FIELD_H
#define CONTENT_PEOPLE_FIELD_H

#include "../vec.h"

#include <stdbool.h>

struct blob {
    bool cone, cut;   // else an ellipsoid; cut: taken away from what came before
    struct vec3 a, b; // a cone's ends; an ellipsoid's centre and half axes
    double ra, rb;    // a cone's radii; an ellipsoid's turn about X, in radians
    double blend;     // over how far it melts into what came before
};

#define FIELD_BLOBS 96
struct field {
    struct blob blobs[FIELD_BLOBS];
    int count;
    double blend;  // added to that of every blob
    double offset; // how far the surface lies outside
    double floor;  // nothing is below this height
    bool one_side; // no mirror image at the other side of x = 0
};

void field_init(struct field *f);
void field_cone(struct field *f, struct vec3 a, struct vec3 b, double ra, double rb, double blend);
void field_ball(struct field *f, struct vec3 center, struct vec3 radii, double turn, double blend);
void field_cut(struct field *f, struct vec3 center, struct vec3 radii, double turn, double blend);
// All blobs of another one, after its own.
void field_append(struct field *f, const struct field *other);

double field_at(const struct field *f, struct vec3 p);
// Towards the outside, of unit length.
struct vec3 field_normal(const struct field *f, struct vec3 p);
// The first point of the surface on the way from `from` to `to`; `to` if there is none.
struct vec3 field_hit(const struct field *f, struct vec3 from, struct vec3 to);
// The first point of the surface on the way from inside to `to`; `to` if there is none.
struct vec3 field_leave(const struct field *f, struct vec3 from, struct vec3 to);
// The point of the surface near p, along the gradient.
struct vec3 field_snap(const struct field *f, struct vec3 p);

// 0 below a, 1 above b, smooth between; a may be above b.
static inline double ramp(double x, double a, double b)
{
    double t = (x - a) / (b - a);
    t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    return t * t * (3.0 - 2.0 * t);
}

static inline double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}

static inline double bump(double x, double center, double width)
{
    double t = (x - center) / width;
    return exp(-t * t);
}

// Smooth noise from -1 to 1 with cells of size 1.
double field_noise(struct vec3 p);

#endif
