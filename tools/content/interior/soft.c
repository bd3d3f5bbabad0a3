// A box of quads is shaped by a function of its points. Catmull-Clark rounds it within the first cell from an
// edge and leaves the rest where it was.
#include "soft.h"

#include "../texture.h"

#include <stdlib.h>

static double coordinate(const struct soft *s, int axis, uint32_t i)
{
    uint32_t n = s->cells[axis];
    double half = 0.5 * s->size[axis], edge = fmin(s->edge, 0.9 * half);
    if (i == 0 || i == n)
        return i ? half : -half;
    if (n < 3)
        return 0.0;
    return -half + edge + (2.0 * (half - edge)) * (i - 1) / (n - 2);
}

struct lattice {
    const struct soft *soft;
    NG_ARRAY(uint32_t) points; // of the cage, by place; UINT32_MAX: not made
};

static uint32_t lattice_point(struct lattice *l, struct cage *c, const uint32_t at[3])
{
    const struct soft *s = l->soft;
    uint32_t *point = &l->points.items[(at[2] * (s->cells[1] + 1) + at[1]) * (s->cells[0] + 1) + at[0]];
    if (*point == UINT32_MAX) {
        struct vec3 p = {coordinate(s, 0, at[0]), coordinate(s, 1, at[1]), coordinate(s, 2, at[2])};
        struct vec3 unit = {2 * p.x / s->size[0], 2 * p.y / s->size[1], 2 * p.z / s->size[2]};
        *point = cage_point(c, s->shape ? s->shape(p, unit, s->user) : p);
    }
    return *point;
}

// The side towards + or - of axis k, counter-clockwise from outside.
static void add_side(struct lattice *l, struct cage *c, int k, bool positive)
{
    const struct soft *s = l->soft;
    int a = (k + 1) % 3, b = (k + 2) % 3;
    int u = k == 0 ? 2 : 0, v = k == 1 ? 2 : 1; // of the texture
    for (uint32_t j = 0; j < s->cells[b]; j++)
        for (uint32_t i = 0; i < s->cells[a]; i++) {
            uint32_t face[4];
            for (uint32_t n = 0; n < 4; n++) {
                uint32_t turn = positive ? n : 3 - n, at[3];
                at[k] = positive ? s->cells[k] : 0;
                at[a] = i + (turn == 1 || turn == 2);
                at[b] = j + (turn >= 2);
                face[n] = lattice_point(l, c, at);
                struct cage_uv uv = {coordinate(s, u, at[u]), coordinate(s, v, at[v])};
                c->failed |= !ng_array_push(&c->uvs, uv);
            }
            cage_face(c, face, 4);
            if (s->seam > 0.0 && j == 0) // each edge of the box once: those along axis a
                for (uint32_t end = 0; end < 2; end++) {
                    uint32_t p[3], q[3];
                    p[k] = q[k] = positive ? s->cells[k] : 0;
                    p[b] = q[b] = end ? s->cells[b] : 0;
                    p[a] = i;
                    q[a] = i + 1;
                    cage_add_crease(c, lattice_point(l, c, p), lattice_point(l, c, q), s->seam);
                }
        }
}

void soft_box(struct cage *c, const struct soft *s)
{
    struct lattice l = {.soft = s};
    size_t count = (size_t)(s->cells[0] + 1) * (s->cells[1] + 1) * (s->cells[2] + 1);
    if (!ng_array_resize(&l.points, count)) {
        c->failed = true;
        return;
    }
    for (size_t i = 0; i < count; i++)
        l.points.items[i] = UINT32_MAX;
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++)
            add_side(&l, c, k, side);
    ng_array_finish(&l.points);
}

// ---- shapes ----

static struct vec3 stuffed(struct vec3 at, struct vec3 unit, const void *user)
{
    double bulge = *(const double *)user, x = 1 - unit.x * unit.x, y = 1 - unit.y * unit.y,
           z = 1 - unit.z * unit.z;
    at.y += unit.y * bulge * x * z;
    at.x += unit.x * 0.35 * bulge * y * z;
    at.z += unit.z * 0.35 * bulge * x * y;
    return at;
}

// The square's lines of one coordinate become parts of ellipses, which meet its border at right angles.
struct vec3 soft_round(struct vec3 at, struct vec3 unit, const void *user)
{
    double across = 1 - 0.5 * unit.z * unit.z, along = 1 - 0.5 * unit.x * unit.x;
    double r = unit.x * unit.x * across + unit.z * unit.z * along; // squared, 1 at the rim
    double bulge = user ? *(const double *)user : 0.0, side = 1 + bulge * (1 - unit.y * unit.y);
    return vec3_make(at.x * sqrt(across) * side, at.y + unit.y * bulge * (1 - r), at.z * sqrt(along) * side);
}

void soft_cushion(struct cage *c, double w, double h, double d, double edge, double bulge, double seam)
{
    uint32_t across = w > 0.9 ? 7 : 5;
    soft_box(c, &(struct soft){.size = {w, h, d},
                               .edge = edge,
                               .cells = {across, 3, d > 0.9 ? 7 : 5},
                               .seam = seam,
                               .shape = stuffed,
                               .user = &bulge});
}

// Value noise from -1 to 1 of a place in metres; features of `size`.
static double crumple(double x, double y, double size, uint64_t seed)
{
    const uint32_t period = 16;
    double u = x / (size * period) + 0.5, v = y / (size * period) + 0.5;
    return 2.0 * texture_noise(u - floor(u), v - floor(v), period, period, seed) - 1.0;
}

struct pillow {
    double h;
    uint64_t seed;
};

static struct vec3 pillow_shape(struct vec3 at, struct vec3 unit, const void *user)
{
    const struct pillow *p = user;
    double x = unit.x * unit.x, z = unit.z * unit.z;
    double thick = pow(fmax((1 - x * x) * (1 - z * z), 0.0), 0.42);
    double corner = x * z, wrinkle = crumple(at.x, at.z, 0.09, p->seed) * 0.012 * thick;
    at.y = at.y * (0.06 + 0.94 * thick) + wrinkle * (unit.y > 0 ? 1 : 0.5);
    at.x *= 1.0 - 0.05 * (1 - z) * x + 0.03 * corner;
    at.z *= 1.0 - 0.05 * (1 - x) * z + 0.03 * corner;
    return at;
}

void soft_pillow(struct cage *c, double w, double h, double d, uint64_t seed)
{
    const struct pillow p = {h, seed};
    soft_box(c, &(struct soft){.size = {w, h, d},
                               .edge = 0.05 * w,
                               .cells = {9, 2, w > 1.3 * d ? 7 : 9},
                               .shape = pillow_shape,
                               .user = &p});
}

// Along a cover from the edge of its bed: how far it lies out, and how far down it hangs.
static double hang(double along, double half, double *down)
{
    double over = fabs(along) - half, bend = 0.05;
    *down = 0.0;
    if (over <= -bend)
        return along;
    if (over < bend) { // a quarter of a circle, nearly
        double t = (over + bend) / (2 * bend);
        *down = bend * t * t;
        return (along > 0 ? 1 : -1) * (half - bend + bend * (2 * t - t * t));
    }
    *down = over;
    return along > 0 ? half : -half;
}

static struct vec3 cover_shape(struct vec3 at, struct vec3 unit, const void *user)
{
    const struct soft_cover *c = user;
    double down_x, down_z, side = at.x, front = at.z + 0.5 * c->front;
    double x = hang(side, 0.5 * c->w, &down_x), z = hang(front, 0.5 * c->d, &down_z);
    if (front < 0.0) { // it ends on the bed at its head
        z = front;
        down_z = 0.0;
    }
    double down = fmax(down_x, down_z), wave = 0.0;
    double low = down / fmax(c->drop, 0.01);
    if (down_x > down_z)
        wave = crumple(front, 0.1, 0.16, c->seed) * low;
    else if (down_z > 0)
        wave = crumple(side, 0.6, 0.16, c->seed + 1) * low;
    double puff = crumple(side, front, 0.21, c->seed + 2) + 0.5 * crumple(side, front, 0.1, c->seed + 3);
    struct vec3 out = {x, -down, z};
    double thick = 0.5 * c->t * unit.y;
    bool hangs_x = down_x > 0.04 && down_x >= down_z, hangs_z = down_z > 0.04 && down_z > down_x;
    double offset = thick + c->folds * (hangs_x || hangs_z ? 1.6 * wave + 0.5 * low : 0.5 * puff + 0.4);
    if (hangs_x)
        out.x += (side > 0 ? 1 : -1) * (0.5 * c->t + offset);
    else if (hangs_z)
        out.z += 0.5 * c->t + offset;
    else
        out.y += 0.5 * c->t + offset;
    return out;
}

void soft_cover(struct cage *c, const struct soft_cover *cover)
{
    soft_box(c, &(struct soft){.size = {cover->w + 2 * cover->drop, cover->t, cover->d + cover->front},
                               .edge = 0.03,
                               .cells = {18, 1, cover->d > 1.0 ? 13 : 6},
                               .shape = cover_shape,
                               .user = cover});
}
