// A disk (an ellipse under non-uniform scale) of uniform radiance, sampled by area.
#include "components/components.h"
#include "components/light_disk.h"
#include "light/light_internal.h"
#include "light/unit_shape.h"

static bool radiance(const struct ng_light_source *s, float rgb[3])
{
    const struct ng_light_disk *p = (const void *)s->params;
    return p->on && ng_light_color(p->color, p->radiance, rgb);
}

// The plane in which the disk has radius 1; its area becomes the disk's.
static bool plane_of(const struct ng_light_source *s, struct ng_light_plane *out)
{
    const struct ng_light_disk *p = (const void *)s->params;
    bool ok = ng_light_plane_make(s, p->radius, p->radius, out);
    out->area *= NG_PI;
    return ok;
}

static bool power(const struct ng_light_source *s, float rgb[3])
{
    struct ng_light_plane plane;
    if (!radiance(s, rgb) || !plane_of(s, &plane))
        return false;
    ng_light_scaled(rgb, NG_PI * plane.area, rgb);
    return true;
}

static bool emit(const struct ng_light_source *s, const struct ng_light_plane *plane,
                 struct ng_light_sample *out)
{
    memcpy(out->normal, plane->normal, sizeof out->normal);
    out->pdf = 1 / plane->area;
    return radiance(s, out->radiance) && power(s, out->power);
}

static bool sample(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    struct ng_light_plane plane;
    float place[2];
    if (!plane_of(s, &plane))
        return false;
    ng_light_on_disk(u[0], u[1], &place[0], &place[1]);
    ng_light_mad(ng_light_origin(s), plane.x, place[0], out->position);
    ng_light_mad(out->position, plane.y, place[1], out->position);
    return emit(s, &plane, out);
}

static bool at_hit(const struct ng_light_source *s, const struct ng_light_hit *hit,
                   struct ng_light_sample *out)
{
    struct ng_light_plane plane;
    memcpy(out->position, hit->position, sizeof out->position);
    return plane_of(s, &plane) && emit(s, &plane, out);
}

static bool proxy(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    struct ng_light_plane plane;
    if (!plane_of(s, &plane))
        return false;
    memcpy(out->direction, plane.normal, sizeof out->direction);
    ng_light_up(s, out->direction, out->up);
    memcpy(out->position, ng_light_origin(s), sizeof out->position);
    ng_light_lift(s, plane.normal, out->position);
    out->views = NG_VIEWS_CUBE;
    return true;
}

static void surface(const struct ng_light_source *s, struct ng_light_surface *out)
{
    const struct ng_light_disk *p = (const void *)s->params;
    out->shape = NG_LIGHT_SHAPE_DISK;
    memcpy(out->matrix, s->matrix, sizeof out->matrix);
    ng_light_scaled(&s->matrix[0], p->radius, &out->matrix[0]);
    ng_light_scaled(&s->matrix[4], p->radius, &out->matrix[4]);
    memcpy(out->albedo, p->albedo, sizeof out->albedo);
    if (!radiance(s, out->radiance))
        memset(out->radiance, 0, sizeof out->radiance);
}

static void unit(struct ng_light_source *s)
{
    struct ng_light_disk *p = (void *)s->params;
    p->on = true;
    p->radiance = 1;
}

const struct ng_light_type ng_light_disk_type = {
    .name = "disk",
    .component = NG_LIGHT_DISK,
    .power = power,
    .sample = sample,
    .unit = unit,
    .at_hit = at_hit,
    .proxy = proxy,
    .surface = surface,
};
