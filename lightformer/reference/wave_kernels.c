// Compiled once for each instruction set (CMakeLists.txt), NG_KERNELS being the name of its table. Every loop
// over lanes is free of branches and calls, so that sixteen iterations become one.
#include "lightformer/reference/wave.h"

#include "light/light.h"
#include "light/unit_shape.h"
#include "lightformer/trace/tracer.h"
#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"

#include <math.h>

#define BLOCK 16
#define LANES _Pragma("omp simd") for (uint32_t i = 0; i < lanes; i++)

#define LEAST_VIEW_COSINE 1e-4f
#define LEAST_SHARE       0.1f  // of a lobe that is there at all
#define MOST_SURVIVAL     0.95f // so that paths end in a white room, too
#define MOST_BELOW_ONE    0x1.fffffep-1f

struct vec {
    float x, y, z;
};

static inline struct vec load(const lf_lanes3 from, uint32_t i)
{
    return (struct vec){from[0][i], from[1][i], from[2][i]};
}

static inline void store(struct vec v, lf_lanes3 to, uint32_t i)
{
    to[0][i] = v.x;
    to[1][i] = v.y;
    to[2][i] = v.z;
}

static inline float dot(struct vec a, struct vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec scale(struct vec a, float t)
{
    return (struct vec){a.x * t, a.y * t, a.z * t};
}

// a + b * t
static inline struct vec mad(struct vec a, struct vec b, float t)
{
    return (struct vec){a.x + b.x * t, a.y + b.y * t, a.z + b.z * t};
}

static inline struct vec pick(bool first, struct vec a, struct vec b)
{
    return (struct vec){first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
}

static inline float max3(struct vec v)
{
    return ng_max(ng_max(v.x, v.y), v.z);
}

static uint32_t whole_blocks(const struct lf_wave *w)
{
    return (w->count + BLOCK - 1) / BLOCK * BLOCK;
}

static void draw(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w), number = w->draw++;
    if (w->sampler == LF_SAMPLER_SOBOL) {
        LANES lf_sobol_2d(w->pixel[i], w->reversed[i], number, &w->u[0][i], &w->u[1][i]);
        return;
    }
    for (int k = 0; k < 2; k++)
        LANES
        {
            struct ng_rng rng = {w->rng_state[i], w->rng_stream[i]};
            w->u[k][i] = ng_rng_float(&rng);
            w->rng_state[i] = rng.state;
        }
}

static void draw_one(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w), number = w->draw++;
    if (w->sampler == LF_SAMPLER_SOBOL) {
        LANES w->u[0][i] = lf_sobol_1d(w->pixel[i], w->reversed[i], number);
        return;
    }
    LANES
    {
        struct ng_rng rng = {w->rng_state[i], w->rng_stream[i]};
        w->u[0][i] = ng_rng_float(&rng);
        w->rng_state[i] = rng.state;
    }
}

// ---- surfaces --------------------------------------------------------------------------------------------
static inline struct vec to_local(const struct lf_wave *w, struct vec d, uint32_t i)
{
    return (struct vec){dot(load(w->tangent, i), d), dot(load(w->bitangent, i), d),
                        dot(load(w->normal, i), d)};
}

static void make_frames(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    LANES
    {
        struct vec n = load(w->normal, i);
        const struct lf_frame frame = lf_frame_around(n.x, n.y, n.z);
        const float *t = frame.tangent, *b = frame.bitangent;
        store((struct vec){t[0], t[1], t[2]}, w->tangent, i);
        store((struct vec){b[0], b[1], b[2]}, w->bitangent, i);
    }
}

static void find_views(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    const float across = ng_sqrt(1 - LEAST_VIEW_COSINE * LEAST_VIEW_COSINE);
    LANES
    {
        struct vec v = to_local(w, scale(load(w->came, i), -1), i);
        float flat = ng_sqrt(v.x * v.x + v.y * v.y), stretch = across / ng_max(flat, 1e-20f);
        bool away = v.z < LEAST_VIEW_COSINE;
        w->view[0][i] = away ? (flat > 0 ? v.x * stretch : 1) : v.x;
        w->view[1][i] = away ? v.y * stretch : v.y;
        w->view[2][i] = away ? LEAST_VIEW_COSINE : v.z;
    }
}

// Estimated reflectance of the two lobes decides how often each is chosen.
static void share_lobes(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    LANES
    {
        float f0 = (w->f0[0][i] + w->f0[1][i] + w->f0[2][i]) / 3, nv = w->view[2][i];
        float albedo = (w->albedo[0][i] + w->albedo[1][i] + w->albedo[2][i]) / 3;
        float specular = ng_brdf_specular_albedo(nv, f0, w->roughness[i]);
        float diffuse = albedo * (1 - ng_brdf_f(nv, f0));
        float share = ng_clamp(specular / (specular + diffuse), LEAST_SHARE, 1 - LEAST_SHARE);
        w->specular_share[i] = diffuse > 0 ? share : 1;
    }
}

static void arrive(struct lf_wave *w)
{
    make_frames(w);
    find_views(w);
    share_lobes(w);
}

// The BRDF at `local`, which is above the surface (elsewhere the result is no more than finite or not).
static void find_lobes(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    LANES
    {
        struct vec l = load(w->local, i), v = load(w->view, i), h = mad(l, v, 1);
        float inverse = 1 / ng_sqrt(dot(h, h)); // both are above, so that h is not zero
        float nh = h.z * inverse, roughness = w->roughness[i], share = w->specular_share[i];
        w->vh[i] = ng_max(dot(v, h) * inverse, 0.0f);
        w->lobe[i] = ng_brdf_lobe(l.z, v.z, nh, roughness);
        w->pdf[i] = share * ng_brdf_sample_pdf(v.z, nh, roughness) + (1 - share) * l.z / NG_SHADER_PI;
    }
}

static void eval(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    find_lobes(w);
    for (int c = 0; c < 3; c++)
        LANES
        {
            float nl = w->local[2][i], f0 = w->f0[c][i], vh = w->vh[i];
            w->value[c][i] = nl * (ng_brdf_diffuse(nl, w->view[2][i], vh, w->albedo[c][i], f0) +
                                   w->lobe[i] * ng_brdf_f(vh, f0));
        }
}

static inline int is_above(const struct lf_wave *w, struct vec local, struct vec direction, uint32_t i)
{
    return (local.z > 0) & (dot(load(w->flat_normal, i), direction) > 0);
}

// ---- lights ----------------------------------------------------------------------------------------------
static void weigh_lights(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    LANES
    {
        w->light_total[i] = 0;
        w->light[i] = 0;
        w->chosen[i] = 1;
        w->below[i] = 0;
    }
    for (uint32_t l = 0; l < w->lights->count; l++) {
        const struct lf_light_entry *e = &w->lights->entries[l];
        LANES w->light_total[i] +=
            lf_light_weight(e, w->position[0][i], w->position[1][i], w->position[2][i]);
    }
}

// The last light below whose part of [0, 1) u[0] does not lie; what is left of u[0] is uniform again.
static void choose_lights(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w), lit = w->lights->lit;
    lf_lanes next = {0};
    for (uint32_t l = 0; l < w->lights->count; l++) {
        const struct lf_light_entry *e = &w->lights->entries[l];
        if (!(e->strength > 0))
            continue;
        LANES
        {
            float weight = lf_light_weight(e, w->position[0][i], w->position[1][i], w->position[2][i]);
            float probability = lf_light_probability(weight, w->light_total[i], lit);
            bool reached = w->u[0][i] >= next[i];
            w->light[i] = reached ? l : w->light[i];
            w->chosen[i] = reached ? probability : w->chosen[i];
            w->below[i] = reached ? next[i] : w->below[i];
            next[i] += probability;
        }
    }
    LANES w->u[0][i] = ng_min((w->u[0][i] - w->below[i]) / w->chosen[i], MOST_BELOW_ONE);
}

// Where lanes have chosen this light.
static inline void store_sample(struct lf_wave *w, uint32_t l, struct vec position, struct vec normal,
                                uint32_t i)
{
    bool mine = w->light[i] == l;
    store(pick(mine, position, load(w->light_position, i)), w->light_position, i);
    store(pick(mine, normal, load(w->light_normal, i)), w->light_normal, i);
}

static inline struct vec vec_of(const float v[3])
{
    return (struct vec){v[0], v[1], v[2]};
}

static void sample_square(struct lf_wave *w, const struct lf_light_entry *e, uint32_t l)
{
    uint32_t lanes = whole_blocks(w);
    const struct vec normal = vec_of(e->sample.normal), center = vec_of(e->center);
    const struct vec axes[2] = {vec_of(e->axes[0]), vec_of(e->axes[1])};
    LANES
    {
        float x, y;
        ng_light_on_square(w->u[0][i], w->u[1][i], &x, &y);
        store_sample(w, l, mad(mad(center, axes[0], x), axes[1], y), normal, i);
    }
}

static void sample_disk(struct lf_wave *w, const struct lf_light_entry *e, uint32_t l)
{
    uint32_t lanes = whole_blocks(w);
    const struct vec normal = vec_of(e->sample.normal), center = vec_of(e->center);
    const struct vec axes[2] = {vec_of(e->axes[0]), vec_of(e->axes[1])};
    LANES
    {
        float x, y;
        ng_light_on_disk(w->u[0][i], w->u[1][i], &x, &y);
        store_sample(w, l, mad(mad(center, axes[0], x), axes[1], y), normal, i);
    }
}

static void sample_sphere(struct lf_wave *w, const struct lf_light_entry *e, uint32_t l)
{
    uint32_t lanes = whole_blocks(w);
    const struct vec center = vec_of(e->center);
    const float radius = e->axes[0][0];
    LANES
    {
        struct vec n;
        ng_light_on_sphere(w->u[0][i], w->u[1][i], &n.x, &n.y, &n.z);
        store_sample(w, l, mad(center, n, radius), n, i);
    }
}

// ng_light_incident_at for surfaces of one radiance.
static void receive(struct lf_wave *w, const struct lf_light_entry *e, uint32_t l)
{
    uint32_t lanes = whole_blocks(w);
    LANES
    {
        struct vec way = mad(load(w->light_position, i), load(w->position, i), -1);
        float square = dot(way, way), distance = ng_sqrt(square);
        struct vec d = scale(way, 1 / distance);
        float cosine = -dot(load(w->light_normal, i), d), density = e->sample.pdf * square / cosine;
        bool mine = w->light[i] == l;
        bool arrives = (square > 0) & (square < INFINITY) & (cosine > 0);
        w->light_distance[i] = mine ? distance : w->light_distance[i];
        w->light_pdf[i] = mine ? (arrives ? density : 0) : w->light_pdf[i];
        for (int k = 0; k < 3; k++) {
            float arriving = arrives ? e->sample.radiance[k] * (1 / density) : 0;
            w->irradiance[k][i] = mine ? arriving : w->irradiance[k][i];
        }
        store(pick(mine, d, load(w->incident, i)), w->incident, i);
    }
}

// A light of any kind, asked itself.
static void sample_other(struct lf_wave *w, const struct ng_light_source *source, uint32_t i)
{
    struct ng_light_sample sample;
    struct ng_light_incident incident;
    const float u[2] = {w->u[0][i], w->u[1][i]};
    const float position[3] = {w->position[0][i], w->position[1][i], w->position[2][i]};
    ng_light_sample_at(source, u, &sample);
    ng_light_incident_at(source, &sample, position, &incident);
    for (int k = 0; k < 3; k++) {
        w->light_position[k][i] = sample.position[k];
        w->light_normal[k][i] = sample.normal[k];
        w->incident[k][i] = incident.direction[k];
        w->irradiance[k][i] = incident.irradiance[k];
    }
    w->light_distance[i] = incident.distance;
    w->light_pdf[i] = incident.pdf;
}

static void sample_light(struct lf_wave *w, uint32_t l)
{
    const struct lf_light_entry *e = &w->lights->entries[l];
    const struct ng_light_source *source = &w->lights->snapshot->lights[l].source;
    switch (e->form) {
    case LF_LIGHT_OTHER:
        for (uint32_t i = 0; i < w->count; i++)
            if (w->light[i] == l)
                sample_other(w, source, i);
        return;
    case LF_LIGHT_SQUARE:
        sample_square(w, e, l);
        break;
    case LF_LIGHT_DISK:
        sample_disk(w, e, l);
        break;
    case LF_LIGHT_SPHERE:
        sample_sphere(w, e, l);
        break;
    }
    receive(w, e, l);
}

static bool is_chosen(const struct lf_wave *w, uint32_t l)
{
    uint32_t lanes = whole_blocks(w), any = 0;
    for (uint32_t i = 0; i < lanes; i++)
        any |= w->light[i] == l;
    return any;
}

// From a surface along a direction above it.
static inline struct vec leave(const struct lf_wave *w, uint32_t i)
{
    struct vec p = load(w->position, i);
    return mad(p, load(w->flat_normal, i), lf_trace_offset(w->scene_radius, p.x, p.y, p.z));
}

static void weigh_connections(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    LANES store(to_local(w, load(w->incident, i), i), w->local, i);
    eval(w);
    LANES
    {
        // Divided first: densities of tiny lights overflow when squared.
        float ratio = w->pdf[i] / (w->chosen[i] * w->light_pdf[i]);
        float weight = (w->light_pdf[i] > 0 ? 1 / (1 + ratio * ratio) : 1) / w->chosen[i];
        bool passes = is_above(w, load(w->local, i), load(w->incident, i), i) &
                      (max3(load(w->irradiance, i)) > 0) & (max3(load(w->value, i)) > 0);
        for (int c = 0; c < 3; c++)
            w->whole[c][i] = passes ? w->value[c][i] * w->irradiance[c][i] * weight : 0;
    }
}

// To just before the emitter's own surface.
static void aim(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    LANES
    {
        struct vec d = load(w->incident, i), n = load(w->light_normal, i), p = load(w->light_position, i);
        struct vec from = leave(w, i);
        float off = ng_light_skin(w->scene_radius, p.x, p.y, p.z) + w->place_size;
        struct vec way = mad(mad(p, n, dot(n, d) > 0 ? -off : off), from, -1);
        float length = ng_sqrt(dot(way, way)), inverse = 1 / length;
        bool endless = w->light_distance[i] == INFINITY;
        store(from, w->origin, i);
        store(pick(endless, d, scale(way, inverse)), w->direction, i);
        float far = endless ? INFINITY : length * (1 - 1e-6f);
        w->far[i] = max3(load(w->whole, i)) > 0 ? far : 0;
    }
}

static void connect(struct lf_wave *w)
{
    arrive(w);
    weigh_lights(w);
    draw(w);
    if (w->lights->lit)
        choose_lights(w);
    for (uint32_t l = 0; w->lights->lit && l < w->lights->count; l++)
        if (is_chosen(w, l))
            sample_light(w, l);
    weigh_connections(w);
    aim(w);
}

// ---- directions ------------------------------------------------------------------------------------------
static void choose_directions(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    LANES
    {
        // What is left of u[0] after the choice of a lobe is uniform again.
        float share = w->specular_share[i], u = w->u[0][i], cosine, sine;
        bool specular = u < share;
        ng_turn(specular ? u / share : (u - share) / (1 - share), &cosine, &sine);
        struct ng_local_direction v = {w->view[0][i], w->view[1][i], w->view[2][i]};
        struct ng_local_direction a =
            ng_brdf_reflect(v, ng_brdf_half(v, w->roughness[i], cosine, sine, w->u[1][i]));
        struct ng_local_direction b = ng_brdf_cosine(cosine, sine, w->u[1][i]);
        // Unit, as the frame is.
        struct vec l = pick(specular, (struct vec){a.x, a.y, a.z}, (struct vec){b.x, b.y, b.z});
        store(l, w->local, i);
        struct vec d = scale(load(w->tangent, i), l.x);
        d = mad(d, load(w->bitangent, i), l.y);
        store(mad(d, load(w->normal, i), l.z), w->direction, i);
    }
}

static void scatter(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    draw(w);
    choose_directions(w);
    eval(w);
    LANES
    {
        struct vec value = load(w->value, i);
        float inverse = 1 / w->pdf[i];
        bool passes =
            is_above(w, load(w->local, i), load(w->direction, i), i) & (max3(value) > 0) & (w->pdf[i] > 0);
        store(leave(w, i), w->origin, i);
        for (int c = 0; c < 3; c++)
            w->throughput[c][i] *= w->value[c][i] * inverse;
        w->goes[i] = w->survives[i] = passes;
        w->boost[i] = 1;
    }
}

static void play_roulette(struct lf_wave *w)
{
    uint32_t lanes = whole_blocks(w);
    draw_one(w);
    LANES
    {
        float most = max3(load(w->throughput, i));
        float survival = ng_min(ng_sqrt(most), MOST_SURVIVAL); // README.md: why the root
        w->survives[i] = w->u[0][i] < survival;
        w->boost[i] = 1 / survival;
    }
}

#define LF_JOIN_(a, b) a##b
#define LF_JOIN(a, b)  LF_JOIN_(a, b)
#define LF_QUOTE_(a)   #a
#define LF_QUOTE(a)    LF_QUOTE_(a)

extern const struct lf_wave_kernels LF_JOIN(lf_wave_kernels_, NG_KERNELS);
const struct lf_wave_kernels LF_JOIN(lf_wave_kernels_, NG_KERNELS) = {
    .name = LF_QUOTE(NG_KERNELS), .connect = connect, .scatter = scatter, .play_roulette = play_roulette};
