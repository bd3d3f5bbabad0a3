// Uniform rectangles, disks and spheres are known by the surface that their type shows; what else has extent
// is its direct VPLs.
#include "lightformer/clues/clues_internal.h"

#include "lightformer/trace/vec.h"

#include <string.h>

#define DISK_SAMPLES 32

// Nodes and weights of the Gauss-Legendre rules of 1, 2, 4, 8 and 16 points on [-1, 1], one after another.
#define RULE_SAMPLES 16
#define FAR_SAMPLES  4
static const float rules[][2] = {
    {0, 2},
    {-0.577350269f, 1.000000000f},
    {0.577350269f, 1.000000000f},
    {-0.861136312f, 0.347854845f},
    {-0.339981044f, 0.652145155f},
    {0.339981044f, 0.652145155f},
    {0.861136312f, 0.347854845f},
    {-0.960289856f, 0.101228536f},
    {-0.796666477f, 0.222381034f},
    {-0.525532410f, 0.313706646f},
    {-0.183434642f, 0.362683783f},
    {0.183434642f, 0.362683783f},
    {0.525532410f, 0.313706646f},
    {0.796666477f, 0.222381034f},
    {0.960289856f, 0.101228536f},
    {-0.989400935f, 0.027152459f},
    {-0.944575023f, 0.062253524f},
    {-0.865631202f, 0.095158512f},
    {-0.755404408f, 0.124628971f},
    {-0.617876244f, 0.149595989f},
    {-0.458016778f, 0.169156519f},
    {-0.281603551f, 0.182603415f},
    {-0.095012510f, 0.189450610f},
    {0.095012510f, 0.189450610f},
    {0.281603551f, 0.182603415f},
    {0.458016778f, 0.169156519f},
    {0.617876244f, 0.149595989f},
    {0.755404408f, 0.124628971f},
    {0.865631202f, 0.095158512f},
    {0.944575023f, 0.062253524f},
    {0.989400935f, 0.027152459f},
};

// Of `count` points, a power of two.
static const float (*rule_of(uint32_t count))[2]
{
    return rules + count - 1;
}

// Half axes of a unit rectangle, or radii of a unit disk, and what maps points to coordinates along them.
// False where they span no plane.
static bool set_plane(const struct ng_light_surface *surface, const struct lf_space *space,
                      struct lf_emitter *out)
{
    bool disk = surface->shape == NG_LIGHT_SHAPE_DISK;
    float x[3], y[3], cross[3], scale = (disk ? 1 : 0.5f) / space->radius;
    lf_scale(&surface->matrix[0], scale, x);
    lf_scale(&surface->matrix[4], scale, y);
    lf_cross(x, y, cross);
    float xx = lf_dot(x, x), xy = lf_dot(x, y), yy = lf_dot(y, y), determinant = xx * yy - xy * xy;
    if (!(determinant > 0) || !isfinite(1 / determinant))
        return false;
    for (int c = 0; c < 3; c++) {
        out->u[c] = (yy * x[c] - xy * y[c]) / determinant;
        out->v[c] = (xx * y[c] - xy * x[c]) / determinant;
    }
    out->kind = disk ? LF_EMITTER_DISK : LF_EMITTER_RECTANGLE;
    out->area = (disk ? NG_PI : 4) * sqrtf(lf_dot(cross, cross));
    out->coarseness = sqrtf(fmaxf(xx, yy)); // of a disk
    out->radius = disk ? out->coarseness : sqrtf(xx + yy + 2 * fabsf(xy));
    return true;
}

// Whether the light is a uniform surface with a closed form; fills what follows from it.
static bool set_surface(const struct lf_light_clues *light, struct lf_emitter *out)
{
    const struct ng_light_source *s = &light->unit;
    struct ng_light_surface surface;
    if (!s->type->surface || s->image.width)
        return false;
    s->type->surface(s, &surface);
    if (surface.shape == NG_LIGHT_SHAPE_MESH)
        return false; // it says no more of itself
    lf_to_scene(&light->space, &surface.matrix[12], out->center);
    for (int c = 0; c < 3; c++)
        out->radiance[c] = surface.radiance[c] / light->phi * light->space.radius * light->space.radius;
    switch (surface.shape) {
    case NG_LIGHT_SHAPE_RECTANGLE:
    case NG_LIGHT_SHAPE_DISK:
        return set_plane(&surface, &light->space, out);
    case NG_LIGHT_SHAPE_SPHERE:
        out->kind = LF_EMITTER_SPHERE;
        out->radius = surface.matrix[0] / light->space.radius;
        return true;
    case NG_LIGHT_SHAPE_MESH:
        break;
    }
    return false;
}

static void add_sample(const struct lf_light_clues *light, const struct ng_light_sample *from, uint32_t count,
                       struct lf_emitter *out)
{
    if (!(from->pdf > 0))
        return;
    const struct ng_light_type *type = light->unit.type;
    float square = light->space.radius * light->space.radius;
    struct lf_light_sample *to = &out->samples[out->sample_count++];
    lf_to_scene(&light->space, from->position, to->position);
    memcpy(to->normal, from->normal, sizeof to->normal);
    lf_scale(from->radiance, (type->infinite ? square : 1) / (from->pdf * (float)count * light->phi),
             to->weight);
    to->density = type->delta ? 0 : from->pdf * (float)count * (type->infinite ? 1 : square);
}

static void bound_samples(struct lf_emitter *out)
{
    float least = INFINITY, offset[3];
    for (uint32_t i = 0; i < out->sample_count; i++) {
        lf_mad(out->center, out->samples[i].position, 1 / (float)out->sample_count, out->center);
        least = fminf(least, out->samples[i].density);
    }
    for (uint32_t i = 0; i < out->sample_count; i++) {
        lf_mad(out->samples[i].position, out->center, -1, offset);
        out->radius = fmaxf(out->radius, sqrtf(lf_dot(offset, offset)));
    }
    out->coarseness = least > 0 ? 2 / sqrtf(least) : 0;
}

// How many of `count` samples the first side has: so many that the spaces between them are as alike as may
// be.
static uint32_t choose_rule(float width, float height, float count)
{
    float columns = sqrtf(count), rows = columns;
    for (; rows > 1 && width * rows > 2 * height * columns; rows /= 2)
        columns *= 2;
    for (; columns > 1 && height * columns > 2 * width * rows; columns /= 2)
        rows *= 2;
    return (uint32_t)columns;
}

// Gauss points of a rectangle. `count`: 4 or 16.
static void add_rule(const struct lf_light_clues *light, const float normal[3], uint32_t count,
                     struct lf_emitter *out)
{
    struct ng_light_surface surface;
    light->unit.type->surface(&light->unit, &surface);
    const float *side[2] = {&surface.matrix[0], &surface.matrix[4]};
    float scale = 1 / light->space.radius, half[2];
    for (int i = 0; i < 2; i++)
        half[i] = 0.5f * sqrtf(lf_dot(side[i], side[i])) * scale;
    uint32_t columns = choose_rule(half[0], half[1], (float)count), rows = count / columns;
    out->coarseness = 4 * fmaxf(half[0] / (float)columns, half[1] / (float)rows);
    out->sample_count = count;
    for (uint32_t i = 0; i < count; i++) {
        const float *a = rule_of(columns)[i % columns], *b = rule_of(rows)[i / columns];
        struct lf_light_sample *to = &out->samples[i];
        lf_mad(out->center, side[0], 0.5f * a[0] * scale, to->position);
        lf_mad(to->position, side[1], 0.5f * b[0] * scale, to->position);
        memcpy(to->normal, normal, sizeof to->normal);
        lf_scale(out->radiance, out->area * a[1] * b[1] / 4, to->weight);
        to->density = (float)count / out->area;
    }
}

// Four points of a disk, exact for cubic polynomials as those of a rectangle are.
static void add_disk_rule(const struct lf_light_clues *light, const float normal[3], struct lf_emitter *out)
{
    struct ng_light_surface surface;
    light->unit.type->surface(&light->unit, &surface);
    float along = 0.5f / light->space.radius; // both ways, at sqrt(1/2) of the radius
    out->sample_count = FAR_SAMPLES;
    for (uint32_t i = 0; i < FAR_SAMPLES; i++) {
        struct lf_light_sample *to = &out->samples[i];
        lf_mad(out->center, &surface.matrix[0], i % 2 ? along : -along, to->position);
        lf_mad(to->position, &surface.matrix[4], i / 2 ? along : -along, to->position);
        memcpy(to->normal, normal, sizeof to->normal);
        lf_scale(out->radiance, out->area / FAR_SAMPLES, to->weight);
        to->density = FAR_SAMPLES / out->area;
    }
}

static void make_far(struct lf_light_clues *light)
{
    struct lf_emitter *out = &light->far_emitter;
    *out = light->emitter;
    if (out->kind == LF_EMITTER_RECTANGLE)
        add_rule(light, out->normal, FAR_SAMPLES, out);
    else if (out->kind == LF_EMITTER_DISK)
        add_disk_rule(light, out->normal, out);
}

void lf_emitter_make(struct lf_light_clues *light)
{
    const struct ng_light_type *type = light->unit.type;
    struct lf_emitter *out = &light->emitter;
    struct ng_light_sample samples[LF_LIGHT_SAMPLES];
    *out = (struct lf_emitter){.skin = light->skin / light->space.radius};
    light->far_emitter = *out;
    light->needs_brdf_rays = false;
    if (!(light->phi > 0))
        return; // dark, but not by its brightness: no samples
    bool closed = !type->delta && set_surface(light, out);
    if (!closed)
        out->kind = type->infinite ? LF_EMITTER_DIRECTION
                    : type->delta  ? LF_EMITTER_POINT
                                   : LF_EMITTER_SURFACE;
    light->needs_brdf_rays = !closed && !type->delta;
    ng_light_cone(&light->unit, &out->cone_scale, &out->cone_offset);
    if (out->kind == LF_EMITTER_SPHERE)
        return;
    uint32_t count = type->delta ? 1 : closed ? DISK_SAMPLES : LF_LIGHT_SAMPLES;
    ng_light_vpls(&light->unit, count, samples);
    memcpy(out->normal, samples[0].normal, sizeof out->normal);
    if (out->kind == LF_EMITTER_RECTANGLE)
        add_rule(light, samples[0].normal, RULE_SAMPLES, out);
    for (uint32_t i = 0; i < count && out->kind != LF_EMITTER_RECTANGLE; i++)
        add_sample(light, &samples[i], count, out);
    if (out->kind == LF_EMITTER_SURFACE)
        bound_samples(out);
    make_far(light);
}
