// What smooth surfaces and metals reflect. One ray each at every n-th pixel, in a direction that the BRDF
// chooses: one of sixteen, interleaved over blocks of 4 x 4 rays. Where it meets a metal, one more goes on.
// Both are lit where they end. Every pixel then weighs the rays of a block around it by how well its own BRDF
// reflects what they met (Stachowiak 2015, "Stochastic screen-space reflections"): so a block holds a whole
// lobe, and the blur is as wide as roughness, distance and the bend of the surface make it.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define ROWS           4 // of pixels, a job
#define MISSED         4 // the channel after nearness and albedo + F0
#define PIXEL_CHANNELS 5
#define PIXEL_STRIDE   8
#define LEAST_PART     1e-3f // of a lobe, for a mirror
#define TAPS           LF_RAY_TAPS
#define WHOLE          65535.0f // sum of a pixel's weights
#define RAY_GRAIN      0.05f // distance from a pixel's plane, in distances to the eye, that halves a weight

struct cast {
    const struct lf_clues_scene *scene;
    struct lf_pixel_clues *pixels;
    float focal;                               // pixels
    float spiral[LF_INTERLEAVE_DIRECTIONS][3]; // as lf_brdf_samples
};

// ---- kinds -----------------------------------------------------------------------------------------------

static enum lf_reflection_kind find_kind(const struct lf_pixel_clues *p, size_t pixel)
{
    float f0 = fmaxf(p->specular[0][pixel], fmaxf(p->specular[1][pixel], p->specular[2][pixel]));
    if (!(p->mask[pixel] > 0))
        return LF_REFLECTION_NONE;
    if (f0 > LF_METAL)
        return LF_REFLECTION_METAL;
    if (!(p->roughness[pixel] < LF_SMOOTH))
        return LF_REFLECTION_NONE;
    return p->relief.items[pixel] & LF_EDGE ? LF_REFLECTION_EDGE : LF_REFLECTION_GLOSS;
}

static void find_kinds_of_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct lf_pixel_clues *p = user;
    for (size_t i = (size_t)begin * p->width; i < (size_t)end * p->width; i++)
        p->reflections.kinds.items[i] = (unsigned char)find_kind(p, i);
}

// Once, since pixels are counted and listed again and again: going through bytes costs next to nothing.
static ng_result find_kinds(const struct lf_clues_scene *scene, struct lf_pixel_clues *p)
{
    if (!lf_take(&p->memory[LF_PIXEL_REFLECTIONS], &p->reflections.kinds, (size_t)p->width * p->height))
        return ng_out_of_memory("the reflections of a picture");
    ng_jobs_for(scene->jobs, p->height, ROWS, find_kinds_of_rows, p);
    return NG_OK;
}

// ---- between pixels --------------------------------------------------------------------------------------

// Whether it shows what those around it do, which are of one plane and roughness with it.
static bool is_between(const struct lf_pixel_clues *p, uint32_t x, uint32_t y)
{
    size_t pixel = (size_t)y * p->width + x, corners[4];
    if (p->between.items[pixel] != 2 || p->reflections.kinds.items[pixel] != LF_REFLECTION_GLOSS)
        return false;
    lf_pixel_corners(p, x, y, 2, corners);
    bool alike = true;
    for (int k = 0; k < 4; k++)
        alike = alike && p->reflections.kinds.items[corners[k]] == LF_REFLECTION_GLOSS;
    return alike;
}

// Even pixels alone decide for others, and never are between: rows do not wait for each other.
static void find_between_of_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct lf_pixel_clues *p = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < p->width; x++)
            if (is_between(p, x, y))
                p->reflections.kinds.items[(size_t)y * p->width + x] = LF_REFLECTION_BETWEEN;
}

struct filling {
    const struct lf_pixel_clues *pixels;
    float *const *planes;
    uint32_t channels;
};

static void fill_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct filling *f = user;
    const struct lf_pixel_clues *p = f->pixels;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < p->width; x++) {
            size_t pixel = (size_t)y * p->width + x, at[4];
            if (p->reflections.kinds.items[pixel] != LF_REFLECTION_BETWEEN)
                continue;
            lf_pixel_corners(p, x, y, 2, at);
            for (uint32_t c = 0; c < f->channels; c++) {
                const float *plane = f->planes[c];
                f->planes[c][pixel] = 0.25f * (plane[at[0]] + plane[at[1]] + plane[at[2]] + plane[at[3]]);
            }
        }
}

static void fill_between(const struct lf_clues_scene *scene, const struct lf_pixel_clues *p,
                         uint32_t channels, float *const planes[])
{
    struct filling f = {p, planes, channels};
    ng_jobs_for(scene->jobs, p->height, ROWS, fill_rows, &f);
}

// ---- rays ------------------------------------------------------------------------------------------------

static uint32_t count_pixels(const struct lf_pixel_clues *p, enum lf_reflection_kind kind, uint32_t spacing)
{
    const unsigned char *kinds = p->reflections.kinds.items;
    uint32_t count = 0;
    for (size_t y = 0; y < p->height; y += spacing)
        for (size_t x = 0; x < p->width; x += spacing)
            count += kinds[y * p->width + x] == kind;
    return count;
}

static void start_ray(struct lf_reflections *m, size_t pixel, uint32_t x, uint32_t y)
{
    m->hits.items[m->hits.count++] =
        (struct lf_secondary_hit){.pixel = (uint32_t)pixel,
                                  .interleave_index = lf_interleave_index(x, y),
                                  .direction_index = lf_interleave_direction(x, y)};
}

static ng_result choose_pixels(enum lf_reflection_kind kind, uint32_t budget, struct lf_pixel_clues *p)
{
    struct lf_reflections *m = &p->reflections;
    struct lf_reflection_lattice *l = &m->lattices[kind];
    uint32_t count = count_pixels(p, kind, l->spacing = 1);
    while (count > budget)
        count = count_pixels(p, kind, l->spacing *= 2);
    l->width = (p->width + l->spacing - 1) / l->spacing;
    l->height = (p->height + l->spacing - 1) / l->spacing;
    if (!lf_take(&p->memory[LF_PIXEL_REFLECTIONS], &l->hit_at, (size_t)l->width * l->height))
        return ng_out_of_memory("the reflections of a picture");
    uint32_t *hit_at = l->hit_at.items;
    for (uint32_t y = 0; y < l->height; y++)
        for (uint32_t x = 0; x < l->width; x++, hit_at++) {
            size_t pixel = ((size_t)y * p->width + x) * l->spacing;
            bool starts = m->kinds.items[pixel] == kind;
            if (starts)
                start_ray(m, pixel, x, y);
            *hit_at = starts ? (uint32_t)m->hits.count : 0;
        }
    return NG_OK;
}

// Of the BRDF's choice of a direction.
static float density_of(const struct lf_shading_point *at, const float direction[3])
{
    float half[3];
    lf_mad(direction, at->view, 1, half);
    if (!lf_normalize(half))
        return 0;
    float nh = ng_clamp(lf_dot(at->normal, half), 0.0f, 1.0f);
    return ng_brdf_sample_pdf(lf_shading_cosine(at), nh, at->roughness);
}

// `part`: of the lobe, from its middle. A direction that would lead into the surface is replaced by the
// mirrored one, and that, if it does too, by the one mirrored about the geometric normal.
static void choose_direction(const struct lf_shading_point *at, const float u[3], float part,
                             struct lf_secondary_hit *out)
{
    lf_brdf_direction(at, (const float[3]){u[0], u[1], u[2] * part}, out->direction);
    for (int i = 0; i < 2 && !(lf_dot(out->direction, at->flat) > 0); i++)
        lf_mirror_direction(at->view, i ? at->flat : at->normal, out->direction);
    out->density = density_of(at, out->direction) / part;
}

// Neighbours of a mirror see neighbouring things already: no wider than that, or the picture in it would
// swim.
static float part_of_lobe(const struct cast *cast, const struct lf_secondary_hit *hit, float roughness)
{
    const struct lf_reflections *m = &cast->pixels->reflections;
    float spacing = (float)m->lattices[m->kinds.items[hit->pixel]].spacing;
    float spread = 0.5f * ng_brdf_alpha(roughness) * cast->focal / spacing; // in rays
    return ng_clamp(spread * spread, LEAST_PART, 1.0f);
}

static void cast_from_pixels(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct cast *cast = user;
    const struct lf_pixel_clues *p = cast->pixels;
    for (uint32_t i = begin; i < end; i++) {
        struct lf_secondary_hit *hit = &p->reflections.hits.items[i];
        struct lf_shading_point point;
        float position[3];
        lf_pixel_position(p, hit->pixel, position);
        lf_pixel_shading_point(p, hit->pixel, &point);
        choose_direction(&point, cast->spiral[hit->direction_index], part_of_lobe(cast, hit, point.roughness),
                         hit);
        lf_secondary_cast(cast->scene, &p->space, position, point.flat, point.roughness, hit);
        struct lf_reflection_ray *ray = &p->reflections.rays.items[i];
        *ray = (struct lf_reflection_ray){.density = hit->density, .met = hit->met};
        memcpy(ray->from, position, sizeof ray->from);
        memcpy(ray->normal, point.normal, sizeof ray->normal);
        memcpy(ray->to, hit->met ? hit->position : hit->direction, sizeof ray->to);
    }
}

// What a metal shows is mostly something else.
static void go_on(struct lf_reflections *m)
{
    m->first = (uint32_t)m->hits.count;
    for (uint32_t i = 0; i < m->first; i++) {
        const struct lf_secondary_hit *hit = &m->hits.items[i];
        if (lf_secondary_continues(hit))
            m->hits.items[m->hits.count++] = (struct lf_secondary_hit){
                .pixel = hit->pixel, .interleave_index = hit->interleave_index, .through = i + 1};
    }
}

static void cast_from_hits(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct cast *cast = user;
    struct lf_reflections *m = &cast->pixels->reflections;
    for (uint32_t i = m->first + begin; i < m->first + end; i++) {
        struct lf_secondary_hit *hit = &m->hits.items[i];
        const struct lf_secondary_hit *from = &m->hits.items[hit->through - 1];
        lf_mirror_direction(from->view, from->normal, hit->direction);
        if (!(lf_dot(hit->direction, from->flat) > 0))
            lf_mirror_direction(from->view, from->flat, hit->direction);
        lf_secondary_cast(cast->scene, &cast->pixels->space, from->position, from->flat, from->roughness,
                          hit);
    }
}

// ---- what pixels take from rays --------------------------------------------------------------------------

// The rays of a block around a pixel.
struct block {
    const struct lf_reflection_lattice *lattice;
    uint32_t column, row; // of the first; may wrap
};

// The first column or row of the rays around a pixel.
static uint32_t first_ray(uint32_t at, uint32_t spacing)
{
    return (at + spacing / 2) / spacing - LF_INTERLEAVE_HALF;
}

static struct block block_of(const struct lf_pixel_clues *p, uint32_t pixel)
{
    const struct lf_reflection_lattice *l = &p->reflections.lattices[p->reflections.kinds.items[pixel]];
    return (struct block){l, first_ray(pixel % p->width, l->spacing),
                          first_ray(pixel / p->width, l->spacing)};
}

// Index of a ray's hit + 1, or 0.
static uint32_t hit_at(const struct lf_reflection_lattice *l, uint32_t column, uint32_t row)
{
    return column < l->width && row < l->height ? l->hit_at.items[(size_t)row * l->width + column] : 0;
}

// Of ray k of a block.
static uint32_t hit_of(const struct block *b, uint32_t k)
{
    return hit_at(b->lattice, b->column + k % LF_INTERLEAVE_TAPS, b->row + k / LF_INTERLEAVE_TAPS);
}

// LF_LANES pixels of a row, as far apart as rays of a kind are.
struct run {
    const struct lf_pixel_clues *pixels;
    enum lf_reflection_kind kind;
    uint32_t x, y;
};

static uint32_t spacing_of(const struct run *r)
{
    return r->pixels->reflections.lattices[r->kind].spacing;
}

static bool is_of_kind(const struct run *r, uint32_t lane, size_t *pixel)
{
    uint32_t x = r->x + lane * spacing_of(r);
    *pixel = (size_t)r->y * r->pixels->width + x;
    return x < r->pixels->width && r->pixels->reflections.kinds.items[*pixel] == r->kind;
}

static void set_ray(const struct lf_reflection_ray *ray, size_t row, size_t column, struct lf_ray_window *out)
{
    out->there[row][column] = ray ? 1 : 0;
    if (!ray) // any numbers, but numbers
        return;
    for (int c = 0; c < 3; c++) {
        out->from[c][row][column] = ray->from[c];
        out->normal[c][row][column] = ray->normal[c];
        out->to[c][row][column] = ray->to[c];
    }
    out->met[row][column] = ray->met ? 1 : 0;
    out->density[row][column] = ray->density;
}

static void gather_rays(const struct run *r, struct lf_ray_window *out)
{
    const struct lf_reflections *m = &r->pixels->reflections;
    const struct lf_reflection_lattice *l = &m->lattices[r->kind];
    uint32_t column = first_ray(r->x, l->spacing), row = first_ray(r->y, l->spacing);
    float s = (float)l->spacing;
    lf_interleave_window((float)r->x / s - (float)(int32_t)column, out->across);
    lf_interleave_window((float)r->y / s - (float)(int32_t)row, out->down);
    for (uint32_t j = 0; j < LF_INTERLEAVE_TAPS; j++)
        for (uint32_t i = 0; i < LF_RAY_COLUMNS; i++) {
            uint32_t hit = hit_at(l, column + i, row + j);
            set_ray(hit ? &m->rays.items[hit - 1] : NULL, j, i, out);
        }
}

// Weights of a lane as parts of WHOLE.
static void store_taps(const float weight[LF_RAY_TAPS][LF_LANES], uint32_t lane,
                       struct lf_reflection_taps *out)
{
    float sum = 0;
    for (uint32_t k = 0; k < TAPS; k++)
        sum += weight[k][lane];
    bool any = sum > 0 && isfinite(sum);
    float scale = any ? WHOLE / sum : 0;
    for (uint32_t k = 0; k < TAPS; k++)
        out->weight[k] = any ? (uint16_t)lrintf(weight[k][lane] * scale) : 0;
}

static void find_taps(const struct run *r, struct lf_ray_window *rays)
{
    const struct lf_reflections *m = &r->pixels->reflections;
    struct lf_shading_points points;
    float grain[LF_LANES], weight[LF_RAY_TAPS][LF_LANES];
    size_t pixel, some = SIZE_MAX;
    for (uint32_t i = 0; i < LF_LANES; i++)
        some = is_of_kind(r, i, &pixel) ? pixel : some;
    if (some == SIZE_MAX)
        return;
    for (uint32_t i = 0; i < LF_LANES; i++) {
        size_t shown = is_of_kind(r, i, &pixel) ? pixel : some;
        lf_shading_points_set_pixel(r->pixels, shown, (int)i, &points);
        grain[i] = RAY_GRAIN * r->pixels->distance[shown] + 1e-12f;
    }
    gather_rays(r, rays);
    lf_kernels_of(0)->reflect(&points, grain, rays, weight);
    for (uint32_t i = 0; i < LF_LANES; i++)
        if (is_of_kind(r, i, &pixel))
            store_taps(weight, i, &m->taps.items[m->tap_at.items[pixel]]);
}

static void find_row(const struct lf_pixel_clues *p, enum lf_reflection_kind kind, uint32_t y,
                     struct lf_ray_window *rays)
{
    uint32_t spacing = p->reflections.lattices[kind].spacing;
    for (uint32_t phase = 0; phase < spacing && phase < p->width; phase++)
        for (uint32_t x = phase; x < p->width; x += LF_LANES * spacing)
            find_taps(&(struct run){p, kind, x, y}, rays);
}

static void find_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct cast *cast = user;
    struct lf_ray_window rays = {.met = {{0}}};
    for (uint32_t y = begin; y < end; y++)
        for (int kind = 0; kind < LF_REFLECTION_KINDS; kind++)
            find_row(cast->pixels, (enum lf_reflection_kind)kind, y, &rays);
}

static ng_result connect(const struct cast *cast)
{
    struct lf_pixel_clues *p = cast->pixels;
    struct lf_reflections *m = &p->reflections;
    struct lf_memory *memory = &p->memory[LF_PIXEL_REFLECTIONS];
    size_t count = 0;
    for (size_t i = 0; m->hits.count && i < m->kinds.count; i++)
        count += m->kinds.items[i] < LF_REFLECTION_KINDS;
    if (!lf_take(memory, &m->taps, count) || !lf_take(memory, &m->tap_at, m->kinds.count))
        return ng_out_of_memory("the reflections of a picture");
    for (size_t i = 0, next = 0; next < count; i++)
        if (m->kinds.items[i] < LF_REFLECTION_KINDS) {
            m->tap_at.items[i] = (uint32_t)next;
            m->taps.items[next++].pixel = (uint32_t)i;
        }
    if (count)
        ng_jobs_for(cast->scene->jobs, p->height, ROWS, find_rows, (void *)cast);
    return NG_OK;
}

// `seen`: [hits][LF_HIT_CHANNELS]. Adds what is seen through a metal to what the metal shows.
static void add_reflections(const struct lf_reflections *m, float *seen)
{
    for (size_t i = m->first; i < m->hits.count; i++) {
        const struct lf_secondary_hit *hit = &m->hits.items[i], *metal = &m->hits.items[hit->through - 1];
        float *to = seen + (size_t)(hit->through - 1) * LF_HIT_CHANNELS;
        float cosine = fmaxf(lf_dot(metal->normal, metal->view), 0);
        for (uint32_t c = 0; c < 3; c++)
            to[c] += ng_brdf_f(cosine, metal->f0[c]) * seen[i * LF_HIT_CHANNELS + c];
    }
}

struct spreading {
    const struct lf_pixel_clues *pixels;
    const float *from; // [hits][stride], and of these the first channels
    uint32_t stride, channels;
    float *planes[PIXEL_CHANNELS];
};

// Inlined with a stride that is known, so that its loops vectorize.
static inline void spread_to(const struct spreading *s, const struct lf_reflection_taps *t, uint32_t stride)
{
    struct block b = block_of(s->pixels, t->pixel);
    float sum[PIXEL_STRIDE] = {0};
    for (uint32_t k = 0; k < TAPS; k++) {
        if (!t->weight[k])
            continue;
        const float *seen = s->from + (size_t)(hit_of(&b, k) - 1) * stride;
        for (size_t c = 0; c < stride; c++)
            sum[c] += (float)t->weight[k] * seen[c];
    }
    for (uint32_t c = 0; c < s->channels; c++)
        s->planes[c][t->pixel] = lf_finite(sum[c] / WHOLE);
}

static void spread_taps(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct spreading *s = user;
    const struct lf_reflection_taps *taps = s->pixels->reflections.taps.items;
    for (uint32_t i = begin; i < end; i++)
        if (s->stride == LF_HIT_CHANNELS)
            spread_to(s, &taps[i], LF_HIT_CHANNELS);
        else
            spread_to(s, &taps[i], PIXEL_STRIDE);
}

struct clearing {
    const struct spreading *planes;
    size_t count;
};

static void clear_planes(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct clearing *c = user;
    for (uint32_t i = begin; i < end; i++)
        memset(c->planes->planes[i], 0, c->count * sizeof(float));
}

// Pixels without a reflection show none.
static void spread(const struct lf_clues_scene *scene, const struct spreading *s)
{
    struct clearing clearing = {.planes = s, .count = (size_t)s->pixels->width * s->pixels->height};
    ng_jobs_for(scene->jobs, s->channels, 1, clear_planes, &clearing);
    ng_jobs_for(scene->jobs, (uint32_t)s->pixels->reflections.taps.count, 2048, spread_taps, (void *)s);
}

// ---- pixels ----------------------------------------------------------------------------------------------

static bool wants_any(const struct lf_clues_scene *s)
{
    return lf_clues_wants(s, LF_INPUT_PIXEL_REFLECTION_NEARNESS) ||
           lf_clues_wants(s, LF_INPUT_PIXEL_REFLECTION_MISSED) ||
           lf_clues_wants(s, LF_INPUT_PIXEL_REFLECTION_ALBEDO) || lf_clues_wants(s, LF_INPUT_PIXEL_REFLECTED);
}

// Floats for what hits show, and, when pixels have taken that, for averages of pixels.
static size_t room_for(const struct lf_reflections *m)
{
    size_t hits = PIXEL_STRIDE * m->hits.count, averages = PIXEL_CHANNELS * m->taps.count;
    return hits > averages ? hits : averages;
}

static ng_result fill_pixels(const struct lf_clues_scene *scene, struct lf_pixel_clues *p)
{
    struct lf_reflections *m = &p->reflections;
    if (!lf_take(&p->memory[LF_PIXEL_GRID], &m->seen, room_for(m)))
        return ng_out_of_memory("the reflections of a picture");
    for (size_t i = 0; i < m->hits.count; i++) {
        const struct lf_secondary_hit *hit = &m->hits.items[i];
        float *seen = m->seen.items + i * PIXEL_STRIDE;
        seen[0] = hit->met ? lf_finite(1 / (1 + hit->distance / p->distance[hit->pixel])) : 0;
        lf_mad(hit->albedo, hit->f0, 1, seen + 1);
        seen[MISSED] = hit->met ? 0 : 1;
        p->misses = p->misses || !hit->met;
    }
    struct spreading s = {.pixels = p,
                          .from = m->seen.items,
                          .stride = PIXEL_STRIDE,
                          .channels = PIXEL_CHANNELS,
                          .planes = {p->reflection_nearness, p->reflection_albedo[0], p->reflection_albedo[1],
                                     p->reflection_albedo[2], p->reflection_missed}};
    spread(scene, &s);
    NG_TRY(lf_reflection_filter_find(scene, p));
    lf_reflection_filter_apply(scene, p, PIXEL_CHANNELS, m->seen.items, s.planes);
    fill_between(scene, p, PIXEL_CHANNELS, s.planes);
    p->values.of[LF_INPUT_PIXEL_REFLECTION_NEARNESS] = p->reflection_nearness;
    p->values.of[LF_INPUT_PIXEL_REFLECTION_MISSED] = p->misses ? p->reflection_missed : NULL;
    p->values.of[LF_INPUT_PIXEL_REFLECTION_ALBEDO] = p->reflection_albedo[0];
    return NG_OK;
}

ng_result lf_reflections_cast(const struct lf_clues_scene *scene, float focal, uint32_t budget,
                              struct lf_pixel_clues *out)
{
    struct cast cast = {.scene = scene, .pixels = out, .focal = focal};
    struct lf_reflections *m = &out->reflections;
    if (!wants_any(scene))
        return NG_OK;
    if (!lf_take(&out->memory[LF_PIXEL_REFLECTIONS], &m->hits, 2 * lf_reflection_rays_at_most(out)))
        return ng_out_of_memory("the reflections of a picture");
    m->hits.count = 0; // every ray may go on once
    lf_brdf_spiral(LF_INTERLEAVE_DIRECTIONS, cast.spiral);
    NG_TRY(find_kinds(scene, out));
    NG_TRY(choose_pixels(LF_REFLECTION_METAL, budget - budget / 4, out)); // at least one each
    NG_TRY(choose_pixels(LF_REFLECTION_EDGE, (uint32_t)lf_reflection_edge_budget(budget), out));
    NG_TRY(choose_pixels(LF_REFLECTION_GLOSS, (budget + 3) / 4, out));
    if (m->lattices[LF_REFLECTION_GLOSS].spacing > 1) // or pixels between would have rays of their own
        ng_jobs_for(scene->jobs, out->height, ROWS, find_between_of_rows, out);
    if (!lf_take(&out->memory[LF_PIXEL_REFLECTIONS], &m->rays, m->hits.count))
        return ng_out_of_memory("the reflections of a picture");
    ng_jobs_for(scene->jobs, (uint32_t)m->hits.count, 64, cast_from_pixels, &cast);
    go_on(m);
    ng_jobs_for(scene->jobs, (uint32_t)m->hits.count - m->first, 64, cast_from_hits, &cast);
    NG_TRY(connect(&cast));
    return fill_pixels(scene, out);
}

// ---- light -----------------------------------------------------------------------------------------------

ng_result lf_reflections_light(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                               struct lf_light_clues *light)
{
    const struct lf_reflections *m = &pixels->reflections;
    if (!lf_take(&light->memory[LF_LIGHT_HITS], &light->reflected, LF_HIT_CHANNELS * m->hits.count))
        return ng_out_of_memory("the view of a light");
    lf_secondary_light(scene, light, m->hits.items, (uint32_t)m->hits.count, m->first,
                       light->reflected.items);
    return NG_OK;
}

void lf_reflections_spread(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                           float *seen, float *scratch, float *const out[3])
{
    struct spreading s = {.pixels = pixels,
                          .from = seen,
                          .stride = LF_HIT_CHANNELS,
                          .channels = 3,
                          .planes = {out[0], out[1], out[2]}};
    add_reflections(&pixels->reflections, seen);
    spread(scene, &s);
    lf_reflection_filter_apply(scene, pixels, 3, scratch, out);
    fill_between(scene, pixels, 3, out);
}
