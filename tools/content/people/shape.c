#include "shape.h"

#include "field.h"

#include <stdlib.h>
#include <string.h>

void shape_finish(struct shape *s)
{
    for (int i = 0; i < PEOPLE_PARTS; i++) {
        ng_array_finish(&s->parts[i].vertices);
        ng_array_finish(&s->parts[i].triangles);
    }
}

static void keep_four(struct shape_vertex *v, const struct weights *w)
{
    double left[PEOPLE_JOINTS], sum = 0.0;
    memcpy(left, w->of, sizeof left);
    for (int k = 0; k < 4; k++) {
        int most = 0;
        for (int j = 1; j < PEOPLE_JOINTS; j++)
            most = left[j] > left[most] ? j : most;
        v->joints[k] = left[most] > 0.004 ? (uint8_t)most : 0;
        v->weights[k] = left[most] > 0.004 ? left[most] : 0.0;
        sum += v->weights[k];
        left[most] = 0.0;
    }
    for (int k = 0; k < 4; k++)
        v->weights[k] /= sum;
}

uint32_t shape_vertex(struct shape *s, enum people_part part, struct vec3 place, const double uv[2],
                      const struct weights *w)
{
    struct shape_vertex v = {.place = place, .color = {1, 1, 1}};
    if (uv) {
        v.uv[0] = uv[0];
        v.uv[1] = uv[1];
    }
    keep_four(&v, w);
    s->failed |= !ng_array_push(&s->parts[part].vertices, v);
    return s->failed ? 0 : (uint32_t)s->parts[part].vertices.count - 1;
}

struct shape_vertex *shape_at(struct shape *s, enum people_part part, uint32_t index)
{
    return &s->parts[part].vertices.items[index];
}

static void triangle(struct shape *s, enum people_part part, uint32_t a, uint32_t b, uint32_t c)
{
    if (s->failed || a == b || b == c || a == c)
        return;
    const struct shape_vertex *v = s->parts[part].vertices.items;
    struct vec3 n = vec3_cross(vec3_sub(v[b].place, v[a].place), vec3_sub(v[c].place, v[a].place));
    if (vec3_length(n) < 1e-10) // of no size
        return;
    const uint32_t corners[3] = {a, b, c};
    for (int k = 0; k < 3; k++)
        s->failed |= !ng_array_push(&s->parts[part].triangles, corners[k]);
}

void shape_quad(struct shape *s, enum people_part part, uint32_t a, uint32_t b, uint32_t c, uint32_t d,
                bool flip)
{
    if (s->failed)
        return;
    if (flip) {
        uint32_t t = b;
        b = d;
        d = t;
    }
    // Along the shorter diagonal.
    const struct shape_vertex *v = s->parts[part].vertices.items;
    if (vec3_length(vec3_sub(v[a].place, v[c].place)) <=
        vec3_length(vec3_sub(v[b].place, v[d].place)) + 1e-6) {
        triangle(s, part, a, b, c);
        triangle(s, part, a, c, d);
    } else {
        triangle(s, part, a, b, d);
        triangle(s, part, b, c, d);
    }
}

// The mean of a vertex and of its neighbours, which `count` and `sum` hold of places and weights.
static void relax_vertex(struct shape_vertex *v, const struct vec3 *sum, const struct weights *weights,
                         double count, double near)
{
    v->place = vec3_mix(v->place, vec3_scale(*sum, 1.0 / count), 0.5 * near);
    struct weights w = {0};
    for (int k = 0; k < 4; k++)
        w.of[v->joints[k]] += v->weights[k] * (1.0 - 0.5 * near);
    for (int j = 0; j < PEOPLE_JOINTS; j++)
        w.of[j] += weights->of[j] / count * 0.5 * near;
    keep_four(v, &w);
}

void shape_relax(struct shape *s, enum people_part part, struct vec3 at, double radius, int steps)
{
    struct shape_part *p = &s->parts[part];
    size_t n = p->vertices.count + 1;
    struct vec3 *sum = calloc(n, sizeof *sum);
    struct weights *weights = calloc(n, sizeof *weights);
    double *count = calloc(n, sizeof *count);
    s->failed |= !sum || !weights || !count;
    for (int step = 0; step < steps && !s->failed; step++) {
        memset(sum, 0, n * sizeof *sum);
        memset(weights, 0, n * sizeof *weights);
        memset(count, 0, n * sizeof *count);
        for (size_t t = 0; t < p->triangles.count; t++) { // each edge once from either side
            uint32_t a = p->triangles.items[t], b = p->triangles.items[t % 3 == 2 ? t - 2 : t + 1];
            const struct shape_vertex *v = &p->vertices.items[b];
            sum[a] = vec3_add(sum[a], v->place);
            for (int k = 0; k < 4; k++)
                weights[a].of[v->joints[k]] += v->weights[k];
            count[a] += 1.0;
        }
        for (size_t v = 0; v < p->vertices.count; v++) {
            double near = ramp(vec3_length(vec3_sub(p->vertices.items[v].place, at)), radius, 0.6 * radius);
            if (count[v] > 2.5 && near > 0.0)
                relax_vertex(&p->vertices.items[v], &sum[v], &weights[v], count[v], near);
        }
    }
    free(sum);
    free(weights);
    free(count);
}

void shape_prune(struct shape *s)
{
    for (int i = 0; i < PEOPLE_PARTS && !s->failed; i++) {
        struct shape_part *p = &s->parts[i];
        uint32_t *to = calloc(p->vertices.count + 1, sizeof *to), kept = 0;
        if (!to) {
            s->failed = true;
            return;
        }
        for (size_t t = 0; t < p->triangles.count; t++)
            to[p->triangles.items[t]] = 1;
        for (size_t v = 0; v < p->vertices.count; v++)
            if (to[v]) {
                p->vertices.items[kept] = p->vertices.items[v];
                to[v] = kept++;
            }
        for (size_t t = 0; t < p->triangles.count; t++)
            p->triangles.items[t] = to[p->triangles.items[t]];
        p->vertices.count = kept;
        free(to);
    }
}

void shape_normals(struct shape *s)
{
    for (int i = 0; i < PEOPLE_PARTS && !s->failed; i++) {
        struct shape_part *p = &s->parts[i];
        struct vec3 *sum = calloc(p->vertices.count + 1, sizeof *sum);
        if (!sum) {
            s->failed = true;
            return;
        }
        for (size_t t = 0; t + 2 < p->triangles.count; t += 3)
            for (int k = 0; k < 3; k++) {
                uint32_t at = p->triangles.items[t + (size_t)k];
                struct vec3 o = p->vertices.items[at].place;
                struct vec3 a =
                    vec3_sub(p->vertices.items[p->triangles.items[t + (size_t)(k + 1) % 3]].place, o);
                struct vec3 b =
                    vec3_sub(p->vertices.items[p->triangles.items[t + (size_t)(k + 2) % 3]].place, o);
                struct vec3 n = vec3_cross(a, b);
                double size = vec3_length(n), angle = atan2(size, vec3_dot(a, b));
                if (size > 1e-14)
                    sum[at] = vec3_add(sum[at], vec3_scale(n, angle / size));
            }
        for (size_t v = 0; v < p->vertices.count; v++)
            if (vec3_length(p->vertices.items[v].normal) == 0.0)
                p->vertices.items[v].normal = vec3_normalize(sum[v]);
        free(sum);
    }
}
