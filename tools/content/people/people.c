#include "people.h"

#include "../stage.h"
#include "cloth.h"
#include "head.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const people_body_names[PEOPLE_BODIES] = {"jacket", "bob", "beard", "long",
                                                      "curls",  "bun", "tall",  "tail"};

enum cloth { PLAIN, WOVEN, DENIM, LEATHER };

struct dress {
    double color[3], roughness;
    enum cloth cloth;
};

static const struct body {
    struct build build;
    struct face face;
    struct hair hair;
    double skin[3], iris[3], hair_color[3];
    struct dress top, bottom, shoes;
    struct garment shirt, trousers;
    double sole, shaft, sole_color[3];
} bodies[PEOPLE_BODIES] = {
    [PEOPLE_JACKET] = {.build = {1.02, 1.02, 1.0, 1.03, 0.98, 1.0, 0.0, 0.5, 0.0},
                       .face = {0.1, 0.3, 0.4, 0.4, 0.2, 0.5, 0.2, 0, 0.5, -0.3, 0.2, 0, 0.1, 0.2},
                       .hair = {0.066, -0.012, -0.075, 0.030, 0.011, 0.014, 1, 0, 0.35, 0, 0, 0, 0, -0.28,
                                0.0042},
                       .skin = {0.62, 0.40, 0.29},
                       .iris = {0.16, 0.24, 0.30},
                       .hair_color = {0.085, 0.045, 0.024},
                       .top = {{0.030, 0.026, 0.024}, 0.36, LEATHER},
                       .bottom = {{0.075, 0.105, 0.19}, 0.85, DENIM},
                       .shoes = {{0.05, 0.030, 0.018}, 0.42, LEATHER},
                       .shirt = {.part = PART_TOP,
                                 .ease = 0.016,
                                 .blend = 0.03,
                                 .low = -0.03,
                                 .high = 0.45,
                                 .arms = true,
                                 .trunk = true,
                                 .arm_to = 0.99,
                                 .sleeve = 0.042,
                                 .folds = 0.0060,
                                 .thickness = 0.004,
                                 .collar = 0.034},
                       .trousers = {.part = PART_BOTTOM,
                                    .ease = 0.006,
                                    .blend = 0.02,
                                    .low = -0.115,
                                    .high = 0.07,
                                    .legs = true,
                                    .trunk = true,
                                    .leg_to = 1.03,
                                    .leg_width = 0.062,
                                    .folds = 0.0050,
                                    .thickness = 0.003},
                       .sole = 0.022,
                       .shaft = 0.16,
                       .sole_color = {0.35, 0.32, 0.30}},
    [PEOPLE_BOB] = {.build = {0.95, 0.99, 0.96, 0.90, 1.02, 0.98, -0.1, 0.2, 1.0},
                    .face = {0, -0.3, -0.2, 0, 0.4, -0.3, -0.3, -0.2, -0.2, 0.5, 0, 0.5, 0.4, 0},
                    .hair = {0.056, -0.02, -0.07, 0.022, 0.020, 0.022, -1, 0, 0.22, 0.085, 66, 0, 0, 0,
                             0.0030},
                    .skin = {0.72, 0.50, 0.39},
                    .iris = {0.22, 0.12, 0.05},
                    .hair_color = {0.028, 0.018, 0.014},
                    .top = {{0.52, 0.07, 0.065}, 0.75, WOVEN},
                    .bottom = {{0.05, 0.055, 0.075}, 0.7, WOVEN},
                    .shoes = {{0.60, 0.58, 0.55}, 0.5, LEATHER},
                    .shirt = {.part = PART_TOP,
                              .ease = 0.008,
                              .blend = 0.03,
                              .low = 0.03,
                              .high = 0.30,
                              .arms = true,
                              .trunk = true,
                              .arm_to = 0.36,
                              .sleeve = 0.0,
                              .flare = 0.006,
                              .folds = 0.0045,
                              .thickness = 0.003},
                    .trousers = {.part = PART_BOTTOM,
                                 .ease = 0.005,
                                 .blend = 0.05,
                                 .low = -0.10,
                                 .high = 0.10,
                                 .trunk = true,
                                 .skirt = 0.42,
                                 .leg_width = 0.06,
                                 .folds = 0.002,
                                 .thickness = 0.003},
                    .sole = 0.024,
                    .shaft = 0.10,
                    .sole_color = {1, 1, 1}},
    [PEOPLE_BEARD] = {.build = {1.0, 0.97, 1.0, 1.06, 1.04, 1.03, 0.95, 0.4, 0.0},
                      .face = {0.8, 0, 0.8, 0.2, 0.3, 0.8, 0.1, 0.9, 0.2, 0, 0.3, -0.2, -0.2, 0.5},
                      .hair = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.016, 0.0046},
                      .skin = {0.60, 0.36, 0.26},
                      .iris = {0.12, 0.19, 0.12},
                      .hair_color = {0.16, 0.060, 0.024},
                      .top = {{0.10, 0.17, 0.13}, 0.85, WOVEN},
                      .bottom = {{0.16, 0.13, 0.095}, 0.85, WOVEN},
                      .shoes = {{0.15, 0.085, 0.04}, 0.5, LEATHER},
                      .shirt = {.part = PART_TOP,
                                .ease = 0.014,
                                .blend = 0.06,
                                .low = -0.07,
                                .high = 0.42,
                                .arms = true,
                                .trunk = true,
                                .arm_to = 0.62,
                                .sleeve = 0.044,
                                .folds = 0.0055,
                                .thickness = 0.003,
                                .collar = 0.022,
                                .flare = 0.008},
                      .trousers = {.part = PART_BOTTOM,
                                   .ease = 0.006,
                                   .blend = 0.03,
                                   .low = -0.115,
                                   .high = 0.06,
                                   .legs = true,
                                   .trunk = true,
                                   .leg_to = 1.0,
                                   .leg_width = 0.078,
                                   .folds = 0.0055,
                                   .thickness = 0.003},
                      .sole = 0.026,
                      .shaft = 0.14,
                      .sole_color = {0.6, 0.5, 0.4}},
    [PEOPLE_LONG] = {.build = {1.01, 1.04, 1.0, 0.92, 0.98, 0.98, -0.3, 0.2, 1.0},
                     .face = {-0.3, 0.2, -0.3, 0.2, 0.8, -0.2, 0.1, -0.4, 0.3, 0.7, 0.3, 0.3, 0.7, 0},
                     .hair = {0.062, -0.02, -0.07, 0.022, 0.018, 0.024, 0.35, 0, 0.45, 0.26, 74, 0, 0, 0,
                              0.0030},
                     .skin = {0.74, 0.50, 0.38},
                     .iris = {0.10, 0.22, 0.16},
                     .hair_color = {0.42, 0.24, 0.095},
                     .top = {{0.62, 0.60, 0.56}, 0.8, WOVEN},
                     .bottom = {{0.026, 0.024, 0.026}, 0.33, LEATHER},
                     .shoes = {{0.03, 0.028, 0.03}, 0.3, LEATHER},
                     .shirt = {.part = PART_TOP,
                               .ease = 0.012,
                               .blend = 0.045,
                               .low = -0.06,
                               .high = 0.22,
                               .arms = true,
                               .trunk = true,
                               .arm_to = 0.90,
                               .sleeve = 0.036,
                               .folds = 0.0050,
                               .thickness = 0.003,
                               .flare = 0.010},
                     .trousers = {.part = PART_BOTTOM,
                                  .ease = 0.003,
                                  .blend = 0.015,
                                  .low = -0.11,
                                  .high = 0.06,
                                  .legs = true,
                                  .trunk = true,
                                  .leg_to = 0.97,
                                  .leg_width = 0.0,
                                  .folds = 0.0035,
                                  .thickness = 0.003},
                     .sole = 0.024,
                     .shaft = 0.19,
                     .sole_color = {0.6, 0.6, 0.6}},
    [PEOPLE_CURLS] = {.build = {0.99, 1.01, 1.02, 0.98, 0.95, 1.0, -0.35, 0.2, 0.0},
                      .face = {-0.2, -0.2, -0.2, 0, 0.3, 0, -0.3, 0.9, -0.4, 1.0, 0.5, 0.3, 0.2, 0},
                      .hair = {0.060, 0.004, -0.06, 0.050, 0.024, 0.034, 0, 0.008, 0.10, 0, 0, 0, 0, 0,
                               0.0040},
                      .skin = {0.185, 0.090, 0.052},
                      .iris = {0.055, 0.025, 0.012},
                      .hair_color = {0.014, 0.010, 0.008},
                      .top = {{0.62, 0.36, 0.05}, 0.9, WOVEN},
                      .bottom = {{0.06, 0.062, 0.07}, 0.85, WOVEN},
                      .shoes = {{0.70, 0.70, 0.68}, 0.5, LEATHER},
                      .shirt = {.part = PART_TOP,
                                .ease = 0.022,
                                .blend = 0.06,
                                .low = -0.06,
                                .high = 0.36,
                                .arms = true,
                                .trunk = true,
                                .arm_to = 0.97,
                                .sleeve = 0.044,
                                .folds = 0.0070,
                                .thickness = 0.005,
                                .collar = 0.032},
                      .trousers = {.part = PART_BOTTOM,
                                   .ease = 0.007,
                                   .blend = 0.03,
                                   .low = -0.13,
                                   .high = 0.06,
                                   .legs = true,
                                   .trunk = true,
                                   .leg_to = 0.96,
                                   .leg_width = 0.060,
                                   .folds = 0.0055,
                                   .thickness = 0.003},
                      .sole = 0.026,
                      .shaft = 0.11,
                      .sole_color = {1, 1, 1}},
    [PEOPLE_BUN] = {.build = {0.94, 0.97, 0.97, 0.93, 1.08, 1.0, 0.35, 0.0, 1.0},
                    .face = {0.3, 0.1, 0.1, -0.2, 0.1, 0, 0.4, 0.2, 0.2, -0.3, 0, -0.3, -0.3, 1.0},
                    .hair = {0.060, -0.004, -0.05, 0.015, 0.009, 0.010, 0, 0, 0.25, 0, 0, 0.036, 0, 0,
                             0.0026},
                    .skin = {0.68, 0.46, 0.37},
                    .iris = {0.12, 0.20, 0.26},
                    .hair_color = {0.42, 0.41, 0.40},
                    .top = {{0.10, 0.20, 0.27}, 0.9, WOVEN},
                    .bottom = {{0.20, 0.18, 0.17}, 0.8, WOVEN},
                    .shoes = {{0.11, 0.05, 0.035}, 0.45, LEATHER},
                    .shirt = {.part = PART_TOP,
                              .ease = 0.016,
                              .blend = 0.055,
                              .low = -0.13,
                              .high = 0.34,
                              .arms = true,
                              .trunk = true,
                              .arm_to = 0.95,
                              .sleeve = 0.040,
                              .folds = 0.0055,
                              .thickness = 0.005,
                              .collar = 0.014,
                              .flare = 0.010},
                    .trousers = {.part = PART_BOTTOM,
                                 .ease = 0.006,
                                 .blend = 0.03,
                                 .low = -0.115,
                                 .high = 0.05,
                                 .legs = true,
                                 .trunk = true,
                                 .leg_to = 0.98,
                                 .leg_width = 0.066,
                                 .folds = 0.0045,
                                 .thickness = 0.003},
                    .sole = 0.020,
                    .shaft = 0.10,
                    .sole_color = {0.5, 0.5, 0.5}},
    [PEOPLE_TALL] = {.build = {1.07, 1.03, 1.03, 1.0, 0.94, 0.98, -0.55, 0.1, 0.0},
                     .face = {-0.5, 0.8, -0.1, 0.6, 0.1, 0.3, 0.9, -0.2, 0.9, -0.4, 0, -0.1, -0.1, 0.3},
                     .hair = {0.068, -0.03, -0.07, 0.020, 0.014, 0.022, 0.01, 0, 0.50, 0.17, 78, 0, 0, -0.42,
                              0.0042},
                     .skin = {0.58, 0.37, 0.26},
                     .iris = {0.14, 0.085, 0.03},
                     .hair_color = {0.11, 0.062, 0.032},
                     .top = {{0.075, 0.075, 0.08}, 0.85, WOVEN},
                     .bottom = {{0.032, 0.036, 0.048}, 0.8, DENIM},
                     .shoes = {{0.04, 0.04, 0.045}, 0.6, WOVEN},
                     .shirt = {.part = PART_TOP,
                               .ease = 0.011,
                               .blend = 0.05,
                               .low = -0.05,
                               .high = 0.33,
                               .arms = true,
                               .trunk = true,
                               .arm_to = 0.40,
                               .sleeve = 0.050,
                               .folds = 0.0060,
                               .thickness = 0.003,
                               .flare = 0.006},
                     .trousers = {.part = PART_BOTTOM,
                                  .ease = 0.005,
                                  .blend = 0.02,
                                  .low = -0.115,
                                  .high = 0.06,
                                  .legs = true,
                                  .trunk = true,
                                  .leg_to = 0.98,
                                  .leg_width = 0.046,
                                  .folds = 0.0050,
                                  .thickness = 0.003},
                     .sole = 0.024,
                     .shaft = 0.13,
                     .sole_color = {1, 1, 1}},
    [PEOPLE_TAIL] = {.build = {0.925, 0.99, 0.98, 0.93, 1.0, 1.0, 0.0, 0.6, 1.0},
                     .face = {0.2, -0.4, 0.1, 0.1, 0.5, -0.1, -0.4, 0.5, -0.3, 0.9, 0.4, 0.4, 0.3, 0},
                     .hair = {0.058, 0.0, -0.05, 0.012, 0.008, 0.010, 0, 0, 0.28, 0, 0, 0, 0.26, 0, 0.0032},
                     .skin = {0.30, 0.155, 0.092},
                     .iris = {0.08, 0.04, 0.018},
                     .hair_color = {0.030, 0.017, 0.012},
                     .top = {{0.05, 0.30, 0.33}, 0.7, WOVEN},
                     .bottom = {{0.30, 0.31, 0.34}, 0.85, DENIM},
                     .shoes = {{0.65, 0.12, 0.10}, 0.5, LEATHER},
                     .shirt = {.part = PART_TOP,
                               .ease = 0.006,
                               .blend = 0.03,
                               .low = 0.0,
                               .high = 0.20,
                               .arms = true,
                               .trunk = true,
                               .arm_to = 0.20,
                               .folds = 0.0030,
                               .thickness = 0.003},
                     .trousers = {.part = PART_BOTTOM,
                                  .ease = 0.005,
                                  .blend = 0.02,
                                  .low = -0.115,
                                  .high = 0.10,
                                  .legs = true,
                                  .trunk = true,
                                  .leg_to = 0.90,
                                  .leg_width = 0.052,
                                  .folds = 0.0045,
                                  .thickness = 0.003},
                     .sole = 0.028,
                     .shaft = 0.10,
                     .sole_color = {1, 1, 1}},
};

bool people_shape(enum people_body body, struct shape *s, struct skeleton *skeleton)
{
    const struct body *b = &bodies[body];
    struct anatomy a;
    memset(s, 0, sizeof *s);
    anatomy_make(&b->build, &a);
    *skeleton = a.skeleton;
    body_garment(s, &a, &b->shirt);
    body_garment(s, &a, &b->trousers);
    double bare = b->shirt.arm_to < 0.9 ? b->shirt.arm_to - 0.05 : 0.88;
    body_garment(s, &a, &(struct garment){.part = PART_SKIN, .arms = true, .arm_from = bare, .arm_to = 1.0});
    double bare_leg = b->trousers.skirt > 0.0 ? b->trousers.skirt - 0.2 : b->trousers.leg_to - 0.06;
    if (b->trousers.skirt > 0.0 || b->shaft < 0.12)
        body_garment(s, &a,
                     &(struct garment){.part = PART_SKIN, .legs = true, .arm_from = bare_leg, .leg_to = 1.0});
    body_hands(s, &a);
    body_shoes(s, &a, b->sole, b->shaft, b->sole_color);
    head_build(s, &a, &b->face, &b->hair, b->iris);
    shape_prune(s);
    shape_normals(s);
    for (int i = 0; i < PEOPLE_PARTS; i++)
        for (size_t v = 0; v < s->parts[i].vertices.count; v++)
            s->parts[i].vertices.items[v].place =
                vec3_scale(s->parts[i].vertices.items[v].place, b->build.height);
    return !s->failed;
}

// ---- quantized data ----

// Positions are fractions of a cube about the body, which the inverse bind matrices scale back.
#define CUBE        1.15
#define CUBE_MIDDLE 1.05

enum { BYTE = 5120, SHORT = 5122 };

// `width` integers an element, each element padded to a multiple of four bytes.
static int packed(struct glb *g, const double *values, size_t count, int width, int type, bool bounds,
                  enum ng_gltf_target target)
{
    bool wide = type == SHORT || type == NG_GLTF_U16, sign = type == BYTE || type == SHORT;
    double most = (double)((1 << ((wide ? 16 : 8) - (sign ? 1 : 0))) - 1);
    size_t stride = (size_t)(width * (wide ? 2 : 1) + 3) / 4 * 4;
    unsigned char *data = calloc(count + 1, stride);
    double low[4] = {1e9, 1e9, 1e9, 1e9}, high[4] = {-1e9, -1e9, -1e9, -1e9};
    if (!data) {
        g->w.failed = true;
        return 0;
    }
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < width; k++) {
            double v =
                round(fmin(fmax(values[i * (size_t)width + (size_t)k], sign ? -1.0 : 0.0), 1.0) * most);
            uint32_t bits = (uint32_t)(int32_t)v;
            unsigned char *at = data + i * stride + (size_t)(k * (wide ? 2 : 1));
            at[0] = (unsigned char)bits;
            if (wide)
                at[1] = (unsigned char)(bits >> 8);
            low[k] = fmin(low[k], v);
            high[k] = fmax(high[k], v);
        }
    cJSON *accessor;
    int view = ng_gltf_add_view(&g->w, data, count * stride, target);
    if (target == NG_GLTF_VERTICES)
        glb_set(g, ng_gltf_at(&g->w, NG_GLTF_VIEWS, view), "byteStride", (double)stride);
    int index = ng_gltf_append(&g->w, NG_GLTF_ACCESSORS, &accessor);
    glb_set(g, accessor, "bufferView", view);
    glb_set(g, accessor, "componentType", type);
    glb_set_bool(g, accessor, "normalized", true);
    glb_set(g, accessor, "count", (double)count);
    glb_set_text(g, accessor, "type", width == 2 ? "VEC2" : width == 3 ? "VEC3" : "VEC4");
    if (bounds) {
        glb_set_list(g, accessor, "min", low, width);
        glb_set_list(g, accessor, "max", high, width);
    }
    free(data);
    return index;
}

// Whole 255ths that sum to 1: the largest takes what rounding leaves.
static void round_weights(const double in[4], double out[4])
{
    int sum = 0, steps[4];
    for (int k = 0; k < 4; k++)
        sum += steps[k] = (int)lround(in[k] * 255.0);
    steps[0] += 255 - sum;
    for (int k = 0; k < 4; k++)
        out[k] = steps[k] / 255.0;
}

static void write_part(struct people *p, enum people_body body, enum people_part part,
                       const struct shape_part *s)
{
    struct glb *g = p->g;
    size_t n = s->vertices.count;
    p->bodies[body].parts[part].indices = -1;
    if (!s->triangles.count)
        return;
    double *values = calloc(n * 4, sizeof *values);
    uint32_t *joints = calloc(n * 4, sizeof *joints);
    g->w.failed |= !values || !joints;
    if (!g->w.failed) {
        const struct shape_vertex *v = s->vertices.items;
        for (size_t i = 0; i < n; i++) {
            values[i * 3] = v[i].place.x / CUBE;
            values[i * 3 + 1] = (v[i].place.y - CUBE_MIDDLE) / CUBE;
            values[i * 3 + 2] = v[i].place.z / CUBE;
        }
        p->bodies[body].parts[part].position = packed(g, values, n, 3, SHORT, true, NG_GLTF_VERTICES);
        for (size_t i = 0; i < n; i++)
            memcpy(values + i * 3, &v[i].normal, 3 * sizeof *values);
        p->bodies[body].parts[part].normal = packed(g, values, n, 3, BYTE, false, NG_GLTF_VERTICES);
        for (size_t i = 0; i < n; i++)
            for (int k = 0; k < 2; k++) // two metres and a half each way
                values[i * 2 + (size_t)k] = 0.4 * v[i].uv[k];
        p->bodies[body].parts[part].uv = part == PART_SKIN || part == PART_EYES
                                             ? -1
                                             : packed(g, values, n, 2, NG_GLTF_U16, false, NG_GLTF_VERTICES);
        for (size_t i = 0; i < n; i++)
            memcpy(values + i * 3, v[i].color, 3 * sizeof *values);
        p->bodies[body].parts[part].color = packed(g, values, n, 3, NG_GLTF_U8, false, NG_GLTF_VERTICES);
        for (size_t i = 0; i < n; i++)
            round_weights(v[i].weights, values + i * 4);
        p->bodies[body].parts[part].weights = packed(g, values, n, 4, NG_GLTF_U8, false, NG_GLTF_VERTICES);
        for (size_t i = 0; i < n * 4; i++)
            joints[i] = values[i] > 0.0 ? v[i / 4].joints[i % 4] : 0;
        p->bodies[body].parts[part].joints =
            ng_gltf_add_integers(&g->w, joints, n, 4, 1, NG_GLTF_VERTICES, NULL);
        p->bodies[body].parts[part].indices =
            ng_gltf_add_integers(&g->w, s->triangles.items, s->triangles.count, 1, 0, NG_GLTF_INDICES, NULL);
    }
    free(values);
    free(joints);
}

static void write_body(struct people *p, enum people_body body)
{
    struct shape s;
    p->g->w.failed |= !people_shape(body, &s, &p->skeletons[body]);
    for (int i = 0; i < PEOPLE_PARTS && !p->g->w.failed; i++)
        write_part(p, body, (enum people_part)i, &s.parts[i]);
    shape_finish(&s);
    double matrices[PEOPLE_JOINTS][16] = {0};
    for (int i = 0; i < PEOPLE_JOINTS; i++) {
        struct vec3 rest = vec3_scale(p->skeletons[body].rest[i], p->skeletons[body].height);
        for (int k = 0; k < 15; k += 5)
            matrices[i][k] = CUBE;
        matrices[i][12] = -rest.x;
        matrices[i][13] = CUBE_MIDDLE - rest.y;
        matrices[i][14] = -rest.z;
        matrices[i][15] = 1.0;
    }
    p->bodies[body].inverse_bind = glb_doubles(p->g, matrices[0], PEOPLE_JOINTS, 16, false);
    p->bodies[body].made = true;
}

// ---- materials and meshes ----

static void name_extension(struct glb *g, const char *list, const char *name)
{
    cJSON *names = ng_gltf_json_list(&g->w, g->w.root, list), *entry;
    cJSON_ArrayForEach(entry, names) if (strcmp(cJSON_GetStringValue(entry), name) == 0) return;
    if (names && !cJSON_AddItemToArray(names, cJSON_CreateString(name)))
        g->w.failed = true;
}

void people_init(struct people *p, struct glb *g)
{
    memset(p, 0, sizeof *p);
    p->g = g;
    name_extension(g, "extensionsUsed", "KHR_mesh_quantization");
    name_extension(g, "extensionsRequired", "KHR_mesh_quantization");
}

// A normal map that repeats every `size` metres.
static void add_relief(struct people *p, int material, enum cloth cloth, bool hair)
{
    struct glb *g = p->g;
    int *texture = hair               ? &p->strands
                   : cloth == LEATHER ? &p->leather
                   : cloth == DENIM   ? &p->denim
                                      : &p->cloth;
    ng_result (*make)(struct bytes *) = hair               ? cloth_strands
                                        : cloth == LEATHER ? cloth_leather
                                        : cloth == DENIM   ? cloth_denim
                                                           : cloth_weave;
    const char *name = hair ? "strands" : cloth == LEATHER ? "leather" : cloth == DENIM ? "denim" : "weave";
    double size = hair ? 0.05 : cloth == LEATHER ? 0.055 : cloth == DENIM ? 0.050 : 0.050;
    if (!*texture)
        *texture = glb_texture(g, name, make, GLB_REPEAT) + 1;
    cJSON *normal =
        ng_gltf_json_object(&g->w, ng_gltf_at(&g->w, NG_GLTF_MATERIALS, material), "normalTexture");
    glb_set(g, normal, "index", *texture - 1);
    const double scale[2] = {2.5 / size, 2.5 / (hair ? 0.3 : size)};
    glb_set_list(g, ng_gltf_json_extension(&g->w, normal, "KHR_texture_transform"), "scale", scale, 2);
}

static const double *chosen(const double own[3], const double *other)
{
    return other && other[0] >= 0.0 ? other : own;
}

static int add_material(struct people *p, enum people_body body, enum people_part part,
                        const struct people_colors *c)
{
    const struct body *b = &bodies[body];
    static const char *const names[PEOPLE_PARTS] = {"skin", "eyes", "hair", "top", "bottom", "shoes"};
    static const double white[3] = {1, 1, 1};
    const struct dress *dress = part == PART_TOP ? &b->top : part == PART_BOTTOM ? &b->bottom : &b->shoes;
    const double *color = part == PART_EYES     ? white
                          : part == PART_SKIN   ? chosen(b->skin, c ? c->skin : NULL)
                          : part == PART_HAIR   ? chosen(b->hair_color, c ? c->hair : NULL)
                          : part == PART_TOP    ? chosen(dress->color, c ? c->top : NULL)
                          : part == PART_BOTTOM ? chosen(dress->color, c ? c->bottom : NULL)
                                                : chosen(dress->color, c ? c->shoes : NULL);
    char name[64];
    snprintf(name, sizeof name, "%s-%s", people_body_names[body], names[part]);
    double roughness = part == PART_SKIN   ? 0.48
                       : part == PART_EYES ? 0.12
                       : part == PART_HAIR ? 0.46
                                           : dress->roughness;
    int material = glb_add_material(
        p->g,
        &(struct glb_material){.name = name,
                               .base_color = {color[0], color[1], color[2]},
                               .roughness = roughness,
                               .double_sided = part == PART_TOP || part == PART_BOTTOM || part == PART_HAIR});
    if (part >= PART_TOP && dress->cloth != PLAIN)
        add_relief(p, material, dress->cloth, false);
    if (part == PART_HAIR)
        add_relief(p, material, PLAIN, true);
    return material;
}

static int write_mesh(struct people *p, enum people_body body, const struct people_colors *c)
{
    struct glb *g = p->g;
    cJSON *mesh;
    int index = ng_gltf_append(&g->w, NG_GLTF_MESHES, &mesh);
    glb_set_text(g, mesh, "name", people_body_names[body]);
    cJSON *list = ng_gltf_json_list(&g->w, mesh, "primitives");
    for (int i = 0; i < PEOPLE_PARTS && !g->w.failed; i++) {
        if (p->bodies[body].parts[i].indices < 0)
            continue;
        cJSON *primitive = ng_gltf_json_append(&g->w, list),
              *attributes = ng_gltf_json_object(&g->w, primitive, "attributes");
        glb_set(g, attributes, "POSITION", p->bodies[body].parts[i].position);
        glb_set(g, attributes, "NORMAL", p->bodies[body].parts[i].normal);
        if (p->bodies[body].parts[i].uv >= 0)
            glb_set(g, attributes, "TEXCOORD_0", p->bodies[body].parts[i].uv);
        glb_set(g, attributes, "COLOR_0", p->bodies[body].parts[i].color);
        glb_set(g, attributes, "JOINTS_0", p->bodies[body].parts[i].joints);
        glb_set(g, attributes, "WEIGHTS_0", p->bodies[body].parts[i].weights);
        glb_set(g, primitive, "indices", p->bodies[body].parts[i].indices);
        glb_set(g, primitive, "material", add_material(p, body, (enum people_part)i, c));
    }
    return index;
}

static int find_mesh(struct people *p, enum people_body body, const struct people_colors *c)
{
    static const struct people_colors own = {{-1}, {-1}, {-1}, {-1}, {-1}};
    if (!c)
        c = &own;
    for (int i = 0; i < p->written_count; i++)
        if (p->written[i].body == body && memcmp(&p->written[i].colors, c, sizeof *c) == 0)
            return p->written[i].mesh;
    if (!p->bodies[body].made)
        write_body(p, body);
    int mesh = write_mesh(p, body, c);
    if (p->written_count < PEOPLE_WRITTEN)
        p->written[p->written_count++] = (struct people_written){body, *c, mesh};
    return mesh;
}

// ---- people ----

void people_add(struct people *p, const struct people_place *place, struct person *out)
{
    int mesh = find_mesh(p, place->body, place->colors);
    const struct skeleton *s = &p->skeletons[place->body];
    char name[96];
    out->body = place->body;
    out->root = glb_add_node(
        p->g, &(struct glb_node){.name = place->name,
                                 .parent = place->parent,
                                 .translation = {place->at.x, place->at.y, place->at.z},
                                 .rotation = {0, sin(0.5 * place->turn), 0, cos(0.5 * place->turn)}});
    for (int i = 0; i < PEOPLE_JOINTS; i++) {
        int parent = s->parent[i];
        struct vec3 t = parent < 0 ? s->rest[i] : vec3_sub(s->rest[i], s->rest[parent]);
        t = vec3_scale(t, s->height);
        skeleton_name(i, name);
        out->nodes[i] =
            glb_add_node(p->g, &(struct glb_node){.name = name,
                                                  .parent = (parent < 0 ? out->root : out->nodes[parent]) + 1,
                                                  .translation = {t.x, t.y, t.z}});
    }
    int skin =
        glb_add_skin(p->g, place->name, out->nodes, PEOPLE_JOINTS, p->bodies[place->body].inverse_bind);
    snprintf(name, sizeof name, "%s-body", place->name);
    glb_add_node(p->g, &(struct glb_node){.name = name, .mesh = mesh + 1, .skin = skin + 1});
}

// ---- clips ----

enum { KEYS = 64 };

static void add_channel(struct people *p, int animation, int node, const char *path, int input, int output)
{
    struct glb *g = p->g;
    cJSON *object = ng_gltf_at(&g->w, NG_GLTF_ANIMATIONS, animation),
          *samplers = ng_gltf_json_list(&g->w, object, "samplers");
    cJSON *sampler = ng_gltf_json_append(&g->w, samplers);
    if (!sampler)
        return;
    glb_set(g, sampler, "input", input);
    glb_set(g, sampler, "output", output);
    cJSON *channel = ng_gltf_json_append(&g->w, ng_gltf_json_list(&g->w, object, "channels"));
    glb_set(g, channel, "sampler", cJSON_GetArraySize(samplers) - 1);
    cJSON *target = ng_gltf_json_object(&g->w, channel, "target");
    glb_set(g, target, "node", node);
    glb_set_text(g, target, "path", path);
}

// Rotations as 16-bit fractions.
static int add_rotations(struct glb *g, const struct quat *keys, int count)
{
    double values[KEYS + 1][4];
    for (int k = 0; k < count; k++) {
        const double q[4] = {keys[k].x, keys[k].y, keys[k].z, keys[k].w};
        memcpy(values[k], q, sizeof q);
    }
    int index = packed(g, values[0], (size_t)count, 4, SHORT, false, NG_GLTF_NO_TARGET);
    return index;
}

static bool constant(const struct quat *keys, int count)
{
    for (int k = 1; k < count; k++)
        if (fabs(keys[k].x - keys[0].x) + fabs(keys[k].y - keys[0].y) + fabs(keys[k].z - keys[0].z) +
                fabs(keys[k].w - keys[0].w) >
            1e-4)
            return false;
    return true;
}

int people_play(struct people *p, const struct person *who, enum people_clip which, const char *name,
                double phase)
{
    const struct clip *clip = &people_clips[which];
    const struct skeleton *s = &p->skeletons[who->body];
    static struct quat turns[PEOPLE_JOINTS][KEYS + 1];
    double times[KEYS + 1], places[KEYS + 1][3];
    int count = clip->keys + 1, animation = glb_add_animation(p->g, name);
    for (int k = 0; k < count; k++) {
        struct pose pose;
        people_pose(s, which, phase + (double)(k % clip->keys) / clip->keys, &pose);
        times[k] = clip->seconds * k / clip->keys;
        places[k][0] = pose.hips.x * s->height;
        places[k][1] = pose.hips.y * s->height;
        places[k][2] = pose.hips.z * s->height;
        for (int j = 0; j < PEOPLE_JOINTS; j++) {
            struct quat q = pose.local[j];
            if (k && q.x * turns[j][k - 1].x + q.y * turns[j][k - 1].y + q.z * turns[j][k - 1].z +
                             q.w * turns[j][k - 1].w <
                         0.0)
                q = (struct quat){-q.x, -q.y, -q.z, -q.w}; // the shorter way
            turns[j][k] = q;
        }
    }
    int input = glb_doubles(p->g, times, (size_t)count, 1, true),
        still = glb_doubles(p->g, times, 1, 1, true);
    add_channel(p, animation, who->nodes[HIPS], "translation", input,
                glb_doubles(p->g, places[0], (size_t)count, 3, false));
    for (int j = 0; j < PEOPLE_JOINTS; j++) {
        bool same = constant(turns[j], count);
        if (same && fabs(turns[j][0].w) > 0.99999)
            continue; // as it rests
        add_channel(p, animation, who->nodes[j], "rotation", same ? still : input,
                    add_rotations(p->g, turns[j], same ? 1 : count));
    }
    return animation;
}

// ---- the row ----

static void add_lamp(struct glb *g, const char *name, struct vec3 at, double down, double left,
                     double radiance, double size)
{
    struct quat q =
        quat_multiply(quat_about(vec3_make(0, 1, 0), left), quat_about(vec3_make(1, 0, 0), -down));
    int node = glb_add_node(g, &(struct glb_node){.name = name,
                                                  .translation = {at.x, at.y, at.z},
                                                  .rotation = {q.x, q.y, q.z, q.w}});
    cJSON *light = glb_component(g, NG_GLTF_NODES, node, "light_rectangle");
    glb_set(g, light, "radiance", radiance);
    glb_set_list(g, light, "size", (const double[2]){size, 1.5}, 2);
}

ng_result people_build(struct bytes *out)
{
    static const struct {
        enum people_body body;
        double turn;
    } row[PEOPLE_CLIPS] = {
        [CLIP_SING] = {PEOPLE_LONG, 0.25},        [CLIP_GUITAR] = {PEOPLE_JACKET, 0.3},
        [CLIP_DRUMS] = {PEOPLE_BEARD, 0.35},      [CLIP_DANCE_STEP] = {PEOPLE_CURLS, 0.1},
        [CLIP_DANCE_BOUNCE] = {PEOPLE_TAIL, 0.1}, [CLIP_DANCE_SWAY] = {PEOPLE_BOB, -0.1},
        [CLIP_CLAP] = {PEOPLE_BUN, -0.2},         [CLIP_ARMS_UP] = {PEOPLE_TALL, -0.2},
        [CLIP_WALK] = {PEOPLE_CURLS, -0.7},       [CLIP_TALK] = {PEOPLE_LONG, -0.5},
    };
    const double quarter = 0.70710678118654752, apart = 0.92;
    struct glb g;
    struct people p;
    glb_init(&g);
    glb_add_node(&g, &(struct glb_node){.name = "camera",
                                        .translation = {0, 1.35, 8.6},
                                        .rotation = {-0.024, 0, 0, 0.99971},
                                        .camera = glb_add_camera(&g, 0.36, 0.05) + 1});
    int floor = stage_plane(&g, "floor", 14, 9, 1, stage_material(&g, "floor", 0.30, 0.28, 0.26, 0.55));
    int wall = stage_plane(&g, "wall", 14, 5, 1, stage_material(&g, "wall", 0.32, 0.36, 0.40, 0.9));
    int stool = stage_material(&g, "stool", 0.22, 0.13, 0.07, 0.5);
    glb_add_node(&g, &(struct glb_node){.name = "floor",
                                        .translation = {0, 0, 2},
                                        .rotation = {-quarter, 0, 0, quarter},
                                        .mesh = floor + 1});
    stage_place(&g, "wall", wall, 0, 2.5, -2.2);
    add_lamp(&g, "key", vec3_make(-2.6, 3.6, 3.4), 0.75, -0.35, 15.0, 4.0);
    add_lamp(&g, "fill", vec3_make(4.6, 2.2, 3.4), 0.20, 0.8, 4.0, 3.0);
    people_init(&p, &g);
    for (int i = 0; i < PEOPLE_CLIPS; i++) {
        struct person who;
        const struct clip *clip = &people_clips[i];
        double x = apart * (i - 0.5 * (PEOPLE_CLIPS - 1)), turn = row[i].turn;
        people_add(&p,
                   &(struct people_place){
                       .name = clip->name, .body = row[i].body, .at = vec3_make(x, 0, 0), .turn = turn},
                   &who);
        people_play(&p, &who, (enum people_clip)i, clip->name, 0.0);
        if (clip->seated) { // 0.2 m behind where the feet are
            double high =
                0.455 * p.skeletons[row[i].body].height * p.skeletons[row[i].body].rest[UPPER_LEG].y / 0.925;
            stage_place(&g, "stool", stage_box(&g, "stool", 0.34, high, 0.34, stool), x - 0.22 * sin(turn),
                        0.5 * high, -0.22 * cos(turn));
        }
    }
    return glb_finish(&g, out);
}
