// A sphere of uniform radiance, sampled by area. Its scale is the placement's largest axis.
#include "components/components.h"
#include "components/light_sphere.h"
#include "light/light_internal.h"
#include "light/unit_shape.h"

static bool radiance(const struct ng_light_source *s, float rgb[3])
{
    const struct ng_light_sphere *p = (const void *)s->params;
    return p->on && ng_light_color(p->color, p->radiance, rgb);
}

static bool radius_of(const struct ng_light_source *s, float *out)
{
    const struct ng_light_sphere *p = (const void *)s->params;
    float scale = 0;
    for (int i = 0; i < 3; i++)
        scale = fmaxf(scale, ng_light_length(&s->matrix[4 * i]));
    *out = p->radius * scale;
    return *out > 0 && isfinite(*out);
}

static bool power(const struct ng_light_source *s, float rgb[3])
{
    float r;
    if (!radiance(s, rgb) || !radius_of(s, &r))
        return false;
    ng_light_scaled(rgb, NG_PI * 4 * NG_PI * r * r, rgb);
    return true;
}

static bool sample(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    float r;
    if (!radius_of(s, &r))
        return false;
    ng_light_on_sphere(u[0], u[1], &out->normal[0], &out->normal[1], &out->normal[2]);
    ng_light_mad(ng_light_origin(s), out->normal, r, out->position);
    out->pdf = 1 / (4 * NG_PI * r * r);
    return radiance(s, out->radiance) && power(s, out->power);
}

static bool at_hit(const struct ng_light_source *s, const struct ng_light_hit *hit,
                   struct ng_light_sample *out)
{
    float r;
    if (!radius_of(s, &r))
        return false;
    memcpy(out->position, hit->position, sizeof out->position);
    ng_light_mad(hit->position, ng_light_origin(s), -1.0f, out->normal);
    out->pdf = 1 / (4 * NG_PI * r * r);
    return ng_light_normalize(out->normal, out->normal) && radiance(s, out->radiance) && power(s, out->power);
}

// At the centre: the sphere itself is excluded from what its light observes.
static bool proxy(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    memcpy(out->position, ng_light_origin(s), sizeof out->position);
    ng_light_axis(s, out->direction);
    ng_light_up(s, out->direction, out->up);
    out->views = NG_VIEWS_CUBE;
    return true;
}

static void surface(const struct ng_light_source *s, struct ng_light_surface *out)
{
    const struct ng_light_sphere *p = (const void *)s->params;
    float r = 0;
    if (!radius_of(s, &r))
        r = 0;
    out->shape = NG_LIGHT_SHAPE_SPHERE;
    memcpy(out->matrix, s->matrix, sizeof out->matrix);
    for (int i = 0; i < 12; i++)
        out->matrix[i] = i % 5 ? 0 : r;
    memcpy(out->albedo, p->albedo, sizeof out->albedo);
    if (!radiance(s, out->radiance))
        memset(out->radiance, 0, sizeof out->radiance);
}

static void unit(struct ng_light_source *s)
{
    struct ng_light_sphere *p = (void *)s->params;
    p->on = true;
    p->radiance = 1;
}

const struct ng_light_type ng_light_sphere_type = {
    .name = "sphere",
    .component = NG_LIGHT_SPHERE,
    .power = power,
    .sample = sample,
    .unit = unit,
    .at_hit = at_hit,
    .proxy = proxy,
    .surface = surface,
};
