// A surface of few triangles is taken as it is; a textured one is cut, so that facets know bright from dark.
// Of one with more triangles facets are samples. A ball is known by its own closed form.
#include "render/light_facets.h"

#include <cglm/cglm.h>
#include <string.h>

#define DISK_CORNERS   16
#define DISK_SCALE     1.01300f // the polygon has the disk's area
#define TEXTURE_CUTS   8u
#define MOST_TRIANGLES 128u // each costs as much as a VPL does
#define LEAST_PATCHES  32u
#define MOST_MISSED    0.1f // of the power

// Base triangles of the surface, each cut into cuts x cuts facets.
struct surface {
    const struct ng_light_source *source;
    struct ng_light_surface shape;
    uint32_t triangles, cuts;
    bool textured;
};

static bool is_textured(const struct ng_light_source *s)
{
    return s->image.width && (!s->type->emissive_mesh || s->triangle_uvs);
}

static uint32_t triangles_of(const struct ng_light_source *s, enum ng_light_shape shape)
{
    switch (shape) {
    case NG_LIGHT_SHAPE_RECTANGLE:
        return 2;
    case NG_LIGHT_SHAPE_DISK:
        return DISK_CORNERS;
    case NG_LIGHT_SHAPE_SPHERE:
        return 0;
    case NG_LIGHT_SHAPE_MESH:
        break;
    }
    return s->triangles ? s->triangle_count : 0;
}

// The corners of a base triangle in the shape's own space; of a mesh in the world.
static void base_triangle(const struct surface *s, uint32_t i, vec3 out[3])
{
    static const float square[4][2] = {{-0.5f, -0.5f}, {0.5f, -0.5f}, {0.5f, 0.5f}, {-0.5f, 0.5f}};
    memset(out, 0, 3 * sizeof *out);
    switch (s->shape.shape) {
    case NG_LIGHT_SHAPE_RECTANGLE:
        for (uint32_t k = 0; k < 3; k++)
            memcpy(out[k], square[k ? k + i : 0], sizeof square[0]);
        break;
    case NG_LIGHT_SHAPE_DISK:
        for (uint32_t k = 1; k < 3; k++) {
            float angle = 2 * NG_PI * (float)(i + k) / DISK_CORNERS;
            out[k][0] = DISK_SCALE * cosf(angle);
            out[k][1] = DISK_SCALE * sinf(angle);
        }
        break;
    case NG_LIGHT_SHAPE_SPHERE:
        break;
    case NG_LIGHT_SHAPE_MESH:
        memcpy(out, s->source->triangles + (size_t)i * 9, 3 * sizeof *out);
        break;
    }
}

// Weights of the base triangle's corners 1 and 2 at the corners of facet `k`. Row r has 2 r + 1 facets,
// alternately upright and upside down.
static void cut(uint32_t k, uint32_t cuts, float out[3][2])
{
    uint32_t row = 0;
    while ((row + 1) * (row + 1) <= k)
        row++;
    uint32_t i = k - row * row, j = i / 2;
    bool upright = i % 2 == 0;
    const uint32_t down[3] = {row, row + 1, upright ? row + 1 : row},
                   along[3] = {j, upright ? j : j + 1, j + 1};
    for (int c = 0; c < 3; c++) {
        out[c][0] = (float)(down[c] - along[c]) / (float)cuts;
        out[c][1] = (float)along[c] / (float)cuts;
    }
}

static void place(const struct surface *s, vec3 base[3], const float weights[2], float out[3])
{
    const float *m = s->shape.matrix;
    vec3 p;
    for (int a = 0; a < 3; a++)
        p[a] = base[0][a] * (1 - weights[0] - weights[1]) + base[1][a] * weights[0] + base[2][a] * weights[1];
    for (int a = 0; a < 3; a++)
        out[a] = s->shape.shape == NG_LIGHT_SHAPE_MESH
                     ? p[a]
                     : m[a] * p[0] + m[4 + a] * p[1] + m[8 + a] * p[2] + m[12 + a];
}

static void swap3(float a[3], float b[3])
{
    float t[3];
    memcpy(t, a, sizeof t);
    memcpy(a, b, sizeof t);
    memcpy(b, t, sizeof t);
}

// Along the triangle's normal, twice as long as its area.
static void normal_of(const struct ng_facet_data *f, float out[3])
{
    vec3 a, b;
    glm_vec3_sub((float *)f->corners[1], (float *)f->corners[0], a);
    glm_vec3_sub((float *)f->corners[2], (float *)f->corners[0], b);
    glm_vec3_cross(a, b, out);
}

// What the light says of a facet: the mean of its radiance over a few points, and which side shines.
static void ask_light(const struct surface *s, uint32_t triangle, vec3 base[3], const float weights[3][2],
                      struct ng_facet_data *out)
{
    static const float points[4][3] = {{1 / 3.f, 1 / 3.f, 1 / 3.f},
                                       {2 / 3.f, 1 / 6.f, 1 / 6.f},
                                       {1 / 6.f, 2 / 3.f, 1 / 6.f},
                                       {1 / 6.f, 1 / 6.f, 2 / 3.f}};
    uint32_t count = s->textured ? NG_COUNT(points) : 1;
    float normal[3];
    normal_of(out, normal);
    glm_vec3_zero(out->radiance);
    for (uint32_t i = 0; i < count; i++) {
        struct ng_light_hit hit = {.triangle = triangle};
        struct ng_light_sample sample;
        for (int a = 0; a < 2; a++)
            for (int c = 0; c < 3; c++)
                hit.barycentric[a] += points[i][c] * weights[c][a];
        place(s, base, hit.barycentric, hit.position);
        if (!ng_light_sample_of_hit(s->source, &hit, &sample))
            continue;
        glm_vec3_muladds(sample.radiance, 1.0f / (float)count, out->radiance);
        if (glm_vec3_dot(sample.normal, normal) < 0) {
            swap3(out->corners[1], out->corners[2]);
            glm_vec3_negate(normal);
        }
    }
}

static void take_surface(const struct surface *s, struct ng_light_facets *out)
{
    for (uint32_t i = 0; i < s->triangles; i++) {
        vec3 base[3];
        base_triangle(s, i, base);
        for (uint32_t k = 0; k < s->cuts * s->cuts; k++) {
            struct ng_facet_data *f = &out->facets[out->count];
            float weights[3][2];
            cut(k, s->cuts, weights);
            for (int c = 0; c < 3; c++)
                place(s, base, weights[c], f->corners[c]);
            ask_light(s, i, base, weights, f);
            out->count += ng_light_mean(f->radiance) > 0;
        }
    }
}

// Of both sides of a surface.
static void take_samples(const struct ng_light_source *s, uint32_t count, struct ng_light_facets *out)
{
    out->kind = NG_FACETS_PATCHES;
    out->count = 0;
    for (uint32_t i = 0; i < count; i++) {
        struct ng_facet_data *f = &out->facets[out->count];
        struct ng_light_sample sample;
        float u[2];
        ng_light_vpl_point(i, u);
        ng_light_sample_at(s, u, &sample);
        if (!(sample.pdf > 0))
            continue;
        *f = (struct ng_facet_data){.corners[2] = {1 / (sample.pdf * (float)count)}};
        memcpy(f->corners[0], sample.position, sizeof sample.position);
        memcpy(f->corners[1], sample.normal, sizeof sample.normal);
        memcpy(f->radiance, sample.radiance, sizeof sample.radiance);
        out->count++;
    }
}

static float area_of(uint32_t kind, const struct ng_facet_data *f)
{
    float normal[3];
    if (kind == NG_FACETS_BALL)
        return 4 * NG_PI * f->corners[1][0] * f->corners[1][0];
    if (kind == NG_FACETS_PATCHES)
        return f->corners[2][0];
    normal_of(f, normal);
    return 0.5f * glm_vec3_norm(normal) * (kind == NG_FACETS_TWO_SIDED ? 2 : 1);
}

// The light's power over that of its facets: what is cut or sampled knows radiances by points.
static float power_ratio(const struct ng_light_source *s, const struct ng_light_facets *f)
{
    double sum = 0;
    for (uint32_t i = 0; i < f->count; i++)
        sum += (double)area_of(f->kind, &f->facets[i]) * (double)ng_light_mean(f->facets[i].radiance);
    return (float)((double)ng_light_power(s) / ((double)NG_PI * sum));
}

// All together they give the light's power.
static void normalize(const struct ng_light_source *s, struct ng_light_facets *out)
{
    float scale = power_ratio(s, out);
    if (!(scale > 0) || !isfinite(scale))
        out->count = 0;
    for (uint32_t i = 0; i < out->count; i++)
        glm_vec3_scale(out->facets[i].radiance, scale, out->facets[i].radiance);
}

static void take_ball(const struct ng_light_surface *shape, struct ng_light_facets *out)
{
    struct ng_facet_data *f = &out->facets[out->count++];
    *f = (struct ng_facet_data){.corners[1] = {shape->matrix[0]}};
    memcpy(f->corners[0], &shape->matrix[12], sizeof f->corners[0]);
    memcpy(f->radiance, shape->radiance, sizeof f->radiance);
}

static uint32_t cuts_of(const struct surface *s, uint32_t most)
{
    uint32_t cuts = s->textured ? TEXTURE_CUTS : 1;
    while (cuts && s->triangles > most / (cuts * cuts))
        cuts--;
    return cuts;
}

void ng_light_facets_of(const struct ng_light_source *source, uint32_t most, struct ng_light_facets *out)
{
    struct surface s = {.source = source};
    out->kind = NG_FACETS_ONE_SIDED;
    out->count = 0;
    out->facets[0] = (struct ng_facet_data){0};
    if (!source->type->surface)
        return;
    source->type->surface(source, &s.shape);
    s.triangles = triangles_of(source, s.shape.shape);
    s.textured = is_textured(source);
    most = most < NG_LIGHT_FACETS ? most : NG_LIGHT_FACETS;
    s.cuts = cuts_of(&s, most < MOST_TRIANGLES ? most : MOST_TRIANGLES);
    if (s.shape.shape == NG_LIGHT_SHAPE_SPHERE && most) {
        out->kind = NG_FACETS_BALL;
        take_ball(&s.shape, out);
    } else if (s.cuts) {
        out->kind = source->double_sided ? NG_FACETS_TWO_SIDED : NG_FACETS_ONE_SIDED;
        take_surface(&s, out);
    }
    // Small bright spots fall between the points of a cut surface; samples find them.
    bool found = out->count && fabsf(power_ratio(source, out) - 1) < MOST_MISSED;
    if (!found && most >= LEAST_PATCHES)
        take_samples(source, most, out);
    normalize(source, out);
}
