// A point: the same intensity in all directions.
#include "components/components.h"
#include "components/light_point.h"
#include "light/light_internal.h"

static bool intensity(const struct ng_light_source *s, float rgb[3])
{
    const struct ng_light_point *p = (const void *)s->params;
    return p->on && ng_light_color(p->color, p->intensity, rgb);
}

static bool power(const struct ng_light_source *s, float rgb[3])
{
    bool ok = intensity(s, rgb);
    ng_light_scaled(rgb, 4 * NG_PI, rgb);
    return ok;
}

static bool sample(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    NG_UNUSED(u);
    memcpy(out->position, ng_light_origin(s), sizeof out->position);
    out->pdf = 1;
    return intensity(s, out->radiance) && power(s, out->power);
}

static float profile(const struct ng_light_source *s, const struct ng_light_sample *from,
                     const float toward[3])
{
    NG_UNUSED(s), NG_UNUSED(from), NG_UNUSED(toward);
    return 1;
}

static bool proxy(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    memcpy(out->position, ng_light_origin(s), sizeof out->position);
    ng_light_axis(s, out->direction);
    ng_light_up(s, out->direction, out->up);
    out->views = NG_VIEWS_CUBE;
    return true;
}

static void unit(struct ng_light_source *s)
{
    struct ng_light_point *p = (void *)s->params;
    p->on = true;
    p->intensity = 1;
}

const struct ng_light_type ng_light_point_type = {
    .name = "point",
    .component = NG_LIGHT_POINT,
    .delta = true,
    .power = power,
    .sample = sample,
    .unit = unit,
    .profile = profile,
    .proxy = proxy,
};
