// Lets one text compile as GLSL and as C: the spellings of the functions and of struct types that differ.
//
// Shared headers hold scalar functions and structs of scalars only. Literals carry the suffix f. A function
// is `NG_SHADER_FN float name(float x)`, a struct type is used as `NG_STRUCT(name)`.
#ifndef NG_SHADERS_SHARED_GLSL_COMPAT_H
#define NG_SHADERS_SHARED_GLSL_COMPAT_H

#ifdef GL_core_profile // defined by every GLSL compiler for Vulkan

#define NG_SHADER_FN
#define NG_STRUCT(name) name

#define ng_sqrt  sqrt
#define ng_cos   cos
#define ng_sin   sin
#define ng_abs   abs
#define ng_min   min
#define ng_max   max
#define ng_clamp clamp
#define ng_mix   mix
#define ng_uint  uint
#define ng_float float

#else

#include <math.h>
#include <stdint.h>

#define NG_SHADER_FN    static inline
#define NG_STRUCT(name) struct name

#define ng_sqrt     sqrtf
#define ng_cos      cosf
#define ng_sin      sinf
#define ng_abs      fabsf
#define ng_uint     uint32_t
#define ng_float(x) ((float)(x))

// Comparisons, not fminf and fmaxf, so that loops vectorise; the second argument wins over a NaN.
static inline float ng_min(float a, float b)
{
    return a < b ? a : b;
}
static inline float ng_max(float a, float b)
{
    return a > b ? a : b;
}
static inline float ng_clamp(float x, float low, float high)
{
    return ng_min(ng_max(x, low), high);
}
static inline float ng_mix(float a, float b, float t)
{
    return a * (1.0f - t) + b * t;
}

#endif

#define NG_SHADER_PI 3.14159265358979323846f

#endif
