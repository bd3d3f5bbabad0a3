// A rectangle (a parallelogram under shear) of uniform or textured radiance, sampled by the texture's
// brightness. Seen from the side it shines on, with +Y up, the texture is upright: u runs along -X, v along
// -Y.
//
// tables: `integral` is the mean of the texture, `moments` that of the texture times (u, v).
#include "components/components.h"
#include "components/light_rectangle.h"
#include "light/light_internal.h"
#include "light/unit_shape.h"

static bool radiance(const struct ng_light_source *s, float rgb[3])
{
    const struct ng_light_rectangle *p = (const void *)s->params;
    return p->on && ng_light_color(p->color, p->radiance, rgb);
}

static bool plane_of(const struct ng_light_source *s, struct ng_light_plane *out)
{
    const struct ng_light_rectangle *p = (const void *)s->params;
    return ng_light_plane_make(s, p->size[0], p->size[1], out);
}

static void place(const struct ng_light_source *s, const struct ng_light_plane *plane, const float uv[2],
                  float position[3])
{
    float x, y;
    ng_light_on_square(uv[0], uv[1], &x, &y);
    ng_light_mad(ng_light_origin(s), plane->x, x, position);
    ng_light_mad(position, plane->y, y, position);
}

struct moments {
    const struct ng_light_image *image;
    double rgb[3], place[3][2];
};

static float texel_share(const struct ng_light_image *image, uint32_t y)
{
    NG_UNUSED(y);
    return 1.0f / ((float)image->width * (float)image->height);
}

static void add_texel(void *user, uint32_t x, uint32_t y, float share, const float rgb[3])
{
    struct moments *m = user;
    double u = (x + 0.5) / (m->image->width ? m->image->width : 1);
    double v = (y + 0.5) / (m->image->height ? m->image->height : 1);
    for (int i = 0; i < 3; i++) {
        double part = (double)(rgb[i] * share);
        m->rgb[i] += part;
        m->place[i][0] += part * u;
        m->place[i][1] += part * v;
    }
}

static ng_result prepare(struct ng_light_source *s)
{
    struct moments m = {.image = &s->image};
    struct ng_light_tables *t = s->tables;
    struct ng_light_image_walk walk = {.measure = texel_share, .visit = add_texel, .user = &m};
    NG_TRY(ng_light_grid_from_image(t, &s->image, &walk));
    for (int i = 0; i < 3; i++) {
        t->integral[i] = (float)m.rgb[i];
        t->moments[i][0] = (float)m.place[i][0];
        t->moments[i][1] = (float)m.place[i][1];
    }
    return NG_OK;
}

static bool power(const struct ng_light_source *s, float rgb[3])
{
    struct ng_light_plane plane;
    if (!radiance(s, rgb) || !plane_of(s, &plane))
        return false;
    for (int i = 0; i < 3; i++)
        rgb[i] *= NG_PI * plane.area * s->tables->integral[i];
    return true;
}

static bool emit(const struct ng_light_source *s, const struct ng_light_plane *plane, const uint32_t cell[2],
                 const float uv[2], struct ng_light_sample *out)
{
    const struct ng_light_tables *t = s->tables;
    float low[2], high[2], texel[3];
    if (!radiance(s, out->radiance))
        return false;
    ng_light_texel(t, &s->image, uv[0], uv[1], texel);
    ng_light_cell_bounds(t, &s->image, cell[0], cell[1], low, high);
    memcpy(out->normal, plane->normal, sizeof out->normal);
    out->pdf = ng_light_grid_probability(&t->grid, cell[0], cell[1]) /
               ((high[0] - low[0]) * (high[1] - low[1]) * plane->area);
    for (int i = 0; i < 3; i++) {
        out->radiance[i] *= texel[i];
        out->power[i] = NG_PI * out->radiance[i] / out->pdf;
    }
    return true;
}

static bool sample(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    struct ng_light_plane plane;
    uint32_t cell[2];
    float inside[2] = {u[0], u[1]}, low[2], high[2], uv[2];
    if (!plane_of(s, &plane))
        return false;
    ng_light_grid_sample(&s->tables->grid, inside, cell);
    ng_light_cell_bounds(s->tables, &s->image, cell[0], cell[1], low, high);
    for (int i = 0; i < 2; i++)
        uv[i] = low[i] + (high[i] - low[i]) * inside[i];
    place(s, &plane, uv, out->position);
    return emit(s, &plane, cell, uv, out);
}

static bool at_hit(const struct ng_light_source *s, const struct ng_light_hit *hit,
                   struct ng_light_sample *out)
{
    struct ng_light_plane plane;
    uint32_t cell[2];
    float local[2];
    if (!plane_of(s, &plane))
        return false;
    memcpy(out->position, hit->position, sizeof out->position);
    ng_light_plane_local(s, &plane, hit->position, local);
    const float uv[2] = {0.5f - local[0], 0.5f - local[1]};
    ng_light_cell_at(s->tables, &s->image, uv[0], uv[1], cell);
    return emit(s, &plane, cell, uv, out);
}

static bool proxy(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    struct ng_light_plane plane;
    float rgb[3], center[3];
    if (!plane_of(s, &plane) || !radiance(s, rgb))
        return false;
    ng_light_center(s->tables, rgb, center);
    memcpy(out->direction, plane.normal, sizeof out->direction);
    ng_light_up(s, out->direction, out->up);
    place(s, &plane, center, out->position);
    ng_light_lift(s, plane.normal, out->position);
    out->views = NG_VIEWS_CUBE;
    return true;
}

static void surface(const struct ng_light_source *s, struct ng_light_surface *out)
{
    const struct ng_light_rectangle *p = (const void *)s->params;
    out->shape = NG_LIGHT_SHAPE_RECTANGLE;
    memcpy(out->matrix, s->matrix, sizeof out->matrix);
    ng_light_scaled(&s->matrix[0], p->size[0], &out->matrix[0]);
    ng_light_scaled(&s->matrix[4], p->size[1], &out->matrix[4]);
    memcpy(out->albedo, p->albedo, sizeof out->albedo);
    if (!radiance(s, out->radiance))
        memset(out->radiance, 0, sizeof out->radiance);
}

static ng_asset image(const struct ng_light_source *s)
{
    return ((const struct ng_light_rectangle *)(const void *)s->params)->texture;
}

static void unit(struct ng_light_source *s)
{
    struct ng_light_rectangle *p = (void *)s->params;
    p->on = true;
    p->radiance = 1;
}

const struct ng_light_type ng_light_rectangle_type = {
    .name = "rectangle",
    .component = NG_LIGHT_RECTANGLE,
    .prepare = prepare,
    .power = power,
    .sample = sample,
    .unit = unit,
    .at_hit = at_hit,
    .proxy = proxy,
    .surface = surface,
    .image = image,
};
