// Parallel light from infinitely far. Its power is what falls on the disk of the scene's sphere.
#include "components/components.h"
#include "components/light_directional.h"
#include "light/light_internal.h"

static bool irradiance(const struct ng_light_source *s, float rgb[3])
{
    const struct ng_light_directional *p = (const void *)s->params;
    return p->on && ng_light_color(p->color, p->irradiance, rgb);
}

static bool power(const struct ng_light_source *s, float rgb[3])
{
    bool ok = irradiance(s, rgb);
    ng_light_scaled(rgb, NG_PI * s->scene_radius * s->scene_radius, rgb);
    return ok;
}

static bool sample(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    NG_UNUSED(u);
    ng_light_axis(s, out->normal);
    ng_light_mad(s->scene_center, out->normal, -2 * s->scene_radius, out->position);
    out->pdf = 1;
    return irradiance(s, out->radiance) && power(s, out->power);
}

static float profile(const struct ng_light_source *s, const struct ng_light_sample *from,
                     const float toward[3])
{
    NG_UNUSED(s), NG_UNUSED(from), NG_UNUSED(toward);
    return 1;
}

static bool proxy(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    ng_light_axis(s, out->direction);
    ng_light_up(s, out->direction, out->up);
    ng_light_mad(s->scene_center, out->direction, -s->scene_radius, out->position);
    out->views = NG_VIEWS_SINGLE_ORTHOGRAPHIC;
    out->extent = s->scene_radius;
    return true;
}

static void unit(struct ng_light_source *s)
{
    struct ng_light_directional *p = (void *)s->params;
    p->on = true;
    p->irradiance = 1;
}

const struct ng_light_type ng_light_directional_type = {
    .name = "directional",
    .component = NG_LIGHT_DIRECTIONAL,
    .delta = true,
    .infinite = true,
    .power = power,
    .sample = sample,
    .unit = unit,
    .profile = profile,
    .proxy = proxy,
};
