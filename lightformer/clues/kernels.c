// Compiled once for each instruction set (CMakeLists.txt), NG_KERNELS being the name of its table. The loop
// over lanes is innermost and free of branches and calls, so that one iteration becomes one vector operation.
#include "lightformer/clues/kernels.h"

#include "shaders/shared/brdf.h"

#include <math.h>
#include <string.h>

#define LANES  _Pragma("omp simd") for (int i = 0; i < LF_LANES; i++)
// What must be inlined, as its arguments are constants there, or its arrays would go through memory.
#define ALWAYS static inline __attribute__((always_inline))

#define LEAST_DISTANCE 1e-12f // squared
#define LEAST_BLUR     1e-3f  // of an edge, in half widths of the light

// Emitters seen from near by, where their samples show one by one: distances, in units of their coarseness,
// from which on directions around the normal share the light, and all of them do.
#define NEAR_BEGINS 0.8f
#define NEAR_WHOLE  0.4f

// What does not change from sample to sample.
struct surface {
    float view[3][LF_LANES], nv[LF_LANES];
    float alpha[LF_LANES], smith[LF_LANES]; // ng_brdf_smith of nv
    float chosen[LF_LANES];                 // density of a direction that the BRDF chooses, over D
    float tangent[3][LF_LANES], bitangent[3][LF_LANES]; // set where brdf_samples are sampled
};

// Sums of light * cosine * (1 - m5), and of light * cosine * D V * (1 - m5) and ... * m5, where m5 is the
// fifth power in Schlick's F: albedo and F0 enter at the end.
struct sums {
    float diffuse[3][LF_LANES], facing[3][LF_LANES], grazing[3][LF_LANES];
};

static inline float dot(float ax, float ay, float az, float bx, float by, float bz)
{
    return ax * bx + ay * by + az * bz;
}

// Where the shading normal turns away from the viewer, the viewer counts as grazing.
static void see(const struct lf_shading_points *p, struct surface *s)
{
    LANES
    {
        float nx = p->normal[0][i], ny = p->normal[1][i], nz = p->normal[2][i];
        float vx = p->view[0][i], vy = p->view[1][i], vz = p->view[2][i];
        float nv = dot(nx, ny, nz, vx, vy, vz);
        float fx = vx - nx * nv, fy = vy - ny * nv, fz = vz - nz * nv;
        float scale =
            ng_sqrt((1 - LF_LEAST_COSINE * LF_LEAST_COSINE) / ng_max(dot(fx, fy, fz, fx, fy, fz), 1e-20f));
        bool away = nv < LF_LEAST_COSINE;
        s->view[0][i] = away ? fx * scale + nx * LF_LEAST_COSINE : vx;
        s->view[1][i] = away ? fy * scale + ny * LF_LEAST_COSINE : vy;
        s->view[2][i] = away ? fz * scale + nz * LF_LEAST_COSINE : vz;
        nv = away ? LF_LEAST_COSINE : nv;
        s->nv[i] = nv;
        float alpha = ng_brdf_alpha(p->roughness[i]), smith = ng_brdf_smith(nv, alpha);
        s->alpha[i] = alpha;
        s->smith[i] = smith;
        s->chosen[i] = 0.5f / (nv + smith); // as ng_brdf_sample_pdf
    }
}

static void make_frames(const float axis[3][LF_LANES], const float toward[3][LF_LANES],
                        float tangent[3][LF_LANES], float bitangent[3][LF_LANES])
{
    LANES
    {
        const struct lf_frame frame =
            lf_frame_toward((const float[3]){axis[0][i], axis[1][i], axis[2][i]},
                            (const float[3]){toward[0][i], toward[1][i], toward[2][i]});
        for (int c = 0; c < 3; c++) {
            tangent[c][i] = frame.tangent[c];
            bitangent[c][i] = frame.bitangent[c];
        }
    }
}

// ---- light samples ---------------------------------------------------------------------------------------

// A direction to the light at each lane, what arrives along it, and its density for the balance heuristic.
struct arrival {
    float x[LF_LANES], y[LF_LANES], z[LF_LANES];
    float light[LF_LANES];   // what the sample's weight is multiplied with
    float density[LF_LANES]; // samples per solid angle
};

// From a lane to a point.
struct connection {
    float x, y, z;         // unit
    float square, inverse; // of the length
};

static inline struct connection connect(const float point[3], const struct lf_shading_points *p, int i)
{
    float x = point[0] - p->position[0][i], y = point[1] - p->position[1][i],
          z = point[2] - p->position[2][i];
    float square = ng_max(dot(x, y, z, x, y, z), LEAST_DISTANCE), inverse = 1 / ng_sqrt(square);
    return (struct connection){x * inverse, y * inverse, z * inverse, square, inverse};
}

static inline void set_direction(struct arrival *a, int i, struct connection to)
{
    a->x[i] = to.x;
    a->y[i] = to.y;
    a->z[i] = to.z;
}

static void arrive_from_surface(const struct lf_light_sample *l, const struct lf_shading_points *p,
                                struct arrival *a)
{
    LANES
    {
        struct connection to = connect(l->position, p, i);
        float cosine = -dot(to.x, to.y, to.z, l->normal[0], l->normal[1], l->normal[2]);
        cosine = ng_max(cosine, 0.0f);
        set_direction(a, i, to);
        a->light[i] = cosine * to.inverse * to.inverse;
        a->density[i] = l->density * to.square / ng_max(cosine, 1e-6f);
    }
}

static void arrive_from_point(const struct lf_emitter *emitter, const struct lf_light_sample *l,
                              const struct lf_shading_points *p, struct arrival *a)
{
    LANES
    {
        struct connection to = connect(l->position, p, i);
        float cosine = -dot(to.x, to.y, to.z, l->normal[0], l->normal[1], l->normal[2]);
        float cone = ng_clamp(cosine * emitter->cone_scale + emitter->cone_offset, 0.0f, 1.0f);
        set_direction(a, i, to);
        a->light[i] = cone * cone * to.inverse * to.inverse;
        a->density[i] = 0;
    }
}

static void arrive_from_direction(const struct lf_light_sample *l, struct arrival *a)
{
    LANES
    {
        a->x[i] = -l->normal[0];
        a->y[i] = -l->normal[1];
        a->z[i] = -l->normal[2];
        a->light[i] = 1;
        a->density[i] = l->density;
    }
}

// What a sphere covers of the view from each lane: a cone around the direction to its centre.
struct cap {
    float axis[3][LF_LANES], tangent[3][LF_LANES], bitangent[3][LF_LANES];
    float height[LF_LANES];  // 1 - cosine of its half angle; 0 from inside
    float density[LF_LANES]; // 1 / solid angle
};

static void find_caps(const struct lf_emitter *emitter, const struct lf_shading_points *p, struct cap *cap)
{
    LANES
    {
        struct connection to = connect(emitter->center, p, i);
        float sine2 = emitter->radius * emitter->radius * to.inverse * to.inverse;
        bool outside = sine2 < 1;
        float height = sine2 / (1 + ng_sqrt(ng_max(1 - sine2, 0.0f)));
        cap->height[i] = outside ? height : 0;
        cap->density[i] = outside ? 1 / (2 * NG_SHADER_PI * ng_max(height, 1e-20f)) : 0;
        cap->axis[0][i] = to.x;
        cap->axis[1][i] = to.y;
        cap->axis[2][i] = to.z;
    }
    make_frames(cap->axis, p->normal, cap->tangent, cap->bitangent);
}

// Uniform over the cap; `u` as lf_brdf_samples.
static void arrive_from_cap(const struct cap *cap, const float u[3], float count, struct arrival *a)
{
    LANES
    {
        float height = u[2] * cap->height[i], cosine = 1 - height;
        float sine = ng_sqrt(ng_max(height * (1 + cosine), 0.0f));
        float s = sine * u[0], t = sine * u[1];
        a->x[i] = cap->axis[0][i] * cosine + cap->tangent[0][i] * s + cap->bitangent[0][i] * t;
        a->y[i] = cap->axis[1][i] * cosine + cap->tangent[1][i] * s + cap->bitangent[1][i] * t;
        a->z[i] = cap->axis[2][i] * cosine + cap->tangent[2][i] * s + cap->bitangent[2][i] * t;
        a->light[i] = 2 * NG_SHADER_PI * cap->height[i] / count;
        a->density[i] = cap->density[i] * count;
    }
}

// Adds what arrives. Who shares it: `brdf_samples` directions of the BRDF, the specular part;
// `cosine_samples` directions around the normal, of which the part `near` counts, the diffuse part, and the
// specular one if nobody else does. These numbers are constants where this is inlined; 0: none.
ALWAYS void add_arrival(const struct lf_shading_points *p, const struct surface *s, const struct arrival *a,
                        const float weight[3], float brdf_samples, float cosine_samples,
                        const float near[LF_LANES], struct sums *sums)
{
    LANES
    {
        float x = a->x[i], y = a->y[i], z = a->z[i], nv = s->nv[i], alpha = s->alpha[i];
        float cosine = dot(x, y, z, p->normal[0][i], p->normal[1][i], p->normal[2][i]);
        float fl = dot(x, y, z, p->flat[0][i], p->flat[1][i], p->flat[2][i]);
        float lv = dot(x, y, z, s->view[0][i], s->view[1][i], s->view[2][i]);
        float nl = ng_max(cosine, 0.0f), light = fl > 0 ? a->light[i] * nl : 0;
        float half = 1 / ng_sqrt(ng_max(2 + 2 * lv, 1e-12f)); // 1 / |l + v|
        float nh = ng_clamp((nl + nv) * half, 0.0f, 1.0f), vh = ng_max((1 + lv) * half, 0.0f);
        float m5 = ng_brdf_f(vh, 0), rest = light * (1 - m5);
        float d = ng_brdf_d(nh, alpha), lobe = d * ng_brdf_v_known(nl, nv, s->smith[i], alpha);
        float kept = 1;
        if (cosine_samples > 0)
            kept = a->density[i] / (a->density[i] + near[i] * cosine_samples * nl / NG_SHADER_PI + 1e-20f);
        if (brdf_samples > 0)
            lobe *= a->density[i] / (a->density[i] + brdf_samples * d * s->chosen[i]);
        else
            lobe *= kept;
        float facing = rest * lobe, grazing = light * m5 * lobe;
        rest *= kept;
        for (int c = 0; c < 3; c++) {
            sums->diffuse[c][i] += rest * weight[c];
            sums->facing[c][i] += facing * weight[c];
            sums->grazing[c][i] += grazing * weight[c];
        }
    }
}

ALWAYS void add_light_samples(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                              const struct surface *s, float brdf_samples, float cosine_samples,
                              const float near[LF_LANES], struct sums *sums)
{
    struct arrival a;
    for (uint32_t k = 0; k < emitter->sample_count; k++) {
        const struct lf_light_sample *l = &emitter->samples[k];
        if (emitter->kind == LF_EMITTER_POINT)
            arrive_from_point(emitter, l, p, &a);
        else if (emitter->kind == LF_EMITTER_DIRECTION)
            arrive_from_direction(l, &a);
        else
            arrive_from_surface(l, p, &a);
        add_arrival(p, s, &a, l->weight, brdf_samples, cosine_samples, near, sums);
    }
}

static inline void add_sphere(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                              const struct surface *s, const struct cap *cap, float brdf_samples,
                              struct sums *sums)
{
    struct arrival a;
    for (uint32_t k = 0; k < LF_BRDF_SAMPLES; k++) {
        arrive_from_cap(cap, lf_brdf_samples[k], LF_BRDF_SAMPLES, &a);
        add_arrival(p, s, &a, emitter->radiance, brdf_samples, 0, NULL, sums);
    }
}

// ---- directions of the BRDF ------------------------------------------------------------------------------

// Directions that a sample chooses at each lane.
struct reflection {
    float x[LF_LANES], y[LF_LANES], z[LF_LANES];
    float value[LF_LANES]; // D V cosine, 0 where it goes nowhere
    float m5[LF_LANES], pdf[LF_LANES];
};

static inline void reflect_lane(const struct lf_shading_points *p, const struct surface *s, float u0,
                                float u1, float u2, struct reflection *r, int i)
{
    float vx = s->view[0][i], vy = s->view[1][i], vz = s->view[2][i], roughness = p->roughness[i];
    struct ng_local_direction v = {
        dot(vx, vy, vz, s->tangent[0][i], s->tangent[1][i], s->tangent[2][i]),
        dot(vx, vy, vz, s->bitangent[0][i], s->bitangent[1][i], s->bitangent[2][i]), s->nv[i]};
    struct ng_local_direction h = ng_brdf_half(v, roughness, u0, u1, u2);
    struct ng_local_direction l = ng_brdf_reflect(v, h);
    float vh = ng_max(v.x * h.x + v.y * h.y + v.z * h.z, 0.0f), nh = ng_clamp(h.z, 0.0f, 1.0f);
    float x = s->tangent[0][i] * l.x + s->bitangent[0][i] * l.y + p->normal[0][i] * l.z;
    float y = s->tangent[1][i] * l.x + s->bitangent[1][i] * l.y + p->normal[1][i] * l.z;
    float z = s->tangent[2][i] * l.x + s->bitangent[2][i] * l.y + p->normal[2][i] * l.z;
    bool above = l.z > 0 && dot(x, y, z, p->flat[0][i], p->flat[1][i], p->flat[2][i]) > 0;
    r->x[i] = x;
    r->y[i] = y;
    r->z[i] = z;
    float d = ng_brdf_d(nh, s->alpha[i]), nl = ng_max(l.z, 0.0f);
    r->value[i] = above ? d * ng_brdf_v_known(nl, v.z, s->smith[i], s->alpha[i]) * nl : 0;
    r->m5[i] = ng_brdf_f(vh, 0);
    r->pdf[i] = d * s->chosen[i];
}

// One sample at all lanes.
ALWAYS void reflect(const struct lf_shading_points *p, const struct surface *s, const float u[3],
                    struct reflection *r)
{
    LANES reflect_lane(p, s, u[0], u[1], u[2], r, i);
}

// One at each.
static void reflect_each(const struct lf_shading_points *p, const struct surface *s,
                         const float u[3][LF_LANES], struct reflection *r)
{
    LANES reflect_lane(p, s, u[0][i], u[1][i], u[2][i], r, i);
}

// What directions meet of the light.
struct meeting {
    float density[LF_LANES]; // with which the light's own samples find the direction, per solid angle
    float part[LF_LANES];    // 1; less where it is the light's edge that is met, 0 beside it
};

// How much of [a - half, a + half] is within [-1, 1].
static inline float overlap(float a, float half)
{
    float width = ng_min(a + half, 1.0f) - ng_max(a - half, -1.0f);
    return ng_max(width, 0.0f) / (2 * half);
}

// Of a flat emitter, in one place: what loops over lanes read stays in registers.
struct plane {
    float center[3], normal[3], u[3], v[3];
    float uu, vv; // squares of u and v
    float area;
};

static inline struct plane plane_of(const struct lf_emitter *emitter)
{
    struct plane p = {.area = emitter->area};
    memcpy(p.center, emitter->center, sizeof p.center);
    memcpy(p.normal, emitter->normal, sizeof p.normal);
    memcpy(p.u, emitter->u, sizeof p.u);
    memcpy(p.v, emitter->v, sizeof p.v);
    p.uu = dot(p.u[0], p.u[1], p.u[2], p.u[0], p.u[1], p.u[2]);
    p.vv = dot(p.v[0], p.v[1], p.v[2], p.v[0], p.v[1], p.v[2]);
    return p;
}

// A direction stands for a sixteenth of its lobe, which is as wide as the density is low. Since all pixels
// take the same sixteen, an edge would show as that many steps; so it is blurred by the width on the light's
// plane.
ALWAYS void meet_plane(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                       const struct reflection *r, float count, struct meeting *m)
{
    const struct plane e = plane_of(emitter);
    const float *u = e.u, *v = e.v, per_u = ng_sqrt(e.uu), per_v = ng_sqrt(e.vv);
    bool disk = emitter->kind == LF_EMITTER_DISK;
    LANES
    {
        float x = e.center[0] - p->position[0][i], y = e.center[1] - p->position[1][i],
              z = e.center[2] - p->position[2][i];
        float cosine = -dot(r->x[i], r->y[i], r->z[i], e.normal[0], e.normal[1], e.normal[2]);
        float height = -dot(x, y, z, e.normal[0], e.normal[1], e.normal[2]);
        float slope = ng_max(cosine, 1e-6f), t = height / slope;
        x = r->x[i] * t - x, y = r->y[i] * t - y, z = r->z[i] * t - z;
        float a = dot(x, y, z, u[0], u[1], u[2]), b = dot(x, y, z, v[0], v[1], v[2]);
        float chosen = LF_BRDF_SAMPLES * r->pdf[i];
        float half = 0.5f * t * ng_sqrt(1 / ng_max(chosen * slope, 1e-12f));
        float half_u = ng_max(half * per_u, LEAST_BLUR), half_v = ng_max(half * per_v, LEAST_BLUR);
        float across = ng_sqrt(a * a + b * b), half_disk = ng_sqrt(half_u * half_v);
        float of_disk = overlap(across, half_disk) * ng_min(1.0f, NG_SHADER_PI / (4 * half_disk));
        m->part[i] = disk ? of_disk : overlap(a, half_u) * overlap(b, half_v);
        float found = count * t * t / (e.area * slope);
        found = height > 0 ? found : 0;
        m->density[i] = cosine > 1e-6f ? found : 0;
    }
}

static void meet_cap(const struct cap *cap, const struct reflection *r, float count, struct meeting *m)
{
    LANES
    {
        float cosine = dot(r->x[i], r->y[i], r->z[i], cap->axis[0][i], cap->axis[1][i], cap->axis[2][i]);
        float chosen = LF_BRDF_SAMPLES * r->pdf[i];
        float radius = ng_sqrt(2 * ng_max(cap->height[i], 1e-12f)); // half angles, nearly
        float half = ng_max(0.5f * ng_sqrt(1 / ng_max(chosen, 1e-12f)) / radius, LEAST_BLUR);
        float across = ng_sqrt(2 * ng_max(1 - cosine, 0.0f)) / radius;
        m->part[i] = overlap(across, half) * ng_min(1.0f, NG_SHADER_PI / (4 * half));
        m->density[i] = count * cap->density[i];
    }
}

static void add_reflection(const struct lf_emitter *emitter, const struct reflection *r,
                           const struct meeting *m, struct sums *sums)
{
    LANES
    {
        bool meets = m->density[i] > 0 && r->pdf[i] > 0;
        float light = meets ? r->value[i] * m->part[i] / (LF_BRDF_SAMPLES * r->pdf[i] + m->density[i]) : 0;
        for (int c = 0; c < 3; c++) {
            sums->facing[c][i] += light * (1 - r->m5[i]) * emitter->radiance[c];
            sums->grazing[c][i] += light * r->m5[i] * emitter->radiance[c];
        }
    }
}

ALWAYS void add_brdf_samples(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                             const struct surface *s, const struct cap *cap, struct sums *sums)
{
    for (uint32_t k = 0; k < LF_BRDF_SAMPLES; k++) {
        struct reflection r;
        struct meeting m;
        reflect(p, s, lf_brdf_samples[k], &r);
        if (emitter->kind == LF_EMITTER_SPHERE)
            meet_cap(cap, &r, LF_BRDF_SAMPLES, &m);
        else
            meet_plane(emitter, p, &r, (float)emitter->sample_count, &m);
        add_reflection(emitter, &r, &m, sums);
    }
}

// ---- directions around the normal ------------------------------------------------------------------------

static inline float share_near(float distance)
{
    return ng_clamp((NEAR_BEGINS - distance) / (NEAR_BEGINS - NEAR_WHOLE), 0.0f, 1.0f);
}

static bool is_any_near(const float share[LF_LANES])
{
    float most = 0;
    for (int i = 0; i < LF_LANES; i++)
        most = ng_max(most, share[i]);
    return most > 0;
}

// What most lanes are not is found out cheaply.
static inline bool may_be_near(const struct lf_emitter *emitter, const struct lf_shading_points *p)
{
    float range = emitter->radius + NEAR_BEGINS * emitter->coarseness, square = range * range;
    const float x = emitter->center[0], y = emitter->center[1], z = emitter->center[2];
    int any = 0;
    _Pragma("omp simd reduction(| : any)") for (int i = 0; i < LF_LANES; i++)
    {
        float dx = p->position[0][i] - x, dy = p->position[1][i] - y, dz = p->position[2][i] - z;
        any |= dot(dx, dy, dz, dx, dy, dz) < square;
    }
    return any;
}

// How much of a flat emitter's light directions around the normal share with its samples; false if none.
static bool find_near_plane(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                            float share[LF_LANES])
{
    const struct plane e = plane_of(emitter);
    const float *u = e.u, *v = e.v, *n = e.normal;
    float per_unit = 1 / emitter->coarseness, skin = emitter->skin; // within it lies the emitter itself
    bool disk = emitter->kind == LF_EMITTER_DISK;
    LANES
    {
        float x = p->position[0][i] - e.center[0], y = p->position[1][i] - e.center[1],
              z = p->position[2][i] - e.center[2];
        float a = dot(x, y, z, u[0], u[1], u[2]), b = dot(x, y, z, v[0], v[1], v[2]);
        float height = dot(x, y, z, n[0], n[1], n[2]);
        // What lies beside the emitter, in half widths.
        float beside_u = ng_max(ng_max(a, -a) - 1, 0.0f), beside_v = ng_max(ng_max(b, -b) - 1, 0.0f);
        float beside_disk = ng_max(ng_sqrt(a * a + b * b) - 1, 0.0f);
        float beside = disk ? beside_disk * beside_disk / ng_min(e.uu, e.vv)
                            : beside_u * beside_u / e.uu + beside_v * beside_v / e.vv;
        float distance = ng_sqrt(height * height + beside) * per_unit;
        float near = share_near(distance);
        share[i] = height > skin ? near : 0;
    }
    return is_any_near(share);
}

// The same of other emitters, by the nearest sample: four of them in a row are twice the coarseness.
static bool find_near_samples(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                              float share[LF_LANES])
{
    float least[LF_LANES];
    LANES least[i] = INFINITY;
    for (uint32_t k = 0; k < emitter->sample_count; k++) {
        const struct lf_light_sample *l = &emitter->samples[k];
        LANES
        {
            float square = connect(l->position, p, i).square * l->density;
            least[i] = ng_min(least[i], square);
        }
    }
    LANES share[i] = share_near(0.5f * ng_sqrt(least[i]));
    return is_any_near(share);
}

// By the cosine; `u` as lf_brdf_samples.
static void choose_by_cosine(const struct lf_shading_points *p, const struct surface *s, const float u[3],
                             struct reflection *r)
{
    float sine = ng_sqrt(u[2]), cosine = ng_sqrt(1 - u[2]), a = u[0] * sine, b = u[1] * sine;
    LANES
    {
        r->x[i] = s->tangent[0][i] * a + s->bitangent[0][i] * b + p->normal[0][i] * cosine;
        r->y[i] = s->tangent[1][i] * a + s->bitangent[1][i] * b + p->normal[1][i] * cosine;
        r->z[i] = s->tangent[2][i] * a + s->bitangent[2][i] * b + p->normal[2][i] * cosine;
        r->pdf[i] = cosine / NG_SHADER_PI;
    }
}

// What directions around the normal find of a flat emitter: the part of its light that its samples leave out.
static void add_cosine_samples(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                               const struct surface *s, float brdf_samples, const float near[LF_LANES],
                               struct sums *sums)
{
    struct sums found;
    memset(&found, 0, sizeof found);
    for (uint32_t k = 0; k < LF_BRDF_SAMPLES; k++) {
        struct reflection r;
        struct meeting m;
        struct arrival a;
        choose_by_cosine(p, s, lf_brdf_samples[k], &r);
        meet_plane(emitter, p, &r, (float)emitter->sample_count, &m);
        LANES
        {
            float chosen = near[i] * LF_BRDF_SAMPLES * r.pdf[i];
            a.x[i] = r.x[i], a.y[i] = r.y[i], a.z[i] = r.z[i];
            a.light[i] = near[i] * m.part[i] / (chosen + m.density[i] + 1e-20f);
            a.light[i] = m.density[i] > 0 ? a.light[i] : 0;
            a.density[i] = 0;
        }
        add_arrival(p, s, &a, emitter->radiance, 0, 0, NULL, &found);
    }
    bool specular = !(brdf_samples > 0); // else directions of the BRDF find it
    for (int c = 0; c < 3; c++)
        LANES
        {
            sums->diffuse[c][i] += found.diffuse[c][i];
            sums->facing[c][i] += specular ? found.facing[c][i] : 0;
            sums->grazing[c][i] += specular ? found.grazing[c][i] : 0;
        }
}

// ---- the kernels -----------------------------------------------------------------------------------------

static void finish(const struct lf_shading_points *p, const struct sums *sums, struct lf_lit *out)
{
    for (int c = 0; c < 3; c++)
        LANES
        {
            float f0 = p->f0[c][i];
            out->diffuse[c][i] = sums->diffuse[c][i] * p->albedo[c][i] * (1 - f0) / NG_SHADER_PI;
            out->glossy[c][i] = sums->facing[c][i] * f0 + sums->grazing[c][i];
        }
}

// What shares the light is constant wherever this is inlined, which it must be, so that surfaces that are
// rough and far do none of the work of weighing.
ALWAYS void light_surfaces(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                           float brdf_samples, float cosine_samples, const float near[LF_LANES],
                           struct lf_lit *out)
{
    struct surface s;
    struct sums sums;
    struct cap cap;
    memset(&sums, 0, sizeof sums);
    see(p, &s);
    if (emitter->kind == LF_EMITTER_SPHERE) {
        find_caps(emitter, p, &cap);
        add_sphere(emitter, p, &s, &cap, brdf_samples, &sums);
    } else {
        add_light_samples(emitter, p, &s, brdf_samples, cosine_samples, near, &sums);
    }
    if (emitter->kind >= LF_EMITTER_RECTANGLE) {
        make_frames(p->normal, p->view, s.tangent, s.bitangent);
        if (cosine_samples > 0 && emitter->kind != LF_EMITTER_SURFACE)
            add_cosine_samples(emitter, p, &s, brdf_samples, near, &sums);
        if (brdf_samples > 0)
            add_brdf_samples(emitter, p, &s, &cap, &sums);
    }
    finish(p, &sums, out);
}

static bool find_near(const struct lf_emitter *emitter, const struct lf_shading_points *p,
                      float share[LF_LANES])
{
    memset(share, 0, LF_LANES * sizeof *share);
    if (!may_be_near(emitter, p))
        return false;
    switch (emitter->kind) {
    case LF_EMITTER_RECTANGLE:
    case LF_EMITTER_DISK:
        return find_near_plane(emitter, p, share);
    case LF_EMITTER_SURFACE:
        return find_near_samples(emitter, p, share);
    default:
        return false;
    }
}

static void direct(const struct lf_emitter *emitter, const struct lf_shading_points *p, bool brdf_samples,
                   struct lf_lit *out)
{
    float cosine_samples = emitter->kind == LF_EMITTER_SURFACE ? LF_COSINE_SAMPLES : LF_BRDF_SAMPLES;
    if (find_near(emitter, p, out->share))
        light_surfaces(emitter, p, brdf_samples ? LF_BRDF_SAMPLES : 0, cosine_samples, out->share, out);
    else if (brdf_samples)
        light_surfaces(emitter, p, LF_BRDF_SAMPLES, 0, out->share, out);
    else
        light_surfaces(emitter, p, 0, 0, out->share, out);
}

// A source is a small disk: its form factor does not grow without bounds where the receiver comes near.
static void add_source(const struct lf_rsm_source *source, const struct lf_shading_points *p,
                       float sums[3][LF_LANES])
{
    LANES
    {
        float x = source->position[0] - p->position[0][i], y = source->position[1] - p->position[1][i],
              z = source->position[2] - p->position[2][i];
        float square = ng_max(dot(x, y, z, x, y, z), LEAST_DISTANCE);
        float receive = dot(x, y, z, p->normal[0][i], p->normal[1][i], p->normal[2][i]);
        float emit = -dot(x, y, z, source->normal[0], source->normal[1], source->normal[2]);
        float factor = ng_max(receive, 0.0f) * ng_max(emit, 0.0f) /
                       (NG_SHADER_PI * square * (NG_SHADER_PI * square + source->area));
        for (int c = 0; c < 3; c++)
            sums[c][i] += factor * source->flux[c];
    }
}

static void rsm_gather(const struct lf_rsm_source *sources, uint32_t count, const struct lf_shading_points *p,
                       float out[3][LF_LANES])
{
    float sums[3][LF_LANES] = {{0}};
    for (uint32_t k = 0; k < count; k++) {
        const struct lf_rsm_source source = sources[k];
        add_source(&source, p, sums);
    }
    memcpy(out, sums, sizeof sums);
}

// ---- rays to the light ------------------------------------------------------------------------------------

#define INSIDE 0.98f // of an emitter's extent

// The point of a flat emitter that a direction comes nearest to: where it meets the plane, drawn in to the
// edge.
static void nearest_of_plane(const struct lf_emitter *l, const struct lf_shading_points *p,
                             const struct reflection *r, float out[3][LF_LANES])
{
    const float *u = l->u, *v = l->v, *n = l->normal;
    bool disk = l->kind == LF_EMITTER_DISK;
    LANES
    {
        float x = l->center[0] - p->position[0][i], y = l->center[1] - p->position[1][i],
              z = l->center[2] - p->position[2][i];
        float cosine = -dot(r->x[i], r->y[i], r->z[i], n[0], n[1], n[2]);
        float t = ng_max(-dot(x, y, z, n[0], n[1], n[2]) / ng_max(cosine, 1e-3f), 0.0f);
        x = r->x[i] * t - x, y = r->y[i] * t - y, z = r->z[i] * t - z;
        float a = dot(x, y, z, u[0], u[1], u[2]), b = dot(x, y, z, v[0], v[1], v[2]);
        float across = ng_sqrt(a * a + b * b), most = ng_max(ng_max(a, -a), ng_max(b, -b));
        float extent = disk ? across : most;
        float part = extent > INSIDE ? INSIDE / extent : 1; // toward the centre
        float off = dot(x, y, z, n[0], n[1], n[2]);
        out[0][i] = l->center[0] + (x - n[0] * off) * part + n[0] * l->skin;
        out[1][i] = l->center[1] + (y - n[1] * off) * part + n[1] * l->skin;
        out[2][i] = l->center[2] + (z - n[2] * off) * part + n[2] * l->skin;
    }
}

static void nearest_of_sphere(const struct lf_emitter *l, const struct lf_shading_points *p,
                              const struct reflection *r, float out[3][LF_LANES])
{
    LANES
    {
        float x = l->center[0] - p->position[0][i], y = l->center[1] - p->position[1][i],
              z = l->center[2] - p->position[2][i];
        float t = ng_max(dot(x, y, z, r->x[i], r->y[i], r->z[i]), 0.0f);
        x = r->x[i] * t - x, y = r->y[i] * t - y, z = r->z[i] * t - z;
        float distance = ng_sqrt(dot(x, y, z, x, y, z));
        float part = ng_min(INSIDE * l->radius / ng_max(distance, 1e-12f), 1.0f);
        out[0][i] = l->center[0] + x * part; // on the disk that is seen
        out[1][i] = l->center[1] + y * part;
        out[2][i] = l->center[2] + z * part;
    }
}

// Among samples, the one whose direction is nearest; the centre, where all turn away.
static void nearest_of_samples(const struct lf_emitter *l, const struct lf_shading_points *p,
                               const struct reflection *r, float out[3][LF_LANES])
{
    float best[LF_LANES];
    LANES
    {
        best[i] = -2;
        out[0][i] = l->center[0], out[1][i] = l->center[1], out[2][i] = l->center[2];
    }
    bool infinite = l->kind == LF_EMITTER_DIRECTION, surface = l->kind == LF_EMITTER_SURFACE;
    float off = surface ? l->skin : 0;
    for (uint32_t k = 0; k < l->sample_count; k++) {
        const struct lf_light_sample *sample = &l->samples[k];
        const float *n = sample->normal;
        LANES
        {
            struct connection to = connect(sample->position, p, i);
            float x = infinite ? -n[0] : to.x, y = infinite ? -n[1] : to.y, z = infinite ? -n[2] : to.z;
            float cosine = dot(x, y, z, r->x[i], r->y[i], r->z[i]);
            cosine = surface && dot(x, y, z, n[0], n[1], n[2]) >= 0 ? -3 : cosine;
            bool nearer = cosine > best[i];
            best[i] = nearer ? cosine : best[i];
            float px = infinite ? p->position[0][i] + 4 * x : sample->position[0] + n[0] * off;
            float py = infinite ? p->position[1][i] + 4 * y : sample->position[1] + n[1] * off;
            float pz = infinite ? p->position[2][i] + 4 * z : sample->position[2] + n[2] * off;
            out[0][i] = nearer ? px : out[0][i];
            out[1][i] = nearer ? py : out[1][i];
            out[2][i] = nearer ? pz : out[2][i];
        }
    }
}

static void aim(const struct lf_emitter *light, const struct lf_shading_points *p, const float u[3][LF_LANES],
                struct lf_aim *out)
{
    struct surface s;
    struct reflection r;
    float target[3][LF_LANES];
    see(p, &s);
    make_frames(p->normal, p->view, s.tangent, s.bitangent);
    reflect_each(p, &s, u, &r);
    if (light->kind == LF_EMITTER_SPHERE)
        nearest_of_sphere(light, p, &r, target);
    else if (light->kind == LF_EMITTER_RECTANGLE || light->kind == LF_EMITTER_DISK)
        nearest_of_plane(light, p, &r, target);
    else
        nearest_of_samples(light, p, &r, target);
    LANES
    {
        float x = target[0][i] - p->position[0][i], y = target[1][i] - p->position[1][i],
              z = target[2][i] - p->position[2][i];
        float square = ng_max(dot(x, y, z, x, y, z), LEAST_DISTANCE), inverse = 1 / ng_sqrt(square);
        x *= inverse, y *= inverse, z *= inverse;
        float cosine = dot(x, y, z, p->normal[0][i], p->normal[1][i], p->normal[2][i]);
        float fl = dot(x, y, z, p->flat[0][i], p->flat[1][i], p->flat[2][i]);
        float lv = dot(x, y, z, s.view[0][i], s.view[1][i], s.view[2][i]);
        float nl = ng_max(cosine, 0.0f), half = 1 / ng_sqrt(ng_max(2 + 2 * lv, 1e-12f)); // 1 / |l + v|
        float nh = ng_clamp((nl + s.nv[i]) * half, 0.0f, 1.0f);
        float lobe = ng_brdf_d(nh, s.alpha[i]) * ng_brdf_v_known(nl, s.nv[i], s.smith[i], s.alpha[i]) * nl;
        out->direction[0][i] = x, out->direction[1][i] = y, out->direction[2][i] = z;
        out->distance[i] = square * inverse;
        out->weight[i] = fl > 0 ? lobe : 0;
    }
}

static void arrive(const struct lf_light_sample *sample, bool infinite, const struct lf_shading_points *p,
                   struct lf_aim *out)
{
    struct arrival a;
    const float *w = sample->weight, mean = (w[0] + w[1] + w[2]) / 3;
    if (infinite)
        arrive_from_direction(sample, &a);
    else
        arrive_from_surface(sample, p, &a);
    LANES
    {
        float x = a.x[i], y = a.y[i], z = a.z[i];
        float cosine = dot(x, y, z, p->normal[0][i], p->normal[1][i], p->normal[2][i]);
        float fl = dot(x, y, z, p->flat[0][i], p->flat[1][i], p->flat[2][i]);
        out->direction[0][i] = x, out->direction[1][i] = y, out->direction[2][i] = z;
        out->distance[i] =
            dot(x, y, z, sample->position[0] - p->position[0][i], sample->position[1] - p->position[1][i],
                sample->position[2] - p->position[2][i]);
        out->weight[i] = fl > 0 ? mean * a.light[i] * ng_max(cosine, 0.0f) : 0;
    }
}

// ---- reflections ------------------------------------------------------------------------------------------

// Of the half vectors between viewers and rays; a ray that a surface does not reflect loses its weight.
struct halves {
    float cosine[LF_RAY_TAPS][LF_LANES];  // of the ray
    float nh[LF_RAY_TAPS][LF_LANES];      // of the half vector
    float tangent[LF_RAY_TAPS][LF_LANES]; // of the half vector, squared
};

// How much a ray from elsewhere counts, by the cosine between the normals and the height over the plane, in
// grains. Far milder than lf_bilateral_weight: there a neighbour's answer is taken as it is, and holds for
// its own normal; here what its ray met is weighed by this surface's own BRDF, so that bent surfaces may
// share.
static inline float ray_weight(float facing, float height)
{
    return ng_max(facing, 0.0f) / (1 + height * height);
}

static void find_halves(const struct lf_shading_points *at, const float per_grain[LF_LANES],
                        const struct lf_ray_window *rays, int tap, struct halves *out, float weight[LF_LANES])
{
    int row = tap / LF_INTERLEAVE_TAPS, column = tap % LF_INTERLEAVE_TAPS;
    float window = rays->across[column] * rays->down[row];
    LANES
    {
        int k = i + column;
        float px = at->position[0][i], py = at->position[1][i], pz = at->position[2][i];
        float nx = at->normal[0][i], ny = at->normal[1][i], nz = at->normal[2][i];
        float met = rays->met[row][k];
        float wx = rays->to[0][row][k] - met * px, wy = rays->to[1][row][k] - met * py,
              wz = rays->to[2][row][k] - met * pz;
        float scale = 1 / ng_sqrt(ng_max(dot(wx, wy, wz, wx, wy, wz), 1e-30f));
        wx *= scale;
        wy *= scale;
        wz *= scale;
        float hx = wx + at->view[0][i], hy = wy + at->view[1][i], hz = wz + at->view[2][i];
        float nh = dot(nx, ny, nz, hx, hy, hz) / ng_sqrt(ng_max(dot(hx, hy, hz, hx, hy, hz), 1e-30f));
        float nl = dot(nx, ny, nz, wx, wy, wz),
              fl = dot(at->flat[0][i], at->flat[1][i], at->flat[2][i], wx, wy, wz);
        float height = per_grain[i] * dot(nx, ny, nz, rays->from[0][row][k] - px, rays->from[1][row][k] - py,
                                          rays->from[2][row][k] - pz);
        float facing =
            dot(nx, ny, nz, rays->normal[0][row][k], rays->normal[1][row][k], rays->normal[2][row][k]);
        float square = nh * nh;
        float kept = nl > 0 ? window * rays->there[row][k] : 0;
        kept = fl > 0 ? kept : 0;
        kept = nh > 0 ? kept : 0;
        weight[i] = kept * ray_weight(facing, height);
        out->cosine[tap][i] = nl;
        out->nh[tap][i] = ng_min(nh, 1.0f);
        float tangent = ng_max(1 - square, 0.0f) / ng_max(square, 1e-6f);
        out->tangent[tap][i] = weight[i] > 0 ? tangent : 1e30f;
    }
}

static void reflect_rays(const struct lf_shading_points *at, const float grain[LF_LANES],
                         const struct lf_ray_window *rays, float weight[LF_RAY_TAPS][LF_LANES])
{
    struct halves h;
    float per_grain[LF_LANES], least[LF_LANES], nv[LF_LANES], roughness[LF_LANES];
    LANES per_grain[i] = 1 / grain[i], least[i] = 1e30f;
    for (int k = 0; k < LF_RAY_TAPS; k++) {
        find_halves(at, per_grain, rays, k, &h, weight[k]);
        LANES least[i] = ng_min(least[i], h.tangent[k][i]);
    }
    LANES
    {
        float alpha = ng_brdf_alpha(at->roughness[i]);
        float cosine = dot(at->normal[0][i], at->normal[1][i], at->normal[2][i], at->view[0][i],
                           at->view[1][i], at->view[2][i]);
        nv[i] = ng_max(cosine, LF_LEAST_COSINE);
        roughness[i] = ng_sqrt(ng_min(ng_sqrt(alpha * alpha + least[i]), 1.0f));
    }
    for (int k = 0; k < LF_RAY_TAPS; k++) {
        int row = k / LF_INTERLEAVE_TAPS, column = k % LF_INTERLEAVE_TAPS;
        LANES
        {
            float density =
                ng_brdf_sample_pdf(nv[i], h.nh[k][i], roughness[i]) + rays->density[row][i + column];
            float nl = ng_max(h.cosine[k][i], 1e-6f); // of a ray that counts it is more
            weight[k][i] *= ng_brdf_lobe(nl, nv[i], h.nh[k][i], roughness[i]) * nl / density;
        }
    }
}

// ---- neighbours ------------------------------------------------------------------------------------------

#define NARROW 0.1f   // alpha
#define SAME   0.999f // overlap of lobes

// What does not change from neighbour to neighbour.
struct own {
    float per_grain[LF_LANES];
    float narrowness[LF_LANES]; // 1 / alpha^2
    float least[LF_LANES];      // overlap that counts
};

static inline struct own own_of(const struct lf_neighbourhood *n)
{
    struct own own;
    LANES
    {
        float alpha = ng_brdf_alpha(n->roughness[i]);
        own.per_grain[i] = 1 / lf_plane_grain(n->distance[i]);
        own.narrowness[i] = 1 / (alpha * alpha);
        own.least[i] = alpha < NARROW ? SAME : 0;
    }
    return own;
}

// How much of a neighbour's lobe is in the pixel's: GGX of the normal between, the peak being 1. `chord`: of
// the normals, squared.
static inline float lobe_overlap(float narrowness, float chord)
{
    float cosine = ng_max(1 - 0.5f * chord, 1e-3f), sine = ng_max(chord * (1 - 0.25f * chord), 0.0f);
    float square = cosine * cosine, part = square / (square + sine * narrowness);
    return part * part;
}

// What a neighbour of each lane adds.
ALWAYS void add_neighbour(const struct lf_neighbourhood *n, const struct own *own, ptrdiff_t to, float window,
                          bool specular, float sum[LF_LANES], float weights[LF_LANES])
{
    LANES
    {
        const ptrdiff_t other = to + i;
        float nx = n->normal[0][i], ny = n->normal[1][i], nz = n->normal[2][i];
        float mx = n->normal[0][other], my = n->normal[1][other], mz = n->normal[2][other];
        float x = n->position[0][other] - n->position[0][i], y = n->position[1][other] - n->position[1][i],
              z = n->position[2][other] - n->position[2][i];
        float height = dot(x, y, z, nx, ny, nz) * own->per_grain[i];
        float weight = n->weight[other] * window * n->mask[other] *
                       lf_bilateral_falloff(height, dot(mx, my, mz, nx, ny, nz));
        if (specular) { // a narrow lobe has an answer of its own, known to those that look the same way
            float dx = nx - mx, dy = ny - my, dz = nz - mz;
            float overlap = lobe_overlap(own->narrowness[i], dot(dx, dy, dz, dx, dy, dz));
            weight *= overlap < own->least[i] ? 0 : overlap;
        }
        weights[i] += weight;
        sum[i] += weight * n->part[other];
    }
}

ALWAYS void average_all(const struct lf_neighbourhood *n, bool specular, float out[LF_LANES])
{
    const struct own own = own_of(n);
    const ptrdiff_t half = LF_INTERLEAVE_HALF;
    float sum[LF_LANES] = {0}, weights[LF_LANES] = {0}, window[LF_INTERLEAVE_TAPS];
    lf_interleave_window(LF_INTERLEAVE_HALF, window);
    for (ptrdiff_t y = -half; y <= half; y++)
        for (ptrdiff_t x = -half; x <= half; x++)
            add_neighbour(n, &own, y * (ptrdiff_t)n->stride + x, window[y + half] * window[x + half],
                          specular, sum, weights);
    LANES
    {
        bool any = weights[i] > 0 && weights[i] - weights[i] == 0;
        out[i] = any ? sum[i] / (any ? weights[i] : 1) : n->part[i];
    }
}

static void average(const struct lf_neighbourhood *n, bool specular, float out[LF_LANES])
{
    if (specular)
        average_all(n, true, out);
    else
        average_all(n, false, out);
}

#define NAME_(x)  #x
#define NAME(x)   NAME_(x)
#define TABLE_(x) lf_kernels_##x
#define TABLE(x)  TABLE_(x)
extern const struct lf_kernels TABLE(NG_KERNELS);
const struct lf_kernels TABLE(NG_KERNELS) = {.name = NAME(NG_KERNELS),
                                             .direct = direct,
                                             .rsm_gather = rsm_gather,
                                             .aim = aim,
                                             .arrive = arrive,
                                             .reflect = reflect_rays,
                                             .average = average};
