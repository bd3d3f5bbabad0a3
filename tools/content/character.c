// A skinned figure: 17 joints, tubes around them whose rings blend between two joints, and two clips: a walk
// for the whole body, a wave for the right arm. All joints rest unrotated, so an inverse bind matrix is a
// translation. Metres; the figure faces +Z.
#include "content.h"
#include "stage.h"
#include "unseen.h"

#include <stdlib.h>
#include <string.h>

enum joint {
    HIPS,
    SPINE,
    CHEST,
    NECK,
    HEAD,
    LEFT_UPPER_ARM,
    LEFT_LOWER_ARM,
    LEFT_HAND,
    RIGHT_UPPER_ARM,
    RIGHT_LOWER_ARM,
    RIGHT_HAND,
    LEFT_UPPER_LEG,
    LEFT_LOWER_LEG,
    LEFT_FOOT,
    RIGHT_UPPER_LEG,
    RIGHT_LOWER_LEG,
    RIGHT_FOOT,
    JOINTS
};

static const struct {
    const char *name;
    int parent;
    struct vec3 rest; // in the world
} joints[JOINTS] = {
    {"hips", -1, {0, 0.95, 0}},
    {"spine", HIPS, {0, 1.07, 0}},
    {"chest", SPINE, {0, 1.22, 0}},
    {"neck", CHEST, {0, 1.45, 0}},
    {"head", NECK, {0, 1.55, 0.01}},
    {"upper-arm-left", CHEST, {0.19, 1.39, 0}},
    {"lower-arm-left", LEFT_UPPER_ARM, {0.25, 1.12, 0}},
    {"hand-left", LEFT_LOWER_ARM, {0.30, 0.87, 0}},
    {"upper-arm-right", CHEST, {-0.19, 1.39, 0}},
    {"lower-arm-right", RIGHT_UPPER_ARM, {-0.25, 1.12, 0}},
    {"hand-right", RIGHT_LOWER_ARM, {-0.30, 0.87, 0}},
    {"upper-leg-left", HIPS, {0.10, 0.90, 0}},
    {"lower-leg-left", LEFT_UPPER_LEG, {0.11, 0.50, 0.01}},
    {"foot-left", LEFT_LOWER_LEG, {0.12, 0.09, 0}},
    {"upper-leg-right", HIPS, {-0.10, 0.90, 0}},
    {"lower-leg-right", RIGHT_UPPER_LEG, {-0.11, 0.50, 0.01}},
    {"foot-right", RIGHT_LOWER_LEG, {-0.12, 0.09, 0}},
};

// ---- the skin ----

// A ring of a tube, level in the world; it follows `a`, and `b` by `blend`.
struct ring {
    struct vec3 center;
    double radius_x, radius_z;
    enum joint a, b;
    double blend;
};

struct skin {
    struct cage cage;
    NG_ARRAY(struct ring) rings; // of each point of the cage
};

// Upwards, closed at both ends; between two rings the tube runs straight, with `STEPS` rings of its own.
static void add_tube(struct skin *s, const struct ring *rings, int count, double mirror)
{
    enum { SIDES = 12, STEPS = 3 };
    uint32_t below = 0;
    int last = (count - 1) * STEPS;
    for (int i = 0; i <= last; i++) {
        const struct ring *r = &rings[i / STEPS], *next = i < last ? r + 1 : r;
        double t = (double)(i % STEPS) / STEPS, ease = t * t * (3.0 - 2.0 * t);
        struct ring at = *r;
        at.center = vec3_mix(r->center, next->center, t);
        at.center.x *= mirror;
        at.radius_x += ease * (next->radius_x - r->radius_x);
        at.radius_z += ease * (next->radius_z - r->radius_z);
        if (next->a == r->a && next->b == r->b)
            at.blend += t * (next->blend - r->blend);
        uint32_t first = cage_ring(&s->cage, SIDES, 1.0, 0.0);
        if (i == 0 || i == last)
            cage_cap(&s->cage, SIDES, first, vec3_make(0, 0, 0), i == last);
        if (i)
            cage_bridge(&s->cage, SIDES, below, first);
        below = first;
        for (size_t p = first; p < s->cage.points.count; p++) {
            struct vec3 *q = &s->cage.points.items[p];
            *q = vec3_add(at.center, vec3_make(q->x * at.radius_x, 0, q->z * at.radius_z));
            s->cage.failed |= !ng_array_push(&s->rings, at);
        }
    }
}

// The joint on the other side of the body.
static enum joint other_side(enum joint j)
{
    return j >= LEFT_UPPER_LEG ? j + 3 : j >= LEFT_UPPER_ARM ? j + 3 : j;
}

static void add_limb(struct skin *s, const struct ring *left, int count)
{
    struct ring right[8];
    memcpy(right, left, (size_t)count * sizeof *left);
    for (int i = 0; i < count; i++) {
        right[i].a = other_side(left[i].a);
        right[i].b = other_side(left[i].b);
    }
    add_tube(s, left, count, 1.0);
    add_tube(s, right, count, -1.0);
}

static void build_skin(struct skin *s)
{
    static const struct ring torso[] = {
        {{0, 0.84, 0}, 0.08, 0.07, HIPS, SPINE, 0},      {{0, 0.88, 0}, 0.155, 0.11, HIPS, SPINE, 0},
        {{0, 0.98, 0}, 0.15, 0.105, HIPS, SPINE, 0},     {{0, 1.08, 0}, 0.125, 0.09, HIPS, SPINE, 1},
        {{0, 1.16, 0}, 0.135, 0.095, SPINE, CHEST, 0.3}, {{0, 1.28, 0}, 0.165, 0.11, SPINE, CHEST, 1},
        {{0, 1.38, 0}, 0.17, 0.10, CHEST, NECK, 0},      {{0, 1.45, 0}, 0.08, 0.07, CHEST, NECK, 0.5},
    };
    static const struct ring neck[] = {
        {{0, 1.41, 0}, 0.055, 0.055, CHEST, NECK, 0.3},   {{0, 1.47, 0}, 0.05, 0.05, CHEST, NECK, 1},
        {{0, 1.54, 0.01}, 0.052, 0.055, NECK, HEAD, 0.8}, {{0, 1.57, 0.02}, 0.07, 0.085, NECK, HEAD, 1},
        {{0, 1.63, 0.02}, 0.085, 0.105, NECK, HEAD, 1},   {{0, 1.70, 0.015}, 0.09, 0.105, NECK, HEAD, 1},
        {{0, 1.77, 0.005}, 0.07, 0.08, NECK, HEAD, 1},    {{0, 1.795, 0}, 0.03, 0.035, NECK, HEAD, 1},
    };
    static const struct ring nose[] = {
        {{0, 1.625, 0.125}, 0.016, 0.016, HEAD, HEAD, 0},
        {{0, 1.645, 0.128}, 0.018, 0.02, HEAD, HEAD, 0},
        {{0, 1.69, 0.11}, 0.008, 0.008, HEAD, HEAD, 0},
    };
    static const struct ring arm[] = {
        {{0.315, 0.74, 0}, 0.015, 0.03, LEFT_LOWER_ARM, LEFT_HAND, 1},
        {{0.31, 0.79, 0}, 0.024, 0.045, LEFT_LOWER_ARM, LEFT_HAND, 1},
        {{0.30, 0.87, 0}, 0.027, 0.034, LEFT_LOWER_ARM, LEFT_HAND, 0.5},
        {{0.275, 1.00, 0}, 0.037, 0.037, LEFT_LOWER_ARM, LEFT_HAND, 0},
        {{0.25, 1.12, 0}, 0.042, 0.042, LEFT_UPPER_ARM, LEFT_LOWER_ARM, 0.5},
        {{0.22, 1.26, 0}, 0.050, 0.050, LEFT_UPPER_ARM, LEFT_LOWER_ARM, 0},
        {{0.19, 1.39, 0}, 0.060, 0.062, CHEST, LEFT_UPPER_ARM, 0.7},
        {{0.165, 1.43, 0}, 0.03, 0.035, CHEST, LEFT_UPPER_ARM, 0.4},
    };
    static const struct ring leg[] = {
        {{0.12, 0.06, 0}, 0.04, 0.05, LEFT_LOWER_LEG, LEFT_FOOT, 1},
        {{0.12, 0.10, 0}, 0.042, 0.05, LEFT_LOWER_LEG, LEFT_FOOT, 0.5},
        {{0.118, 0.20, 0}, 0.045, 0.048, LEFT_LOWER_LEG, LEFT_FOOT, 0},
        {{0.114, 0.38, 0}, 0.058, 0.064, LEFT_LOWER_LEG, LEFT_FOOT, 0},
        {{0.11, 0.50, 0.01}, 0.058, 0.062, LEFT_UPPER_LEG, LEFT_LOWER_LEG, 0.5},
        {{0.105, 0.64, 0.005}, 0.072, 0.076, LEFT_UPPER_LEG, LEFT_LOWER_LEG, 0},
        {{0.095, 0.84, 0}, 0.085, 0.09, HIPS, LEFT_UPPER_LEG, 0.8},
        {{0.085, 0.93, 0}, 0.06, 0.07, HIPS, LEFT_UPPER_LEG, 0.4},
    };
    static const struct ring foot[] = {
        {{0.12, 0.0, 0.06}, 0.046, 0.12, LEFT_FOOT, LEFT_FOOT, 0},
        {{0.12, 0.03, 0.055}, 0.048, 0.125, LEFT_FOOT, LEFT_FOOT, 0},
        {{0.12, 0.065, 0.02}, 0.042, 0.08, LEFT_FOOT, LEFT_FOOT, 0},
        {{0.12, 0.10, 0.0}, 0.03, 0.04, LEFT_FOOT, LEFT_FOOT, 0},
    };
    add_tube(s, torso, NG_COUNT(torso), 1.0);
    add_tube(s, neck, NG_COUNT(neck), 1.0);
    add_tube(s, nose, NG_COUNT(nose), 1.0);
    add_limb(s, arm, NG_COUNT(arm));
    add_limb(s, leg, NG_COUNT(leg));
    add_limb(s, foot, NG_COUNT(foot));
}

// Positions, normals, joints (8 bits) and weights (normalised, summing to exactly 255) of the tubes.
static int add_skin_mesh(struct glb *g, int material)
{
    struct skin s = {0};
    build_skin(&s);
    size_t n = s.cage.points.count;
    uint32_t corners = cage_triangle_count(&s.cage) * 3;
    struct vec3 *normals = calloc(n, sizeof *normals);
    uint32_t *influence = calloc(n * 4, sizeof *influence), *indices = calloc(corners, sizeof *indices);
    double *weights = calloc(n * 4, sizeof *weights);
    g->w.failed |= s.cage.failed || !normals || !influence || !indices || !weights;
    int mesh = 0;
    if (!g->w.failed) {
        cage_normals(&s.cage, normals);
        cage_triangles(&s.cage, indices);
        for (size_t i = 0; i < n; i++) {
            double b = round(s.rings.items[i].blend * 255.0);
            influence[i * 4] = s.rings.items[i].a;
            influence[i * 4 + 1] = b > 0.0 ? s.rings.items[i].b : 0;
            weights[i * 4] = (255.0 - b) / 255.0;
            weights[i * 4 + 1] = b / 255.0;
        }
        mesh = glb_add_mesh(
            g, &(struct glb_mesh){.name = "figure",
                                  .positions = glb_doubles(g, &s.cage.points.items[0].x, n, 3, true) + 1,
                                  .normals = glb_doubles(g, &normals[0].x, n, 3, false) + 1,
                                  .joints = glb_integers(g, influence, n, 4) + 1,
                                  .weights = glb_normalized(g, weights, n, 4, 8) + 1,
                                  .indices = glb_integers(g, indices, corners, 1) + 1,
                                  .material = material});
    }
    free(normals);
    free(influence);
    free(indices);
    free(weights);
    cage_finish(&s.cage);
    ng_array_finish(&s.rings);
    return mesh;
}

// ---- the skeleton and its clips ----

// `body`: the node that the hips hang on, index + 1.
static void add_skeleton(struct glb *g, int body, int nodes[JOINTS])
{
    for (int i = 0; i < JOINTS; i++) {
        int parent = joints[i].parent;
        struct vec3 t = joints[i].rest;
        if (parent >= 0)
            t = vec3_sub(t, joints[parent].rest);
        nodes[i] = glb_add_node(g, &(struct glb_node){.name = joints[i].name,
                                                      .parent = parent < 0 ? body : nodes[parent] + 1,
                                                      .translation = {t.x, t.y, t.z}});
    }
}

static int add_inverse_bind(struct glb *g)
{
    double matrices[JOINTS][16] = {0};
    for (int i = 0; i < JOINTS; i++) {
        for (int k = 0; k < 16; k += 5)
            matrices[i][k] = 1.0;
        matrices[i][12] = -joints[i].rest.x;
        matrices[i][13] = -joints[i].rest.y;
        matrices[i][14] = -joints[i].rest.z;
    }
    return glb_doubles(g, matrices[0], JOINTS, 16, false);
}

enum { KEYS = 13 };

// A joint that turns about an axis (0: X, 2: Z) by angle(phase), phase 0 to 1 over the clip.
static void add_turn(struct glb *g, int clip, int node, double seconds, int axis, double (*angle)(double))
{
    double times[KEYS], turns[KEYS][4] = {0};
    for (int k = 0; k < KEYS; k++) {
        double half = 0.5 * angle((double)k / (KEYS - 1));
        times[k] = seconds * k / (KEYS - 1);
        turns[k][axis] = sin(half);
        turns[k][3] = cos(half);
    }
    glb_add_channel(g, clip,
                    &(struct glb_channel){.node = node,
                                          .path = "rotation",
                                          .interpolation = "LINEAR",
                                          .times = times,
                                          .values = turns[0],
                                          .keys = KEYS});
}

static double wave(double phase)
{
    return sin(2.0 * CONTENT_PI * phase);
}

// About X: positive swings a hanging limb backwards. The left leg leads; knees bend while the leg comes
// forward.
static double leg_left(double p)
{
    return 0.5 * -wave(p);
}
static double leg_right(double p)
{
    return 0.5 * wave(p);
}
static double knee_left(double p)
{
    return 0.1 + 0.45 * (1.0 + wave(p + 0.30));
}
static double knee_right(double p)
{
    return knee_left(p + 0.5);
}
static double foot_left(double p)
{
    return 0.15 * wave(p + 0.1);
}
static double foot_right(double p)
{
    return foot_left(p + 0.5);
}
static double arm_left(double p)
{
    return 0.4 * wave(p);
}
static double arm_right(double p)
{
    return -0.4 * wave(p);
}
static double elbow(double p)
{
    return -0.45 - 0.15 * wave(2.0 * p);
}
static double lean(double p)
{
    return 0.05 + 0.02 * wave(2.0 * p);
}
static double nod(double p)
{
    return -0.03 - 0.02 * wave(2.0 * p);
}
static double raise(double p)
{
    return -2.3 + 0.1 * wave(p);
}
static double beckon(double p)
{
    return -0.5 + 0.5 * wave(2.0 * p);
}
static double tilt(double p)
{
    return 0.08 * wave(p);
}

static void add_walk(struct glb *g, int clip, const int nodes[JOINTS])
{
    static const struct {
        enum joint joint;
        double (*angle)(double);
    } turns[] = {
        {SPINE, lean},
        {HEAD, nod},
        {LEFT_UPPER_LEG, leg_left},
        {RIGHT_UPPER_LEG, leg_right},
        {LEFT_LOWER_LEG, knee_left},
        {RIGHT_LOWER_LEG, knee_right},
        {LEFT_FOOT, foot_left},
        {RIGHT_FOOT, foot_right},
        {LEFT_UPPER_ARM, arm_left},
        {RIGHT_UPPER_ARM, arm_right},
        {LEFT_LOWER_ARM, elbow},
        {RIGHT_LOWER_ARM, elbow},
    };
    const double seconds = 1.2;
    for (size_t i = 0; i < NG_COUNT(turns); i++)
        add_turn(g, clip, nodes[turns[i].joint], seconds, 0, turns[i].angle);
    double times[KEYS], places[KEYS][3];
    for (int k = 0; k < KEYS; k++) { // the hips bob twice a cycle
        times[k] = seconds * k / (KEYS - 1);
        places[k][0] = 0.0;
        places[k][1] = joints[HIPS].rest.y - 0.025 - 0.02 * cos(4.0 * CONTENT_PI * k / (KEYS - 1));
        places[k][2] = 0.0;
    }
    glb_add_channel(g, clip,
                    &(struct glb_channel){.node = nodes[HIPS],
                                          .path = "translation",
                                          .interpolation = "LINEAR",
                                          .times = times,
                                          .values = places[0],
                                          .keys = KEYS});
}

// Stronger than the walk where both drive the right arm.
static void add_wave(struct glb *g, const int nodes[JOINTS])
{
    const double seconds = 1.6;
    int clip = glb_add_animation(g, "wave");
    add_turn(g, clip, nodes[RIGHT_UPPER_ARM], seconds, 2, raise);
    add_turn(g, clip, nodes[RIGHT_LOWER_ARM], seconds, 2, beckon);
    add_turn(g, clip, nodes[HEAD], seconds, 2, tilt);
    glb_set(g, glb_component(g, NG_GLTF_ANIMATIONS, clip, "animation"), "weight", 4.0);
}

// ---- figures ----

struct figure figure_init(struct glb *g, int material)
{
    int mesh = add_skin_mesh(g, material);
    return (struct figure){.mesh = mesh, .inverse_bind = add_inverse_bind(g)};
}

// Fills the nodes of its joints.
static void add_figure(struct glb *g, const struct figure *f, const char *name, int body, int nodes[JOINTS])
{
    add_skeleton(g, body, nodes);
    int skin = glb_add_skin(g, name, nodes, JOINTS, f->inverse_bind);
    glb_add_node(g, &(struct glb_node){.name = name, .mesh = f->mesh + 1, .skin = skin + 1});
}

void figure_add(struct glb *g, const struct figure *f, const char *name, int parent, double scale, int clip)
{
    int nodes[JOINTS];
    int body =
        glb_add_node(g, &(struct glb_node){.name = "body", .parent = parent, .scale = {scale, scale, scale}});
    add_figure(g, f, name, body + 1, nodes);
    add_walk(g, clip, nodes);
}

ng_result unit_character(struct bytes *out)
{
    struct glb g;
    int nodes[JOINTS];
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    struct figure figure = figure_init(&g, stage_material(&g, "figure", 0.72, 0.48, 0.26, 0.4));
    add_figure(&g, &figure, "figure", 0, nodes);
    add_walk(&g, glb_add_animation(&g, "walk"), nodes);
    add_wave(&g, nodes);
    return glb_finish(&g, out);
}
