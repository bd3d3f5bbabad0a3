// Three-vectors in double precision: shapes are computed in double and stored on a grid of single precision
// (glb.h), so that the last bit of a machine's sin or cos never reaches a file.
#ifndef CONTENT_VEC_H
#define CONTENT_VEC_H

#include <math.h>

#define CONTENT_PI 3.14159265358979323846

struct vec3 {
    double x, y, z;
};

static inline struct vec3 vec3_make(double x, double y, double z)
{
    return (struct vec3){x, y, z};
}

static inline struct vec3 vec3_add(struct vec3 a, struct vec3 b)
{
    return vec3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline struct vec3 vec3_sub(struct vec3 a, struct vec3 b)
{
    return vec3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline struct vec3 vec3_scale(struct vec3 a, double s)
{
    return vec3_make(a.x * s, a.y * s, a.z * s);
}

static inline struct vec3 vec3_mix(struct vec3 a, struct vec3 b, double t)
{
    return vec3_add(vec3_scale(a, 1.0 - t), vec3_scale(b, t));
}

static inline double vec3_dot(struct vec3 a, struct vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec3 vec3_cross(struct vec3 a, struct vec3 b)
{
    return vec3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline double vec3_length(struct vec3 a)
{
    return sqrt(vec3_dot(a, a));
}

// The zero vector stays zero.
static inline struct vec3 vec3_normalize(struct vec3 a)
{
    double n = vec3_length(a);
    return n > 0.0 ? vec3_scale(a, 1.0 / n) : a;
}

#endif
