// The G-buffer as planes, in the units of the network. What is no number in it becomes 0 here, once, so that
// nothing behind has to look again.
#include "lightformer/clues/clues_internal.h"

#include "base/half.h"
#include "lightformer/trace/vec.h"

#include <assert.h>
#include <string.h>

#define ROWS         4    // of pixels, a job
#define LEAST_WEIGHT 0.6f // of all neighbours, below which a pixel stands alone

#define RUN 128 // pixels that are read together

struct reading {
    struct lf_pixel_clues *out;
    struct lf_gbuffer gbuffer;
};

// ---- planes ----------------------------------------------------------------------------------------------

struct layout {
    struct lf_pixel_clues *out;
    float *next;
    size_t count; // of pixels
    int plane;
};

static void set_planes(struct layout *l, float **planes, int channels)
{
    for (int c = 0; c < channels; c++) {
        l->out->planes[l->plane++] = planes[c] = l->next;
        l->next += l->count;
    }
    l->next += LF_PLANE_GAP;
}

static void set_value(struct lf_pixel_clues *p, enum lf_net_input input, const float *plane)
{
    p->values.of[input] = plane;
}

static ng_result begin_memory(struct lf_pixel_clues *p)
{
    const struct lf_clues_bytes bytes = lf_clues_bytes(p->width, p->height, p->reflection_rays);
    for (int i = 0; i < LF_PIXEL_PARTS; i++)
        if (i != LF_PIXEL_ARRIVING)
            NG_TRY(lf_memory_begin(&p->memory[i], bytes.pixels[i], "the inputs of a picture"));
    return NG_OK;
}

static ng_result lay_out(struct lf_pixel_clues *p)
{
    size_t count = (size_t)p->width * p->height;
    LF_PART(float) all;
    if (!lf_take(&p->memory[LF_PIXEL_PLANES_PART], &all, LF_PIXEL_PLANES * (count + LF_PLANE_GAP)) ||
        !lf_take(&p->memory[LF_PIXEL_PLANES_PART], &p->relief, count) ||
        !lf_take(&p->memory[LF_PIXEL_PLANES_PART], &p->between, count))
        return ng_out_of_memory("the inputs of a picture");
    struct layout l = {.out = p, .next = all.items, .count = count};
    set_planes(&l, &p->mask, 1);
    set_planes(&l, p->position, 3);
    set_planes(&l, p->normal, 3);
    set_planes(&l, p->flat, 3);
    set_planes(&l, p->view, 3);
    set_planes(&l, &p->distance, 1);
    set_planes(&l, p->diffuse, 3);
    set_planes(&l, p->specular, 3);
    set_planes(&l, &p->roughness, 1);
    set_planes(&l, &p->reflection_nearness, 1);
    set_planes(&l, &p->reflection_missed, 1);
    set_planes(&l, p->reflection_albedo, 3);
    set_planes(&l, p->gathered_albedo, 3);
    set_planes(&l, &p->gathered_missed, 1);
    assert(l.plane == LF_PIXEL_PLANES);
    set_value(p, LF_INPUT_PIXEL_MASK, p->mask);
    set_value(p, LF_INPUT_PIXEL_POSITION, p->position[0]);
    set_value(p, LF_INPUT_PIXEL_NORMAL, p->normal[0]);
    set_value(p, LF_INPUT_PIXEL_VIEW, p->view[0]);
    set_value(p, LF_INPUT_PIXEL_DISTANCE, p->distance);
    set_value(p, LF_INPUT_PIXEL_DIFFUSE, p->diffuse[0]);
    set_value(p, LF_INPUT_PIXEL_SPECULAR, p->specular[0]);
    set_value(p, LF_INPUT_PIXEL_ROUGHNESS, p->roughness);
    return NG_OK;
}

// The geometric normal (engine/shaders/geometry.glsl).
static void decode_flat(float x, float y, const float normal[3], float out[3])
{
    float z = 1 - fabsf(x) - fabsf(y), t = z < 0 ? -z : 0;
    out[0] = x + (x >= 0 ? -t : t);
    out[1] = y + (y >= 0 ? -t : t);
    out[2] = z;
    if (!lf_normalize(out))
        memcpy(out, normal, 3 * sizeof *out);
}

// A run of pixels, its halfs made floats in one loop that vectorizes.
struct run {
    float normal[RUN][4], diffuse[RUN][4], specular[RUN][4];
};

static void to_floats(const uint16_t *picture, size_t first, size_t count, float (*out)[4])
{
    const uint16_t *from = picture + 4 * first;
    float *to = out[0];
    for (size_t i = 0; i < 4 * count; i++)
        to[i] = lf_finite(ng_half_to_float(from[i]));
}

static void read_pixel(const struct reading *r, size_t i, const float normal4[4], const float diffuse[4],
                       const float specular[4])
{
    struct lf_pixel_clues *p = r->out;
    const float *world = r->gbuffer.position + 4 * i;
    float position[3], normal[3] = {normal4[0], normal4[1], normal4[2]}, view[3], flat[3];
    if (!(world[3] > 0) || !isfinite(world[0] + world[1] + world[2]))
        return;
    if (p->eye.parallel)
        memcpy(view, p->eye.at, sizeof view);
    else
        lf_mad(p->eye.at, world, -1, view);
    float distance = p->eye.parallel ? p->eye.distance : sqrtf(lf_dot(view, view));
    if (!lf_normalize(normal) || !lf_normalize(view))
        return;
    lf_to_scene(&p->space, world, position);
    decode_flat(diffuse[3], specular[3], normal, flat);
    p->mask[i] = 1;
    p->distance[i] = distance / p->space.radius;
    p->roughness[i] = normal4[3];
    for (int c = 0; c < 3; c++) {
        p->position[c][i] = position[c];
        p->normal[c][i] = normal[c];
        p->view[c][i] = view[c];
        p->flat[c][i] = flat[c];
        p->diffuse[c][i] = diffuse[c];
        p->specular[c][i] = specular[c];
    }
}

// Pixels without a surface stay zero in all planes.
static void read_runs(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct reading *r = user;
    size_t all = (size_t)r->out->width * r->out->height;
    for (size_t n = begin; n < end; n++) {
        struct run run;
        size_t first = n * RUN, count = all - first < RUN ? all - first : RUN;
        to_floats(r->gbuffer.normal, first, count, run.normal);
        to_floats(r->gbuffer.diffuse, first, count, run.diffuse);
        to_floats(r->gbuffer.specular, first, count, run.specular);
        for (size_t k = 0; k < LF_PIXEL_PLANES; k++)
            memset(r->out->planes[k] + first, 0, count * sizeof(float));
        for (size_t i = 0; i < count; i++)
            read_pixel(r, first + i, run.normal[i], run.diffuse[i], run.specular[i]);
    }
}

void lf_pixel_position(const struct lf_pixel_clues *p, size_t pixel, float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = p->position[c][pixel];
}

void lf_pixel_shading_point(const struct lf_pixel_clues *p, size_t pixel, struct lf_shading_point *out)
{
    for (int c = 0; c < 3; c++) {
        out->normal[c] = p->normal[c][pixel];
        out->flat[c] = p->flat[c][pixel];
        out->view[c] = p->view[c][pixel];
    }
    out->roughness = p->roughness[pixel];
}

void lf_shading_points_set_pixel(const struct lf_pixel_clues *p, size_t pixel, int lane,
                                 struct lf_shading_points *out)
{
    for (int c = 0; c < 3; c++) {
        out->position[c][lane] = p->position[c][pixel];
        out->normal[c][lane] = p->normal[c][pixel];
        out->flat[c][lane] = p->flat[c][pixel];
        out->view[c][lane] = p->view[c][pixel];
        out->albedo[c][lane] = p->diffuse[c][pixel];
        out->f0[c][lane] = p->specular[c][pixel];
    }
    out->roughness[lane] = p->roughness[pixel];
}

// ---- relief ----------------------------------------------------------------------------------------------

#define LIKE   0.5f    // bilateral weight
#define FLAT   0.9995f // cosine between normals
#define HEIGHT 0.1f    // over the plane, in grains

// How pixels of a row from `i` on are unlike those `step` further.
static void compare_row(const struct lf_pixel_clues *p, size_t i, uint32_t count, size_t step,
                        unsigned char *out)
{
    const float *const *x = (const float *const *)p->position, *const *n = (const float *const *)p->normal;
    for (size_t k = i; k < i + count; k++) {
        size_t other = k + step;
        float height = (x[0][other] - x[0][k]) * n[0][k] + (x[1][other] - x[1][k]) * n[1][k] +
                       (x[2][other] - x[2][k]) * n[2][k];
        float cosine = n[0][other] * n[0][k] + n[1][other] * n[1][k] + n[2][other] * n[2][k];
        float like = lf_bilateral_falloff(height / lf_plane_grain(p->distance[k]), cosine);
        bool same = like > LIKE && p->mask[k] > 0 && p->mask[other] > 0;
        bool flat = same && cosine > FLAT && fabsf(height) < HEIGHT * lf_plane_grain(p->distance[k]);
        out[k - i] = (unsigned char)((same ? 0 : LF_EDGE) | (flat ? 0 : LF_BENT));
    }
}

// Of RELIEF_RUN pixels of a row, so that what is compared stays small.
#define RELIEF_RUN 256
static void find_relief(struct lf_pixel_clues *p, uint32_t y, uint32_t x0, uint32_t x1)
{
    unsigned char right[RELIEF_RUN + 1], above[RELIEF_RUN], below[RELIEF_RUN];
    uint32_t count = x1 - x0, left = x0 > 0, ends = x1 == p->width;
    size_t first = (size_t)y * p->width + x0;
    memset(right, 0, sizeof right); // beyond the picture all is alike
    memset(above, 0, sizeof above);
    memset(below, 0, sizeof below);
    compare_row(p, first - left, count + left - ends, 1, right + 1 - left);
    if (y > 0)
        compare_row(p, first - p->width, count, p->width, above);
    if (y + 1 < p->height)
        compare_row(p, first, count, p->width, below);
    for (uint32_t i = 0; i < count; i++)
        p->relief.items[first + i] = right[i] | right[i + 1] | above[i] | below[i];
}

static void find_relief_of_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct lf_pixel_clues *p = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < p->width; x += RELIEF_RUN)
            find_relief(p, y, x, p->width - x < RELIEF_RUN ? p->width : x + RELIEF_RUN);
}

// ---- between pixels --------------------------------------------------------------------------------------

#define LATTICE        4    // the coarsest
#define NARROW         0.2f // roughness of lobes that may look different from one pixel to the next
#define SAME_ROUGHNESS 0.02f
#define SAME_F0        1e-3f
#define LEAST_ALBEDO   1e-3f // by which light is divided
#define ONE_PLANE      0.95f // bilateral weight
#define ONE_BEND       0.7f  // the same

// Whether what another pixel reflects says what this one does, but for its albedo. Relief says that of those
// that touch.
static bool speaks_for(const struct lf_pixel_clues *p, size_t other, size_t pixel, uint32_t lattice)
{
    bool alike = !(p->relief.items[other] & LF_BENT) &&
                 fabsf(p->roughness[other] - p->roughness[pixel]) < SAME_ROUGHNESS;
    for (int c = 0; c < 3; c++)
        alike = alike && p->diffuse[c][other] > LEAST_ALBEDO &&
                fabsf(p->specular[c][other] - p->specular[c][pixel]) < SAME_F0;
    return alike && (lattice == 2 || lf_bilateral_weight(p, pixel, other) > ONE_PLANE);
}

// Whether it may do so of a bent surface where light need not be exact.
static bool hints_at(const struct lf_pixel_clues *p, size_t other, size_t pixel)
{
    bool alike = fabsf(p->roughness[other] - p->roughness[pixel]) < SAME_ROUGHNESS;
    for (int c = 0; c < 3; c++)
        alike = alike && (p->diffuse[c][other] > LEAST_ALBEDO || p->diffuse[c][pixel] <= LEAST_ALBEDO) &&
                fabsf(p->specular[c][other] - p->specular[c][pixel]) < SAME_F0;
    return alike && lf_bilateral_weight(p, pixel, other) > ONE_BEND;
}

static bool is_between_alike(const struct lf_pixel_clues *p, const size_t corners[4], size_t pixel)
{
    for (int k = 0; k < 4; k++)
        if (!hints_at(p, corners[k], pixel))
            return false;
    return true;
}

// Each pixel but those of the coarsest lattice is in the middle of two or four of one.
static uint32_t lattice_around(const struct lf_pixel_clues *p, uint32_t x, uint32_t y)
{
    uint32_t lattice = 2;
    size_t pixel = (size_t)y * p->width + x, corners[4];
    while (lattice <= LATTICE && x % lattice == 0 && y % lattice == 0)
        lattice *= 2;
    if (lattice > LATTICE || !(p->mask[pixel] > 0) || p->roughness[pixel] < NARROW ||
        x + x % lattice >= p->width || y + y % lattice >= p->height)
        return 0;
    lf_pixel_corners(p, x, y, lattice, corners);
    bool alike = !(p->relief.items[pixel] & LF_BENT);
    for (int k = 0; k < 4; k++)
        alike = alike && speaks_for(p, corners[k], pixel, lattice);
    if (alike)
        return lattice;
    return lattice == 2 && is_between_alike(p, corners, pixel) ? LF_BETWEEN_BENT : 0;
}

static void find_between(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct lf_pixel_clues *p = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < p->width; x++)
            p->between.items[(size_t)y * p->width + x] = (unsigned char)lattice_around(p, x, y);
}

// ---- the grid --------------------------------------------------------------------------------------------

float lf_bilateral_weight(const struct lf_pixel_clues *p, size_t pixel, size_t other)
{
    float height = 0, cosine = 0;
    for (int c = 0; c < 3; c++) {
        height += (p->position[c][other] - p->position[c][pixel]) * p->normal[c][pixel];
        cosine += p->normal[c][other] * p->normal[c][pixel];
    }
    return p->mask[other] * lf_bilateral_falloff(height / lf_plane_grain(p->distance[pixel]), cosine);
}

static void tap_grid(struct lf_pixel_clues *p, uint32_t x, uint32_t y)
{
    size_t pixel = (size_t)y * p->width + x;
    struct lf_grid_taps *taps = &p->grid_taps.items[pixel];
    uint32_t gx = x / LF_GRID_STEP, gy = y / LF_GRID_STEP;
    float fx = (float)(x % LF_GRID_STEP) / LF_GRID_STEP, fy = (float)(y % LF_GRID_STEP) / LF_GRID_STEP;
    float sum = 0;
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t nx = gx + (k & 1), ny = gy + (k >> 1);
        taps->weight[k] = 0;
        if (p->mask[pixel] > 0 && nx < p->grid_width && ny < p->grid_height)
            taps->weight[k] = (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy) *
                              lf_bilateral_weight(p, pixel, lf_grid_pixel(p, nx, ny));
        sum += taps->weight[k];
    }
    for (int k = 0; k < 4; k++)
        taps->weight[k] = sum > LEAST_WEIGHT ? taps->weight[k] / sum : 0;
}

static void tap_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct lf_pixel_clues *p = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < p->width; x++)
            tap_grid(p, x, y);
}

static ng_result connect_to_grid(const struct lf_clues_scene *scene, struct lf_pixel_clues *p)
{
    size_t count = (size_t)p->width * p->height;
    p->grid_width = (p->width + LF_GRID_STEP - 1) / LF_GRID_STEP;
    p->grid_height = (p->height + LF_GRID_STEP - 1) / LF_GRID_STEP;
    if (!lf_take(&p->memory[LF_PIXEL_GRID], &p->grid_taps, count) ||
        !lf_take(&p->memory[LF_PIXEL_GRID], &p->alone, count))
        return ng_out_of_memory("the inputs of a picture");
    ng_jobs_for(scene->jobs, p->height, ROWS, tap_rows, p);
    p->alone.count = 0;
    for (size_t i = 0; i < count; i++) {
        const float *w = p->grid_taps.items[i].weight;
        if (p->mask[i] > 0 && !(w[0] + w[1] + w[2] + w[3] > 0))
            p->alone.items[p->alone.count++] = (uint32_t)i;
    }
    return NG_OK;
}

ng_result lf_pixels_read(const struct lf_clues_scene *scene, const struct lf_clues_pixels_params *params,
                         struct lf_pixel_clues *out)
{
    const struct ng_snapshot *snapshot = lf_tracer_snapshot(scene->tracer);
    struct reading reading = {.out = out, .gbuffer = params->gbuffer};
    out->width = params->width;
    out->height = params->height;
    out->reflection_rays = params->reflection_rays;
    out->space = lf_space_of(snapshot);
    out->misses = false;
    out->surfaces = 0;
    memset(&out->values, 0, sizeof out->values);
    out->eye = ng_camera_eye_of(&snapshot->camera);
    NG_TRY(begin_memory(out));
    NG_TRY(lay_out(out));
    ng_jobs_for(scene->jobs, (uint32_t)(((size_t)out->width * out->height + RUN - 1) / RUN), 16, read_runs,
                &reading);
    for (size_t i = 0; i < (size_t)out->width * out->height; i++)
        out->surfaces += out->mask[i] > 0;
    ng_jobs_for(scene->jobs, out->height, ROWS, find_relief_of_rows, out);
    ng_jobs_for(scene->jobs, out->height, ROWS, find_between, out);
    bool gridded = lf_clues_wants(scene, LF_INPUT_VIEW_IRRADIANCE_RSM) ||
                   lf_clues_wants(scene, LF_INPUT_PIXEL_GATHERED) ||
                   lf_clues_wants(scene, LF_INPUT_PIXEL_GATHERED_ALBEDO) ||
                   lf_clues_wants(scene, LF_INPUT_PIXEL_GATHERED_MISSED);
    return gridded ? connect_to_grid(scene, out) : NG_OK;
}
