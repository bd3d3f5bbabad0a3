// Polygons into triangles by ear clipping (Meisters, "Polygons have ears", 1975): a corner is cut off where
// it is convex and no other corner lies in its triangle.
#include "asset/obj_internal.h"

struct ring {
    const double (*points)[2];
    uint32_t *next, *prev;
    uint64_t *work;
};

static double turn(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static bool same(const double a[2], const double b[2])
{
    return a[0] == b[0] && a[1] == b[1];
}

static bool is_ear(const struct ring *r, uint32_t b)
{
    const double *pa = r->points[r->prev[b]], *pb = r->points[b], *pc = r->points[r->next[b]];
    if (*r->work == 0)
        return true;
    --*r->work;
    if (!(turn(pa, pb, pc) > 0))
        return false;
    for (uint32_t i = r->next[r->next[b]]; i != r->prev[b]; i = r->next[i]) {
        const double *p = r->points[i];
        if (*r->work == 0)
            return true;
        --*r->work;
        // Holes are joined to the outline by edges that are passed twice.
        if (same(p, pa) || same(p, pb) || same(p, pc))
            continue;
        if (turn(pa, pb, p) >= 0 && turn(pb, pc, p) >= 0 && turn(pc, pa, p) >= 0)
            return false;
    }
    return true;
}

static double distance_squared(const double a[2], const double b[2])
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

void ng_obj_triangles(const struct obj_polygon *p, uint32_t *out)
{
    struct ring r = {p->points, p->links, p->links + p->count, p->work};
    for (uint32_t i = 0; i < p->count; i++) {
        r.next[i] = (i + 1) % p->count;
        r.prev[i] = (i + p->count - 1) % p->count;
    }
    // A quadrilateral is divided along its shorter diagonal.
    uint32_t b = p->count == 4 && distance_squared(p->points[1], p->points[3]) <
                                      distance_squared(p->points[0], p->points[2])
                     ? 0
                     : 1;
    uint32_t refused = 0;
    for (uint32_t left = p->count; left >= 3;) {
        uint32_t a = r.prev[b], c = r.next[b];
        // Where no corner is an ear, the outline crosses itself.
        if (left > 3 && refused < left && !is_ear(&r, b)) {
            refused++;
            b = c;
            continue;
        }
        *out++ = a;
        *out++ = b;
        *out++ = c;
        r.next[a] = c;
        r.prev[c] = a;
        left--;
        refused = 0;
        b = r.next[c] == a ? c : r.next[c];
    }
}
