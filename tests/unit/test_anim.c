// Sampling and blending of clips, and skinning, against closed forms and a naive double-precision reference.
#include "test.h"

#include "anim/sample.h"
#include "anim/skinning.h"
#include "base/jobs.h"
#include "base/rng.h"

#include <math.h>

#define NEAR(a, b, e) assert_true(fabs((double)(a) - (double)(b)) <= (e))

static void test_clip_time(void **state)
{
    (void)state;
    struct ng_animation a = {.speed = 2, .offset = 0.5f, .loop = true};
    NEAR(ng_clip_time(&a, 2, 1), 0.5, 1e-6); // 2.5 wraps to 0.5
    NEAR(ng_clip_time(&a, 2, -1), 0.5, 1e-6);
    assert_true(ng_clip_time(&a, 2, 0.75) == 0); // exactly the length is the start
    a.loop = false;
    NEAR(ng_clip_time(&a, 2, 10), 2, 0);
    NEAR(ng_clip_time(&a, 2, -10), 0, 0);
    assert_true(ng_clip_time(&a, 0, 5) == 0);
    a.loop = true;
    a.offset = -1e-9f;
    float t = ng_clip_time(&a, 2, 0);
    assert_true(t >= 0 && t < 2);
    assert_true(ng_clip_time(&a, 2, INFINITY) == 0);
}

static void test_step_and_linear(void **state)
{
    (void)state;
    float times[] = {1, 2, 4}, values[] = {10, 0, 20, 1, 40, 5}, out[4];
    struct ng_channel c = {.width = 2, .key_count = 3, .times = times, .values = values};
    const float at[] = {0, 1, 1.5f, 2, 3, 4, 9}, step[] = {10, 10, 10, 20, 20, 40, 40},
                linear[] = {10, 10, 15, 20, 30, 40, 40};
    for (size_t i = 0; i < NG_COUNT(at); i++) {
        c.interpolation = NG_INTERPOLATION_STEP;
        ng_channel_sample(&c, at[i], out);
        assert_true(out[0] == step[i]);
        c.interpolation = NG_INTERPOLATION_LINEAR;
        ng_channel_sample(&c, at[i], out);
        NEAR(out[0], linear[i], 1e-6);
    }
}

static void test_single_key_and_none(void **state)
{
    (void)state;
    float time = 3, values[] = {9, 7, 9}, out[4] = {5};
    struct ng_channel c = {.width = 1, .key_count = 1, .times = &time, .values = values};
    c.interpolation = NG_INTERPOLATION_CUBIC; // in-tangent, value, out-tangent
    for (float t = 0; t < 6; t += 1.5f) {
        ng_channel_sample(&c, t, out);
        assert_true(out[0] == 7);
    }
    c.key_count = 0;
    ng_channel_sample(&c, 1, out);
    assert_true(out[0] == 0);
}

static void about_y(float angle, float q[4])
{
    memcpy(q, (const float[4]){0, sinf(angle / 2), 0, cosf(angle / 2)}, 4 * sizeof(float));
}

static void test_slerp_goes_the_shortest_way_at_even_speed(void **state)
{
    (void)state;
    float times[] = {0, 1}, values[8], out[4], expected[4];
    struct ng_channel c = {.width = 4, .rotation = true, .key_count = 2, .times = times, .values = values};
    c.interpolation = NG_INTERPOLATION_LINEAR;
    for (int flip = 0; flip < 2; flip++)
        for (float angle = 0; angle < 3; angle += 0.37f) {
            about_y(0.2f, values);
            about_y(0.2f + angle, values + 4);
            for (int i = 4; flip && i < 8; i++)
                values[i] = -values[i];
            for (float t = 0; t < 1; t += 0.125f) { // a key itself is returned as it is, whatever its sign
                ng_channel_sample(&c, t, out);
                about_y(0.2f + angle * t, expected);
                for (int i = 0; i < 4; i++)
                    NEAR(out[i], expected[i], 2e-6);
            }
        }
}

// A cubic Hermite spline reproduces any cubic polynomial exactly.
static void test_cubic_spline_reproduces_a_cubic(void **state)
{
    (void)state;
    float times[] = {0.5f, 1.5f, 4}, values[3][3][1], out[4];
    for (int k = 0; k < 3; k++) {
        float x = times[k];
        values[k][1][0] = x * x * x - 2 * x * x + 3 * x - 1;
        values[k][0][0] = values[k][2][0] = 3 * x * x - 4 * x + 3;
    }
    struct ng_channel c = {.width = 1, .key_count = 3, .times = times, .values = &values[0][0][0]};
    c.interpolation = NG_INTERPOLATION_CUBIC;
    for (float x = 0.5f; x <= 4; x += 0.1f) {
        ng_channel_sample(&c, x, out);
        NEAR(out[0], x * x * x - 2 * x * x + 3 * x - 1, 1e-4);
    }
}

static void test_cubic_rotation_is_unit(void **state)
{
    (void)state;
    float times[] = {0, 1},
          values[2][3][4] = {{{0}, {0, 0, 0, 1}, {3, 1, 0, 0}}, {{0, 2, 0, 0}, {1, 0, 0, 0}, {0}}};
    struct ng_channel c = {.width = 4, .rotation = true, .key_count = 2, .times = times};
    c.values = &values[0][0][0];
    c.interpolation = NG_INTERPOLATION_CUBIC;
    for (float t = 0; t <= 1; t += 0.1f) {
        float q[4];
        ng_channel_sample(&c, t, q);
        NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-5);
    }
}

static void test_blending(void **state)
{
    (void)state;
    const float a[4] = {0.1f, 0.7f, 3, 0}, b[4] = {2, 1, -1, 0};
    float out[4];
    struct ng_blend blend = {0};
    assert_false(ng_blend_result(&blend, 3, false, out));
    ng_blend_add(&blend, b, 3, false, 0);
    ng_blend_add(&blend, b, 3, false, NAN);
    assert_false(ng_blend_result(&blend, 3, false, out));
    ng_blend_add(&blend, a, 3, false, 0.3f); // alone: unchanged to the bit
    assert_true(ng_blend_result(&blend, 3, false, out));
    assert_memory_equal(out, a, 3 * sizeof(float));
    ng_blend_add(&blend, b, 3, false, 0.9f); // weights are relative: 1/4, 3/4
    assert_true(ng_blend_result(&blend, 3, false, out));
    for (int i = 0; i < 3; i++)
        NEAR(out[i], 0.25f * a[i] + 0.75f * b[i], 1e-6);
    ng_blend_add(&blend, a, 3, false, 1.8f); // a thing blended in any parts of itself: here 2.1 a, 0.9 b
    assert_true(ng_blend_result(&blend, 3, false, out));
    NEAR(out[2], 0.7f * 3 - 0.3f, 1e-6);
}

static void test_blending_rotations(void **state)
{
    (void)state;
    float a[4], b[4], out[4], expected[4];
    about_y(0.4f, a);
    about_y(1.0f, b);
    about_y(0.7f, expected);
    for (int i = 0; i < 4; i++)
        b[i] = -b[i]; // the same rotation, written the other way
    struct ng_blend blend = {0};
    ng_blend_add(&blend, a, 4, true, 2);
    ng_blend_add(&blend, b, 4, true, 2);
    assert_true(ng_blend_result(&blend, 4, true, out));
    for (int i = 0; i < 4; i++)
        NEAR(out[i], expected[i], 1e-6);
}

// ---- skinning --------------------------------------------------------------------------------------------
enum { JOINTS = 7, MAX_VERTICES = 2051 };

struct character {
    float world[JOINTS][16], inverse_bind[JOINTS][16];
    struct ng_joint_matrix palette[JOINTS];
    uint16_t joints[MAX_VERTICES][4];
    float weights[MAX_VERTICES][4], positions[MAX_VERTICES][3], normals[MAX_VERTICES][3],
        tangents[MAX_VERTICES][4];
    float out_positions[MAX_VERTICES][3], out_normals[MAX_VERTICES][3], out_tangents[MAX_VERTICES][4];
};

static void random_matrix(struct ng_rng *rng, bool mirror, float m[16])
{
    for (int i = 0; i < 16; i++)
        m[i] = ng_rng_range(rng, -0.3f, 0.3f);
    m[3] = m[7] = m[11] = 0;
    m[15] = 1;
    m[0] += mirror ? -1.5f : 1.5f;
    m[5] += 1;
    m[10] += 0.7f;
}

static void make_character(struct character *c, bool mirror)
{
    struct ng_rng rng = ng_rng_make(11, mirror);
    for (int j = 0; j < JOINTS; j++) {
        random_matrix(&rng, mirror, c->world[j]);
        random_matrix(&rng, false, c->inverse_bind[j]);
    }
    for (int i = 0; i < MAX_VERTICES; i++) {
        float sum = 0, length = 0;
        for (int k = 0; k < 4; k++) {
            c->joints[i][k] = (uint16_t)ng_rng_below(&rng, JOINTS);
            sum += c->weights[i][k] = k < i % 4 ? ng_rng_range(&rng, 0.1f, 1) : k == 3 ? 1.0f : 0.0f;
        }
        for (int k = 0; k < 3; k++) {
            c->positions[i][k] = ng_rng_range(&rng, -1, 1);
            c->normals[i][k] = ng_rng_range(&rng, -1, 1);
            length += c->normals[i][k] * c->normals[i][k];
            c->tangents[i][k] = ng_rng_range(&rng, -1, 1);
        }
        c->tangents[i][3] = i % 2 ? 1 : -1;
        for (int k = 0; k < 3; k++)
            c->normals[i][k] /= sqrtf(length);
        for (int k = 0; k < 4; k++)
            c->weights[i][k] /= sum;
    }
    ng_skin_palette(JOINTS, c->world[0], c->inverse_bind[0], c->palette);
}

static struct ng_skin_params params_of(struct character *c, uint32_t count)
{
    return (struct ng_skin_params){
        .vertex_count = count,
        .joint_count = JOINTS,
        .palette = c->palette,
        .joints = c->joints[0],
        .weights = c->weights[0],
        .positions = c->positions[0],
        .normals = c->normals[0],
        .tangents = c->tangents[0],
        .out_positions = c->out_positions[0],
        .out_normals = c->out_normals[0],
        .out_tangents = c->out_tangents[0],
    };
}

// The blended matrix of a vertex, row by row, in double.
static void reference_matrix(const struct character *c, uint32_t vertex, double m[3][4])
{
    memset(m, 0, 12 * sizeof(double));
    for (int k = 0; k < 4; k++)
        for (int row = 0; row < 3; row++)
            for (int col = 0; col < 4; col++)
                for (int n = 0; n < 4; n++) {
                    uint16_t joint = c->joints[vertex][k];
                    m[row][col] += (double)c->weights[vertex][k] * (double)c->world[joint][n * 4 + row] *
                                   (double)c->inverse_bind[joint][col * 4 + n];
                }
}

// Unit inverse transpose times a vector: solves transpose(m) x = n by Cramer's rule.
static void reference_normal(double m[3][4], const float n[3], double out[3])
{
    double det = 0, length = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        det += m[0][i] * (m[1][j] * m[2][k] - m[1][k] * m[2][j]);
    }
    for (int r = 0; r < 3; r++) {
        out[r] = 0;
        for (int col = 0; col < 3; col++) {
            int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (col + 1) % 3, c2 = (col + 2) % 3;
            out[r] += (m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]) / det * (double)n[col];
        }
        length += out[r] * out[r];
    }
    for (int r = 0; r < 3; r++)
        out[r] /= sqrt(length);
}

// Four influences, two in each set, move as four in one.
static void test_two_sets_of_influences(void **state)
{
    (void)state;
    static struct character c;
    static uint16_t joints[2][MAX_VERTICES][4];
    static float weights[2][MAX_VERTICES][4], expected[MAX_VERTICES][3];
    make_character(&c, false);
    struct ng_skin_params p = params_of(&c, MAX_VERTICES);
    ng_skin_vertices(NULL, &p);
    memcpy(expected, c.out_positions, sizeof expected);
    for (int i = 0; i < MAX_VERTICES; i++)
        for (int k = 0; k < 4; k++) {
            joints[k / 2][i][k] = c.joints[i][k];
            weights[k / 2][i][k] = c.weights[i][k];
        }
    p.joints = joints[0][0];
    p.weights = weights[0][0];
    p.joints1 = joints[1][0];
    p.weights1 = weights[1][0];
    ng_skin_vertices(NULL, &p);
    for (int i = 0; i < MAX_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            NEAR(c.out_positions[i][k], expected[i][k], 1e-6);
}

static void test_skinning_equals_the_reference(void **state)
{
    (void)state;
    static struct character c;
    for (int mirror = 0; mirror < 2; mirror++) {
        make_character(&c, mirror);
        struct ng_skin_params p = params_of(&c, MAX_VERTICES);
        ng_skin_vertices(NULL, &p);
        for (uint32_t i = 0; i < MAX_VERTICES; i++) {
            double m[3][4], normal[3], tangent[3], length = 0;
            reference_matrix(&c, i, m);
            reference_normal(m, c.normals[i], normal);
            for (int r = 0; r < 3; r++) {
                double x = m[r][3];
                tangent[r] = 0;
                for (int k = 0; k < 3; k++) {
                    x += m[r][k] * (double)c.positions[i][k];
                    tangent[r] += m[r][k] * (double)c.tangents[i][k];
                }
                length += tangent[r] * tangent[r];
                NEAR(c.out_positions[i][r], x, 1e-5);
                NEAR(c.out_normals[i][r], normal[r], 1e-3);
            }
            for (int r = 0; r < 3; r++)
                NEAR(c.out_tangents[i][r], tangent[r] / sqrt(length), 1e-4);
            assert_true(c.out_tangents[i][3] == c.tangents[i][3] * (mirror ? -1.0f : 1.0f));
        }
    }
}

static void test_skinning_does_not_depend_on_threads_or_batches(void **state)
{
    (void)state;
    static struct character one, many;
    make_character(&one, false);
    make_character(&many, false);
    const uint32_t counts[] = {1, 3, 511, 513, MAX_VERTICES};
    for (uint32_t threads = 1; threads <= 4; threads++) {
        struct ng_jobs *jobs;
        assert_int_equal(ng_jobs_create(&(struct ng_jobs_params){.threads = threads}, &jobs), NG_OK);
        for (size_t i = 0; i < NG_COUNT(counts); i++) {
            memset(one.out_positions, 0, sizeof one.out_positions);
            memset(many.out_positions, 0, sizeof many.out_positions);
            struct ng_skin_params a = params_of(&one, counts[i]), b = params_of(&many, counts[i]);
            struct ng_skin_params batch[3] = {{.vertex_count = 0}, b, {.vertex_count = 0}};
            ng_skin_vertices(NULL, &a);
            ng_skin_batch(jobs, batch, 3);
            assert_memory_equal(&one, &many, sizeof one); // nothing past the count is touched either
        }
        ng_jobs_destroy(&jobs);
    }
}

static void test_skinning_positions_only(void **state)
{
    (void)state;
    static struct character c;
    make_character(&c, false);
    struct ng_skin_params p = params_of(&c, 5);
    p.normals = p.tangents = NULL;
    p.out_normals = p.out_tangents = NULL;
    ng_skin_vertices(NULL, &p);
    double m[3][4];
    reference_matrix(&c, 4, m);
    NEAR(c.out_positions[4][0],
         m[0][3] + m[0][0] * (double)c.positions[4][0] + m[0][1] * (double)c.positions[4][1] +
             m[0][2] * (double)c.positions[4][2],
         1e-5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_clip_time),
        cmocka_unit_test(test_step_and_linear),
        cmocka_unit_test(test_single_key_and_none),
        cmocka_unit_test(test_slerp_goes_the_shortest_way_at_even_speed),
        cmocka_unit_test(test_cubic_spline_reproduces_a_cubic),
        cmocka_unit_test(test_cubic_rotation_is_unit),
        cmocka_unit_test(test_blending),
        cmocka_unit_test(test_blending_rotations),
        cmocka_unit_test(test_skinning_equals_the_reference),
        cmocka_unit_test(test_two_sets_of_influences),
        cmocka_unit_test(test_skinning_does_not_depend_on_threads_or_batches),
        cmocka_unit_test(test_skinning_positions_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
