// What a ray meets: hits from what Embree tells of them, and which of them a query takes.
#include "lightformer/trace/embree_internal.h"
#include "lightformer/trace/surface.h"
#include "lightformer/trace/view.h"
#include "shaders/shared/coverage.h"

static bool is_beside(const struct lf_query *q, const struct lf_trace_slot *s)
{
    return s->seen.flags & NG_INSTANCE_LAMP &&
           ng_lamp_is_beside(&q->tracer->snapshot->instances[s->instance], q->light);
}

bool lf_accepts(const struct lf_query *q, const struct lf_trace_slot *s, const struct RTCRay *ray,
                const struct RTCHit *h)
{
    struct lf_hit hit;
    if (q->light && (s->seen.place == q->light->place || is_beside(q, s)))
        return false;
    if (q->view && q->lamps != !!(s->seen.flags & NG_INSTANCE_LAMP))
        return false;
    if (q->kind == LF_RAY_PAST_LAMPS)
        return !(s->seen.flags & NG_INSTANCE_LAMP);
    if (!q->visit && (q->kind == LF_RAY_ALL || s->seen.flags & NG_INSTANCE_DOUBLE_SIDED))
        return true;
    if (s->shared) // the ray is in the mesh's space, where the sides are the same
        return ray->dir_x * h->Ng_x + ray->dir_y * h->Ng_y + ray->dir_z * h->Ng_z < 0;
    lf_describe(s, ray, h, &hit);
    if (q->visit)
        q->visit(q->user, &hit);
    return !q->visit && hit.front;
}

void lf_filter_query(const struct RTCFilterFunctionNArguments *a)
{
    const struct lf_query *q = (const void *)a->context;
    for (unsigned int i = 0; i < a->N; i++) {
        if (!a->valid[i])
            continue;
        struct RTCRay ray = lf_ray_of(a->ray, a->N, i);
        struct RTCHit hit = lf_hit_of(a->hit, a->N, i);
        if (!lf_accepts(q, lf_trace_slot_met(q->tracer, &hit), &ray, &hit))
            a->valid[i] = 0;
    }
}

// The side of a surface that a ray meets, and whose surface it is (shaders/shared/coverage.h).
static uint32_t name_surface(const struct lf_trace_slot *s, const struct RTCRay *ray, const struct RTCHit *h)
{
    float cosine = ray->dir_x * h->Ng_x + ray->dir_y * h->Ng_y + ray->dir_z * h->Ng_z;
    bool mirrored =
        !s->shared && s->seen.flags & NG_INSTANCE_MIRRORED; // in a mesh's space sides are the same
    return 2 * ng_entity_index(s->entity) + ((cosine < 0) != mirrored);
}

// Of a ray that is no pixel's: a hash of it, so that it meets the same whoever traces it.
static float ray_threshold(const struct RTCRay *ray, uint32_t surface, uint32_t triangle)
{
    const float numbers[6] = {ray->org_x, ray->org_y, ray->org_z, ray->dir_x, ray->dir_y, ray->dir_z};
    uint32_t words[6], hash = ng_coverage_hash(ng_coverage_hash(surface) + triangle) ^ ray->id;
    memcpy(words, numbers, sizeof words);
    for (int i = 0; i < 6; i++)
        hash = ng_coverage_hash(hash ^ words[i]);
    return (float)(hash >> 8) * NG_COVERAGE_STEP;
}

// As is_cut of engine/shaders/cut.glsl.
static bool is_cut_for_pixel(const struct ng_snapshot_material *m, const struct lf_alpha *a, float threshold)
{
    if (m->alpha_mode == NG_ALPHA_BLEND)
        return a->texel * a->factor <= threshold;
    float cutoff = m->alpha_cutoff / lf_max(a->factor, 1e-6f), part = lf_min(a->level, 1);
    return a->factor < m->alpha_cutoff || a->texel < cutoff + part * (threshold - cutoff);
}

// A meeting of a view's ray. Inside of what is shared the ray is not in the world: the pixel tells where it
// is.
static bool is_cut_in_view(const struct lf_query *q, const struct lf_trace_slot *s, const struct RTCRay *ray,
                           const struct RTCHit *h)
{
    const struct lf_view *v = q->view;
    const uint32_t pixel[2] = {ray->id % v->width, ray->id / v->width};
    const struct lf_ray world = lf_view_ray(v, pixel[0], pixel[1]);
    struct lf_hit hit = {.instance = s->instance, .triangle = h->primID, .barycentric = {h->u, h->v}};
    struct lf_footprint footprint;
    float right[3], down[3];
    lf_mad(world.origin, world.direction, ray->tfar, hit.position);
    lf_triangle_normal(s, h, hit.normal);
    lf_view_steps(v, hit.position, hit.normal, right, down);
    lf_footprint_find(q->tracer, &hit, right, down, &footprint);
    const struct lf_alpha alpha = lf_surface_alpha(q->tracer, &hit, &footprint);
    return is_cut_for_pixel(s->seen.material, &alpha,
                            ng_coverage_threshold(pixel[0], pixel[1], name_surface(s, ray, h), v->subpixel));
}

static bool is_cut(const struct lf_query *q, const struct RTCRay *ray, const struct RTCHit *h)
{
    const struct lf_trace_slot *s = lf_trace_slot_met(q->tracer, h);
    const struct ng_snapshot_material *m = s->seen.material;
    if (m->alpha_mode == NG_ALPHA_OPAQUE)
        return false;
    if (q->view)
        return is_cut_in_view(q, s, ray, h);
    const struct lf_hit hit = {.instance = s->instance, .triangle = h->primID, .barycentric = {h->u, h->v}};
    const struct lf_alpha parts = lf_surface_alpha(q->tracer, &hit, NULL);
    float alpha = parts.texel * parts.factor;
    if (m->alpha_mode == NG_ALPHA_MASK)
        return alpha < m->alpha_cutoff;
    uint32_t surface = name_surface(s, ray, h);
    return alpha <= (q->pixel ? ng_coverage_threshold(q->pixel[0], q->pixel[1], surface, 0)
                              : ray_threshold(ray, surface, h->primID));
}

void lf_filter_mask(const struct RTCFilterFunctionNArguments *a)
{
    const struct lf_query *q = (const void *)a->context;
    for (unsigned int i = 0; i < a->N; i++) {
        if (!a->valid[i])
            continue;
        struct RTCRay ray = lf_ray_of(a->ray, a->N, i);
        struct RTCHit hit = lf_hit_of(a->hit, a->N, i);
        if (is_cut(q, &ray, &hit))
            a->valid[i] = 0;
    }
}
