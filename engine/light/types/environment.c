// Light from all around: a latitude-longitude map, or one radiance everywhere, turned by the placement's
// rotation. Directions are sampled by the map's brightness times solid angle; inside a cell of the map's grid
// uniformly by solid angle.
//
// tables: `integral` is the map integrated over the sphere, `moments` the map times direction,
// both before colour and rotation, so that turning or tinting the light rebuilds nothing.
#include "components/components.h"
#include "components/light_environment.h"
#include "light/light_internal.h"

// The map closes on itself sideways and ends at the poles, whatever its file says.
static struct ng_light_image map_of(const struct ng_light_source *s)
{
    struct ng_light_image map = s->image;
    map.wrap_u = NG_LIGHT_WRAP_REPEAT;
    map.wrap_v = NG_LIGHT_WRAP_CLAMP;
    return map;
}

static bool tint(const struct ng_light_source *s, float rgb[3])
{
    const struct ng_light_environment *p = (const void *)s->params;
    return p->on && ng_light_color(p->color, p->intensity, rgb);
}

// Columns: the placement's axes, made unit and perpendicular.
static bool rotation_of(const struct ng_light_source *s, float axes[3][3])
{
    static const float none[3] = {0};
    memcpy(axes[1], &s->matrix[4], sizeof axes[1]);
    memcpy(axes[2], &s->matrix[8], sizeof axes[2]);
    if (!ng_light_normalize(axes[1], none))
        return false;
    ng_light_mad(axes[2], axes[1], -ng_light_dot(axes[2], axes[1]), axes[2]);
    if (!ng_light_normalize(axes[2], none))
        return false;
    ng_light_cross(axes[1], axes[2], axes[0]);
    return true;
}

static void to_world(float axes[3][3], const float local[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = axes[0][i] * local[0] + axes[1][i] * local[1] + axes[2][i] * local[2];
}

// Map centre is -Z; u grows to the right of someone who looks there with +Y up, which is +X.
static void direction_at(float u, float cos_theta, float out[3])
{
    float phi = 2 * NG_PI * (u - 0.5f), ring = sqrtf(fmaxf(1 - cos_theta * cos_theta, 0));
    out[0] = ring * sinf(phi);
    out[1] = cos_theta;
    out[2] = -ring * cosf(phi);
}

static void place_of(const float local[3], float uv[2])
{
    uv[0] = 0.5f + atan2f(local[0], -local[2]) / (2 * NG_PI);
    uv[1] = acosf(fminf(fmaxf(local[1], -1.0f), 1.0f)) / NG_PI;
}

struct moments {
    const struct ng_light_image *map;
    double rgb[3], direction[3][3];
};

static float texel_solid_angle(const struct ng_light_image *map, uint32_t y)
{
    double top = cos(3.14159265358979 * y / map->height),
           bottom = cos(3.14159265358979 * (y + 1.0) / map->height);
    return (float)(2 * 3.14159265358979 / map->width * (top - bottom));
}

static void add_texel(void *user, uint32_t x, uint32_t y, float solid_angle, const float rgb[3])
{
    struct moments *m = user;
    for (int i = 0; i < 3; i++)
        m->rgb[i] += (double)(rgb[i] * solid_angle);
    if (!m->map->width) // one radiance everywhere: no direction stands out
        return;
    float direction[3], v = ((float)y + 0.5f) / (float)m->map->height;
    direction_at(((float)x + 0.5f) / (float)m->map->width, cosf(NG_PI * v), direction);
    for (int i = 0; i < 9; i++)
        m->direction[i / 3][i % 3] += (double)(rgb[i / 3] * solid_angle * direction[i % 3]);
}

static ng_result prepare(struct ng_light_source *s)
{
    struct ng_light_tables *t = s->tables;
    struct ng_light_image map = map_of(s);
    struct moments m = {.map = &map};
    struct ng_light_image_walk walk = {.measure = texel_solid_angle, .visit = add_texel, .user = &m};
    NG_TRY(ng_light_grid_from_image(t, &map, &walk));
    for (int i = 0; i < 3; i++) {
        t->integral[i] = (float)m.rgb[i];
        for (int k = 0; k < 3; k++)
            t->moments[i][k] = (float)m.direction[i][k];
    }
    return NG_OK;
}

static float disk_of_scene(const struct ng_light_source *s)
{
    return NG_PI * s->scene_radius * s->scene_radius;
}

static bool power(const struct ng_light_source *s, float rgb[3])
{
    bool ok = tint(s, rgb);
    for (int i = 0; i < 3; i++)
        rgb[i] *= disk_of_scene(s) * s->tables->integral[i];
    return ok;
}

// The sample that comes from a direction of the map.
static bool emit(const struct ng_light_source *s, float axes[3][3], const float local[3],
                 const uint32_t cell[2], struct ng_light_sample *out)
{
    const struct ng_light_tables *t = s->tables;
    struct ng_light_image map = map_of(s);
    float from[3], uv[2], texel[3], low[2], high[2];
    if (!tint(s, out->radiance))
        return false;
    place_of(local, uv);
    ng_light_texel(t, &map, uv[0], uv[1], texel);
    to_world(axes, local, from);
    ng_light_scaled(from, -1.0f, out->normal);
    ng_light_mad(s->scene_center, from, 2 * s->scene_radius, out->position);
    ng_light_cell_bounds(t, &map, cell[0], cell[1], low, high);
    float solid_angle = 2 * NG_PI * (high[0] - low[0]) * (cosf(NG_PI * low[1]) - cosf(NG_PI * high[1]));
    out->pdf = ng_light_grid_probability(&t->grid, cell[0], cell[1]) / solid_angle;
    for (int i = 0; i < 3; i++) {
        out->radiance[i] *= texel[i];
        out->power[i] = disk_of_scene(s) * out->radiance[i] / out->pdf;
    }
    return true;
}

static bool sample(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    struct ng_light_image map = map_of(s);
    uint32_t cell[2];
    float axes[3][3], inside[2] = {u[0], u[1]}, low[2], high[2], local[3];
    if (!rotation_of(s, axes))
        return false;
    ng_light_grid_sample(&s->tables->grid, inside, cell);
    ng_light_cell_bounds(s->tables, &map, cell[0], cell[1], low, high);
    float top = cosf(NG_PI * low[1]), bottom = cosf(NG_PI * high[1]);
    direction_at(low[0] + (high[0] - low[0]) * inside[0], top + (bottom - top) * inside[1], local);
    return emit(s, axes, local, cell, out);
}

static bool at_hit(const struct ng_light_source *s, const struct ng_light_hit *hit,
                   struct ng_light_sample *out)
{
    struct ng_light_image map = map_of(s);
    uint32_t cell[2];
    float axes[3][3], local[3], uv[2];
    if (!rotation_of(s, axes))
        return false;
    for (int i = 0; i < 3; i++)
        local[i] = ng_light_dot(axes[i], hit->direction);
    place_of(local, uv);
    ng_light_cell_at(s->tables, &map, uv[0], uv[1], cell);
    return emit(s, axes, local, cell, out);
}

static float profile(const struct ng_light_source *s, const struct ng_light_sample *from,
                     const float toward[3])
{
    NG_UNUSED(s), NG_UNUSED(from), NG_UNUSED(toward);
    return 1;
}

static bool proxy(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    float axes[3][3], rgb[3], mean[3], from[3] = {0, 1, 0};
    if (!rotation_of(s, axes) || !tint(s, rgb))
        return false;
    ng_light_center(s->tables, rgb, mean);
    if (ng_light_length(mean) > 1e-3f) {
        to_world(axes, mean, from);
        ng_light_normalize(from, (const float[3]){0, 1, 0});
    }
    ng_light_scaled(from, -1.0f, out->direction);
    ng_light_up(s, out->direction, out->up);
    ng_light_mad(s->scene_center, from, s->scene_radius, out->position);
    out->views = NG_VIEWS_SINGLE_ORTHOGRAPHIC;
    out->extent = s->scene_radius;
    return true;
}

static ng_asset image(const struct ng_light_source *s)
{
    return ((const struct ng_light_environment *)(const void *)s->params)->map;
}

static void unit(struct ng_light_source *s)
{
    struct ng_light_environment *p = (void *)s->params;
    p->on = true;
    p->intensity = 1;
}

const struct ng_light_type ng_light_environment_type = {
    .name = "environment",
    .component = NG_LIGHT_ENVIRONMENT,
    .infinite = true,
    .prepare = prepare,
    .power = power,
    .sample = sample,
    .unit = unit,
    .at_hit = at_hit,
    .profile = profile,
    .proxy = proxy,
    .image = image,
};
