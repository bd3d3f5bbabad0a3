// Uniform rectangles, disks and spheres are known by the surface that their type shows; what else has extent
// is its direct VPLs.
#include "lightformer/encode/clues_internal.h"

#include "lightformer/trace/vec.h"

#include <string.h>

#define DISK_SAMPLES 32

// Nodes and weights of the Gauss-Legendre rule of four points on [-1, 1].
#define RULE 4
static const float rule[RULE][2] = {{-0.861136312f, 0.347854845f},
                                    {-0.339981044f, 0.652145155f},
                                    {0.339981044f, 0.652145155f},
                                    {0.861136312f, 0.347854845f}};

// Half axes of a unit rectangle, or radii of a unit disk, and what maps points to coordinates along them.
// False where they span no plane.
static bool set_plane(const struct ng_light_surface *surface, const struct lf_space *space,
                      struct lf_light_shape *out)
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
    out->emitter = disk ? LF_EMITTER_DISK : LF_EMITTER_RECTANGLE;
    out->area = (disk ? NG_PI : 4) * sqrtf(lf_dot(cross, cross));
    return true;
}

// Whether the light is a uniform surface with a closed form; fills what follows from it.
static bool set_surface(const struct lf_light_clues *light, struct lf_light_shape *out)
{
    const struct ng_light_source *s = &light->unit;
    struct ng_light_surface surface;
    if (!s->type->surface || s->image.width)
        return false;
    s->type->surface(s, &surface);
    lf_to_scene(&light->space, &surface.matrix[12], out->center);
    for (int c = 0; c < 3; c++)
        out->radiance[c] = surface.radiance[c] / light->phi * light->space.radius * light->space.radius;
    switch (surface.shape) {
    case NG_LIGHT_SHAPE_RECTANGLE:
    case NG_LIGHT_SHAPE_DISK:
        return set_plane(&surface, &light->space, out);
    case NG_LIGHT_SHAPE_SPHERE:
        out->emitter = LF_EMITTER_SPHERE;
        out->radius = surface.matrix[0] / light->space.radius;
        return true;
    case NG_LIGHT_SHAPE_MESH:
        break;
    }
    return false;
}

static void add_sample(const struct lf_light_clues *light, const struct ng_light_sample *from, uint32_t count,
                       struct lf_light_shape *out)
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

// `x`, `y`: half axes.
static void add_rule(const struct lf_light_clues *light, const float normal[3], struct lf_light_shape *out)
{
    struct ng_light_surface surface;
    light->unit.type->surface(&light->unit, &surface);
    float scale = 1 / light->space.radius;
    for (int i = 0; i < RULE * RULE; i++) {
        const float *a = rule[i % RULE], *b = rule[i / RULE];
        struct lf_light_sample *to = &out->samples[out->sample_count++];
        lf_mad(out->center, &surface.matrix[0], 0.5f * a[0] * scale, to->position);
        lf_mad(to->position, &surface.matrix[4], 0.5f * b[0] * scale, to->position);
        memcpy(to->normal, normal, sizeof to->normal);
        lf_scale(out->radiance, out->area * a[1] * b[1] / 4, to->weight);
        to->density = RULE * RULE / out->area;
    }
}

void lf_shape_make(struct lf_light_clues *light)
{
    const struct ng_light_type *type = light->unit.type;
    struct lf_light_shape *out = &light->shape;
    struct ng_light_sample samples[LF_LIGHT_SAMPLES];
    *out = (struct lf_light_shape){0};
    light->lobes_by_hand = false;
    if (!(light->phi > 0))
        return; // dark, but not by its brightness: no samples
    bool closed = !type->delta && set_surface(light, out);
    if (!closed)
        out->emitter = type->infinite ? LF_EMITTER_DIRECTION
                       : type->delta  ? LF_EMITTER_POINT
                                      : LF_EMITTER_SURFACE;
    light->lobes_by_hand = !closed && !type->delta;
    ng_light_cone(&light->unit, &out->cone_scale, &out->cone_offset);
    if (out->emitter == LF_EMITTER_SPHERE)
        return;
    uint32_t count = type->delta ? 1 : closed ? DISK_SAMPLES : LF_LIGHT_SAMPLES;
    ng_light_vpls(&light->unit, count, samples);
    memcpy(out->normal, samples[0].normal, sizeof out->normal);
    if (out->emitter == LF_EMITTER_RECTANGLE)
        add_rule(light, samples[0].normal, out);
    for (uint32_t i = 0; i < count && out->emitter != LF_EMITTER_RECTANGLE; i++)
        add_sample(light, &samples[i], count, out);
}
