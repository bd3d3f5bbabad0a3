// A cone: full intensity inside the inner angle, none outside the outer, and between them the square of a
// ramp in the cosine (KHR_lights_punctual, "Inner and Outer Cone Angles").
#include "components/components.h"
#include "components/light_spot.h"
#include "light/light_internal.h"

#define WIDEST_SINGLE_VIEW 1.308996939f // 75 degrees; beyond, a perspective view wastes its texels

struct cone {
    float cos_outer;
    float ramp; // width of the ramp in the cosine; never 0
};

static bool cone_of(const struct ng_light_source *s, struct cone *out)
{
    const struct ng_light_spot *p = (const void *)s->params;
    float outer = fminf(fmaxf(p->outer_angle, 0.0f), NG_PI);
    float inner = fminf(fmaxf(p->inner_angle, 0.0f), outer);
    out->cos_outer = cosf(outer);
    out->ramp = fmaxf(0.001f, cosf(inner) - out->cos_outer);
    return isfinite(p->outer_angle) && isfinite(p->inner_angle) && outer > 0;
}

static bool intensity(const struct ng_light_source *s, float rgb[3])
{
    const struct ng_light_spot *p = (const void *)s->params;
    return p->on && ng_light_color(p->color, p->intensity, rgb);
}

// Intensity integrated over the cone, in closed form. The ramp ends on the axis at the latest.
static bool power(const struct ng_light_source *s, float rgb[3])
{
    struct cone c;
    if (!cone_of(s, &c) || !intensity(s, rgb))
        return false;
    float ramp_end = fminf(c.cos_outer + c.ramp, 1.0f), t = (ramp_end - c.cos_outer) / c.ramp;
    ng_light_scaled(rgb, 2 * NG_PI * ((1 - ramp_end) + c.ramp * t * t * t / 3), rgb);
    return true;
}

static bool sample(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    NG_UNUSED(u);
    memcpy(out->position, ng_light_origin(s), sizeof out->position);
    ng_light_axis(s, out->normal);
    out->pdf = 1;
    return intensity(s, out->radiance) && power(s, out->power);
}

static float profile(const struct ng_light_source *s, const struct ng_light_sample *from,
                     const float toward[3])
{
    struct cone c;
    if (!cone_of(s, &c))
        return 0;
    float t = (ng_light_dot(from->normal, toward) - c.cos_outer) / c.ramp;
    t = fminf(fmaxf(t, 0.0f), 1.0f);
    return t * t;
}

static void cone(const struct ng_light_source *s, float *scale, float *offset)
{
    struct cone c;
    if (!cone_of(s, &c))
        return;
    *scale = 1 / c.ramp;
    *offset = -c.cos_outer / c.ramp;
}

static bool proxy(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    const struct ng_light_spot *p = (const void *)s->params;
    memcpy(out->position, ng_light_origin(s), sizeof out->position);
    ng_light_axis(s, out->direction);
    ng_light_up(s, out->direction, out->up);
    out->views = p->outer_angle <= WIDEST_SINGLE_VIEW ? NG_VIEWS_SINGLE_PERSPECTIVE : NG_VIEWS_CUBE;
    out->fov = 2 * p->outer_angle;
    return true;
}

static void unit(struct ng_light_source *s)
{
    struct ng_light_spot *p = (void *)s->params;
    p->on = true;
    p->intensity = 1;
}

const struct ng_light_type ng_light_spot_type = {
    .name = "spot",
    .component = NG_LIGHT_SPOT,
    .delta = true,
    .power = power,
    .sample = sample,
    .unit = unit,
    .profile = profile,
    .cone = cone,
    .proxy = proxy,
};
