// What the light types share: importance tables, texels, small vectors.
#ifndef NG_LIGHT_LIGHT_INTERNAL_H
#define NG_LIGHT_LIGHT_INTERNAL_H

#include "light/light.h"

#include <math.h>
#include <string.h>

// A piecewise-constant density over [0, 1)^2 as cumulative tables: a row by u[1], then a cell of it by u[0].
// The cells of a mesh are dealt out over rows too, so that fp32 resolves them.
struct ng_light_grid {
    uint32_t width, height;
    float *rows;  // [height + 1], cumulative
    float *cells; // [height][width + 1], cumulative within the row
    size_t row_capacity, cell_capacity;
};

struct ng_light_tables {
    struct ng_light_grid grid;
    bool dark;           // nothing to sample
    uint32_t block;      // texels along a grid cell's edge
    float integral[3];   // the type's measure of its texture: see prepare of each type
    float moments[3][3]; // by channel: the same integral of texture times place (position or direction, in
                         // the type's own frame)
    float normal[3];     // mesh: mean normal
    float srgb[256];     // decoded sRGB bytes
    uint32_t *first;     // mesh: [triangle_count + 1] first cell of each triangle
    float *weights;      // [cells], scratch of prepare
    size_t first_capacity, weight_capacity;
};

// ---- tables.c --------------------------------------------------------------------------------------------
// Builds the grid from width * height weights (finite, not negative). `dark` is set where all are zero.
NG_NODISCARD ng_result ng_light_grid_build(struct ng_light_tables *t, uint32_t width, uint32_t height,
                                           const float *weights);
// Picks a cell; u becomes the place inside it, in [0, 1)^2.
void ng_light_grid_sample(const struct ng_light_grid *g, float u[2], uint32_t cell[2]);
// Probability of a cell.
float ng_light_grid_probability(const struct ng_light_grid *g, uint32_t x, uint32_t y);

// Bilinear lookup; an image of no size is white.
void ng_light_texel(const struct ng_light_tables *t, const struct ng_light_image *image, float u, float v,
                    float rgb[3]);

// Makes the grid of an image: each texel's weight is the mean of its bilinear surface, times measure(y). The
// grid is at most 1024 cells wide and high; larger images have blocks of texels a cell. `visit` sees every
// texel's mean.
struct ng_light_image_walk {
    float (*measure)(const struct ng_light_image *image, uint32_t y);
    void (*visit)(void *user, uint32_t x, uint32_t y, float measure, const float rgb[3]);
    void *user;
};
NG_NODISCARD ng_result ng_light_grid_from_image(struct ng_light_tables *t, const struct ng_light_image *image,
                                                const struct ng_light_image_walk *walk);
// Bounds of a grid cell in texture coordinates.
void ng_light_cell_bounds(const struct ng_light_tables *t, const struct ng_light_image *image, uint32_t x,
                          uint32_t y, float low[2], float high[2]);
// The cell that holds texture coordinates (clamped to [0, 1]).
void ng_light_cell_at(const struct ng_light_tables *t, const struct ng_light_image *image, float u, float v,
                      uint32_t cell[2]);
// The mean place of what is emitted when the texture is tinted.
void ng_light_center(const struct ng_light_tables *t, const float tint[3], float out[3]);
// Grow-only scratch of at least `count` items of `size` bytes.
NG_NODISCARD ng_result ng_light_reserve(void **items, size_t *capacity, size_t count, size_t size);

// ---- small things ----------------------------------------------------------------------------------------
// colour * scale; false where that is not finite or nothing is left. Negative channels count as 0.
static inline bool ng_light_color(const float color[3], float scale, float rgb[3])
{
    float sum = 0;
    for (int i = 0; i < 3; i++) {
        rgb[i] = color[i] * scale;
        if (!isfinite(rgb[i]))
            return false;
        rgb[i] = rgb[i] > 0 ? rgb[i] : 0;
        sum += rgb[i];
    }
    return sum > 0 && isfinite(sum);
}

static inline float ng_light_dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static inline float ng_light_length(const float a[3])
{
    return sqrtf(ng_light_dot(a, a));
}
static inline void ng_light_cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}
// False, and `fallback`, where there is no direction.
static inline bool ng_light_normalize(float v[3], const float fallback[3])
{
    float length = ng_light_length(v);
    bool ok = length > 1e-20f && isfinite(length);
    for (int i = 0; i < 3; i++)
        v[i] = ok ? v[i] / length : fallback[i];
    return ok;
}
static inline void ng_light_mad(const float a[3], const float b[3], float t, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] + b[i] * t;
}
static inline void ng_light_scaled(const float a[3], float t, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] * t;
}
static inline const float *ng_light_origin(const struct ng_light_source *s)
{
    return &s->matrix[12];
}
// The entity's -Z in the world: where punctual lights point.
static inline void ng_light_axis(const struct ng_light_source *s, float out[3])
{
    ng_light_scaled(&s->matrix[8], -1.0f, out);
    ng_light_normalize(out, (const float[3]){0, 0, -1});
}
// A point of the surface that emits, moved off it.
static inline void ng_light_lift(const struct ng_light_source *s, const float normal[3], float point[3])
{
    ng_light_mad(point, normal, ng_light_skin(s->scene_radius, point[0], point[1], point[2]), point);
}
// A unit vector perpendicular to a unit `direction`, near the entity's +Y.
void ng_light_up(const struct ng_light_source *s, const float direction[3], float out[3]);

// Flat emitters in the entity's XY plane that shine along -Z (rectangle, disk): the plane in the world.
struct ng_light_plane {
    float x[3], y[3]; // edges: local (a, b) is at origin + a x + b y
    float normal[3];  // emitting side
    float area;       // of the unit square
};
// False where the plane is degenerate. Inline: paths make it at every surface, and it is small.
static inline bool ng_light_plane_make(const struct ng_light_source *s, float scale_x, float scale_y,
                                       struct ng_light_plane *out)
{
    ng_light_scaled(&s->matrix[0], scale_x, out->x);
    ng_light_scaled(&s->matrix[4], scale_y, out->y);
    ng_light_cross(out->x, out->y, out->normal);
    out->area = ng_light_length(out->normal);
    if (!(out->area > 0) || !isfinite(out->area))
        return false;
    // x cross y points along the entity's Z, or against it where the placement mirrors.
    float sign = ng_light_dot(out->normal, &s->matrix[8]) < 0 ? 1.0f : -1.0f;
    ng_light_scaled(out->normal, sign / out->area, out->normal);
    return true;
}

// Local coordinates of a point of the plane.
static inline void ng_light_plane_local(const struct ng_light_source *s, const struct ng_light_plane *plane,
                                        const float position[3], float local[2])
{
    float p[3];
    ng_light_mad(position, ng_light_origin(s), -1.0f, p);
    // The edges need not be perpendicular (shear): solve the 2 x 2 normal equations.
    float xx = ng_light_dot(plane->x, plane->x), xy = ng_light_dot(plane->x, plane->y);
    float yy = ng_light_dot(plane->y, plane->y), px = ng_light_dot(p, plane->x),
          py = ng_light_dot(p, plane->y);
    float determinant = xx * yy - xy * xy;
    local[0] = (px * yy - py * xy) / determinant;
    local[1] = (py * xx - px * xy) / determinant;
}

#endif
