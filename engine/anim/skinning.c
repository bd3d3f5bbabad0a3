// Linear blend skinning. For each vertex the joints' matrices are blended by weight, column by column in
// vectors of four floats, and the blend moves position, normal and tangent: 16 multiply-adds of vectors and a
// handful more, no branch, every buffer read and written once in order.
//
// Normals go by the cofactor matrix of the blend (its inverse transpose times its determinant), whose columns
// are cross products of the blend's columns.
#include "anim/skinning.h"

#include "base/jobs.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define GRAIN 512u // vertices a chunk: about 20 microseconds

// Four floats in a register: gcc's and clang's vector extension.
typedef float v4 __attribute__((vector_size(16)));

static inline v4 load(const float *p)
{
    v4 v;
    memcpy(&v, p, sizeof v);
    return v;
}
static inline void store3(float *p, v4 v)
{
    p[0] = v[0];
    p[1] = v[1];
    p[2] = v[2];
}
static inline v4 cross(v4 a, v4 b)
{
    v4 a_yzx = {a[1], a[2], a[0], 0}, b_yzx = {b[1], b[2], b[0], 0};
    v4 c = a * b_yzx - a_yzx * b;
    return (v4){c[1], c[2], c[0], 0};
}
static inline float dot3(v4 a, v4 b)
{
    v4 m = a * b;
    return m[0] + m[1] + m[2];
}
static inline v4 unit(v4 v)
{
    float square = dot3(v, v);
    return v * (square > 0 ? 1.0f / sqrtf(square) : 0.0f);
}

void ng_skin_palette(uint32_t count, const float *joint_world, const float *inverse_bind,
                     struct ng_joint_matrix *palette)
{
    for (uint32_t j = 0; j < count; j++) {
        const float *w = joint_world + (size_t)j * 16, *b = inverse_bind + (size_t)j * 16;
        v4 columns[4] = {load(w), load(w + 4), load(w + 8), load(w + 12)};
        for (uint32_t c = 0; c < 4; c++) {
            v4 column = columns[0] * b[c * 4] + columns[1] * b[c * 4 + 1] + columns[2] * b[c * 4 + 2] +
                        columns[3] * b[c * 4 + 3];
            memcpy(palette[j].column[c], &column, sizeof column);
        }
    }
}

static inline void add_joints(const struct ng_skin_params *p, const uint16_t *joints, const float *weights,
                              int begin, v4 out[4])
{
    for (int k = begin; k < 4; k++) {
        const struct ng_joint_matrix *joint = &p->palette[joints[k]];
        for (int c = 0; c < 4; c++)
            out[c] += load(joint->column[c]) * weights[k];
    }
}

static inline void blend(const struct ng_skin_params *p, uint32_t vertex, v4 out[4])
{
    const size_t at = (size_t)vertex * 4;
    const struct ng_joint_matrix *joint = &p->palette[p->joints[at]];
    for (int c = 0; c < 4; c++)
        out[c] = load(joint->column[c]) * p->weights[at];
    add_joints(p, p->joints + at, p->weights + at, 1, out);
    if (p->joints1)
        add_joints(p, p->joints1 + at, p->weights1 + at, 0, out);
}

static void skin_range(const struct ng_skin_params *p, uint32_t begin, uint32_t end)
{
    for (uint32_t i = begin; i < end; i++) {
        size_t at3 = (size_t)i * 3, at4 = (size_t)i * 4;
        v4 m[4];
        blend(p, i, m);
        const float *position = p->positions + at3;
        store3(p->out_positions + at3, m[0] * position[0] + m[1] * position[1] + m[2] * position[2] + m[3]);
        if (!p->normals && !p->tangents)
            continue;
        v4 yz = cross(m[1], m[2]);
        float side = dot3(m[0], yz) < 0 ? -1.0f : 1.0f; // mirroring joints turn the cofactors around
        if (p->normals) {
            const float *n = p->normals + at3;
            v4 normal = yz * n[0] + cross(m[2], m[0]) * n[1] + cross(m[0], m[1]) * n[2];
            store3(p->out_normals + at3, unit(normal * side));
        }
        if (p->tangents) {
            const float *t = p->tangents + at4;
            store3(p->out_tangents + at4, unit(m[0] * t[0] + m[1] * t[1] + m[2] * t[2]));
            p->out_tangents[at4 + 3] = t[3] * side;
        }
    }
}

struct batch {
    const struct ng_skin_params *meshes;
    uint32_t count;
};

static uint32_t chunks_of(const struct ng_skin_params *p)
{
    return p->vertex_count / GRAIN + (p->vertex_count % GRAIN != 0);
}

// The last mesh whose chunks begin at this one or before: chunks are numbered mesh after mesh.
static uint32_t mesh_of(const struct batch *b, uint32_t chunk)
{
    uint32_t low = 0, high = b->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (b->meshes[middle].first_chunk <= chunk)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void skin_chunks(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct batch *b = user;
    for (uint32_t i = mesh_of(b, begin); i < b->count && b->meshes[i].first_chunk < end; i++) {
        const struct ng_skin_params *p = &b->meshes[i];
        uint32_t first = p->first_chunk, chunks = chunks_of(p);
        for (uint32_t chunk = begin > first ? begin : first; chunk < end && chunk < first + chunks; chunk++) {
            uint32_t from = (chunk - first) * GRAIN, left = p->vertex_count - from;
            skin_range(p, from, from + (left < GRAIN ? left : GRAIN));
        }
    }
}

void ng_skin_batch(struct ng_jobs *jobs, struct ng_skin_params *meshes, uint32_t count)
{
    struct batch b = {meshes, count};
    uint32_t chunks = 0;
    for (uint32_t i = 0; i < count; i++) {
        meshes[i].first_chunk = chunks;
        chunks += chunks_of(&meshes[i]);
    }
    ng_jobs_for(jobs, chunks, 1, skin_chunks, &b);
}

void ng_skin_vertices(struct ng_jobs *jobs, const struct ng_skin_params *p)
{
    struct ng_skin_params one = *p;
    ng_skin_batch(jobs, &one, 1);
}
