#include "skeleton.h"

#include "base/array.h"
#include "base/result.h"

#include <stdio.h>

static const struct {
    const char *name;
    int parent;
    struct vec3 rest; // of the left side
} joints[SIDE_END] = {
    [HIPS] = {"hips", -1, {0, 0.955, 0}},
    [SPINE_LOW] = {"spine-low", HIPS, {0, 1.05, 0}},
    [SPINE_MIDDLE] = {"spine-middle", SPINE_LOW, {0, 1.17, -0.012}},
    [SPINE_HIGH] = {"spine-high", SPINE_MIDDLE, {0, 1.29, -0.02}},
    [NECK] = {"neck", SPINE_HIGH, {0, 1.465, -0.025}},
    [HEAD] = {"head", NECK, {0, 1.56, -0.005}},
    [JAW] = {"jaw", HEAD, {0, 1.59, 0.02}},
    [LIDS] = {"lids", HEAD, {0, 1.637, 0.0715}},
    [EYE_LEFT] = {"eye-left", HEAD, {0.031, 1.637, 0.0715}},
    [EYE_RIGHT] = {"eye-right", HEAD, {-0.031, 1.637, 0.0715}},
    [CLAVICLE] = {"clavicle", SPINE_HIGH, {0.02, 1.42, 0.0}},
    [SHOULDER_HALF] = {"shoulder-half", CLAVICLE, {0.172, 1.405, -0.02}},
    [UPPER_ARM] = {"upper-arm", CLAVICLE, {0.172, 1.405, -0.02}},
    [ELBOW_HALF] = {"elbow-half", UPPER_ARM, {0.388, 1.224, -0.02}},
    [LOWER_ARM] = {"lower-arm", UPPER_ARM, {0.388, 1.224, -0.02}},
    [LOWER_ARM_TWIST] = {"lower-arm-twist", LOWER_ARM, {0.480, 1.147, -0.02}},
    [HAND] = {"hand", LOWER_ARM, {0.579, 1.064, -0.02}},
    // Fingers: along and across the hand, set in skeleton_make.
    [FINGERS + 0] = {"thumb", HAND, {0, 0, 0}},
    [FINGERS + 1] = {"thumb-end", FINGERS + 0, {0, 0, 0}},
    [FINGERS + 2] = {"index", HAND, {0, 0, 0}},
    [FINGERS + 3] = {"index-end", FINGERS + 2, {0, 0, 0}},
    [FINGERS + 4] = {"middle", HAND, {0, 0, 0}},
    [FINGERS + 5] = {"middle-end", FINGERS + 4, {0, 0, 0}},
    [FINGERS + 6] = {"ring", HAND, {0, 0, 0}},
    [FINGERS + 7] = {"ring-end", FINGERS + 6, {0, 0, 0}},
    [FINGERS + 8] = {"little", HAND, {0, 0, 0}},
    [FINGERS + 9] = {"little-end", FINGERS + 8, {0, 0, 0}},
    [HIP_HALF] = {"hip-half", HIPS, {0.09, 0.925, 0}},
    [UPPER_LEG] = {"upper-leg", HIPS, {0.09, 0.925, 0}},
    [KNEE_HALF] = {"knee-half", UPPER_LEG, {0.1, 0.505, 0.008}},
    [LOWER_LEG] = {"lower-leg", UPPER_LEG, {0.1, 0.505, 0.008}},
    [FOOT] = {"foot", LOWER_LEG, {0.108, 0.085, -0.02}},
    [TOES] = {"toes", FOOT, {0.118, 0.022, 0.115}},
};

// Root and second joint of each finger in the frame of the hand: along it, towards the thumb, out of its
// back.
static const double fingers[10][3] = {
    {0.028, 0.030, -0.014},  {0.066, 0.054, -0.022},  {0.090, 0.027, 0.002},  {0.130, 0.031, -0.001},
    {0.093, 0.006, 0.005},   {0.137, 0.007, 0.001},   {0.089, -0.014, 0.002}, {0.130, -0.017, -0.001},
    {0.082, -0.032, -0.003}, {0.114, -0.038, -0.006},
};

int skeleton_mirror(int joint)
{
    if (joint == EYE_LEFT || joint == EYE_RIGHT)
        return EYE_LEFT + EYE_RIGHT - joint;
    return joint < CLAVICLE ? joint : joint < SIDE_END ? joint + RIGHT_SIDE : joint - RIGHT_SIDE;
}

void skeleton_name(int joint, char out[32])
{
    int left = joint < SIDE_END ? joint : joint - RIGHT_SIDE;
    const char *side = joint < CLAVICLE ? "" : joint < SIDE_END ? "-left" : "-right";
    snprintf(out, 32, "%s%s", joints[left].name, side);
}

static struct vec3 stretched(const struct build *b, int joint, struct vec3 p)
{
    struct vec3 hip = joints[UPPER_LEG].rest, shoulder = joints[UPPER_ARM].rest;
    double wide = joint >= HIP_HALF ? b->hips : joint >= CLAVICLE ? b->shoulders : 1.0;
    if (joint >= UPPER_ARM && joint < HIP_HALF) { // arms
        struct vec3 from = vec3_sub(p, shoulder);
        p = vec3_add(vec3_make(shoulder.x * wide, shoulder.y, shoulder.z), vec3_scale(from, b->arms));
    } else if (joint >= HIP_HALF) {
        p.x += hip.x * (wide - 1.0);
    } else {
        p.x *= wide;
    }
    double leg = hip.y * (b->legs - 1.0);
    p.y += leg * fmin(p.y / hip.y, 1.0);
    if (joint >= JAW && joint < CLAVICLE) {
        struct vec3 neck = joints[HEAD].rest;
        neck.y += leg;
        p = vec3_add(neck, vec3_scale(vec3_sub(p, neck), b->head));
    }
    return p;
}

void skeleton_make(const struct build *b, struct skeleton *out)
{
    out->height = b->height;
    struct vec3 along = vec3_normalize(vec3_sub(joints[HAND].rest, joints[UPPER_ARM].rest));
    struct vec3 across = vec3_make(0, 0, 1), back = vec3_cross(across, along);
    for (int i = 0; i < SIDE_END; i++) {
        struct vec3 p = joints[i].rest;
        if (i >= FINGERS && i < FINGERS_END) {
            const double *f = fingers[i - FINGERS];
            p = vec3_add(joints[HAND].rest, vec3_add(vec3_scale(along, f[0]), vec3_scale(across, f[1])));
            p = vec3_add(p, vec3_scale(back, f[2]));
        }
        out->parent[i] = joints[i].parent;
        out->rest[i] = stretched(b, i, p);
        if (i >= CLAVICLE) {
            int parent = joints[i].parent;
            out->parent[i + RIGHT_SIDE] = parent >= CLAVICLE ? parent + RIGHT_SIDE : parent;
            out->rest[i + RIGHT_SIDE] = vec3_make(-out->rest[i].x, out->rest[i].y, out->rest[i].z);
        }
    }
}

// ---- quaternions ----

struct quat quat_identity(void)
{
    return (struct quat){0, 0, 0, 1};
}

struct quat quat_about(struct vec3 axis, double angle)
{
    double s = sin(0.5 * angle);
    return (struct quat){axis.x * s, axis.y * s, axis.z * s, cos(0.5 * angle)};
}

struct quat quat_multiply(struct quat a, struct quat b)
{
    return (struct quat){
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

struct quat quat_conjugate(struct quat q)
{
    return (struct quat){-q.x, -q.y, -q.z, q.w};
}

struct vec3 quat_rotate(struct quat q, struct vec3 v)
{
    struct vec3 u = vec3_make(q.x, q.y, q.z), t = vec3_scale(vec3_cross(u, v), 2.0);
    return vec3_add(vec3_add(v, vec3_scale(t, q.w)), vec3_cross(u, t));
}

struct quat quat_part(struct quat q, double t)
{
    if (q.w < 0.0)
        q = (struct quat){-q.x, -q.y, -q.z, -q.w};
    struct vec3 axis = vec3_make(q.x, q.y, q.z);
    double s = vec3_length(axis);
    return s > 1e-9 ? quat_about(vec3_scale(axis, 1.0 / s), 2.0 * t * atan2(s, q.w)) : quat_identity();
}

static struct quat quat_of_axes(struct vec3 x, struct vec3 y, struct vec3 z)
{
    double trace = x.x + y.y + z.z;
    struct quat q;
    if (trace > 0.0)
        q = (struct quat){y.z - z.y, z.x - x.z, x.y - y.x, 1.0 + trace};
    else if (x.x > y.y && x.x > z.z)
        q = (struct quat){1.0 + x.x - y.y - z.z, y.x + x.y, z.x + x.z, y.z - z.y};
    else if (y.y > z.z)
        q = (struct quat){y.x + x.y, 1.0 + y.y - x.x - z.z, z.y + y.z, z.x - x.z};
    else
        q = (struct quat){z.x + x.z, z.y + y.z, 1.0 + z.z - x.x - y.y, x.y - y.x};
    double n = sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return (struct quat){q.x / n, q.y / n, q.z / n, q.w / n};
}

static struct quat frame(struct vec3 along, struct vec3 side)
{
    along = vec3_normalize(along);
    struct vec3 third = vec3_normalize(vec3_cross(along, side));
    return quat_of_axes(along, vec3_cross(third, along), third);
}

struct quat quat_frames(struct vec3 from, struct vec3 from_side, struct vec3 to, struct vec3 to_side)
{
    return quat_multiply(frame(to, to_side), quat_conjugate(frame(from, from_side)));
}

struct quat quat_twist(struct quat q, struct vec3 axis)
{
    double d = q.x * axis.x + q.y * axis.y + q.z * axis.z, n = sqrt(d * d + q.w * q.w);
    if (n < 1e-9)
        return quat_identity();
    return (struct quat){axis.x * d / n, axis.y * d / n, axis.z * d / n, q.w / n};
}

struct quat quat_euler(double x, double y, double z)
{
    struct quat a = quat_about(vec3_make(1, 0, 0), x), b = quat_about(vec3_make(0, 1, 0), y);
    return quat_multiply(quat_about(vec3_make(0, 0, 1), z), quat_multiply(b, a));
}

// ---- poses ----

void pose_init(struct pose *p, const struct skeleton *s)
{
    p->s = s;
    p->hips = s->rest[HIPS];
    for (int i = 0; i < PEOPLE_JOINTS; i++)
        p->local[i] = quat_identity();
}

void pose_solve(struct pose *p)
{
    for (int i = 0; i < PEOPLE_JOINTS; i++) {
        int parent = p->s->parent[i];
        if (parent < 0) {
            p->world[i] = p->local[i];
            p->place[i] = p->hips;
            continue;
        }
        struct vec3 t = vec3_sub(p->s->rest[i], p->s->rest[parent]);
        p->world[i] = quat_multiply(p->world[parent], p->local[i]);
        p->place[i] = vec3_add(p->place[parent], quat_rotate(p->world[parent], t));
    }
}

// Turns `joint` so that in the world it has rotation `world`.
static void turn_to(struct pose *p, int joint, struct quat world)
{
    p->local[joint] = quat_multiply(quat_conjugate(p->world[p->s->parent[joint]]), world);
    p->world[joint] = world;
}

// The law of cosines; `hinge` is the axis that bends the middle at rest.
static void reach(struct pose *p, int upper, int lower, int end, struct vec3 hinge, struct vec3 target,
                  struct vec3 pole)
{
    const struct vec3 *rest = p->s->rest;
    struct vec3 root = p->place[upper];
    struct vec3 rest_upper = vec3_sub(rest[lower], rest[upper]),
                rest_lower = vec3_sub(rest[end], rest[lower]);
    double a = vec3_length(rest_upper), b = vec3_length(rest_lower);
    struct vec3 way = vec3_sub(target, root);
    double d = fmin(fmax(vec3_length(way), fabs(a - b) + 0.05), 0.998 * (a + b));
    way = vec3_normalize(way);
    double along = (a * a - b * b + d * d) / (2.0 * d), out = sqrt(fmax(a * a - along * along, 0.0));
    struct vec3 side = vec3_normalize(vec3_sub(pole, vec3_scale(way, vec3_dot(pole, way))));
    struct vec3 middle = vec3_add(root, vec3_add(vec3_scale(way, along), vec3_scale(side, out)));
    struct vec3 tip = vec3_add(root, vec3_scale(way, d));
    struct vec3 axis = vec3_cross(side, way); // turns the lower part away from the pole
    turn_to(p, upper, quat_frames(rest_upper, hinge, vec3_sub(middle, root), axis));
    p->place[lower] = middle;
    turn_to(p, lower, quat_frames(rest_lower, hinge, vec3_sub(tip, middle), axis));
    p->place[end] = tip;
    p->world[end] = p->world[lower];
    p->local[end] = quat_identity();
}

void pose_reach_arm(struct pose *p, int side, struct vec3 target, struct vec3 pole)
{
    int o = side ? RIGHT_SIDE : 0;
    struct vec3 arm = vec3_sub(p->s->rest[LOWER_ARM + o], p->s->rest[UPPER_ARM + o]);
    struct vec3 hinge = vec3_normalize(vec3_cross(arm, vec3_make(0, 0, 1)));
    reach(p, UPPER_ARM + o, LOWER_ARM + o, HAND + o, hinge, target, pole);
}

void pose_reach_leg(struct pose *p, int side, struct vec3 target, struct vec3 pole)
{
    int o = side ? RIGHT_SIDE : 0;
    reach(p, UPPER_LEG + o, LOWER_LEG + o, FOOT + o, vec3_make(1, 0, 0), target, pole);
}

void pose_turn_end(struct pose *p, int joint, struct quat world)
{
    turn_to(p, joint, world);
}

void pose_follow(struct pose *p)
{
    static const int halves[][2] = {
        {SHOULDER_HALF, UPPER_ARM}, {ELBOW_HALF, LOWER_ARM}, {HIP_HALF, UPPER_LEG}, {KNEE_HALF, LOWER_LEG}};
    for (int o = 0; o <= RIGHT_SIDE; o += RIGHT_SIDE) {
        for (size_t i = 0; i < NG_COUNT(halves); i++)
            p->local[halves[i][0] + o] = quat_part(p->local[halves[i][1] + o], 0.5);
        struct vec3 axis = vec3_normalize(vec3_sub(p->s->rest[HAND + o], p->s->rest[LOWER_ARM + o]));
        p->local[LOWER_ARM_TWIST + o] = quat_part(quat_twist(p->local[HAND + o], axis), 0.5);
    }
    pose_solve(p);
}
