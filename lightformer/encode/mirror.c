// What smooth surfaces reflect: one ray each at every n-th pixel, lit where it ends, blurred on the lattice
// of the rays by passes of growing width (Dammertz et al. 2010) as far as roughness and distance blur a
// reflection, and spread to the pixels between.
//
// A reflection at distance t behind a surface at distance d from the eye moves across the screen as something
// at d
// + t does. So the lobe's width, seen at the end of the ray, is lobe * t / (d + t) * focal length in pixels.
#include "lightformer/encode/clues_internal.h"

#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"

#include <string.h>

#define SHADOW_RAYS     4 // to an extended light
#define SHADOW_REACH    0.999f
#define LEAST_ROUGHNESS 0.3f // of what is seen in a mirror: sharper highlights there would alias
#define CHANNELS        8    // of what a hit shows, room included: loops of a fixed, round number vectorize
#define PIXEL_CHANNELS  7    // nearness, albedo + F0, emission
#define LIGHT_CHANNELS  6    // direct light, bounce * albedo
#define PLANE_GRAIN     0.02f
#define LEAST_WEIGHT    0.02f

struct cast {
    const struct lf_encode_scene *scene;
    struct lf_pixel_clues *pixels;
    float focal; // pixels
};

static bool is_smooth(const struct lf_pixel_clues *p, size_t pixel)
{
    return p->mask[pixel] > 0 && p->roughness[pixel] < LF_SMOOTH;
}

// ---- rays ------------------------------------------------------------------------------------------------

static uint32_t count_smooth(const struct lf_pixel_clues *p, uint32_t spacing)
{
    uint32_t count = 0;
    for (size_t y = 0; y < p->height; y += spacing)
        for (size_t x = 0; x < p->width; x += spacing)
            count += is_smooth(p, y * p->width + x);
    return count;
}

static ng_result choose_pixels(uint32_t budget, struct lf_pixel_clues *p)
{
    struct lf_mirror *m = &p->reflections;
    m->spacing = 1;
    while (count_smooth(p, m->spacing) > budget)
        m->spacing *= 2;
    m->width = (p->width + m->spacing - 1) / m->spacing;
    m->height = (p->height + m->spacing - 1) / m->spacing;
    m->hits.count = 0;
    if (!ng_array_resize(&m->hit_at, (size_t)m->width * m->height) ||
        !ng_array_reserve(&m->hits, m->hit_at.count))
        return ng_out_of_memory("the reflections of a picture");
    for (size_t i = 0; i < m->hit_at.count; i++) {
        size_t pixel = i / m->width * m->spacing * p->width + i % m->width * m->spacing;
        m->hit_at.items[i] = 0;
        if (!is_smooth(p, pixel))
            continue;
        m->hits.items[m->hits.count++] = (struct lf_mirror_hit){.pixel = (uint32_t)pixel};
        m->hit_at.items[i] = (uint32_t)m->hits.count;
    }
    return NG_OK;
}

static void take(float *const planes[3], size_t pixel, float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = planes[c][pixel];
}

// About the shading normal; about the geometric one where that would lead into the surface.
static void reflect(const struct lf_pixel_clues *p, size_t pixel, float out[3])
{
    float view[3], normal[3], flat[3];
    take(p->view, pixel, view);
    take(p->normal, pixel, normal);
    take(p->flat, pixel, flat);
    for (int i = 0; i < 2; i++) {
        const float *n = i ? flat : normal;
        lf_scale(n, 2 * lf_dot(n, view), out);
        lf_mad(out, view, -1, out);
        if (lf_dot(out, flat) > 0)
            break;
    }
    lf_normalize(out);
}

static void set_surface(const struct lf_pixel_clues *p, const struct lf_surface *s, const float direction[3],
                        struct lf_mirror_hit *out)
{
    lf_to_scene(&p->space, s->position, out->position);
    memcpy(out->normal, s->normal, sizeof out->normal);
    memcpy(out->flat, s->flat_normal, sizeof out->flat);
    lf_scale(direction, -1, out->view);
    out->roughness = fmaxf(s->roughness, LEAST_ROUGHNESS);
    for (int c = 0; c < 3 && !lf_surface_is_black(s); c++) {
        out->albedo[c] = lf_finite(s->albedo[c]);
        out->f0[c] = lf_finite(s->f0[c]);
        out->emission[c] = lf_finite(s->emission[c]);
    }
}

static void cast_rays(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct cast *cast = user;
    const struct lf_pixel_clues *p = cast->pixels;
    for (uint32_t i = begin; i < end; i++) {
        struct lf_mirror_hit *hit = &p->reflections.hits.items[i];
        struct lf_ray ray = {.near = 0, .far = INFINITY};
        struct lf_hit met;
        struct lf_surface surface;
        float position[3], flat[3];
        take(p->position, hit->pixel, position);
        take(p->flat, hit->pixel, flat);
        lf_to_world(&p->space, position, position);
        reflect(p, hit->pixel, ray.direction);
        lf_trace_origin(cast->scene->tracer, position, flat, ray.direction, ray.origin);
        hit->met = lf_trace_closest(cast->scene->tracer, &ray, LF_RAY_ALL, &met);
        if (!hit->met)
            continue;
        lf_surface_at(cast->scene->tracer, &met, &surface);
        hit->distance = met.distance / p->space.radius;
        set_surface(p, &surface, ray.direction, hit);
    }
}

// ---- blur ------------------------------------------------------------------------------------------------

// Likeness of the surfaces of two pixels: normal, plane, roughness.
static float likeness(const struct lf_pixel_clues *p, size_t pixel, size_t other)
{
    float height = 0, cosine = 0, rough = p->roughness[other] - p->roughness[pixel];
    for (int c = 0; c < 3; c++) {
        height += (p->position[c][other] - p->position[c][pixel]) * p->normal[c][pixel];
        cosine += p->normal[c][other] * p->normal[c][pixel];
    }
    height /= PLANE_GRAIN * p->distance[pixel] + 1e-12f;
    float square = cosine > 0 ? cosine * cosine : 0, eighth = square * square * square * square;
    return eighth * eighth / (1 + height * height) / (1 + 400 * rough * rough);
}

// Pixels over which the lobe spreads the reflection.
static float spread_of(const struct cast *cast, const struct lf_mirror_hit *hit)
{
    float alpha = ng_brdf_alpha(cast->pixels->roughness[hit->pixel]), d = cast->pixels->distance[hit->pixel];
    return alpha * cast->focal * (hit->met ? hit->distance / (hit->distance + d + 1e-12f) : 1);
}

static void find_blur(const struct cast *cast, uint32_t index, uint32_t pass, struct lf_mirror_blur *out)
{
    const struct lf_pixel_clues *p = cast->pixels;
    const struct lf_mirror *m = &p->reflections;
    const struct lf_mirror_hit *hit = &m->hits.items[index];
    int reach = 1 << pass, x0 = (int)(hit->pixel % p->width / m->spacing),
        y0 = (int)(hit->pixel / p->width / m->spacing);
    float spread = spread_of(cast, hit) / (float)(reach * (int)m->spacing), sum = 0;
    float share = spread * spread / (1 + spread * spread); // of a neighbour
    for (int k = 0; k < 9; k++) {
        int x = x0 + (k % 3 - 1) * reach, y = y0 + (k / 3 - 1) * reach;
        bool inside = x >= 0 && y >= 0 && x < (int)m->width && y < (int)m->height;
        uint32_t other = inside ? m->hit_at.items[(size_t)y * m->width + (size_t)x] : 0;
        out->hit[k] = other ? other - 1 : index;
        out->weight[k] = k == 4 ? 1 : 0;
        if (k != 4 && other)
            out->weight[k] =
                share * (k % 2 ? 0.5f : 0.25f) * likeness(p, hit->pixel, m->hits.items[other - 1].pixel);
        sum += out->weight[k];
    }
    for (int k = 0; k < 9; k++)
        out->weight[k] /= sum;
}

static void find_blurs(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct cast *cast = user;
    const struct lf_mirror *m = &cast->pixels->reflections;
    for (uint32_t i = begin; i < end; i++)
        for (uint32_t pass = 0; pass < LF_MIRROR_PASSES; pass++)
            find_blur(cast, i, pass, &m->blurs.items[pass * m->hits.count + i]);
}

struct blurring {
    const struct lf_mirror_blur *blurs; // of a pass
    const float *from;                  // [hits][CHANNELS]
    float *to;
};

static void blur_hits(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct blurring *b = user;
    for (size_t i = begin; i < end; i++) {
        const struct lf_mirror_blur *blur = &b->blurs[i];
        float sum[CHANNELS] = {0};
        for (int k = 0; k < 9; k++)
            for (size_t c = 0; c < CHANNELS; c++)
                sum[c] += blur->weight[k] * b->from[blur->hit[k] * (size_t)CHANNELS + c];
        memcpy(b->to + i * CHANNELS, sum, sizeof sum);
    }
}

// `seen`: two of them; the result is in the second.
static void blur(const struct lf_encode_scene *scene, const struct lf_mirror *m, const struct lf_floats *seen)
{
    for (size_t pass = 0; pass < LF_MIRROR_PASSES; pass++) {
        struct blurring b = {.blurs = m->blurs.items + pass * m->hits.count,
                             .from = seen[pass % 2].list.items,
                             .to = seen[(pass + 1) % 2].list.items};
        ng_jobs_for(scene->jobs, (uint32_t)m->hits.count, 512, blur_hits, &b);
    }
}

// ---- to the pixels between -------------------------------------------------------------------------------

static void find_taps(const struct lf_pixel_clues *p, struct lf_mirror_taps *t)
{
    const struct lf_mirror *m = &p->reflections;
    uint32_t x = t->pixel % p->width, y = t->pixel / p->width, s = m->spacing;
    float fx = (float)(x % s) / (float)s, fy = (float)(y % s) / (float)s, sum = 0;
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t column = x / s + (k & 1), row = y / s + (k >> 1);
        bool inside = column < m->width && row < m->height;
        uint32_t hit = inside ? m->hit_at.items[(size_t)row * m->width + column] : 0;
        t->hit[k] = hit ? hit - 1 : 0;
        t->weight[k] = 0;
        if (hit)
            t->weight[k] = ((k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy) + LEAST_WEIGHT) *
                           (likeness(p, t->pixel, m->hits.items[hit - 1].pixel) + 1e-6f);
        sum += t->weight[k];
    }
    for (int k = 0; k < 4; k++)
        t->weight[k] = sum > 0 ? t->weight[k] / sum : 0;
}

static void find_all_taps(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct cast *cast = user;
    for (uint32_t i = begin; i < end; i++)
        find_taps(cast->pixels, &cast->pixels->reflections.taps.items[i]);
}

static ng_result connect(const struct cast *cast)
{
    struct lf_pixel_clues *p = cast->pixels;
    struct lf_mirror *m = &p->reflections;
    size_t count = (size_t)p->width * p->height;
    m->taps.count = 0;
    if (!ng_array_resize(&m->blurs, LF_MIRROR_PASSES * m->hits.count) || !ng_array_reserve(&m->taps, count))
        return ng_out_of_memory("the reflections of a picture");
    for (size_t i = 0; m->hits.count && i < count; i++)
        if (is_smooth(p, i))
            m->taps.items[m->taps.count++].pixel = (uint32_t)i;
    ng_jobs_for(cast->scene->jobs, (uint32_t)m->hits.count, 256, find_blurs, (void *)cast);
    ng_jobs_for(cast->scene->jobs, (uint32_t)m->taps.count, 1024, find_all_taps, (void *)cast);
    return NG_OK;
}

struct spreading {
    const struct lf_mirror *mirror;
    const float *from;
    uint32_t channels;
    float *planes[PIXEL_CHANNELS];
};

static void spread_taps(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct spreading *s = user;
    for (uint32_t i = begin; i < end; i++) {
        const struct lf_mirror_taps *t = &s->mirror->taps.items[i];
        float sum[CHANNELS] = {0};
        for (int k = 0; k < 4; k++)
            for (size_t c = 0; c < CHANNELS; c++)
                sum[c] += t->weight[k] * s->from[t->hit[k] * (size_t)CHANNELS + c];
        for (uint32_t c = 0; c < s->channels; c++)
            s->planes[c][t->pixel] = sum[c];
    }
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

// Pixels that are not smooth have no reflection.
static void spread(const struct lf_encode_scene *scene, const struct lf_pixel_clues *p,
                   const struct spreading *s)
{
    struct clearing clearing = {.planes = s, .count = (size_t)p->width * p->height};
    ng_jobs_for(scene->jobs, s->channels, 1, clear_planes, &clearing);
    ng_jobs_for(scene->jobs, (uint32_t)s->mirror->taps.count, 2048, spread_taps, (void *)s);
}

// ---- pixels ----------------------------------------------------------------------------------------------

static bool wants_any(const struct lf_encode_scene *s)
{
    return lf_encode_wants(s, LF_INPUT_PIXEL_MIRROR) || lf_encode_wants(s, LF_INPUT_PIXEL_MIRROR_ALBEDO) ||
           lf_encode_wants(s, LF_INPUT_PIXEL_MIRROR_EMISSION) || lf_encode_wants(s, LF_INPUT_VIEW_MIRROR) ||
           lf_encode_wants(s, LF_INPUT_VIEW_MIRROR_BOUNCE);
}

static ng_result fill_pixels(const struct lf_encode_scene *scene, struct lf_pixel_clues *p)
{
    struct lf_mirror *m = &p->reflections;
    for (int i = 0; i < 2; i++)
        if (!ng_array_resize(&m->seen[i].list, CHANNELS * m->hits.count))
            return ng_out_of_memory("the reflections of a picture");
    for (size_t i = 0; i < m->hits.count; i++) {
        const struct lf_mirror_hit *hit = &m->hits.items[i];
        float *seen = m->seen[0].list.items + i * CHANNELS;
        seen[0] = hit->met ? 1 / (1 + hit->distance) : 0;
        lf_mad(hit->albedo, hit->f0, 1, seen + 1);
        memcpy(seen + 4, hit->emission, sizeof hit->emission);
        p->emits = p->emits || lf_max3(hit->emission) > 0;
    }
    blur(scene, m, m->seen);
    struct spreading s = {.mirror = m,
                          .from = m->seen[1].list.items,
                          .channels = PIXEL_CHANNELS,
                          .planes = {p->mirror, p->mirror_albedo[0], p->mirror_albedo[1], p->mirror_albedo[2],
                                     p->emission[0], p->emission[1], p->emission[2]}};
    spread(scene, p, &s);
    p->values.of[LF_INPUT_PIXEL_MIRROR] = p->mirror;
    p->values.of[LF_INPUT_PIXEL_MIRROR_ALBEDO] = p->mirror_albedo[0];
    p->values.of[LF_INPUT_PIXEL_MIRROR_EMISSION] = p->emits ? p->mirror_emission[0] : NULL;
    return NG_OK;
}

ng_result lf_mirror_cast(const struct lf_encode_scene *scene, uint32_t budget, struct lf_pixel_clues *out)
{
    const struct ng_snapshot_camera *camera = &lf_tracer_snapshot(scene->tracer)->camera;
    struct cast cast = {.scene = scene, .pixels = out};
    if (!wants_any(scene))
        return NG_OK;
    cast.focal = lf_finite((float)out->height / (2 * tanf(camera->fov_y / 2)));
    NG_TRY(choose_pixels(budget, out));
    ng_jobs_for(scene->jobs, (uint32_t)out->reflections.hits.count, 64, cast_rays, &cast);
    NG_TRY(connect(&cast));
    return fill_pixels(scene, out);
}

// ---- lights ----------------------------------------------------------------------------------------------

struct lighting {
    const struct lf_encode_scene *scene;
    const struct lf_mirror *mirror;
    const struct lf_light_clues *light;
    float *out; // [hits][CHANNELS]
};

static void set_lane(const struct lf_mirror_hit *hit, int lane, struct lf_points *out)
{
    for (int c = 0; c < 3; c++) {
        out->position[c][lane] = hit->position[c];
        out->normal[c][lane] = hit->normal[c];
        out->flat[c][lane] = hit->flat[c];
        out->view[c][lane] = hit->view[c];
        out->albedo[c][lane] = hit->albedo[c];
        out->f0[c][lane] = hit->f0[c];
    }
    out->roughness[lane] = hit->roughness;
}

// The part of the light that reaches a hit: by rays to the first of its direct VPLs, the same for all hits.
static float visibility(const struct lighting *l, const struct lf_mirror_hit *hit)
{
    const struct lf_light_clues *light = l->light;
    uint32_t count = light->vpl_count < SHADOW_RAYS ? light->vpl_count : SHADOW_RAYS;
    float position[3], sum = 0, seen = 0;
    lf_to_world(&light->space, hit->position, position);
    for (uint32_t i = 0; i < count; i++) {
        struct ng_light_incident in;
        struct lf_ray ray = {.near = 0};
        ng_light_incident_at(&light->unit, &light->vpls.items[i], position, &in);
        float weight = ng_light_mean(in.irradiance) * lf_dot(hit->normal, in.direction);
        if (!(weight > 0) || !(lf_dot(hit->flat, in.direction) > 0))
            continue;
        lf_trace_origin(l->scene->tracer, position, hit->flat, in.direction, ray.origin);
        memcpy(ray.direction, in.direction, sizeof ray.direction);
        ray.far = in.distance * SHADOW_REACH;
        sum += weight;
        seen += lf_trace_occluded(l->scene->tracer, &ray) ? 0 : weight;
    }
    return sum > 0 ? seen / sum : 0;
}

static void light_lanes(const struct lighting *l, size_t first)
{
    size_t left = l->mirror->hits.count - first, count = left < LF_LANES ? left : LF_LANES;
    const struct lf_mirror_hit *hits = l->mirror->hits.items + first;
    struct lf_points points;
    struct lf_lit lit;
    float bounce[3][LF_LANES];
    for (size_t i = 0; i < LF_LANES; i++)
        set_lane(&hits[i < count ? i : 0], (int)i, &points);
    lf_direct_at(l->scene, l->light, &points, (uint32_t)count, false, &lit);
    lf_kernels_of(0)->bounce(l->light->sources.items, (uint32_t)l->light->sources.count, &points, bounce);
    for (size_t i = 0; i < count; i++) {
        float *out = l->out + (first + i) * CHANNELS, lit_sum = 0;
        for (int c = 0; c < 3; c++) {
            out[c] = hits[i].met ? lf_finite(lit.diffuse[c][i] + lit.glossy[c][i]) : 0;
            out[3 + c] = hits[i].met ? lf_finite(bounce[c][i] * hits[i].albedo[c]) : 0;
            lit_sum += out[c];
        }
        float part = lit_sum > 0 ? visibility(l, &hits[i]) : 0;
        lf_scale(out, part, out);
    }
}

static void light_hits(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    for (size_t block = begin; block < end; block++)
        light_lanes(user, block * LF_LANES);
}

ng_result lf_mirror_light(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                          struct lf_light_clues *light, float *const direct[3], float *const bounce[3])
{
    const struct lf_mirror *m = &pixels->reflections;
    for (int i = 0; i < 2; i++)
        if (!ng_array_resize(&light->reflected[i].list, CHANNELS * m->hits.count))
            return ng_out_of_memory("the view of a light");
    struct lighting l = {.scene = scene, .mirror = m, .light = light, .out = light->reflected[0].list.items};
    ng_jobs_for(scene->jobs, (uint32_t)((m->hits.count + LF_LANES - 1) / LF_LANES), 4, light_hits, &l);
    blur(scene, m, light->reflected);
    struct spreading s = {.mirror = m,
                          .from = light->reflected[1].list.items,
                          .channels = LIGHT_CHANNELS,
                          .planes = {direct[0], direct[1], direct[2], bounce[0], bounce[1], bounce[2]}};
    spread(scene, pixels, &s);
    return NG_OK;
}
