// What a ray meets: hits from what Embree tells of them, and which of them a query takes.
#include "lightformer/trace/embree_internal.h"

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

void lf_filter_mask(const struct RTCFilterFunctionNArguments *a)
{
    const struct lf_tracer *t = ((const struct lf_query *)(const void *)a->context)->tracer;
    for (unsigned int i = 0; i < a->N; i++) {
        if (!a->valid[i])
            continue;
        struct RTCHit hit = lf_hit_of(a->hit, a->N, i);
        const float barycentric[2] = {hit.u, hit.v};
        if (lf_surface_is_cut(t, lf_trace_slot_met(t, &hit)->instance, hit.primID, barycentric))
            a->valid[i] = 0;
    }
}
