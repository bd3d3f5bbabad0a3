// What all light types have in common: from samples to light that arrives, densities for multiple importance
// sampling, direct VPLs. Each type's own file says what it emits from where.
#include "light/light_internal.h"

#include "base/log.h"

#include <stdlib.h>

#include "light/list.inc"

#define NG_LIGHT_DECLARE(name) extern const struct ng_light_type ng_light_##name##_type;
NG_LIGHT_TYPE_LIST(NG_LIGHT_DECLARE)

#define NG_LIGHT_ADDRESS(name) &ng_light_##name##_type,
const struct ng_light_type *const ng_light_types[] = {NG_LIGHT_TYPE_LIST(NG_LIGHT_ADDRESS) NULL};

const struct ng_light_type *ng_light_type_of(ng_component component)
{
    for (uint32_t i = 0; ng_light_types[i]; i++)
        if (ng_light_types[i]->component == component)
            return ng_light_types[i];
    return NULL;
}

static void decode_srgb(float table[256])
{
    for (int i = 0; i < 256; i++) {
        float x = (float)i / 255.0f;
        table[i] = x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
    }
}

ng_result ng_light_prepare(struct ng_light_source *s)
{
    NG_REQUIRE(s->type, "a light source has a type");
    if (!s->type->prepare)
        return NG_OK;
    if (!s->tables) {
        s->tables = calloc(1, sizeof *s->tables);
        if (!s->tables)
            return ng_out_of_memory(s->type->name);
        decode_srgb(s->tables->srgb);
    }
    ng_result r = s->type->prepare(s);
    if (r != NG_OK)
        s->tables->dark = true;
    return r;
}

void ng_light_finish(struct ng_light_source *s)
{
    if (s->tables) {
        free(s->tables->grid.rows);
        free(s->tables->grid.cells);
        free(s->tables->first);
        free(s->tables->weights);
        free(s->tables);
    }
    *s = (struct ng_light_source){0};
}

void ng_light_unit(const struct ng_light_source *s, struct ng_light_source *out)
{
    *out = *s;
    if (s->type)
        s->type->unit(out);
}

float ng_light_mean(const float rgb[3])
{
    return (rgb[0] + rgb[1] + rgb[2]) / 3.0f;
}

static bool lit(const struct ng_light_source *s)
{
    return s->type && (!s->type->prepare || (s->tables && !s->tables->dark));
}

// Zero times anything finite is zero; of the rest it is NaN. One comparison instead of three.
static float zeros(const float v[3])
{
    return v[0] * 0 + v[1] * 0 + v[2] * 0;
}

static bool finite3(const float v[3])
{
    return zeros(v) == 0;
}

void ng_light_power_rgb(const struct ng_light_source *s, float rgb[3])
{
    if (!lit(s) || !s->type->power(s, rgb) || !finite3(rgb))
        memset(rgb, 0, 3 * sizeof(float));
}

float ng_light_power(const struct ng_light_source *s)
{
    float rgb[3];
    ng_light_power_rgb(s, rgb);
    return ng_light_mean(rgb);
}

static bool valid(const struct ng_light_sample *p)
{
    return p->pdf > 0 &&
           p->pdf * 0 + zeros(p->radiance) + zeros(p->position) + zeros(p->normal) + zeros(p->power) == 0;
}

void ng_light_sample_at(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    memset(out, 0, sizeof *out);
    if (!lit(s) || !s->type->sample(s, u, out) || !valid(out)) {
        *out = (struct ng_light_sample){0};
        if (finite3(ng_light_origin(s)))
            memcpy(out->position, ng_light_origin(s), sizeof out->position);
    }
}

static float profile(const struct ng_light_source *s, const struct ng_light_sample *sample,
                     const float toward[3])
{
    if (s->type->profile)
        return s->type->profile(s, sample, toward);
    return ng_light_dot(sample->normal, toward) > 0 ? 1.0f : 0.0f;
}

void ng_light_incident_at(const struct ng_light_source *s, const struct ng_light_sample *sample,
                          const float receiver[3], struct ng_light_incident *out)
{
    *out = (struct ng_light_incident){0};
    if (!(sample->pdf > 0))
        return;
    if (s->type->infinite) {
        ng_light_scaled(sample->normal, -1.0f, out->direction);
        out->distance = INFINITY;
        out->pdf = s->type->delta ? 0 : sample->pdf;
        ng_light_scaled(sample->radiance, 1.0f / sample->pdf, out->irradiance);
        return;
    }
    float way[3], toward[3];
    ng_light_mad(sample->position, receiver, -1.0f, way);
    float square = ng_light_dot(way, way);
    if (!(square > 0) || !isfinite(square))
        return;
    out->distance = sqrtf(square);
    ng_light_scaled(way, 1.0f / out->distance, out->direction);
    ng_light_scaled(out->direction, -1.0f, toward);
    float cosine = s->type->delta ? 1.0f : ng_light_dot(sample->normal, toward);
    if (cosine <= 0)
        return;
    float density = sample->pdf * square / cosine;
    out->pdf = s->type->delta ? 0 : density;
    ng_light_scaled(sample->radiance, profile(s, sample, toward) / density, out->irradiance);
}

bool ng_light_sample_of_hit(const struct ng_light_source *s, const struct ng_light_hit *hit,
                            struct ng_light_sample *out)
{
    memset(out, 0, sizeof *out);
    return lit(s) && s->type->at_hit && s->type->at_hit(s, hit, out) && valid(out);
}

float ng_light_pdf_at(const struct ng_light_source *s, const struct ng_light_hit *hit)
{
    struct ng_light_sample sample;
    if (!ng_light_sample_of_hit(s, hit, &sample))
        return 0;
    if (s->type->infinite)
        return sample.pdf;
    float cosine = -ng_light_dot(sample.normal, hit->direction);
    return cosine > 0 ? sample.pdf * hit->distance * hit->distance / cosine : 0;
}

void ng_light_seen_at(const struct ng_light_source *s, const struct ng_light_hit *hit, float rgb[3])
{
    struct ng_light_sample sample;
    memset(rgb, 0, 3 * sizeof(float));
    if (!ng_light_sample_of_hit(s, hit, &sample))
        return;
    float toward[3];
    ng_light_scaled(hit->direction, -1.0f, toward);
    ng_light_scaled(sample.radiance, profile(s, &sample, toward), rgb);
}

void ng_light_up(const struct ng_light_source *s, const float direction[3], float out[3])
{
    static const float axes[2][3] = {{0, 1, 0}, {1, 0, 0}};
    memcpy(out, &s->matrix[4], 3 * sizeof(float));
    ng_light_normalize(out, axes[0]);
    for (int i = 0; i < 2; i++) {
        ng_light_mad(out, direction, -ng_light_dot(out, direction), out);
        if (ng_light_length(out) > 1e-3f)
            break;
        memcpy(out, axes[fabsf(direction[1]) > 0.9f], 3 * sizeof(float));
    }
    ng_light_normalize(out, axes[0]);
}

void ng_light_cone(const struct ng_light_source *s, float *scale, float *offset)
{
    *scale = 0;
    *offset = 1;
    if (lit(s) && s->type->cone)
        s->type->cone(s, scale, offset);
}

void ng_light_proxy_of(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    *out = (struct ng_light_proxy){0};
    if (lit(s) && s->type->proxy(s, out) && finite3(out->position) && finite3(out->direction))
        return;
    *out = (struct ng_light_proxy){.direction = {0, 0, -1}, .up = {0, 1, 0}, .views = NG_VIEWS_CUBE};
    if (finite3(ng_light_origin(s)))
        memcpy(out->position, ng_light_origin(s), sizeof out->position);
}

// Sobol' dimensions 1 and 2 (van der Corput, and the primitive polynomial x + 1), shifted by a fixed pattern
// of bits so that no point lies on the square's edge while every elementary interval keeps its points.
void ng_light_vpl_point(uint32_t i, float u[2])
{
    uint32_t x = 0, y = 0;
    for (uint32_t bit = 0, direction = 1u << 31; bit < 32; bit++, direction ^= direction >> 1)
        if (i >> bit & 1u) {
            x |= 1u << (31 - bit);
            y ^= direction;
        }
    u[0] = ((float)((x ^ 0x5bd1e995u) >> 9) + 0.5f) * 0x1p-23f;
    u[1] = ((float)((y ^ 0x9e3779b9u) >> 9) + 0.5f) * 0x1p-23f;
}

void ng_light_vpls(const struct ng_light_source *s, uint32_t count, struct ng_light_sample *out)
{
    for (uint32_t i = 0; i < count; i++) {
        float u[2];
        ng_light_vpl_point(i, u);
        ng_light_sample_at(s, u, &out[i]);
    }
}

void ng_light_irradiance(const struct ng_light_source *s, uint32_t count, const float position[3],
                         const float normal[3], float rgb[3])
{
    double sum[3] = {0};
    for (uint32_t i = 0; i < count; i++) {
        float u[2];
        struct ng_light_sample sample;
        struct ng_light_incident incident;
        ng_light_vpl_point(i, u);
        ng_light_sample_at(s, u, &sample);
        ng_light_incident_at(s, &sample, position, &incident);
        float cosine = fmaxf(ng_light_dot(normal, incident.direction), 0);
        for (int c = 0; c < 3; c++)
            sum[c] += (double)(incident.irradiance[c] * cosine);
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = count ? (float)(sum[c] / count) : 0;
}
