// Unshadowed direct light. Pixels are sorted by how the light has to be sampled, a run at a time, so that all
// lanes of a kernel do the same work.
#include "lightformer/clues/clues_internal.h"

#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"

#include <string.h>

#define ROWS   4    // a job
#define RUN    512  // pixels of a row that are sorted together
#define SPREAD 0.1f // of light at neighbours, of which a mean is taken
#define FAR    6.0f // half diagonals of a light, from which on a few points of it are enough

// ---- directions of the BRDF, for lights without a closed form ---------------------------------------------

// One lane as numbers.
struct lane {
    float world[3], albedo[3], f0[3];
    struct lf_shading_point point;
    struct lf_frame frame; // around its normal
    struct ng_local_direction view;
};

static void read_lane(const struct lf_light_clues *light, const struct lf_shading_points *p, uint32_t i,
                      struct lane *out)
{
    float position[3];
    for (int c = 0; c < 3; c++) {
        position[c] = p->position[c][i];
        out->point.normal[c] = p->normal[c][i];
        out->point.flat[c] = p->flat[c][i];
        out->point.view[c] = p->view[c][i];
        out->albedo[c] = p->albedo[c][i];
        out->f0[c] = p->f0[c][i];
    }
    out->point.roughness = p->roughness[i];
    out->frame = lf_frame_toward(out->point.normal, out->point.view);
    out->view = lf_shading_view(&out->point, &out->frame);
    lf_to_world(&light->space, position, out->world);
}

// What a direction meets of the light, as if there were nothing else.
struct meeting {
    const struct lf_clues_scene *scene;
    const struct lf_light_clues *light;
    const struct lane *lane;
    const float *direction;
    float pdf;    // of the direction, times the number of directions
    float sum[3]; // radiance / (pdf + density of the light's samples)
};

static void add_meeting(struct meeting *m, const struct ng_light_hit *hit)
{
    float seen[3], samples = (float)m->light->emitter.sample_count;
    ng_light_seen_at(&m->light->unit, hit, seen);
    float density = samples * ng_light_pdf_at(&m->light->unit, hit);
    if (density > 0)
        lf_mad(m->sum, seen, 1 / (m->pdf + density), m->sum);
}

static void meet_emitter(void *user, const struct lf_hit *hit)
{
    struct meeting *m = user;
    if (lf_tracer_snapshot(m->scene->tracer)->instances[hit->instance].light != m->light->light)
        return;
    struct ng_light_hit h = {.distance = hit->distance};
    lf_hit_on_light(lf_tracer_snapshot(m->scene->tracer), hit, &h);
    memcpy(h.position, hit->position, sizeof h.position);
    memcpy(h.direction, m->direction, sizeof h.direction);
    add_meeting(m, &h);
}

static void meet(struct meeting *m)
{
    struct lf_ray ray = {.near = 0, .far = INFINITY};
    memcpy(ray.direction, m->direction, sizeof ray.direction);
    if (m->light->unit.type->infinite) {
        struct ng_light_hit hit = {.distance = INFINITY};
        memcpy(hit.direction, m->direction, sizeof hit.direction);
        add_meeting(m, &hit);
        return;
    }
    lf_trace_origin(m->scene->tracer, m->lane->world, m->lane->point.flat, m->direction, ray.origin);
    lf_count_rays(m->scene, 1);
    lf_trace_emitters(m->scene->tracer, &ray, meet_emitter, m);
}

// One direction's share of the glossy light.
static void add_direction(const struct lf_clues_scene *scene, const struct lf_light_clues *light,
                          const struct lane *lane, const float u[3], float glossy[3])
{
    float roughness = lane->point.roughness;
    struct ng_local_direction h = ng_brdf_half(lane->view, roughness, u[0], u[1], u[2]);
    struct ng_local_direction l = ng_brdf_reflect(lane->view, h);
    float direction[3], pdf = ng_brdf_sample_pdf(lane->view.z, h.z, roughness);
    lf_local_to_world(&lane->frame, &l, direction);
    if (!(l.z > 0) || !(lf_dot(direction, lane->point.flat) > 0) || !(pdf > 0))
        return;
    struct meeting m = {
        .scene = scene, .light = light, .lane = lane, .direction = direction, .pdf = pdf * LF_BRDF_SAMPLES};
    meet(&m);
    float vh = fmaxf(lane->view.x * h.x + lane->view.y * h.y + lane->view.z * h.z, 0);
    float square = light->space.radius * light->space.radius / light->phi;
    float lobe = ng_brdf_lobe(l.z, lane->view.z, h.z, roughness) * l.z * square;
    for (int c = 0; c < 3; c++)
        glossy[c] += lf_finite(lobe * ng_brdf_f(vh, lane->f0[c]) * m.sum[c]);
}

static void add_brdf_samples(const struct lf_clues_scene *scene, const struct lf_light_clues *light,
                             const struct lf_shading_points *points, uint32_t count, struct lf_lit *out)
{
    for (uint32_t i = 0; i < count; i++) {
        struct lane lane;
        float glossy[3] = {0};
        read_lane(light, points, i, &lane);
        for (int k = 0; k < LF_BRDF_SAMPLES; k++)
            add_direction(scene, light, &lane, lf_brdf_samples[k], glossy);
        for (int c = 0; c < 3; c++)
            out->glossy[c][i] += glossy[c];
    }
}

// ---- directions around the normal, near lights without a closed form -------------------------------------

// Adds what a direction finds of the diffuse light, and of the glossy one if nobody else does.
static void add_cosine_direction(struct meeting *m, const struct ng_local_direction *l, float share,
                                 bool specular, float diffuse[3], float glossy[3])
{
    const struct lane *lane = m->lane;
    const struct ng_local_direction v = lane->view;
    float roughness = lane->point.roughness, h[3] = {l->x + v.x, l->y + v.y, l->z + v.z};
    if (!lf_normalize(h))
        return;
    float vh = fmaxf(v.x * h[0] + v.y * h[1] + v.z * h[2], 0);
    float square = m->light->space.radius * m->light->space.radius / m->light->phi;
    float scale = share * l->z * square, lobe = specular ? ng_brdf_lobe(l->z, v.z, h[2], roughness) : 0;
    meet(m);
    for (int c = 0; c < 3; c++) {
        float light = scale * m->sum[c];
        diffuse[c] += lf_finite(light * ng_brdf_diffuse(l->z, v.z, vh, lane->albedo[c], lane->f0[c]));
        glossy[c] += lf_finite(light * lobe * ng_brdf_f(vh, lane->f0[c]));
    }
}

static void add_cosine_lane(const struct lf_clues_scene *scene, const struct lf_light_clues *light,
                            const struct lane *lane, float share, bool specular, float diffuse[3],
                            float glossy[3])
{
    float u[LF_COSINE_SAMPLES][3], direction[3];
    lf_brdf_spiral(LF_COSINE_SAMPLES, u);
    for (int k = 0; k < LF_COSINE_SAMPLES; k++) {
        float sine = sqrtf(u[k][2]);
        struct ng_local_direction l = {u[k][0] * sine, u[k][1] * sine, sqrtf(1 - u[k][2])};
        lf_local_to_world(&lane->frame, &l, direction);
        struct meeting m = {.scene = scene,
                            .light = light,
                            .lane = lane,
                            .direction = direction,
                            .pdf = share * LF_COSINE_SAMPLES * l.z / NG_PI};
        if (lf_dot(direction, lane->point.flat) > 0)
            add_cosine_direction(&m, &l, share, specular, diffuse, glossy);
    }
}

static void add_cosine_samples(const struct lf_clues_scene *scene, const struct lf_light_clues *light,
                               const struct lf_shading_points *points, uint32_t count, bool specular,
                               struct lf_lit *out)
{
    for (uint32_t i = 0; i < count; i++) {
        struct lane lane;
        float diffuse[3] = {0}, glossy[3] = {0};
        if (!(out->share[i] > 0))
            continue;
        read_lane(light, points, i, &lane);
        add_cosine_lane(scene, light, &lane, out->share[i], specular, diffuse, glossy);
        for (int c = 0; c < 3; c++) {
            out->diffuse[c][i] += diffuse[c];
            out->glossy[c][i] += glossy[c];
        }
    }
}

void lf_direct_at(const struct lf_clues_scene *scene, const struct lf_light_clues *light,
                  const struct lf_shading_points *points, uint32_t count, enum lf_sampling sampling,
                  struct lf_lit *out)
{
    bool brdf_samples = sampling == LF_SAMPLE_LOBE && !light->unit.type->delta;
    const struct lf_emitter *emitter = sampling == LF_SAMPLE_FAR ? &light->far_emitter : &light->emitter;
    lf_kernels_of(0)->direct(emitter, points, brdf_samples, out);
    if (!light->needs_brdf_rays || !light->emitter.sample_count)
        return;
    if (brdf_samples)
        add_brdf_samples(scene, light, points, count, out);
    add_cosine_samples(scene, light, points, count, !brdf_samples, out);
}

bool lf_direct_is_far(const struct lf_light_clues *light, const float position[3], const float normal[3])
{
    const struct lf_emitter *e = &light->emitter;
    float to[3];
    lf_mad(e->center, position, -1, to);
    bool flat = e->kind == LF_EMITTER_RECTANGLE || e->kind == LF_EMITTER_DISK;
    // Not where the surface's horizon cuts the light.
    return flat && lf_dot(to, to) > FAR * FAR * e->radius * e->radius &&
           fabsf(lf_dot(to, normal)) > e->radius;
}

// Whether a lobe is so much wider than the light that samples of the light alone show none of its shape: the
// density of a direction to the light over that of the lobe's middle, at grazing angles stretched.
static bool is_wide(const struct lf_light_clues *light, const float position[3], float roughness,
                    float cosine, float times)
{
    const struct lf_emitter *e = &light->emitter;
    float alpha = ng_brdf_alpha(roughness), to[3];
    lf_mad(e->center, position, -1, to);
    float light_density = lf_dot(to, to),
          lobe_density = e->area / (4 * NG_PI * alpha * alpha * lf_max(cosine, 0.05f));
    return e->area > 0 && light_density > times * lobe_density;
}

// ---- pixels ----------------------------------------------------------------------------------------------

struct lighting {
    const struct lf_clues_scene *scene;
    const struct lf_pixel_clues *pixels;
    const struct lf_light_clues *light;
    float *const *diffuse, *const *glossy;
    bool bent;         // also on surfaces that bend
    uint32_t coarsest; // lattice: of flat surfaces every so many-th pixel each way is lit
    uint32_t step;     // of this pass: pixels between those of that lattice; 0: all that are between none
};

static enum lf_sampling sampling_of(const struct lighting *l, size_t pixel)
{
    const struct lf_pixel_clues *p = l->pixels;
    float position[3], roughness = p->roughness[pixel];
    lf_pixel_position(p, pixel, position);
    const float normal[3] = {p->normal[0][pixel], p->normal[1][pixel], p->normal[2][pixel]};
    float cosine =
        normal[0] * p->view[0][pixel] + normal[1] * p->view[1][pixel] + normal[2] * p->view[2][pixel];
    if (is_wide(l->light, position, roughness, cosine, 16) && lf_direct_is_far(l->light, position, normal))
        return LF_SAMPLE_FAR;
    bool smooth = roughness < LF_SMOOTH && !is_wide(l->light, position, roughness, cosine, 4);
    return smooth ? LF_SAMPLE_LOBE : LF_SAMPLE_LIGHT;
}

static void light_lanes(const struct lighting *l, const size_t *list, uint32_t count,
                        enum lf_sampling sampling)
{
    struct lf_shading_points points;
    struct lf_lit lit;
    for (uint32_t i = 0; i < LF_LANES; i++)
        lf_shading_points_set_pixel(l->pixels, list[i < count ? i : 0], (int)i, &points);
    lf_direct_at(l->scene, l->light, &points, count, sampling, &lit);
    for (int c = 0; c < 3; c++)
        for (uint32_t i = 0; i < count; i++) {
            l->diffuse[c][list[i]] = lf_finite(lit.diffuse[c][i]);
            l->glossy[c][list[i]] = lf_finite(lit.glossy[c][i]);
        }
}

static void light_list(const struct lighting *l, const size_t *list, uint32_t count,
                       enum lf_sampling sampling)
{
    for (uint32_t i = 0; i < count; i += LF_LANES)
        light_lanes(l, list + i, count - i < LF_LANES ? count - i : LF_LANES, sampling);
}

// Radiance by channel with the albedo of a pixel.
static void reflect_as(const struct lighting *l, size_t other, size_t pixel, float diffuse[3],
                       float glossy[3])
{
    const struct lf_pixel_clues *p = l->pixels;
    for (int c = 0; c < 3; c++) {
        float albedo = p->diffuse[c][other]; // of a metal 0, and so is its light
        diffuse[c] = albedo > 0 ? l->diffuse[c][other] / albedo * p->diffuse[c][pixel] : 0;
        glossy[c] = l->glossy[c][other];
    }
}

// Near a lamp, at the edge of its cone or of a highlight, four pixels differ too much for their mean to hold.
static bool take_mean(const struct lighting *l, size_t pixel, const size_t others[4])
{
    float diffuse[4][3], glossy[4][3];
    for (int k = 0; k < 4; k++)
        reflect_as(l, others[k], pixel, diffuse[k], glossy[k]);
    for (int c = 0; c < 3; c++) {
        float least = INFINITY, most = 0, least_glossy = INFINITY, most_glossy = 0;
        for (int k = 0; k < 4; k++) {
            least = lf_min(least, diffuse[k][c]);
            most = lf_max(most, diffuse[k][c]);
            least_glossy = lf_min(least_glossy, glossy[k][c]);
            most_glossy = lf_max(most_glossy, glossy[k][c]);
        }
        if (most - least + most_glossy - least_glossy > SPREAD * (least + least_glossy))
            return false;
    }
    for (int c = 0; c < 3; c++) {
        l->diffuse[c][pixel] =
            lf_finite(0.25f * (diffuse[0][c] + diffuse[1][c] + diffuse[2][c] + diffuse[3][c]));
        l->glossy[c][pixel] = lf_finite(0.25f * (glossy[0][c] + glossy[1][c] + glossy[2][c] + glossy[3][c]));
    }
    return true;
}

// The lattice between whose pixels one lies; 0: it is lit itself.
static uint32_t lattice_of(const struct lighting *l, size_t pixel)
{
    uint32_t between = l->pixels->between.items[pixel];
    if (between == LF_BETWEEN_BENT)
        return l->bent ? 2 : 0;
    return between <= l->coarsest ? between : 0;
}

// Whether this pass has to light a pixel itself. A pass between pixels leaves means where they hold.
static bool has_to_light(const struct lighting *l, uint32_t x, uint32_t y)
{
    const struct lf_pixel_clues *p = l->pixels;
    size_t pixel = (size_t)y * p->width + x, others[4];
    uint32_t lattice = lattice_of(l, pixel);
    if (l->step) {
        if (lattice != l->step)
            return false;
        lf_pixel_corners(p, x, y, lattice, others);
        return !take_mean(l, pixel, others);
    }
    if (p->mask[pixel] > 0)
        return !lattice;
    for (int c = 0; c < 3; c++)
        l->diffuse[c][pixel] = l->glossy[c][pixel] = 0;
    return false;
}

static void light_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct lighting *l = user;
    const struct lf_pixel_clues *p = l->pixels;
    size_t lists[LF_SAMPLE_FAR + 1][RUN];
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < p->width; x += RUN) {
            uint32_t counts[LF_SAMPLE_FAR + 1] = {0};
            for (uint32_t i = x; i < p->width && i < x + RUN; i++) {
                size_t pixel = (size_t)y * p->width + i;
                if (!has_to_light(l, i, y))
                    continue;
                enum lf_sampling sampling = sampling_of(l, pixel);
                lists[sampling][counts[sampling]++] = pixel;
            }
            for (int i = 0; i <= LF_SAMPLE_FAR; i++)
                light_list(l, lists[i], counts[i], (enum lf_sampling)i);
        }
}

void lf_direct_view(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                    const struct lf_light_clues *light, float *const diffuse[3], float *const glossy[3])
{
    enum lf_questions questions = lf_questions_of(lf_tracer_snapshot(scene->tracer)->light_count);
    struct lighting l = {scene, pixels, light, diffuse, glossy, .coarsest = 2};
    if (questions >= LF_ASK_FEW) { // what one of many lights is wrong by counts less
        l.coarsest = 4;
        l.bent = true;
    }
    ng_jobs_for(scene->jobs, pixels->height, ROWS, light_rows, &l);
    for (l.step = l.coarsest; l.step > 1; l.step /= 2)
        ng_jobs_for(scene->jobs, pixels->height, ROWS, light_rows, &l);
}
