// A surface over a body is cast: each vertex has a ray, from inside outwards, and lies where the ray last
// leaves the field. Rays stand in rings: 32 around the trunk, 16 around an arm, 20 around a leg. An arm grows
// out of a hole of four by four faces in the trunk; the two legs share three points between them.
#include "body.h"

#include "base/result.h"

#include <string.h>

enum { AROUND = 32, ARM = 16, LEG = 20, RINGS = 64, HOLE = 4 };

// ---- the fields of a body ----

static void make_trunk(struct anatomy *a)
{
    const struct build *b = &a->build;
    const struct vec3 *j = a->skeleton.rest;
    struct field *f = &a->trunk;
    double w = b->weight, fat = fmax(w, 0.0), fem = b->female, m = b->muscle, wide = b->shoulders;
    double hips = j[HIPS].y, chest = j[SPINE_HIGH].y, hip = b->hips;
    field_init(f);
    field_ball(f, vec3_make(0, chest + 0.005, -0.002),
               vec3_make((0.150 - 0.014 * fem + 0.016 * w) * mix(1.0, wide, 0.7), 0.185,
                         0.108 - 0.008 * fem + 0.014 * w),
               0.06, 0.02);
    field_ball(f, vec3_make(0, hips + 0.17, -0.004),
               vec3_make(0.122 - 0.012 * fem + 0.034 * w, 0.17, 0.092 - 0.008 * fem + 0.024 * w), 0, 0.08);
    field_ball(f, vec3_make(0, hips + 0.10, 0.035 + 0.045 * fat),
               vec3_make(0.10 + 0.05 * fat, 0.11 + 0.03 * fat, 0.06 + 0.065 * fat), 0, 0.07);
    field_ball(f, vec3_make(0, hips - 0.005, -0.006),
               vec3_make((0.147 + 0.012 * fem) * hip + 0.02 * w, 0.115, 0.104 + 0.012 * w), 0, 0.06);
    field_ball(f, vec3_make(0.072 * hip, hips - 0.07, -0.05 - 0.008 * fem),
               vec3_make(0.084 + 0.008 * fem + 0.012 * w, 0.088, 0.080 + 0.006 * fem + 0.012 * w), 0, 0.04);
    if (fem > 0.5)
        field_ball(f, vec3_make(0.074, chest - 0.005, 0.077 + 0.008 * w),
                   vec3_make(0.058 + 0.01 * w, 0.062 + 0.01 * w, 0.052 + 0.012 * w), -0.1, 0.035);
    else
        field_ball(f, vec3_make(0.072, chest + 0.04, 0.062 + 0.01 * w),
                   vec3_make(0.082, 0.062, 0.040 + 0.012 * m), -0.2, 0.05);
    double neck = 0.056 - 0.009 * fem + 0.007 * w + 0.006 * m;
    field_cone(f, vec3_add(j[NECK], vec3_make(0, -0.06, 0.0)), vec3_add(j[HEAD], vec3_make(0, 0.03, -0.004)),
               neck * 1.06, neck, 0.06);
    struct vec3 shoulder = j[UPPER_ARM];
    field_cone(f, vec3_make(0.03, j[NECK].y + 0.0, -0.04),
               vec3_make(shoulder.x - 0.03, shoulder.y + 0.004, -0.026), 0.046 + 0.008 * m, 0.042 + 0.004 * m,
               0.045);
    field_cone(f, vec3_make(0.10 * wide, chest + 0.04, -0.05), vec3_make(0.09 * wide, chest - 0.13, -0.035),
               0.055 + 0.012 * m, 0.04, 0.05);
    field_cone(f, vec3_make(0.04, j[CLAVICLE].y + 0.006, 0.025),
               vec3_make(shoulder.x - 0.02, shoulder.y + 0.012, 0.0), 0.030, 0.036, 0.035);
    double deltoid = 0.054 - 0.006 * fem + 0.008 * w + 0.008 * m;
    field_cone(f, vec3_add(shoulder, vec3_scale(a->arm_axis, -0.005)),
               vec3_add(shoulder, vec3_scale(a->arm_axis, 0.06)), deltoid, deltoid * 0.94, 0.05);
}

static void make_limbs(struct anatomy *a)
{
    const struct build *b = &a->build;
    const struct vec3 *j = a->skeleton.rest;
    double w = b->weight, fem = b->female, m = b->muscle;
    struct vec3 shoulder = j[UPPER_ARM], elbow = j[LOWER_ARM], wrist = j[HAND], d = a->arm_axis,
                up = a->arm_up;
    double deltoid = 0.054 - 0.006 * fem + 0.008 * w + 0.008 * m;
    struct field *f = &a->arm;
    field_init(f);
    field_cone(f, shoulder, vec3_add(shoulder, vec3_scale(d, 0.08)), deltoid, deltoid * 0.92, 0.02);
    field_cone(f, shoulder, elbow, 0.046 - 0.005 * fem + 0.010 * w, 0.037 - 0.003 * fem + 0.004 * w, 0.04);
    struct vec3 biceps = vec3_add(vec3_mix(shoulder, elbow, 0.55), vec3_make(0, 0, 0.012));
    field_ball(f, biceps, vec3_make(0.062, 0.046, 0.030 + 0.012 * m), 0, 0.05);
    field_cone(f, elbow, wrist, 0.038 - 0.003 * fem + 0.005 * w, 0.0235 - 0.002 * fem + 0.002 * w, 0.03);
    struct vec3 belly = vec3_add(vec3_mix(elbow, wrist, 0.24), vec3_make(0, 0, 0.006));
    field_cone(f, belly, vec3_mix(elbow, wrist, 0.42), 0.041 - 0.005 * fem + 0.005 * w + 0.004 * m,
               0.035 - 0.004 * fem, 0.04);
    // The ulna's head, and the elbow's point.
    field_cone(f, vec3_add(wrist, vec3_make(0, 0, 0.009)), vec3_add(wrist, vec3_make(0, 0, -0.010)), 0.020,
               0.019, 0.02);
    field_cone(f, vec3_add(elbow, vec3_make(0, 0, -0.016)), vec3_add(elbow, vec3_scale(d, 0.02)), 0.020,
               0.024, 0.02);

    struct field *p = &a->palm;
    field_init(p);
    double size = b->arms * (1.0 - 0.08 * fem);
    struct vec3 at[6];
    static const double knuckles[6][3] = {{0.0, 0.010, 0.0},      {0.0, -0.010, 0.0},
                                          {0.078, 0.027, 0.0},    {0.084, 0.008, 0.003},
                                          {0.080, -0.012, 0.001}, {0.072, -0.029, -0.004}};
    for (int i = 0; i < 6; i++)
        at[i] =
            vec3_add(vec3_add(wrist, vec3_scale(d, knuckles[i][0] * size)),
                     vec3_add(vec3_make(0, 0, knuckles[i][1] * size), vec3_scale(up, knuckles[i][2] * size)));
    for (int i = 2; i < 6; i++)
        field_cone(p, at[i < 4 ? 0 : 1], at[i], 0.0185 * size, (0.0125 - 0.0006 * i) * size, 0.022);
    struct vec3 thumb = vec3_add(vec3_add(wrist, vec3_scale(d, 0.052 * size)),
                                 vec3_add(vec3_make(0, 0, 0.040 * size), vec3_scale(up, -0.018 * size)));
    field_cone(p, at[0], thumb, 0.018 * size, 0.014 * size, 0.022);

    f = &a->leg;
    field_init(f);
    struct vec3 hip = j[UPPER_LEG], knee = j[LOWER_LEG], ankle = j[FOOT];
    double thigh = 0.082 + 0.004 * fem + 0.018 * w;
    field_cone(f, vec3_add(hip, vec3_make(-0.004, -0.02, -0.004)), vec3_add(knee, vec3_make(0, 0.03, -0.004)),
               thigh, 0.050 + 0.006 * w, 0.02);
    field_ball(f, vec3_add(vec3_mix(hip, knee, 0.42), vec3_make(0.008, 0, 0.022)),
               vec3_make(0.056, 0.16, 0.052 + 0.008 * m), 0, 0.05);
    field_cone(f, knee, ankle, 0.049 + 0.005 * w, 0.034 + 0.003 * w, 0.04);
    field_ball(f, vec3_add(vec3_mix(knee, ankle, 0.30), vec3_make(0.002, 0, -0.022)),
               vec3_make(0.043 + 0.006 * w, 0.105, 0.040 + 0.006 * w + 0.006 * m), 0.08, 0.05);
    field_cone(f, vec3_add(knee, vec3_make(0, 0.02, 0.022)), vec3_add(knee, vec3_make(0, -0.03, 0.02)), 0.030,
               0.027, 0.03);
    field_cone(f, vec3_add(ankle, vec3_make(0.008, 0, -0.003)),
               vec3_add(ankle, vec3_make(-0.008, 0.004, 0.003)), 0.031, 0.031, 0.03);
}

void anatomy_make(const struct build *b, struct anatomy *out)
{
    memset(out, 0, sizeof *out);
    out->build = *b;
    skeleton_make(b, &out->skeleton);
    const struct vec3 *j = out->skeleton.rest;
    struct vec3 arm = vec3_sub(j[HAND], j[UPPER_ARM]);
    out->whole_arm = vec3_length(arm);
    out->upper_arm = vec3_length(vec3_sub(j[LOWER_ARM], j[UPPER_ARM]));
    out->arm_axis = vec3_normalize(arm);
    out->arm_up = vec3_cross(vec3_make(0, 0, 1), out->arm_axis);
    make_trunk(out);
    make_limbs(out);
}

// ---- weights ----

static void share(struct weights *w, int from, int to, double part)
{
    w->of[to] += w->of[from] * part;
    w->of[from] *= 1.0 - part;
}

static void weigh_leg(const struct anatomy *a, struct vec3 p, int o, double side, struct weights *w)
{
    const struct vec3 *j = a->skeleton.rest;
    double hip = j[UPPER_LEG].y, knee = j[LOWER_LEG].y, ankle = j[FOOT].y;
    double half = side * ramp(p.y, hip + 0.055, hip - 0.05), full = side * ramp(p.y, hip - 0.0, hip - 0.15);
    half = fmin(half, w->of[HIPS]);
    full = fmin(full, half);
    w->of[HIPS] -= half;
    w->of[HIP_HALF + o] += half - full;
    w->of[UPPER_LEG + o] += full;
    share(w, UPPER_LEG + o, KNEE_HALF + o, ramp(p.y, knee + 0.10, knee + 0.005));
    share(w, KNEE_HALF + o, LOWER_LEG + o, ramp(p.y, knee - 0.005, knee - 0.10));
    share(w, LOWER_LEG + o, FOOT + o, ramp(p.y, ankle + 0.05, ankle - 0.01));
}

static void weigh_spine(const struct anatomy *a, struct vec3 p, struct weights *w)
{
    const struct vec3 *j = a->skeleton.rest;
    memset(w, 0, sizeof *w);
    w->of[HIPS] = 1.0;
    share(w, HIPS, SPINE_LOW, ramp(p.y, j[SPINE_LOW].y - 0.05, j[SPINE_LOW].y + 0.06));
    share(w, SPINE_LOW, SPINE_MIDDLE, ramp(p.y, j[SPINE_MIDDLE].y - 0.06, j[SPINE_MIDDLE].y + 0.06));
    share(w, SPINE_MIDDLE, SPINE_HIGH, ramp(p.y, j[SPINE_HIGH].y - 0.06, j[SPINE_HIGH].y + 0.06));
    double center = 1.0 - ramp(fabs(p.x), 0.05, 0.12);
    share(w, SPINE_HIGH, NECK, center * ramp(p.y, j[NECK].y - 0.045, j[NECK].y + 0.03));
}

static void weigh_arm(const struct anatomy *a, struct vec3 left, int o, double along, struct weights *w)
{
    double from_spine = w->of[SPINE_HIGH];
    const struct vec3 *j = a->skeleton.rest;
    double half = along < 0.12 ? ramp(along, -0.075, 0.03) : 1.0, full = ramp(along, -0.01, 0.11);
    double gate = ramp(left.y, j[UPPER_ARM].y - 0.135, j[UPPER_ARM].y - 0.04);
    gate = fmax(gate, ramp(vec3_dot(vec3_sub(left, j[UPPER_ARM]), vec3_make(1, 0, 0)), 0.02, 0.07));
    double clavicle = ramp(left.x, 0.03, 0.15) * ramp(left.y, j[UPPER_ARM].y - 0.15, j[UPPER_ARM].y - 0.01);
    NG_UNUSED(from_spine);
    share(w, NECK, SPINE_HIGH, gate * half);
    share(w, SPINE_HIGH, CLAVICLE + o, fmax(clavicle, gate * half));
    share(w, CLAVICLE + o, SHOULDER_HALF + o, gate * half);
    share(w, SHOULDER_HALF + o, UPPER_ARM + o, gate * full);
    double e = a->upper_arm, l = a->whole_arm;
    share(w, UPPER_ARM + o, ELBOW_HALF + o, ramp(along, e - 0.08, e - 0.005));
    share(w, ELBOW_HALF + o, LOWER_ARM + o, ramp(along, e + 0.005, e + 0.08));
    share(w, LOWER_ARM + o, LOWER_ARM_TWIST + o, ramp(along, e + 0.06, l - 0.05));
    share(w, LOWER_ARM_TWIST + o, HAND + o, ramp(along, l - 0.025, l + 0.02));
}

void body_weigh(const struct anatomy *a, struct vec3 p, struct weights *w)
{
    weigh_spine(a, p, w);
    double left = ramp(p.x, -0.03, 0.03);
    weigh_leg(a, p, 0, left, w);
    weigh_leg(a, p, RIGHT_SIDE, 1.0 - left, w);
    int o = p.x >= 0.0 ? 0 : RIGHT_SIDE;
    struct vec3 q = vec3_make(fabs(p.x), p.y, p.z);
    weigh_arm(a, q, o, vec3_dot(vec3_sub(q, a->skeleton.rest[UPPER_ARM]), a->arm_axis), w);
}

// A point of an arm, of a leg: other limbs and the trunk do not count.
void body_weigh_limb(const struct anatomy *a, struct vec3 p, bool arm, struct weights *w)
{
    int o = p.x >= 0.0 ? 0 : RIGHT_SIDE;
    if (!arm) {
        body_weigh(a, p, w);
        return;
    }
    struct vec3 q = vec3_make(fabs(p.x), p.y, p.z);
    double along = vec3_dot(vec3_sub(q, a->skeleton.rest[UPPER_ARM]), a->arm_axis);
    if (along > 0.11) {
        memset(w, 0, sizeof *w);
        w->of[SPINE_HIGH] = 1.0;
    } else {
        weigh_spine(a, vec3_make(p.x, fmax(p.y, a->skeleton.rest[SPINE_HIGH].y + 0.06), p.z), w);
    }
    weigh_arm(a, q, o, along, w);
}

// ---- cast surfaces ----

struct suit {
    struct shape *s;
    const struct anatomy *a;
    const struct garment *g;
    struct field trunk, arm, leg, whole;
};

static struct vec3 arm_point(const struct anatomy *a, double along, double angle, double radius)
{
    struct vec3 center = vec3_add(a->skeleton.rest[UPPER_ARM], vec3_scale(a->arm_axis, along));
    struct vec3 out = vec3_add(vec3_scale(a->arm_up, -cos(angle)), vec3_make(0, 0, sin(angle)));
    return vec3_add(center, vec3_scale(out, radius));
}

static struct vec3 leg_point(const struct anatomy *a, double y, double angle, double radius)
{
    const struct vec3 *j = a->skeleton.rest;
    struct vec3 c =
        y > j[LOWER_LEG].y
            ? vec3_mix(j[LOWER_LEG], j[UPPER_LEG], (y - j[LOWER_LEG].y) / (j[UPPER_LEG].y - j[LOWER_LEG].y))
            : vec3_mix(j[FOOT], j[LOWER_LEG], (y - j[FOOT].y) / (j[LOWER_LEG].y - j[FOOT].y));
    return vec3_make(c.x + radius * sin(angle), y, c.z + radius * cos(angle));
}

// How far cloth stands off or falls in at a point: long folds that lie across a limb, deeper where it bends.
static double fold(const struct suit *u, struct vec3 p)
{
    const struct anatomy *a = u->a;
    const struct vec3 *j = a->skeleton.rest;
    if (u->g->folds <= 0.0)
        return 0.0;
    struct vec3 q = vec3_make(fabs(p.x), p.y, p.z);
    double along = vec3_dot(vec3_sub(q, j[UPPER_ARM]), a->arm_axis);
    double across = vec3_dot(vec3_sub(q, j[UPPER_ARM]), a->arm_up);
    double side = p.x < 0.0 ? 7.3 : 0.0;
    if (along > 0.05 && q.x > j[UPPER_ARM].x) {
        double end = u->g->arm_to * a->whole_arm;
        double deep = 0.35 + bump(along, a->upper_arm, 0.09) +
                      0.9 * bump(along, end - 0.02, 0.06) * (end > a->upper_arm);
        double n =
            field_noise(vec3_make((along + 0.35 * across) * 30.0 + side, across * 9.0, p.z * 9.0 + side));
        return u->g->folds * deep * n;
    }
    if (p.y < j[UPPER_LEG].y - 0.02 && u->g->legs) {
        double knee = j[LOWER_LEG].y, end = mix(j[UPPER_LEG].y, j[FOOT].y, u->g->leg_to);
        double deep = 0.3 + 1.1 * bump(p.y, knee - 0.01, 0.08) +
                      1.5 * bump(p.y, end + 0.04, 0.07) * (end < knee) +
                      0.8 * bump(p.y, j[UPPER_LEG].y - 0.06, 0.05);
        double n =
            field_noise(vec3_make(p.x * 9.0 + side, (p.y + 0.3 * p.z + 0.2 * p.x) * 26.0, p.z * 9.0 + side));
        return u->g->folds * deep * n;
    }
    double waist = bump(p.y, u->g->low + j[HIPS].y + 0.07, 0.10);
    double n = field_noise(
        vec3_make(p.x * 12.0 + 3.0, (p.y + 0.5 * p.x * (p.z > 0 ? 1.0 : -0.7)) * 15.0, p.z * 12.0));
    double pull = field_noise(vec3_make(p.x * 16.0 - 2.0, p.y * 5.0, p.z * 16.0));
    return u->g->folds * ((0.35 + 0.9 * waist) * n + 0.35 * pull);
}

static struct vec3 drape(const struct suit *u, struct vec3 p, struct vec3 inside)
{
    struct vec3 out = vec3_normalize(vec3_sub(p, inside));
    return vec3_add(p, vec3_scale(out, fold(u, p)));
}

static uint32_t put(const struct suit *u, struct vec3 p, struct vec3 inside, double su, double sv, int limb)
{
    struct weights w;
    if (limb == 1)
        body_weigh_limb(u->a, p, true, &w);
    else
        body_weigh(u->a, p, &w);
    if (limb == 3) { // skirts: above the knee both legs pull
        double y = u->a->skeleton.rest[UPPER_LEG].y;
        double legs = 0.8 * ramp(p.y, y + 0.02, y - 0.25), left = ramp(p.x, -0.11, 0.11);
        weigh_spine(u->a, p, &w);
        double free = w.of[HIPS];
        w.of[HIPS] = free * (1.0 - legs);
        w.of[UPPER_LEG] += free * legs * left;
        w.of[UPPER_LEG + RIGHT_SIDE] += free * legs * (1.0 - left);
    }
    return shape_vertex(u->s, u->g->part, drape(u, p, inside), (const double[2]){su, sv}, &w);
}

// The edge of an opening: cloth turns in by its thickness and runs back a little inside.
static void add_rim(const struct suit *u, const uint32_t *ring, int count, bool closed,
                    struct vec3 inwards_center, struct vec3 back, bool flip)
{
    if (u->g->thickness <= 0.0)
        return;
    uint32_t before[64], now[64];
    memcpy(before, ring, (size_t)count * sizeof *ring);
    for (int step = 0; step < 2; step++) {
        for (int i = 0; i < count; i++) {
            struct shape_vertex v = *shape_at(u->s, u->g->part, ring[i]);
            struct vec3 to = vec3_sub(inwards_center, v.place);
            to = vec3_sub(to, vec3_scale(back, vec3_dot(to, back)));
            v.place = vec3_add(v.place, vec3_scale(vec3_normalize(to), u->g->thickness * (1.0 + 0.4 * step)));
            v.place = vec3_add(v.place, vec3_scale(back, step ? 0.014 : -0.0));
            v.color[0] = v.color[1] = v.color[2] = step ? 0.45 : 0.85;
            u->s->failed |= !ng_array_push(&u->s->parts[u->g->part].vertices, v);
            now[i] = (uint32_t)u->s->parts[u->g->part].vertices.count - 1;
        }
        for (int i = 0; i < (closed ? count : count - 1); i++) {
            int n = (i + 1) % count;
            shape_quad(u->s, u->g->part, before[i], before[n], now[n], now[i], flip);
        }
        memcpy(before, now, sizeof now);
    }
}

// The ray of the trunk through height v (up to the armpits' it is level, then it tilts) and around it.
static void trunk_ray(const struct suit *u, double v, double angle, struct vec3 *from, struct vec3 *out)
{
    const struct vec3 *j = u->a->skeleton.rest;
    double armpit = j[UPPER_ARM].y - 0.105, over = fmax(v - armpit, 0.0), pitch = over * 5.0;
    pitch *= 1.0 - 0.13 * cos(angle) * ramp(over, 0.08, 0.17);
    double y = fmin(v, armpit) + 0.32 * over;
    double back = ramp(y, j[SPINE_LOW].y, j[SPINE_HIGH].y) * -0.012 - 0.10 * over;
    *from = vec3_make(0, y, back);
    *out = vec3_make(sin(angle) * cos(pitch), sin(pitch), cos(angle) * cos(pitch));
}

static void add_arm(const struct suit *u, const uint32_t hole[ARM], int side)
{
    const struct anatomy *a = u->a;
    const struct garment *g = u->g;
    double sign = side ? -1.0 : 1.0, from = g->trunk ? 0.105 : g->arm_from * a->whole_arm,
           to = g->arm_to * a->whole_arm;
    int rows = (int)fmax(ceil((to - from) / (g->part == PART_SKIN ? 0.024 : 0.024)), 2.0),
        smooth = g->trunk ? 3 : 0;
    bool hand = g->part == PART_SKIN && g->arm_to >= 1.0;
    uint32_t before[ARM], now[ARM];
    struct vec3 first[ARM];
    memcpy(before, hole ? hole : before, hole ? sizeof before : 0);
    for (int k = 0; k < ARM && hole; k++)
        first[k] = shape_at(u->s, g->part, hole[k])->place;
    for (int i = -smooth; i <= rows; i++) {
        double t = from + (to - from) * fmax(i, 0) / rows;
        for (int k = 0; k < ARM; k++) {
            double angle = 2.0 * CONTENT_PI * k / ARM;
            struct vec3 inside = arm_point(a, t, angle, 0.0),
                        p = field_hit(&u->arm, arm_point(a, t, angle, 0.2), inside);
            if (g->flare > 0.0 && i == rows)
                p = vec3_add(p, vec3_scale(vec3_normalize(vec3_sub(p, inside)), 0.3 * g->flare));
            p.x *= sign;
            inside.x *= sign;
            if (i < 0) {
                double part = (double)(i + smooth + 1) / (smooth + 1);
                p = field_snap(&u->whole, vec3_mix(first[k], p, part));
            }
            double fold_angle = k <= ARM / 2 ? angle : 2.0 * CONTENT_PI - angle;
            now[k] = put(u, p, inside, 0.06 * fold_angle, t, 1);
        }
        if (hole || i > -smooth)
            for (int k = 0; k < ARM; k++) {
                int n = (k + 1) % ARM;
                shape_quad(u->s, g->part, before[k], before[n], now[n], now[k], side == 0);
            }
        memcpy(before, now, sizeof now);
    }
    struct vec3 center = arm_point(a, to, 0, 0), back = vec3_scale(a->arm_axis, -1.0);
    center.x *= sign;
    back.x *= sign;
    if (!hand)
        add_rim(u, now, ARM, true, center, back, side == 0);
}

static void add_leg(const struct suit *u, const uint32_t top[LEG], int side, bool bare, double bare_from)
{
    const struct anatomy *a = u->a;
    const struct garment *g = u->g;
    const struct vec3 *j = a->skeleton.rest;
    double sign = side ? -1.0 : 1.0, hip = j[UPPER_LEG].y, end = mix(hip, j[FOOT].y, g->leg_to);
    double from = bare ? mix(hip, j[FOOT].y, bare_from) : hip - 0.175;
    int rows = (int)ceil((from - end) / (g->part == PART_SKIN ? 0.042 : 0.029)), smooth = bare ? 0 : 4;
    uint32_t before[LEG], now[LEG];
    struct vec3 first[LEG];
    for (int k = 0; k < LEG && !bare; k++) {
        before[k] = top[k];
        first[k] = shape_at(u->s, g->part, top[k])->place;
    }
    for (int i = -smooth; i <= rows; i++) {
        double y = from + (end - from) * fmax(i, 0) / rows;
        for (int k = 0; k < LEG; k++) {
            double angle = 2.0 * CONTENT_PI * (k - 3) / LEG;
            struct vec3 inside = leg_point(a, y, angle, 0.0),
                        p = field_hit(&u->leg, leg_point(a, y, angle, 0.25), inside);
            p.x = fmax(p.x, 0.004);
            p.x *= sign;
            inside.x *= sign;
            if (i < 0) {
                double part = (double)(i + smooth + 1) / (smooth + 1);
                p = vec3_mix(first[k], p, part);
                double x = p.x;
                p = field_snap(&u->whole, p);
                if (x * sign < 0.02)
                    p.x = x;
            }
            double away = fabs(remainder(angle - 0.5 * CONTENT_PI, 2.0 * CONTENT_PI));
            now[k] = put(u, p, inside, 0.08 * away, y, 2);
        }
        if (!bare || i > -smooth)
            for (int k = 0; k < LEG; k++) {
                int n = (k + 1) % LEG;
                shape_quad(u->s, g->part, before[k], before[n], now[n], now[k], side == 0);
            }
        memcpy(before, now, sizeof now);
    }
    struct vec3 center = leg_point(a, end, 0, 0);
    center.x *= sign;
    add_rim(u, now, LEG, true, center, vec3_make(0, 1, 0), side == 0);
}

// Rings of the trunk from below upwards; where arms grow, four of them stand around the hole.
static int trunk_rings(const struct suit *u, double heights[RINGS], int *hole)
{
    const struct vec3 *j = u->a->skeleton.rest;
    const struct garment *g = u->g;
    double armpit = j[UPPER_ARM].y - 0.105, low = j[HIPS].y + g->low;
    double top = g->arms ? armpit : j[HIPS].y + g->high, step = g->part == PART_SKIN ? 0.03 : 0.024;
    int below = (int)ceil((top - low) / step), n = 0;
    for (int i = 0; i <= below; i++)
        heights[n++] = low + (top - low) * i / below;
    *hole = n - 1;
    if (!g->arms)
        return n;
    for (int i = 1; i <= HOLE; i++)
        heights[n++] = armpit + 0.150 * i / HOLE;
    double end = armpit + 0.150 + 0.115 * g->high;
    for (int i = 1; i <= 4; i++)
        heights[n++] = mix(armpit + 0.150, end, i / 4.0);
    return n;
}

static bool in_hole(int ring, int hole, int column)
{
    int c = column < AROUND / 2 ? column : AROUND - 1 - column;
    return ring >= hole && ring < hole + HOLE && c >= AROUND / 4 - 2 && c < AROUND / 4 + 2;
}

static void hole_points(uint32_t grid[RINGS][AROUND], int hole, int side, uint32_t out[ARM])
{
    static const int ring[ARM] = {0, 0, 0, 1, 2, 3, 4, 4, 4, 4, 4, 3, 2, 1, 0, 0};
    static const int column[ARM] = {8, 7, 6, 6, 6, 6, 6, 7, 8, 9, 10, 10, 10, 10, 10, 9};
    for (int k = 0; k < ARM; k++)
        out[k] = grid[hole + ring[k]][side ? AROUND - column[k] : column[k]];
}

static void add_trunk(const struct suit *u)
{
    const struct garment *g = u->g;
    const struct vec3 *j = u->a->skeleton.rest;
    double heights[RINGS];
    static uint32_t grid[RINGS][AROUND];
    int hole, rings = trunk_rings(u, heights, &hole);
    if (!g->arms)
        hole = rings + 1;
    const struct field *f = &u->trunk;
    for (int i = 0; i < rings; i++)
        for (int c = 0; c < AROUND; c++) {
            double angle = 2.0 * CONTENT_PI * c / AROUND,
                   left = c <= AROUND / 2 ? angle : 2.0 * CONTENT_PI - angle;
            struct vec3 from, out;
            trunk_ray(u, heights[i], left, &from, &out);
            struct vec3 p = field_hit(f, vec3_add(from, vec3_scale(out, 0.5)), from);
            if (g->flare > 0.0 && i < 8)
                p = vec3_add(p, vec3_scale(vec3_make(out.x, 0, out.z), g->flare * pow(1.0 - i / 8.0, 1.5)));
            if (c > AROUND / 2)
                p.x = -p.x;
            if (c == 0 || c == AROUND / 2)
                p.x = 0.0;
            grid[i][c] = put(u, p, from, 0.15 * left, heights[i], 0);
        }
    for (int i = 0; i + 1 < rings; i++)
        for (int c = 0; c < AROUND; c++) {
            int n = (c + 1) % AROUND;
            if (!in_hole(i, hole, c))
                shape_quad(u->s, g->part, grid[i][c], grid[i][n], grid[i + 1][n], grid[i + 1][c], false);
        }
    uint32_t ring[ARM];
    for (int side = 0; side < 2 && g->arms; side++) {
        hole_points(grid, hole, side, ring);
        add_arm(u, ring, side);
    }
    const uint32_t *last = grid[rings - 1];
    struct vec3 neck = j[NECK];
    uint32_t stand[AROUND];
    if (g->collar > 0.0 && g->arms) {
        for (int step = 1; step <= 3; step++) {
            for (int c = 0; c < AROUND; c++) {
                struct shape_vertex v = *shape_at(u->s, g->part, grid[rings - 1][c]);
                struct vec3 to = vec3_normalize(vec3_make(v.place.x, 0, v.place.z - neck.z));
                double t = step / 3.0, front = ramp(cos(2.0 * CONTENT_PI * c / AROUND), 0.5, 1.0);
                v.place = vec3_add(v.place, vec3_scale(to, 0.004 + 0.012 * t * t - 0.006 * front));
                v.place.y += g->collar * t * (1.0 - 0.35 * front);
                v.place.z -= 0.010 * t;
                u->s->failed |= !ng_array_push(&u->s->parts[g->part].vertices, v);
                stand[c] = (uint32_t)u->s->parts[g->part].vertices.count - 1;
            }
            for (int c = 0; c < AROUND; c++) {
                int n = (c + 1) % AROUND;
                const uint32_t *b = last;
                shape_quad(u->s, g->part, b[c], b[n], stand[n], stand[c], false);
            }
            memcpy(grid[RINGS - 1], stand, sizeof stand);
            last = grid[RINGS - 1];
        }
    }
    add_rim(u, last, AROUND, true, neck, vec3_make(0, -1, 0), false);
    if (g->legs) {
        // Between the legs: three points under the crotch, from back to front.
        uint32_t middle[3], leg[LEG];
        struct vec3 front = shape_at(u->s, g->part, grid[0][0])->place;
        struct vec3 rear = shape_at(u->s, g->part, grid[0][AROUND / 2])->place;
        for (int k = 0; k < 3; k++) {
            struct vec3 p = vec3_mix(rear, front, (k + 1) / 4.0);
            p.y -= k == 1 ? 0.035 : 0.026;
            p.x = 0.0;
            middle[k] = put(u, p, vec3_add(p, vec3_make(0, 0.05, 0)), 0, p.y, 2);
        }
        for (int side = 0; side < 2; side++) {
            for (int c = 0; c <= AROUND / 2; c++)
                leg[c] = grid[0][side ? (AROUND - c) % AROUND : c];
            for (int k = 0; k < 3; k++)
                leg[AROUND / 2 + 1 + k] = middle[k];
            add_leg(u, leg, side, false, 0);
        }
    } else if (g->skirt > 0.0) {
        double start = heights[0], end = mix(j[UPPER_LEG].y, j[FOOT].y, g->skirt);
        int rows = (int)ceil((start - end) / 0.03);
        uint32_t before[AROUND], now[AROUND];
        memcpy(before, grid[0], sizeof before);
        for (int i = 1; i <= rows; i++) {
            double t = (double)i / rows, y = mix(start, end, t);
            for (int c = 0; c < AROUND; c++) {
                double angle = 2.0 * CONTENT_PI * c / AROUND;
                struct vec3 p = shape_at(u->s, g->part, grid[0][c])->place,
                            inside = vec3_make(0, y, p.z * 0.3);
                double wave = 0.014 * t * sin(8.0 * angle + 1.0) + 0.006 * t * sin(13.0 * angle);
                struct vec3 out = vec3_normalize(vec3_make(p.x, 0, p.z));
                p = vec3_add(p, vec3_scale(out, g->leg_width * t + wave));
                p.y = y;
                now[c] = put(u, p, inside, 0.15 * fmin(angle, 2.0 * CONTENT_PI - angle), y, 3);
            }
            for (int c = 0; c < AROUND; c++) {
                int n = (c + 1) % AROUND;
                shape_quad(u->s, g->part, now[c], now[n], before[n], before[c], false);
            }
            memcpy(before, now, sizeof now);
        }
        add_rim(u, now, AROUND, true, vec3_make(0, end, 0), vec3_make(0, 1, 0), true);
    } else {
        add_rim(u, grid[0], AROUND, true, vec3_make(0, heights[0], 0), vec3_make(0, 1, 0), true);
    }
}

void body_garment(struct shape *s, const struct anatomy *a, const struct garment *g)
{
    struct suit u = {.s = s, .a = a, .g = g, .trunk = a->trunk, .arm = a->arm, .leg = a->leg};
    u.arm.one_side = u.leg.one_side = true;
    const struct vec3 *j = a->skeleton.rest;
    if (g->sleeve > 0.0)
        field_cone(&u.arm, vec3_mix(j[UPPER_ARM], j[LOWER_ARM], 0.45),
                   vec3_add(j[HAND], vec3_scale(a->arm_axis, 0.05)), g->sleeve,
                   g->sleeve * (g->arm_to > 0.8 ? 0.58 : 0.9), 0.04);
    if (g->leg_width > 0.0 && g->legs)
        field_cone(&u.leg, vec3_mix(j[UPPER_LEG], j[LOWER_LEG], 0.3),
                   vec3_make(j[FOOT].x, 0, j[FOOT].z - 0.004), g->leg_width * 1.08, g->leg_width, 0.05);
    field_append(&u.trunk, &u.leg);
    u.trunk.blend = u.arm.blend = u.leg.blend = g->blend;
    u.trunk.offset = u.leg.offset = g->ease;
    u.arm.offset = fmin(g->ease, 0.006 + 0.35 * g->ease);
    if (g->part == PART_SKIN)
        field_append(&u.arm, &a->palm);
    u.whole = u.trunk;
    field_append(&u.whole, &u.arm);
    if (g->trunk) {
        add_trunk(&u);
        for (int side = 0; side < 2 && g->arms; side++) { // the seam of trunk and sleeve
            struct vec3 at = vec3_add(j[UPPER_ARM], vec3_scale(a->arm_axis, 0.035));
            at.y -= 0.01;
            at.x *= side ? -1.0 : 1.0;
            shape_relax(s, g->part, at, 0.150, 8);
        }
        return;
    }
    for (int side = 0; side < 2; side++) {
        if (g->arms)
            add_arm(&u, NULL, side);
        if (g->legs)
            add_leg(&u, NULL, side, true, g->arm_from);
    }
}

// ---- hands ----

// Sets the normal of the skin's last vertex by a field of the left side.
static void field_shade(struct shape *s, uint32_t vertex, const struct field *f, struct vec3 left,
                        double sign)
{
    struct vec3 n = field_normal(f, left);
    shape_at(s, PART_SKIN, vertex)->normal = vec3_make(n.x * sign, n.y, n.z);
}

static void tint(struct shape *s, uint32_t vertex, double r, double g, double b)
{
    double *c = shape_at(s, PART_SKIN, vertex)->color;
    c[0] *= r;
    c[1] *= g;
    c[2] *= b;
}

struct finger {
    struct vec3 root, middle, tip;
    double radius;
    int joint;
};

static void add_finger(struct shape *s, const struct anatomy *a, const struct finger *f,
                       const struct field *whole, int side)
{
    enum { SIDES = 7, STEPS = 9 };
    static const double at[STEPS] = {-0.30, 0.2, 0.72, 0.9, 1.0, 1.12, 1.5, 1.75, 1.93};
    double sign = side ? -1.0 : 1.0;
    struct field own;
    field_init(&own);
    own.one_side = true;
    struct vec3 second = vec3_mix(f->middle, f->tip, 0.55); // where the last joint of three would be
    field_cone(&own, vec3_add(f->root, vec3_scale(vec3_sub(f->root, f->middle), 0.4)), f->middle,
               f->radius * 1.08, f->radius, 0.0);
    field_cone(&own, f->middle, second, f->radius, f->radius * 0.93, 0.004);
    field_cone(&own, second, f->tip, f->radius * 0.93, f->radius * 0.80, 0.004);
    struct field shade = *whole;
    field_append(&shade, &own);
    uint32_t before[SIDES], now[SIDES];
    struct vec3 back = vec3_normalize(
        vec3_cross(vec3_cross(vec3_sub(f->middle, f->root), a->arm_up), vec3_sub(f->middle, f->root)));
    if (f->joint == FINGERS) // the thumb looks across
        back = vec3_normalize(vec3_add(vec3_scale(a->arm_up, 0.5), vec3_make(0, 0, 0.8)));
    double long_root = vec3_length(vec3_sub(f->middle, f->root)),
           long_tip = vec3_length(vec3_sub(f->tip, f->middle));
    for (int i = 0; i <= STEPS; i++) {
        double t = i < STEPS ? at[i] : 2.0;
        struct vec3 center = t < 1.0 ? vec3_mix(f->root, f->middle, t) : vec3_mix(f->middle, f->tip, t - 1.0);
        struct vec3 axis =
            vec3_normalize(t < 1.0 ? vec3_sub(f->middle, f->root) : vec3_sub(f->tip, f->middle));
        if (i == 4)
            axis = vec3_normalize(vec3_sub(f->tip, f->root));
        struct vec3 side_axis = vec3_normalize(vec3_cross(axis, back)), up = vec3_cross(side_axis, axis);
        double along = t < 1.0 ? (t - 1.0) * long_root : (t - 1.0) * long_tip;
        struct weights w = {0};
        w.of[side ? HAND + RIGHT_SIDE : HAND] = 1.0;
        int o = side ? RIGHT_SIDE : 0;
        share(&w, HAND + o, f->joint + o, ramp(along + long_root, -0.010, 0.008));
        share(&w, f->joint + o, f->joint + 1 + o, ramp(along, -0.007, 0.007));
        for (int k = 0; k < SIDES; k++) {
            double angle = 2.0 * CONTENT_PI * k / SIDES;
            struct vec3 out = vec3_add(vec3_scale(up, cos(angle)), vec3_scale(side_axis, sin(angle)));
            double pitch = i == STEPS ? 0.95 : i == STEPS - 1 ? 0.35 : 0.0;
            out = vec3_add(vec3_scale(out, cos(pitch)), vec3_scale(axis, sin(pitch)));
            struct vec3 p = field_hit(&own, vec3_add(center, vec3_scale(out, 0.03)), center);
            struct vec3 place = vec3_make(p.x * sign, p.y, p.z);
            now[k] = shape_vertex(s, PART_SKIN, place, NULL, &w);
            field_shade(s, now[k], &shade, p, sign);
            if (t > 1.85) // nails
                tint(s, now[k], cos(angle) > 0.6 ? 1.12 : 1.0, cos(angle) > 0.6 ? 0.98 : 0.93,
                     cos(angle) > 0.6 ? 1.0 : 0.93);
            else if (fabs(t - 1.0) < 0.05)
                tint(s, now[k], 1.0, 0.90, 0.88);
        }
        for (int k = 0; k < SIDES && i; k++) {
            int n = (k + 1) % SIDES;
            shape_quad(s, PART_SKIN, before[k], before[n], now[n], now[k], side == 1);
        }
        memcpy(before, now, sizeof now);
        if (i == STEPS) {
            struct vec3 p = field_hit(&own, vec3_add(f->tip, vec3_scale(axis, 0.03)), f->tip);
            uint32_t end = shape_vertex(s, PART_SKIN, vec3_make(p.x * sign, p.y, p.z), NULL, &w);
            field_shade(s, end, &shade, p, sign);
            for (int k = 0; k < SIDES; k++)
                shape_quad(s, PART_SKIN, now[k], now[(k + 1) % SIDES], end, end, side == 1);
        }
    }
}

static void add_palm(struct shape *s, const struct anatomy *a, const struct field *f,
                     const struct field *shade, int side)
{
    enum { STEPS = 8 };
    double sign = side ? -1.0 : 1.0, size = a->build.arms * (1.0 - 0.08 * a->build.female);
    uint32_t before[ARM], now[ARM], end = 0;
    for (int i = 0; i <= STEPS; i++) {
        double t = a->whole_arm + fmin(i, 5) * 0.0138 * size, pitch = fmax(i - 5, 0) * 0.46;
        for (int k = 0; k < (i < STEPS ? ARM : 1); k++) {
            double angle = 2.0 * CONTENT_PI * k / ARM;
            struct vec3 inside = arm_point(a, t, angle, 0.0),
                        out = vec3_sub(arm_point(a, t, angle, 1.0), inside);
            if (i == STEPS)
                pitch = 0.5 * CONTENT_PI;
            out = vec3_add(vec3_scale(out, cos(pitch)), vec3_scale(a->arm_axis, sin(pitch)));
            struct vec3 p = field_hit(f, vec3_add(inside, vec3_scale(out, 0.12)), inside),
                        place = vec3_make(p.x * sign, p.y, p.z);
            struct weights w;
            body_weigh_limb(a, place, true, &w);
            uint32_t v = shape_vertex(s, PART_SKIN, place, NULL, &w);
            field_shade(s, v, shade, p, sign);
            now[k] = end = v;
        }
        for (int k = 0; k < ARM && i; k++) {
            int n = (k + 1) % ARM;
            if (i < STEPS)
                shape_quad(s, PART_SKIN, before[k], before[n], now[n], now[k], side == 0);
            else
                shape_quad(s, PART_SKIN, before[k], before[n], end, end, side == 0);
        }
        memcpy(before, now, sizeof now);
    }
}

void body_hands(struct shape *s, const struct anatomy *a)
{
    const struct vec3 *j = a->skeleton.rest;
    double size = a->build.arms * (1.0 - 0.08 * a->build.female);
    static const double lengths[5] = {0.030, 0.043, 0.048, 0.044, 0.033},
                        radii[5] = {0.0112, 0.0092, 0.0094, 0.0088, 0.0078};
    struct finger fingers[5];
    struct field palm = a->arm;
    field_append(&palm, &a->palm);
    palm.one_side = true;
    struct field shade = palm;
    for (int i = 0; i < 5; i++) {
        struct finger *f = &fingers[i];
        f->joint = FINGERS + 2 * i;
        f->root = j[f->joint];
        f->middle = j[f->joint + 1];
        f->radius = radii[i] * size;
        struct vec3 on = vec3_normalize(vec3_sub(f->middle, f->root));
        on = vec3_normalize(vec3_add(on, vec3_scale(a->arm_up, -0.16)));
        f->tip = vec3_add(f->middle, vec3_scale(on, lengths[i] * size));
        field_cone(&shade, vec3_mix(f->root, f->middle, -0.3), f->middle, f->radius * 1.08, f->radius, 0.010);
    }
    for (int side = 0; side < 2; side++) {
        add_palm(s, a, &palm, &shade, side);
        for (int i = 0; i < 5; i++)
            add_finger(s, a, &fingers[i], &palm, side);
    }
}

// ---- shoes ----

// A ring of rays around the vertical through the middle of the foot; they are closer towards toes and heel.
static struct vec3 shoe_ray(int k, int sides, double tilt)
{
    double angle = 2.0 * CONTENT_PI * k / sides;
    angle -= 0.36 * sin(2.0 * angle);
    return vec3_make(sin(angle) * cos(tilt), sin(tilt), cos(angle) * cos(tilt));
}

static void put_shoe(struct shape *s, const struct anatomy *a, struct vec3 p, int side, double around,
                     const double *color, uint32_t *out)
{
    const struct vec3 *j = a->skeleton.rest;
    int o = side ? RIGHT_SIDE : 0;
    struct weights w = {0};
    w.of[FOOT + o] = 1.0;
    share(&w, FOOT + o, TOES + o, ramp(p.z, j[TOES].z - 0.028, j[TOES].z + 0.028));
    share(&w, FOOT + o, LOWER_LEG + o, ramp(p.y, 0.07, 0.17));
    p.x *= side ? -1.0 : 1.0;
    *out = shape_vertex(s, PART_SHOES, p, (const double[2]){0.08 * around, p.y}, &w);
    if (color)
        memcpy(shape_at(s, PART_SHOES, *out)->color, color, 3 * sizeof *color);
}

void body_shoes(struct shape *s, const struct anatomy *a, double sole, double shaft,
                const double sole_color[3])
{
    enum { SIDES = 24, STEPS = 9, SHAFT = 5, LEG_SIDES = 14 };
    struct vec3 ankle = a->skeleton.rest[FOOT];
    double size = 0.93 + 0.07 * (1.0 - a->build.female) + 0.02 * a->build.weight, x = ankle.x;
    double heel = ankle.z - 0.062 * size, toe = ankle.z + 0.198 * size;
    struct field f;
    field_init(&f);
    f.one_side = true;
    field_cone(&f, vec3_make(x, 0.036, heel + 0.036), vec3_make(x + 0.006, 0.034, toe - 0.10), 0.037 * size,
               0.044 * size, 0.03);
    field_cone(&f, vec3_make(x + 0.004, 0.033, toe - 0.10), vec3_make(x + 0.007, 0.029, toe - 0.038),
               0.045 * size, 0.035 * size, 0.03);
    field_cone(&f, vec3_make(x, 0.078, ankle.z + 0.002), vec3_make(x + 0.004, 0.043, toe - 0.095),
               0.042 * size, 0.036 * size, 0.03);
    struct vec3 center = vec3_make(x + 0.004, 0.032, ankle.z + 0.058);
    for (int side = 0; side < 2; side++) {
        uint32_t before[SIDES], now[SIDES], middle;
        put_shoe(s, a, vec3_make(center.x, 0.0, center.z), side, 0, sole_color, &middle);
        for (int i = 0; i <= STEPS; i++) {
            // The sole's edge, twice, so that it shades as one; the welt; then rays that rise.
            static const double tilts[STEPS + 1] = {0, 0, 0, 0, 0.05, 0.22, 0.42, 0.66, 0.95, 1.25};
            static const double out[STEPS + 1] = {-0.002, 0.003, 0.0035, 0.0005, 0, 0, 0, 0, 0, 0};
            for (int k = 0; k < SIDES; k++) {
                struct vec3 ray = shoe_ray(k, SIDES, tilts[i]), from = center;
                struct vec3 p = vec3_add(field_hit(&f, vec3_add(from, vec3_scale(ray, 0.3)), from),
                                         vec3_scale(ray, out[i]));
                double toe_spring = 0.010 * ramp(p.z, toe - 0.09, toe + 0.01);
                p.y = i == 0   ? 0.0
                      : i == 1 ? 0.004
                      : i == 2 ? sole - 0.002
                      : i == 3 ? sole
                               : fmax(p.y, sole + 0.002);
                p.y += i < 4 ? toe_spring * (i ? 1.0 : 0.6) : 0.0;
                put_shoe(s, a, p, side, fabs(remainder(atan2(ray.x, ray.z), 2.0 * CONTENT_PI)),
                         i < 4 ? sole_color : NULL, &now[k]);
            }
            for (int k = 0; k < SIDES; k++) {
                int n = (k + 1) % SIDES;
                if (i)
                    shape_quad(s, PART_SHOES, before[k], before[n], now[n], now[k], side == 1);
                else
                    shape_quad(s, PART_SHOES, middle, middle, now[n], now[k], side == 1);
            }
            memcpy(before, now, sizeof now);
        }
        // The shaft around the ankle, its rim turned in.
        struct field leg = a->leg;
        leg.one_side = true;
        leg.offset = 0.009;
        for (int i = 0; i <= SHAFT + 2; i++) {
            double y = mix(0.066, shaft, (double)(i < SHAFT ? i : SHAFT) / SHAFT);
            for (int k = 0; k < LEG_SIDES; k++) {
                double angle = 2.0 * CONTENT_PI * k / LEG_SIDES;
                struct vec3 inside = leg_point(a, y, angle, 0),
                            p = field_hit(&leg, leg_point(a, y, angle, 0.11), inside);
                if (i > SHAFT)
                    p = vec3_add(p, vec3_scale(vec3_normalize(vec3_sub(inside, p)), 0.004 * (i - SHAFT)));
                p.y -= i == SHAFT + 2 ? 0.012 : 0.0;
                put_shoe(s, a, p, side, fabs(remainder(angle, 2.0 * CONTENT_PI)), NULL, &now[k]);
            }
            for (int k = 0; k < LEG_SIDES && i; k++) {
                int n = (k + 1) % LEG_SIDES;
                shape_quad(s, PART_SHOES, before[k], before[n], now[n], now[k], side == 1);
            }
            memcpy(before, now, sizeof now);
        }
    }
}
