// Cages are grown arrays of points and faces. Radii are given for the smooth surface: the control polygon of
// a ring is a little wider than the curve that Catmull-Clark makes of it, by a factor known in closed form.
#include "cage.h"

#include <stdlib.h>

void cage_finish(struct cage *c)
{
    ng_array_finish(&c->points);
    ng_array_finish(&c->sizes);
    ng_array_finish(&c->indices);
    ng_array_finish(&c->uvs);
    ng_array_finish(&c->creases);
    ng_array_finish(&c->corners);
}

uint32_t cage_point(struct cage *c, struct vec3 p)
{
    if (!ng_array_push(&c->points, p))
        c->failed = true;
    return c->failed ? 0 : (uint32_t)c->points.count - 1;
}

void cage_face(struct cage *c, const uint32_t *points, uint32_t count)
{
    if (!ng_array_push(&c->sizes, count))
        c->failed = true;
    for (uint32_t i = 0; i < count && !c->failed; i++)
        if (!ng_array_push(&c->indices, points[i]))
            c->failed = true;
}

void cage_quad(struct cage *c, uint32_t p0, uint32_t p1, uint32_t p2, uint32_t p3)
{
    cage_face(c, (uint32_t[]){p0, p1, p2, p3}, 4);
}

void cage_add_crease(struct cage *c, uint32_t a, uint32_t b, double sharpness)
{
    if (sharpness > 0.0 && !ng_array_push(&c->creases, (struct cage_crease){a, b, sharpness}))
        c->failed = true;
}

void cage_add_corner(struct cage *c, uint32_t point, double sharpness)
{
    if (!ng_array_push(&c->corners, (struct cage_corner){point, sharpness}))
        c->failed = true;
}

// ---- rings ----

uint32_t cage_ring(struct cage *c, uint32_t sides, double radius, double y)
{
    double step = 2.0 * CONTENT_PI / sides;
    double polygon = radius / (2.0 / 3.0 + cos(step) / 3.0); // cubic B-spline: (p[-1] + 4 p[0] + p[1]) / 6
    uint32_t first = (uint32_t)c->points.count;
    for (uint32_t i = 0; i < sides; i++)
        cage_point(c, vec3_make(polygon * sin(step * i), y, polygon * cos(step * i)));
    return first;
}

void cage_bridge(struct cage *c, uint32_t sides, uint32_t lower, uint32_t upper)
{
    for (uint32_t i = 0; i < sides; i++) {
        uint32_t next = (i + 1) % sides;
        cage_quad(c, lower + i, lower + next, upper + next, upper + i);
    }
}

void cage_cap(struct cage *c, uint32_t sides, uint32_t ring, struct vec3 center, bool up)
{
    uint32_t middle = cage_point(c, center);
    for (uint32_t i = 0; i < sides; i += 2) {
        uint32_t a = ring + i, b = ring + i + 1, d = ring + (i + 2) % sides;
        cage_quad(c, middle, up ? a : d, b, up ? d : a);
    }
}

void cage_crease_ring(struct cage *c, uint32_t sides, uint32_t ring, double sharpness)
{
    for (uint32_t i = 0; i < sides; i++)
        cage_add_crease(c, ring + i, ring + (i + 1) % sides, sharpness);
}

uint32_t cage_turn(struct cage *c, uint32_t sides, uint32_t below, const struct cage_profile *profile,
                   uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t ring = cage_ring(c, sides, profile[i].radius, profile[i].y);
        if (below == CAGE_NO_RING)
            cage_cap(c, sides, ring, vec3_make(0.0, profile[i].y, 0.0), false);
        else
            cage_bridge(c, sides, below, ring);
        cage_crease_ring(c, sides, ring, profile[i].sharpness);
        below = ring;
    }
    return below;
}

// ---- solids ----

uint32_t cage_box(struct cage *c, struct vec3 min, struct vec3 max, double sharpness)
{
    static const uint32_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    uint32_t first = (uint32_t)c->points.count;
    for (uint32_t i = 0; i < 8; i++)
        cage_point(c, vec3_make(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z));
    for (uint32_t i = 0; i < 6; i++)
        cage_quad(c, first + faces[i][0], first + faces[i][1], first + faces[i][2], first + faces[i][3]);
    for (uint32_t i = 0; i < 8; i++)
        for (uint32_t bit = 1; bit < 8; bit <<= 1)
            if (!(i & bit))
                cage_add_crease(c, first + i, first + (i | bit), sharpness);
    return first;
}

// ---- the whole ----

void cage_scale(struct cage *c, double s)
{
    for (size_t i = 0; i < c->points.count; i++)
        c->points.items[i] = vec3_scale(c->points.items[i], s);
}

uint32_t cage_triangle_count(const struct cage *c)
{
    return (uint32_t)(c->indices.count - 2 * c->sizes.count);
}

void cage_triangles(const struct cage *c, uint32_t *out)
{
    const uint32_t *face = c->indices.items;
    for (size_t f = 0; f < c->sizes.count; face += c->sizes.items[f++])
        for (uint32_t i = 2; i < c->sizes.items[f]; i++) {
            *out++ = face[0];
            *out++ = face[i - 1];
            *out++ = face[i];
        }
}

void cage_normals(const struct cage *c, struct vec3 *out)
{
    for (size_t i = 0; i < c->points.count; i++)
        out[i] = vec3_make(0.0, 0.0, 0.0);
    const uint32_t *face = c->indices.items;
    for (size_t f = 0; f < c->sizes.count; face += c->sizes.items[f++])
        for (uint32_t i = 2; i < c->sizes.items[f]; i++) {
            const struct vec3 *p = c->points.items;
            uint32_t v[3] = {face[0], face[i - 1], face[i]};
            struct vec3 n = vec3_cross(vec3_sub(p[v[1]], p[v[0]]), vec3_sub(p[v[2]], p[v[0]]));
            for (int k = 0; k < 3; k++)
                out[v[k]] = vec3_add(out[v[k]], n);
        }
    for (size_t i = 0; i < c->points.count; i++)
        out[i] = vec3_normalize(out[i]);
}

uint64_t cage_refined_triangles(const struct cage *c, uint32_t level)
{
    return level ? (uint64_t)c->indices.count * 2u << (2 * (level - 1)) : cage_triangle_count(c);
}
