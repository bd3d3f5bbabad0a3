#include "anim/morph.h"

#include "base/jobs.h"

#include <math.h>
#include <string.h>

static void add_deltas(float *out, size_t width, const uint32_t *vertices, const float *deltas,
                       uint32_t begin, uint32_t end, float weight)
{
    for (size_t i = begin; i < end; i++)
        for (size_t k = 0; k < 3; k++)
            out[vertices[i] * width + k] += weight * deltas[i * 3 + k];
}

// Sums of no length stay.
static void make_unit(float *out, size_t width, const uint32_t *vertices, uint32_t begin, uint32_t end)
{
    for (size_t i = begin; i < end; i++) {
        float *v = out + vertices[i] * width, square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        float scale = square > 0 && isfinite(square) ? 1.0f / sqrtf(square) : 1.0f;
        for (size_t k = 0; k < 3; k++)
            v[k] *= scale;
    }
}

static void each_target(const struct ng_morph_params *p,
                        void (*visit)(const struct ng_morph_params *, uint32_t, uint32_t, float))
{
    uint32_t begin = 0;
    for (uint32_t t = 0; t < p->target_count; t++) {
        uint32_t end = p->target_ends[t];
        if (p->weights[t] < 0 || p->weights[t] > 0)
            visit(p, begin, end, p->weights[t]);
        begin = end;
    }
}

static void add_target(const struct ng_morph_params *p, uint32_t begin, uint32_t end, float weight)
{
    add_deltas(p->out_positions, 3, p->delta_vertices, p->delta_positions, begin, end, weight);
    if (p->delta_normals)
        add_deltas(p->out_normals, 3, p->delta_vertices, p->delta_normals, begin, end, weight);
    if (p->delta_tangents)
        add_deltas(p->out_tangents, 4, p->delta_vertices, p->delta_tangents, begin, end, weight);
}

static void finish_target(const struct ng_morph_params *p, uint32_t begin, uint32_t end, float weight)
{
    NG_UNUSED(weight);
    if (p->delta_normals)
        make_unit(p->out_normals, 3, p->delta_vertices, begin, end);
    if (p->delta_tangents)
        make_unit(p->out_tangents, 4, p->delta_vertices, begin, end);
}

static void morph_meshes(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct ng_morph_params *meshes = user;
    for (uint32_t i = begin; i < end; i++) {
        const struct ng_morph_params *p = &meshes[i];
        memcpy(p->out_positions, p->positions, p->vertex_count * (size_t)12);
        if (p->normals)
            memcpy(p->out_normals, p->normals, p->vertex_count * (size_t)12);
        if (p->tangents)
            memcpy(p->out_tangents, p->tangents, p->vertex_count * (size_t)16);
        each_target(p, add_target);
        each_target(p, finish_target);
    }
}

void ng_morph_batch(struct ng_jobs *jobs, const struct ng_morph_params *meshes, uint32_t count)
{
    ng_jobs_for(jobs, count, 1, morph_meshes, (void *)meshes);
}
