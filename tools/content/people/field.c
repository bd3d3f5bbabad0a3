#include "field.h"

#include <stdint.h>
#include <string.h>

void field_init(struct field *f)
{
    memset(f, 0, sizeof *f);
    f->floor = -1e9;
}

static void add(struct field *f, struct blob b)
{
    if (f->count < FIELD_BLOBS)
        f->blobs[f->count++] = b;
}

void field_cone(struct field *f, struct vec3 a, struct vec3 b, double ra, double rb, double blend)
{
    add(f, (struct blob){.cone = true, .a = a, .b = b, .ra = ra, .rb = rb, .blend = blend});
}

void field_ball(struct field *f, struct vec3 center, struct vec3 radii, double turn, double blend)
{
    add(f, (struct blob){.a = center, .b = radii, .ra = turn, .blend = blend});
}

void field_cut(struct field *f, struct vec3 center, struct vec3 radii, double turn, double blend)
{
    add(f, (struct blob){.cut = true, .a = center, .b = radii, .ra = turn, .blend = blend});
}

void field_append(struct field *f, const struct field *other)
{
    for (int i = 0; i < other->count; i++)
        add(f, other->blobs[i]);
}

static double cone_at(const struct blob *b, struct vec3 p)
{
    struct vec3 axis = vec3_sub(b->b, b->a), q = vec3_sub(p, b->a);
    double t = vec3_dot(q, axis) / vec3_dot(axis, axis);
    t = fmin(fmax(t, 0.0), 1.0);
    return vec3_length(vec3_sub(q, vec3_scale(axis, t))) - mix(b->ra, b->rb, t);
}

// Quilez's bound: |q / r| (|q / r| - 1) / |q / r^2|, exact at the surface to first order.
static double ball_at(const struct blob *b, struct vec3 p)
{
    struct vec3 q = vec3_sub(p, b->a);
    if (b->ra != 0.0) {
        double c = cos(b->ra), s = sin(b->ra);
        q = vec3_make(q.x, c * q.y + s * q.z, c * q.z - s * q.y);
    }
    struct vec3 u = vec3_make(q.x / b->b.x, q.y / b->b.y, q.z / b->b.z);
    struct vec3 v = vec3_make(u.x / b->b.x, u.y / b->b.y, u.z / b->b.z);
    double k0 = vec3_length(u), k1 = vec3_length(v);
    return k1 > 1e-9 ? k0 * (k0 - 1.0) / k1 : -fmin(b->b.x, fmin(b->b.y, b->b.z));
}

static double smooth_min(double a, double b, double k)
{
    double h = fmax(k - fabs(a - b), 0.0) / k;
    return fmin(a, b) - 0.25 * h * h * k;
}

double field_at(const struct field *f, struct vec3 p)
{
    struct vec3 q = vec3_make(f->one_side ? p.x : fabs(p.x), p.y, p.z);
    double d = 1e3;
    for (int i = 0; i < f->count; i++) {
        const struct blob *b = &f->blobs[i];
        double e = b->cone ? cone_at(b, q) : ball_at(b, q), k = b->blend + f->blend + 1e-6;
        d = b->cut ? -smooth_min(-d, e, k) : smooth_min(d, e, k);
    }
    return fmax(d - f->offset, f->floor - p.y);
}

struct vec3 field_normal(const struct field *f, struct vec3 p)
{
    const double h = 5e-4;
    struct vec3 x = vec3_make(h, 0, 0), y = vec3_make(0, h, 0), z = vec3_make(0, 0, h);
    return vec3_normalize(vec3_make(field_at(f, vec3_add(p, x)) - field_at(f, vec3_sub(p, x)),
                                    field_at(f, vec3_add(p, y)) - field_at(f, vec3_sub(p, y)),
                                    field_at(f, vec3_add(p, z)) - field_at(f, vec3_sub(p, z))));
}

struct vec3 field_hit(const struct field *f, struct vec3 from, struct vec3 to)
{
    double length = vec3_length(vec3_sub(to, from)), t = 0.0, before = 0.0;
    for (int i = 0; i < 200 && t < length; i++) {
        double d = field_at(f, vec3_mix(from, to, t / length));
        if (d < 0.0) { // halve what lies between
            double low = before, high = t;
            for (int k = 0; k < 24; k++) {
                double middle = 0.5 * (low + high);
                if (field_at(f, vec3_mix(from, to, middle / length)) < 0.0)
                    high = middle;
                else
                    low = middle;
            }
            return vec3_mix(from, to, low / length);
        }
        before = t;
        t += fmax(0.7 * d, 5e-4);
    }
    return to;
}

struct vec3 field_leave(const struct field *f, struct vec3 from, struct vec3 to)
{
    double length = vec3_length(vec3_sub(to, from)), t = 0.0;
    for (int i = 0; i < 200 && t < length; i++) {
        double d = field_at(f, vec3_mix(from, to, t / length));
        if (d > -1e-6)
            return vec3_mix(from, to, t / length);
        t += fmax(-0.6 * d, 2e-5);
    }
    return to;
}

struct vec3 field_snap(const struct field *f, struct vec3 p)
{
    for (int i = 0; i < 12; i++)
        p = vec3_sub(p, vec3_scale(field_normal(f, p), 0.8 * field_at(f, p)));
    return p;
}

static double lattice(int32_t x, int32_t y, int32_t z)
{
    uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u ^ (uint32_t)z * 0xcb1ab31fu;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    h ^= h >> 15;
    return h / 2147483647.5 - 1.0;
}

double field_noise(struct vec3 p)
{
    double fx = floor(p.x), fy = floor(p.y), fz = floor(p.z), sum = 0.0;
    double t[3] = {p.x - fx, p.y - fy, p.z - fz};
    for (int i = 0; i < 3; i++)
        t[i] = t[i] * t[i] * (3.0 - 2.0 * t[i]);
    for (int i = 0; i < 8; i++)
        sum += lattice((int32_t)fx + (i & 1), (int32_t)fy + (i >> 1 & 1), (int32_t)fz + (i >> 2)) *
               (i & 1 ? t[0] : 1.0 - t[0]) * (i & 2 ? t[1] : 1.0 - t[1]) * (i & 4 ? t[2] : 1.0 - t[2]);
    return sum;
}
