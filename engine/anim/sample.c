// Keyframes to values (glTF 2.0, appendix C), and weighted means of values.
#include "anim/sample.h"

#include <math.h>
#include <string.h>

float ng_clip_time(const struct ng_animation *a, float duration, double time)
{
    double t = time * (double)a->speed + (double)a->offset, length = (double)duration;
    if (!(length > 0) || !isfinite(t))
        return 0;
    if (!a->loop)
        return (float)fmin(fmax(t, 0.0), length);
    t = fmod(t, length);
    float wrapped = (float)(t < 0 ? t + length : t);
    return wrapped < duration ? wrapped : 0; // just below the length rounds up to it
}

static float dot(const float *a, const float *b, uint32_t width)
{
    float sum = 0;
    for (uint32_t i = 0; i < width; i++)
        sum += a[i] * b[i];
    return sum;
}

static void normalize(float *q)
{
    float length = sqrtf(dot(q, q, 4));
    for (uint32_t i = 0; i < 4; i++)
        q[i] = length > 0 ? q[i] / length : (i == 3 ? 1.0f : 0.0f);
}

static void slerp(const float *a, const float *b, float t, float *out)
{
    float cosine = dot(a, b, 4), sign = cosine < 0 ? -1.0f : 1.0f;
    cosine = fminf(cosine * sign, 1.0f);
    float wa = 1 - t, wb = t, angle = acosf(cosine), sine = sinf(angle);
    // Nearly the same direction: the sines vanish, and the straight line is as good.
    if (sine > 1e-4f) {
        wa = sinf(wa * angle) / sine;
        wb = sinf(wb * angle) / sine;
    }
    for (uint32_t i = 0; i < 4; i++)
        out[i] = wa * a[i] + wb * sign * b[i];
    normalize(out);
}

// The last key at or before t; keys 0 and key_count - 1 bound the answer.
static uint32_t key_before(const struct ng_channel *c, float t)
{
    uint32_t low = 0, high = c->key_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (c->times[middle] <= t)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static const float *key_value(const struct ng_channel *c, uint32_t key)
{
    bool cubic = c->interpolation == NG_INTERPOLATION_CUBIC;
    return c->values + (cubic ? (size_t)key * 3 + 1 : (size_t)key) * c->width;
}

static void cubic(const struct ng_channel *c, uint32_t key, float t, float span, float *out)
{
    const float *from = key_value(c, key), *to = key_value(c, key + 1);
    const float *leave = from + c->width, *arrive = to - c->width; // tangents, per second
    float t2 = t * t, t3 = t2 * t;
    for (uint32_t i = 0; i < c->width; i++)
        out[i] = (2 * t3 - 3 * t2 + 1) * from[i] + span * (t3 - 2 * t2 + t) * leave[i] +
                 (3 * t2 - 2 * t3) * to[i] + span * (t3 - t2) * arrive[i];
    if (c->rotation)
        normalize(out);
}

void ng_channel_sample(const struct ng_channel *c, float t, float out[4])
{
    if (!c->key_count) {
        memset(out, 0, c->width * sizeof(float));
        return;
    }
    uint32_t key = key_before(c, t);
    const float *from = key_value(c, key);
    bool inside = t > c->times[key] && key + 1 < c->key_count;
    if (!inside || c->interpolation == NG_INTERPOLATION_STEP) {
        memcpy(out, from, c->width * sizeof(float));
        return;
    }
    float span = c->times[key + 1] - c->times[key], part = (t - c->times[key]) / span;
    const float *to = key_value(c, key + 1);
    if (c->interpolation == NG_INTERPOLATION_CUBIC)
        cubic(c, key, part, span, out);
    else if (c->rotation)
        slerp(from, to, part, out);
    else
        for (uint32_t i = 0; i < c->width; i++)
            out[i] = from[i] + (to[i] - from[i]) * part;
}

void ng_blend_add(struct ng_blend *b, const float value[4], uint32_t width, bool rotation, float weight)
{
    if (!(weight > 0) || !isfinite(weight))
        return;
    if (b->weight == 0) {
        // Kept as it is, with its weight beside it, so that a single value comes out unchanged.
        memcpy(b->first, value, width * sizeof(float));
        b->weight = weight;
        return;
    }
    if (!b->several)
        for (uint32_t i = 0; i < width; i++)
            b->sum[i] = b->first[i] * b->weight;
    b->several = true;
    float sign = rotation && dot(b->first, value, width) < 0 ? -1.0f : 1.0f;
    for (uint32_t i = 0; i < width; i++)
        b->sum[i] += sign * weight * value[i];
    b->weight += weight;
}

bool ng_blend_result(const struct ng_blend *b, uint32_t width, bool rotation, float out[4])
{
    if (b->weight == 0)
        return false;
    if (!b->several) {
        memcpy(out, b->first, width * sizeof(float));
        return true;
    }
    for (uint32_t i = 0; i < width; i++)
        out[i] = b->sum[i] / b->weight;
    if (rotation)
        normalize(out);
    return true;
}
