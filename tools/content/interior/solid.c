// Rounded edges have normals that turn from one face to the next, and faces keep theirs: light runs along the
// edge, and the face stays flat.
#include "solid.h"

#include "base/hash.h"

#include <stdlib.h>

void solid_finish(struct solid *s)
{
    ng_array_finish(&s->vertices);
    ng_array_finish(&s->indices);
}

double solid_random(uint64_t seed, uint64_t i)
{
    return (double)(ng_hash_combine(ng_hash_u64(seed + 77), i) >> 40) * 0x1p-24;
}

uint32_t solid_vertex(struct solid *s, const struct place *p, struct vec3 position, struct vec3 normal,
                      double u, double v)
{
    if (!ng_array_push(&s->vertices,
                       (struct solid_vertex){place_point(p, position), place_direction(p, normal), u, v}))
        s->failed = true;
    return s->failed ? 0 : (uint32_t)s->vertices.count - 1;
}

static void triangle(struct solid *s, uint32_t a, uint32_t b, uint32_t c)
{
    if (s->failed)
        return;
    const struct solid_vertex *v = s->vertices.items;
    struct vec3 n =
        vec3_cross(vec3_sub(v[b].position, v[a].position), vec3_sub(v[c].position, v[a].position));
    if (vec3_length(n) < 1e-12) // at a pole
        return;
    if (!ng_array_push(&s->indices, a) || !ng_array_push(&s->indices, b) || !ng_array_push(&s->indices, c))
        s->failed = true;
}

void solid_quad(struct solid *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    triangle(s, a, b, c);
    triangle(s, a, c, d);
}

// Where in the wood the next board is cut.
static void next_board(struct solid *s, double *u, double *v)
{
    *u = solid_random(1, s->boards);
    *v = solid_random(2, s->boards++);
}

// ---- boxes ----

// Steps across one face of a rounded box: the half of each rounded edge that belongs to it.
enum { ARC = 2 };

struct box_step {
    double at, slope; // offset from the middle; tangent of the normal's angle
};

static int box_steps(double half, double rounding, struct box_step out[2 * ARC])
{
    if (rounding <= 0.0) {
        out[0] = (struct box_step){-half, 0.0};
        out[1] = (struct box_step){half, 0.0};
        return 2;
    }
    for (int i = 0; i < ARC; i++) {
        double angle = 0.25 * CONTENT_PI * (ARC - 1 - i) / (ARC - 1);
        out[i] = (struct box_step){-half + rounding, -tan(angle)};
        out[2 * ARC - 1 - i] = (struct box_step){half - rounding, tan(angle)};
    }
    return 2 * ARC;
}

static struct vec3 axis(int k)
{
    return vec3_make(k == 0, k == 1, k == 2);
}

// The face towards +axis or -axis k of a box with half sizes h.
static void box_face(struct solid *s, const struct place *p, const double h[3], int k, double sign,
                     double rounding, const double board[2])
{
    int a = (k + 1) % 3, b = (k + 2) % 3;
    if (sign < 0.0) { // counter-clockwise from outside
        int other = a;
        a = b;
        b = other;
    }
    struct box_step across[2 * ARC], up[2 * ARC];
    int columns = box_steps(h[a], rounding, across), rows = box_steps(h[b], rounding, up);
    bool grain_across = h[a] > h[b];
    uint32_t first = (uint32_t)s->vertices.count;
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < columns; i++) {
            struct vec3 n = vec3_normalize(
                vec3_add(vec3_scale(axis(k), sign),
                         vec3_add(vec3_scale(axis(a), across[i].slope), vec3_scale(axis(b), up[j].slope))));
            struct vec3 core =
                vec3_add(vec3_scale(axis(k), sign * (h[k] - rounding)),
                         vec3_add(vec3_scale(axis(a), across[i].at), vec3_scale(axis(b), up[j].at)));
            struct vec3 q = vec3_add(core, vec3_scale(n, rounding));
            double along = vec3_dot(q, axis(a)), over = vec3_dot(q, axis(b));
            solid_vertex(s, p, q, n, board[0] + (grain_across ? over : along),
                         board[1] + (grain_across ? along : over));
        }
    for (int j = 0; j + 1 < rows; j++)
        for (int i = 0; i + 1 < columns; i++) {
            uint32_t at = first + (uint32_t)(j * columns + i);
            solid_quad(s, at, at + 1, at + 1 + (uint32_t)columns, at + (uint32_t)columns);
        }
}

void solid_box(struct solid *s, struct place p, double w, double h, double d, double rounding)
{
    const double half[3] = {0.5 * w, 0.5 * h, 0.5 * d};
    double board[2], most = 0.499 * fmin(w, fmin(h, d));
    next_board(s, &board[0], &board[1]);
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++)
            box_face(s, &p, half, k, side ? 1.0 : -1.0, fmin(rounding, most), board);
}

// ---- ways: polylines whose corners are arcs ----

struct step {
    struct vec3 at, in, out; // directions of arrival and departure; they differ at a sharp corner
    double length;           // from the start
};

struct way {
    NG_ARRAY(struct step) steps;
    bool failed;
};

static void push_step(struct way *w, struct vec3 at, struct vec3 in, struct vec3 out)
{
    double length = 0.0;
    if (w->steps.count) {
        const struct step *last = &w->steps.items[w->steps.count - 1];
        length = last->length + vec3_length(vec3_sub(at, last->at));
    }
    w->failed |= !ng_array_push(&w->steps, (struct step){at, in, out, length});
}

// The arc of the given radius that touches both legs of a corner; `fraction` is how much of a leg it may
// take.
static void push_corner(struct way *w, struct vec3 before, struct vec3 at, struct vec3 after, double radius)
{
    struct vec3 in = vec3_normalize(vec3_sub(at, before)), out = vec3_normalize(vec3_sub(after, at));
    double turn = acos(fmin(fmax(vec3_dot(in, out), -1.0), 1.0));
    if (radius <= 0.0 || turn < 1e-3) {
        push_step(w, at, in, out);
        return;
    }
    double leg = radius * tan(0.5 * turn);
    leg = fmin(leg, 0.499 * fmin(vec3_length(vec3_sub(at, before)), vec3_length(vec3_sub(after, at))));
    radius = leg / tan(0.5 * turn);
    // From the arc's centre: `side` to its start, then towards `in`.
    struct vec3 start = vec3_sub(at, vec3_scale(in, leg));
    struct vec3 inwards = vec3_normalize(vec3_sub(out, vec3_scale(in, vec3_dot(in, out))));
    int pieces = (int)ceil(turn / (CONTENT_PI / 8.0));
    for (int i = 0; i <= pieces; i++) {
        double angle = turn * i / pieces;
        struct vec3 p = vec3_add(start, vec3_add(vec3_scale(in, radius * sin(angle)),
                                                 vec3_scale(inwards, radius * (1.0 - cos(angle)))));
        struct vec3 t = vec3_add(vec3_scale(in, cos(angle)), vec3_scale(inwards, sin(angle)));
        push_step(w, p, t, t);
    }
}

static void build_way(struct way *w, const struct solid_bend *bends, size_t count, bool closed)
{
    for (size_t i = 0; i < count; i++) {
        struct vec3 p[3];
        for (size_t k = 0; k < 3; k++) {
            const struct solid_bend *b = &bends[(i + count + k - 1) % count];
            p[k] = vec3_make(b->x, b->y, b->z);
        }
        bool end = !closed && (i == 0 || i + 1 == count);
        if (end) {
            struct vec3 t = vec3_normalize(i ? vec3_sub(p[1], p[0]) : vec3_sub(p[2], p[1]));
            push_step(w, p[1], t, t);
        } else {
            push_corner(w, p[0], p[1], p[2], bends[i].radius);
        }
    }
    if (closed && w->steps.count && !w->failed) {
        struct step first = w->steps.items[0];
        push_step(w, first.at, first.in, first.out);
    }
}

enum { MOST_CORNERS = 64 };

// An outline in XY as a way.
static bool outline_way(struct way *w, const struct solid_corner *outline, size_t count, bool closed)
{
    struct solid_bend bends[MOST_CORNERS];
    count = count < MOST_CORNERS ? count : MOST_CORNERS;
    for (size_t i = 0; i < count; i++)
        bends[i] = (struct solid_bend){outline[i].x, outline[i].y, 0.0, outline[i].radius};
    build_way(w, bends, count, closed);
    return !w->failed;
}

// To the right of the way in XY: outwards of an outline that goes up, or runs counter-clockwise.
static struct vec3 right_of(struct vec3 t)
{
    return vec3_make(t.y, -t.x, 0.0);
}

// ---- turned ----

static uint32_t turn_ring(struct solid *s, const struct place *p, const struct step *at, struct vec3 tangent,
                          uint32_t sides)
{
    struct vec3 n = right_of(tangent);
    uint32_t first = (uint32_t)s->vertices.count;
    for (uint32_t i = 0; i <= sides; i++) {
        double angle = 2.0 * CONTENT_PI * i / sides, x = sin(angle), z = cos(angle);
        bool flat = fabs(n.y) > 0.9; // a disk shows its wood as a board does
        solid_vertex(s, p, vec3_make(at->at.x * x, at->at.y, at->at.x * z), vec3_make(n.x * x, n.y, n.x * z),
                     flat ? at->at.x * x : angle * fmax(at->at.x, 0.02), flat ? at->at.x * z : at->length);
    }
    return first;
}

void solid_turn(struct solid *s, struct place p, const struct solid_corner *outline, size_t count,
                uint32_t sides)
{
    struct way w = {0};
    bool ok = outline_way(&w, outline, count, false);
    s->failed |= !ok;
    uint32_t lower = 0;
    for (size_t i = 0; ok && i < w.steps.count; i++) {
        const struct step *at = &w.steps.items[i];
        uint32_t upper = i ? turn_ring(s, &p, at, at->in, sides) : 0;
        for (uint32_t k = 0; i && k < sides; k++)
            solid_quad(s, lower + k, lower + k + 1, upper + k + 1, upper + k);
        bool sharp = i == 0 || vec3_dot(at->in, at->out) < 0.999;
        lower = sharp && i + 1 < w.steps.count ? turn_ring(s, &p, at, at->out, sides) : upper;
    }
    ng_array_finish(&w.steps);
}

void solid_cylinder(struct solid *s, struct place p, double radius, double height, double rounding,
                    uint32_t sides)
{
    const struct solid_corner outline[4] = {
        {0, 0, 0}, {radius, 0, rounding}, {radius, height, rounding}, {0, height, 0}};
    solid_turn(s, p, outline, 4, sides);
}

// ---- drawn out ----

static void extrude_cap(struct solid *s, const struct place *p, const struct way *w, double z)
{
    struct vec3 middle = vec3_make(0, 0, 0), n = vec3_make(0, 0, z > 0.0 ? 1 : -1);
    size_t count = w->steps.count - 1; // the last is the first
    for (size_t i = 0; i < count; i++)
        middle = vec3_add(middle, vec3_scale(w->steps.items[i].at, 1.0 / (double)count));
    middle.z = z;
    uint32_t center = solid_vertex(s, p, middle, n, middle.x, middle.y);
    for (size_t i = 0; i <= count; i++) {
        struct vec3 q = w->steps.items[i].at;
        q.z = z;
        solid_vertex(s, p, q, n, q.x, q.y);
        uint32_t last = center + (uint32_t)i;
        if (i)
            triangle(s, center, z > 0.0 ? last : last + 1, z > 0.0 ? last + 1 : last);
    }
}

void solid_extrude(struct solid *s, struct place p, const struct solid_corner *outline, size_t count,
                   double d)
{
    struct way w = {0};
    bool ok = outline_way(&w, outline, count, true);
    s->failed |= !ok;
    for (size_t i = 0; ok && i + 1 < w.steps.count; i++) {
        uint32_t first = (uint32_t)s->vertices.count;
        for (int k = 0; k < 4; k++) {
            const struct step *at = &w.steps.items[i + (k == 1 || k == 2)];
            struct vec3 q = at->at;
            q.z = k < 2 ? 0.5 * d : -0.5 * d;
            solid_vertex(s, &p, q, right_of(k == 1 || k == 2 ? at->in : at->out), q.z, at->length);
        }
        solid_quad(s, first, first + 3, first + 2, first + 1);
    }
    if (ok) {
        extrude_cap(s, &p, &w, 0.5 * d);
        extrude_cap(s, &p, &w, -0.5 * d);
    }
    ng_array_finish(&w.steps);
}

// One side of a moulding, from corner to corner in the direction of local X; mitred at 45 degrees.
static void frame_side(struct solid *s, const struct place *p, double half, double out, const struct way *w)
{
    for (size_t i = 0; i + 1 < w->steps.count; i++) {
        uint32_t first = (uint32_t)s->vertices.count;
        for (int k = 0; k < 4; k++) {
            const struct step *at = &w->steps.items[i + (k >= 2)];
            struct vec3 t = k >= 2 ? at->in : at->out;
            double end = half + at->at.x, x = k == 0 || k == 3 ? -end : end;
            solid_vertex(s, p, vec3_make(x, -out - at->at.x, at->at.y), vec3_make(0, t.y, t.x), at->length,
                         x);
        }
        solid_quad(s, first + 3, first + 2, first + 1, first);
    }
}

void solid_frame(struct solid *s, struct place p, double w, double h, const struct solid_corner *outline,
                 size_t count)
{
    struct way way = {0};
    bool ok = outline_way(&way, outline, count, false);
    s->failed |= !ok;
    for (int side = 0; ok && side < 4; side++) {
        struct place turned = place_turn(p, 'z', 0.5 * CONTENT_PI * side);
        frame_side(s, &turned, 0.5 * (side % 2 ? h : w), 0.5 * (side % 2 ? w : h), &way);
    }
    ng_array_finish(&way.steps);
}

// ---- tubes ----

static uint32_t tube_ring(struct solid *s, const struct place *p, const struct step *at, struct vec3 side,
                          struct vec3 up, double radius, uint32_t sides)
{
    uint32_t first = (uint32_t)s->vertices.count;
    for (uint32_t i = 0; i <= sides; i++) {
        double angle = 2.0 * CONTENT_PI * i / sides;
        struct vec3 n = vec3_add(vec3_scale(side, cos(angle)), vec3_scale(up, sin(angle)));
        solid_vertex(s, p, vec3_add(at->at, vec3_scale(n, radius)), n, angle * radius, at->length);
    }
    return first;
}

static void tube_cap(struct solid *s, const struct place *p, const struct step *at, struct vec3 normal,
                     struct vec3 side, struct vec3 up, double radius, uint32_t sides, bool start)
{
    uint32_t center = solid_vertex(s, p, at->at, normal, 0, 0);
    for (uint32_t i = 0; i <= sides; i++) {
        double angle = 2.0 * CONTENT_PI * i / sides, x = radius * cos(angle), y = radius * sin(angle);
        struct vec3 q = vec3_add(at->at, vec3_add(vec3_scale(side, x), vec3_scale(up, y)));
        solid_vertex(s, p, q, normal, x, y);
        if (i)
            triangle(s, center, center + (start ? i + 1 : i), center + (start ? i : i + 1));
    }
}

void solid_tube(struct solid *s, struct place p, const struct solid_bend *bends, size_t count, double thick,
                double thin, uint32_t sides)
{
    struct way w = {0};
    build_way(&w, bends, count, false);
    s->failed |= w.failed;
    struct vec3 side = vec3_make(0, 0, 0);
    uint32_t last = 0;
    for (size_t i = 0; !w.failed && i < w.steps.count; i++) {
        const struct step *at = &w.steps.items[i];
        struct vec3 t = vec3_normalize(vec3_add(at->in, at->out));
        if (i == 0) // any direction across
            side = vec3_cross(fabs(t.y) < 0.9 ? vec3_make(0, 1, 0) : vec3_make(1, 0, 0), t);
        side = vec3_normalize(vec3_sub(side, vec3_scale(t, vec3_dot(side, t))));
        struct vec3 up = vec3_cross(t, side);
        double radius = thick + (thin - thick) * at->length / w.steps.items[w.steps.count - 1].length;
        if (i == 0)
            tube_cap(s, &p, at, vec3_scale(t, -1.0), side, up, radius, sides, true);
        uint32_t ring = tube_ring(s, &p, at, side, up, radius, sides);
        for (uint32_t k = 0; i && k < sides; k++)
            solid_quad(s, last + k, last + k + 1, ring + k + 1, ring + k);
        if (i + 1 == w.steps.count)
            tube_cap(s, &p, at, t, side, up, radius, sides, false);
        last = ring;
    }
    ng_array_finish(&w.steps);
}

void solid_rod(struct solid *s, struct place p, struct vec3 a, struct vec3 b, double thick, double thin)
{
    const struct solid_bend way[2] = {{a.x, a.y, a.z, 0}, {b.x, b.y, b.z, 0}};
    solid_tube(s, p, way, 2, thick, thin, thick < 0.004 ? 6 : thick < 0.012 ? 9 : 13);
}

// ---- sheets ----

void solid_sheet(struct solid *s, struct place p, solid_surface surface, const void *user, uint32_t columns,
                 uint32_t rows, double width, double height)
{
    const double step = 1e-4;
    uint32_t first = (uint32_t)s->vertices.count;
    for (uint32_t j = 0; j <= rows; j++)
        for (uint32_t i = 0; i <= columns; i++) {
            double u = (double)i / columns, v = (double)j / rows;
            struct vec3 across = vec3_sub(surface(u + step, v, user), surface(u - step, v, user));
            struct vec3 up = vec3_sub(surface(u, v + step, user), surface(u, v - step, user));
            solid_vertex(s, &p, surface(u, v, user), vec3_normalize(vec3_cross(across, up)), u * width,
                         v * height);
        }
    for (uint32_t j = 0; j < rows; j++)
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t at = first + j * (columns + 1) + i;
            solid_quad(s, at, at + 1, at + columns + 2, at + columns + 1);
        }
}
