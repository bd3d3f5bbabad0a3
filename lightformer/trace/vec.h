// Three floats, as the public structs hold them. cglm's own functions take no const arrays.
#ifndef LF_TRACE_VEC_H
#define LF_TRACE_VEC_H

#include <math.h>
#include <stdbool.h>

// As one instruction; fmaxf, which also weighs NaN, is a call.
static inline float lf_max(float a, float b)
{
    return a > b ? a : b;
}

static inline float lf_min(float a, float b)
{
    return a < b ? a : b;
}

static inline float lf_dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// a + b * t
static inline void lf_mad(const float a[3], const float b[3], float t, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] + b[i] * t;
}

static inline void lf_scale(const float a[3], float t, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] * t;
}

static inline void lf_cross(const float a[3], const float b[3], float out[3])
{
    const float c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    for (int i = 0; i < 3; i++)
        out[i] = c[i];
}

// False, and `v` unchanged, where there is no direction.
static inline bool lf_normalize(float v[3])
{
    float square = lf_dot(v, v);
    if (!(square > 0) || !isfinite(square))
        return false;
    lf_scale(v, 1.0f / sqrtf(square), v);
    return true;
}

static inline float lf_mean(const float rgb[3])
{
    return (rgb[0] + rgb[1] + rgb[2]) / 3.0f;
}

static inline float lf_max3(const float rgb[3])
{
    return lf_max(lf_max(rgb[0], rgb[1]), rgb[2]);
}

struct lf_frame {
    float tangent[3], bitangent[3], normal[3];
};

// A frame around the unit normal (x, y, z) (Duff et al. 2017). By scalars and without a jump, so that loops
// over lanes vectorize.
static inline struct lf_frame lf_frame_around(float x, float y, float z)
{
    float sign = z < 0 ? -1.0f : 1.0f, a = -1.0f / (sign + z), b = x * y * a;
    const struct lf_frame frame = {
        {1 + sign * x * x * a, sign * b, -sign * x}, {b, sign + y * y * a, -y}, {x, y, z}};
    return frame;
}

// The same, turned so that the tangent leads to the side of `toward`: as the world turns, so does the frame.
// In that direction itself there is no such side.
static inline struct lf_frame lf_frame_toward(const float axis[3], const float toward[3])
{
    struct lf_frame f = lf_frame_around(axis[0], axis[1], axis[2]);
    float along = axis[0] * toward[0] + axis[1] * toward[1] + axis[2] * toward[2];
    float x = toward[0] - axis[0] * along, y = toward[1] - axis[1] * along, z = toward[2] - axis[2] * along;
    float square = x * x + y * y + z * z;
    bool aside = square > 1e-8f;
    float scale = 1 / sqrtf(aside ? square : 1);
    f.tangent[0] = aside ? x * scale : f.tangent[0];
    f.tangent[1] = aside ? y * scale : f.tangent[1];
    f.tangent[2] = aside ? z * scale : f.tangent[2];
    f.bitangent[0] = axis[1] * f.tangent[2] - axis[2] * f.tangent[1];
    f.bitangent[1] = axis[2] * f.tangent[0] - axis[0] * f.tangent[2];
    f.bitangent[2] = axis[0] * f.tangent[1] - axis[1] * f.tangent[0];
    return f;
}

// `local`: along tangent, bitangent and normal.
static inline void lf_frame_to_world(const struct lf_frame *frame, const float local[3], float out[3])
{
    lf_scale(frame->normal, local[2], out);
    lf_mad(out, frame->tangent, local[0], out);
    lf_mad(out, frame->bitangent, local[1], out);
}

// 3x4 row-major matrices of snapshots.
static inline void lf_transform_vector(const float m[12], const float v[3], float out[3])
{
    const float r[3] = {lf_dot(m, v), lf_dot(m + 4, v), lf_dot(m + 8, v)};
    for (int i = 0; i < 3; i++)
        out[i] = r[i];
}

static inline void lf_transform_point(const float m[12], const float p[3], float out[3])
{
    lf_transform_vector(m, p, out);
    for (int i = 0; i < 3; i++)
        out[i] += m[i * 4 + 3];
}

#endif
