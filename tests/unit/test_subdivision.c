#include "test.h"

#include "asset/assets.h"
#include "asset/geometry.h"
#include "asset/refiner.h"
#include "base/jobs.h"
#include "components/subdivision.h"

#include <math.h>

static float cube_positions[] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                                 -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};
static uint32_t cube_sizes[] = {4, 4, 4, 4, 4, 4};
static uint32_t cube_indices[] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 2, 3, 7, 6, 1, 2, 6, 5, 0, 4, 7, 3};
static float cube_uvs[48]; // the unit square on each face
static uint32_t top_edges[] = {4, 5, 5, 6, 6, 7, 7, 4};
static float top_sharpness[] = {10, 10, 10, 10};

static struct ng_cage make_cube(void)
{
    for (int i = 0; i < 24; i++) {
        cube_uvs[i * 2] = i % 4 == 1 || i % 4 == 2;
        cube_uvs[i * 2 + 1] = i % 4 >= 2;
    }
    return (struct ng_cage){.vertex_count = 8,
                            .face_count = 6,
                            .index_count = 24,
                            .positions = cube_positions,
                            .face_sizes = cube_sizes,
                            .face_indices = cube_indices};
}

struct refined {
    struct ng_refiner *refiner;
    struct ng_refiner_mesh mesh;
    float *positions, *normals, *tangents;
};

static void apply(struct refined *r, struct ng_jobs *jobs, const float *cage)
{
    ng_refiner_apply(r->refiner, jobs,
                     &(struct ng_refiner_vertices){cage, r->positions, r->normals, r->tangents});
}

static struct refined refine(const struct ng_cage *cage, uint32_t level, uint32_t boundary)
{
    struct refined r;
    struct ng_refiner_params params = {.name = "test", .level = level, .boundary = boundary};
    char why[NG_REASON_SIZE];
    assert_int_equal(ng_refiner_create(cage, &params, why, &r.refiner), NG_OK);
    r.mesh = ng_refiner_get_mesh(r.refiner);
    r.positions = calloc(r.mesh.vertex_count, 12);
    r.normals = calloc(r.mesh.vertex_count, 12);
    r.tangents = calloc(r.mesh.vertex_count, 16);
    apply(&r, NULL, cage->positions);
    return r;
}

static void finish(struct refined *r)
{
    ng_refiner_destroy(&r->refiner);
    assert_null(r->refiner);
    free(r->positions);
    free(r->normals);
    free(r->tangents);
}

static float dot(const float *a, const float *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The limit of a cube's corner, by hand: (n*v*n + 4*sum of edge ends + sum of diagonals) / (n*(n+5)), n = 3:
// (9*(1,1,1) + 4*(1,1,1) + (-1,-1,-1)) / 24 = 0.5.
static void test_cube_limit(void **state)
{
    NG_UNUSED(state);
    struct ng_cage cube = make_cube();
    for (uint32_t level = 0; level <= 4; level++) {
        struct refined r = refine(&cube, level, NG_BOUNDARY_EDGE_AND_CORNER);
        assert_int_equal(r.mesh.index_count, 6 * 6 << (2 * level));
        assert_int_equal(r.mesh.vertex_count, (6 << (2 * level)) + 2);
        float largest = 0;
        for (uint32_t i = 0; i < r.mesh.vertex_count; i++) {
            const float *p = r.positions + i * 3, *n = r.normals + i * 3;
            if (fabsf(p[0]) == fabsf(p[1]) && fabsf(p[1]) == fabsf(p[2]))
                largest = fmaxf(largest, p[0]);
            assert_float_equal(dot(n, n), 1, 1e-5);
            assert_true(dot(n, p) > 0.9f * sqrtf(dot(p, p))); // outwards
            assert_float_equal(dot(r.tangents + i * 4, n), 0, 1e-5);
        }
        assert_float_equal(largest, 0.5, 1e-6);
        finish(&r);
    }
}

// Refining twice as far does not move the points that both have: they are on the limit surface.
static void test_levels_agree(void **state)
{
    NG_UNUSED(state);
    struct ng_cage cube = make_cube();
    struct refined coarse = refine(&cube, 1, NG_BOUNDARY_EDGE_AND_CORNER);
    struct refined fine = refine(&cube, 3, NG_BOUNDARY_EDGE_AND_CORNER);
    for (uint32_t i = 0; i < coarse.mesh.vertex_count; i++) {
        float nearest = 1, cosine = 0;
        for (uint32_t k = 0; k < fine.mesh.vertex_count; k++) {
            float d[3];
            for (int c = 0; c < 3; c++)
                d[c] = coarse.positions[i * 3 + (uint32_t)c] - fine.positions[k * 3 + (uint32_t)c];
            if (dot(d, d) < nearest) {
                nearest = dot(d, d);
                cosine = dot(coarse.normals + i * 3, fine.normals + k * 3);
            }
        }
        assert_true(nearest < 1e-11f);
        assert_true(cosine > 0.9999f);
    }
    finish(&coarse);
    finish(&fine);
}

// Facets must face outwards, so that culling and shading agree.
static void test_winding(void **state)
{
    NG_UNUSED(state);
    struct ng_cage cube = make_cube();
    struct refined r = refine(&cube, 2, NG_BOUNDARY_EDGE_AND_CORNER);
    for (uint32_t t = 0; t < r.mesh.index_count; t += 3) {
        const float *a = r.positions + r.mesh.indices[t] * 3, *b = r.positions + r.mesh.indices[t + 1] * 3;
        const float *c = r.positions + r.mesh.indices[t + 2] * 3;
        float u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        assert_true(dot(n, a) > 0);
    }
    finish(&r);
}

// A creased ring keeps its plane, and its two sides have normals of their own.
static void test_creases(void **state)
{
    NG_UNUSED(state);
    struct ng_cage cube = make_cube();
    cube.crease_edges = top_edges;
    cube.crease_sharpness = top_sharpness;
    cube.crease_count = 4;
    struct refined r = refine(&cube, 3, NG_BOUNDARY_EDGE_AND_CORNER);
    uint32_t on_ring = 0, up = 0;
    for (uint32_t i = 0; i < r.mesh.vertex_count; i++) {
        bool flat = fabsf(r.positions[i * 3 + 2] - 1) < 1e-5f;
        bool faces_up = r.normals[i * 3 + 2] > 0.999f;
        on_ring += flat && !faces_up;
        up += flat && faces_up;
    }
    assert_int_equal(on_ring, 4 * 8); // the side of the ring
    assert_int_equal(up, 9 * 9);      // the creased face stays flat, its rim included
    assert_int_equal(r.mesh.vertex_count, 6 * 64 + 2 + 32);
    finish(&r);
}

// One open quad: its corners are kept or rounded off.
static void test_boundary(void **state)
{
    NG_UNUSED(state);
    float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    uint32_t size = 4, indices[] = {0, 1, 2, 3};
    struct ng_cage quad = {.vertex_count = 4,
                           .face_count = 1,
                           .index_count = 4,
                           .positions = positions,
                           .face_sizes = &size,
                           .face_indices = indices};
    struct refined kept = refine(&quad, 3, NG_BOUNDARY_EDGE_AND_CORNER);
    struct refined round = refine(&quad, 3, NG_BOUNDARY_EDGE_ONLY);
    float nearest_kept = 9, nearest_round = 9;
    for (uint32_t i = 0; i < kept.mesh.vertex_count; i++) {
        nearest_kept = fminf(nearest_kept, dot(kept.positions + i * 3, kept.positions + i * 3));
        nearest_round = fminf(nearest_round, dot(round.positions + i * 3, round.positions + i * 3));
        assert_float_equal(kept.normals[i * 3 + 2], 1, 1e-5);
        assert_float_equal(round.normals[i * 3 + 2], 1, 1e-5);
    }
    assert_true(nearest_kept < 1e-10f);
    assert_true(nearest_round > 0.01f);
    finish(&kept);
    finish(&round);
}

// Where faces have UVs of their own a vertex is there once for each.
static void test_face_varying_uvs(void **state)
{
    NG_UNUSED(state);
    struct ng_cage cube = make_cube();
    cube.face_uvs = cube_uvs;
    cube.index_count = 24;
    struct refined r = refine(&cube, 2, NG_BOUNDARY_EDGE_AND_CORNER);
    assert_true(r.mesh.vertex_count > 6 * 16 + 2);
    for (uint32_t t = 0; t < r.mesh.index_count; t += 3) {
        const float *a = r.mesh.uvs + r.mesh.indices[t] * 2, *b = r.mesh.uvs + r.mesh.indices[t + 1] * 2;
        const float *c = r.mesh.uvs + r.mesh.indices[t + 2] * 2;
        float area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        assert_float_equal(area, 1.0 / 16, 5e-3); // of two triangles; none spans a seam
    }
    finish(&r);
}

static void test_moving_cage_and_threads(void **state)
{
    NG_UNUSED(state);
    struct ng_cage cube = make_cube();
    struct ng_jobs *jobs;
    assert_int_equal(ng_jobs_create(&(struct ng_jobs_params){.threads = 4}, &jobs), NG_OK);
    float moved[24];
    for (int i = 0; i < 24; i++)
        moved[i] = cube_positions[i] * 2 + 5;
    struct refined r = refine(&cube, 4, NG_BOUNDARY_EDGE_AND_CORNER);
    size_t size = (size_t)r.mesh.vertex_count * 12;
    float *still = malloc(size), *serial = malloc(size);
    memcpy(still, r.positions, size);
    apply(&r, NULL, moved);
    memcpy(serial, r.positions, size);
    apply(&r, jobs, moved);
    assert_memory_equal(serial, r.positions, size);
    for (size_t i = 0; i < size / 4; i++)
        assert_float_equal(serial[i], still[i] * 2 + 5, 1e-5);
    free(still);
    free(serial);
    finish(&r);
    ng_jobs_destroy(&jobs);
}

static void expect_refused(const struct ng_cage *cage, const char *message)
{
    struct ng_refiner *r;
    struct ng_cage_report report;
    struct ng_refiner_params params = {.level = 1};
    char why[NG_REASON_SIZE];
    assert_int_equal(ng_refiner_create(cage, &params, why, &r), NG_ERROR_FORMAT);
    assert_null(r);
    assert_int_equal(ng_cage_check(cage, &report), NG_ERROR_FORMAT);
    assert_string_equal(report.why, why);
    if (!strstr(why, message))
        fail_msg("\"%s\" is not in \"%s\"", message, why);
}

static void test_refused(void **state)
{
    NG_UNUSED(state);
    struct ng_cage cage = make_cube();
    uint32_t indices[24], sizes[6], edges[] = {0, 8};
    float sharpness = 1;
    cage.face_count = 0;
    expect_refused(&cage, "no faces");
    cage = make_cube();
    cage.face_indices = memcpy(indices, cube_indices, sizeof indices);
    indices[5] = 8;
    expect_refused(&cage, "out of range at face 1");
    indices[5] = 4;
    expect_refused(&cage, "twice in face 1");
    cage = make_cube();
    cage.face_sizes = memcpy(sizes, cube_sizes, sizeof sizes);
    sizes[2] = 2;
    expect_refused(&cage, "corners is not in 3 to 1,024 at face 2");
    sizes[2] = 3;
    expect_refused(&cage, "have 23 corners, but there are 24 indices");
    sizes[2] = UINT32_MAX;
    expect_refused(&cage, "corners is not in 3 to 1,024 at face 2");
    cage = make_cube();
    cage.crease_edges = edges;
    cage.crease_sharpness = &sharpness;
    cage.crease_count = 1;
    expect_refused(&cage, "out of range at crease 0");
    edges[1] = 1;
    sharpness = NAN;
    expect_refused(&cage, "sharpness is not in 0 to 10 at crease 0");
    cage = make_cube();
    cage.corners = edges;
    cage.corner_sharpness = &sharpness;
    cage.corner_count = 1;
    sharpness = 1e9f;
    expect_refused(&cage, "sharpness is not in 0 to 10 at corner 0");
    cage = make_cube();
    struct ng_refiner *r;
    struct ng_refiner_params tight = {.level = 6, .max_memory = 1 << 20};
    char why[NG_REASON_SIZE];
    assert_int_equal(ng_refiner_create(&cage, &tight, why, &r), NG_ERROR_UNSUPPORTED);
    assert_non_null(strstr(why, "use a lower one"));
}

// Many faces on one edge: a strip of two quads a face, so that the edge's line goes on through a vertex.
static void test_many_faces_on_an_edge(void **state)
{
    NG_UNUSED(state);
    enum { FACES = 40, VERTICES = 3 + 3 * FACES };
    float positions[VERTICES * 3];
    uint32_t sizes[2 * FACES], indices[8 * FACES];
    for (uint32_t i = 0; i < VERTICES; i++) {
        uint32_t ring = i / 3;
        float angle = (float)ring * 0.15f, radius = ring ? 1 : 0;
        positions[i * 3] = radius * cosf(angle);
        positions[i * 3 + 1] =
            (float)(i % 3) + (i % 3 == 1 ? 0.3f : 0); // not on a straight line with even steps
        positions[i * 3 + 2] = radius * sinf(angle);
    }
    for (uint32_t f = 0; f < 2 * FACES; f++) {
        uint32_t low = f % 2, out = 3 + f / 2 * 3 + low;
        sizes[f] = 4;
        memcpy(indices + f * 4, (uint32_t[]){low, low + 1, out + 1, out}, 16);
    }
    struct ng_cage fan = {.vertex_count = VERTICES,
                          .face_count = 2 * FACES,
                          .index_count = 8 * FACES,
                          .positions = positions,
                          .face_sizes = sizes,
                          .face_indices = indices};
    struct ng_cage_report report;
    assert_int_equal(ng_cage_check(&fan, &report), NG_OK);
    assert_int_equal(report.divided_edges, 2);
    struct refined r = refine(&fan, 2, NG_BOUNDARY_EDGE_AND_CORNER);
    assert_int_equal(r.mesh.index_count, 2 * FACES * 16 * 6);
    // All sheets keep the line, and its middle is the B-spline's limit: (0 + 4 * 1.3 + 2) / 6.
    uint32_t middle = 0;
    for (uint32_t i = 0; i < r.mesh.vertex_count; i++) {
        const float *p = r.positions + i * 3;
        assert_true(isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]));
        middle += fabsf(p[0]) + fabsf(p[2]) < 1e-6f && fabsf(p[1] - 1.2f) < 1e-5f;
    }
    assert_int_equal(middle, FACES);
    finish(&r);
}

// The same quad many times, and one that faces the other way: each keeps its corners.
static void test_repeated_faces(void **state)
{
    NG_UNUSED(state);
    enum { FACES = 64 };
    uint32_t sizes[FACES], indices[4 * FACES];
    for (uint32_t f = 0; f < FACES; f++) {
        sizes[f] = 4;
        memcpy(indices + f * 4, f == 5 ? (uint32_t[]){3, 2, 1, 0} : (uint32_t[]){0, 1, 2, 3}, 16);
    }
    struct ng_cage cage = make_cube();
    cage.face_count = FACES;
    cage.index_count = 4 * FACES;
    cage.face_sizes = sizes;
    cage.face_indices = indices;
    struct refined r = refine(&cage, 1, NG_BOUNDARY_EDGE_ONLY);
    assert_int_equal(r.mesh.vertex_count, FACES * 9);
    for (uint32_t i = 0; i < r.mesh.vertex_count; i++)
        assert_float_equal(r.positions[i * 3 + 2], -1, 1e-5); // of the cube's lower side
    finish(&r);
}

// Two cubes that touch in a vertex stay joined there, whichever is subdivided.
static void test_touching_surfaces(void **state)
{
    NG_UNUSED(state);
    float positions[48];
    uint32_t sizes[12], indices[48];
    for (uint32_t i = 0; i < 48; i++) {
        positions[i] = cube_positions[i % 24] + (i < 24 ? 0 : 2);
        indices[i] = cube_indices[i % 24] + (i < 24 ? 0 : 8);
        indices[i] = indices[i] == 8 ? 6 : indices[i]; // the second's lowest corner is the first's highest
        sizes[i % 12] = 4;
    }
    struct ng_cage cage = {.vertex_count = 16,
                           .face_count = 12,
                           .index_count = 48,
                           .positions = positions,
                           .face_sizes = sizes,
                           .face_indices = indices};
    struct ng_cage_report report;
    assert_int_equal(ng_cage_check(&cage, &report), NG_OK);
    assert_int_equal(report.divided_edges, 0);
    struct refined r = refine(&cage, 2, NG_BOUNDARY_EDGE_AND_CORNER);
    uint32_t at_corner = 0;
    for (uint32_t i = 0; i < r.mesh.vertex_count; i++) {
        const float *p = r.positions + i * 3;
        at_corner += fabsf(p[0] - 1) + fabsf(p[1] - 1) + fabsf(p[2] - 1) < 1e-5f;
    }
    assert_int_equal(at_corner, 2);
    finish(&r);
}

// The estimate that the limit is checked against is not below what is held.
static void test_estimate(void **state)
{
    NG_UNUSED(state);
    struct ng_cage cube = make_cube();
    struct refined r = refine(&cube, 5, NG_BOUNDARY_EDGE_AND_CORNER);
    size_t held = ng_refiner_memory(r.refiner);
    struct ng_refiner *other;
    struct ng_refiner_params params = {.level = 5, .max_memory = held / 2};
    char why[NG_REASON_SIZE];
    assert_int_equal(ng_refiner_create(&cube, &params, why, &other), NG_ERROR_UNSUPPORTED);
    finish(&r);
}

// A cube of triangles with split corners becomes a closed cage of 8 vertices.
static void test_cage_from_triangles(void **state)
{
    NG_UNUSED(state);
    struct ng_geometry g = {.vertex_count = 24, .index_count = 36};
    g.positions = malloc(24 * 12);
    g.indices = malloc(36 * 4);
    for (uint32_t i = 0; i < 24; i++)
        memcpy(g.positions + i * 3, cube_positions + cube_indices[i] * 3, 12);
    for (uint32_t f = 0; f < 6; f++)
        for (uint32_t k = 0; k < 6; k++)
            g.indices[f * 6 + k] = f * 4 + (const uint32_t[]){0, 1, 2, 0, 2, 3}[k];
    assert_int_equal(ng_geometry_complete(&g), NG_OK);
    struct ng_cage cage;
    assert_int_equal(ng_cage_from_geometry(&g, &cage), NG_OK);
    assert_int_equal(cage.vertex_count, 8);
    assert_int_equal(cage.face_count, 12);
    struct refined r = refine(&cage, 2, NG_BOUNDARY_EDGE_AND_CORNER);
    for (uint32_t i = 0; i < r.mesh.vertex_count; i++)
        assert_true(dot(r.normals + i * 3, r.positions + i * 3) > 0);
    finish(&r);
    ng_cage_finish(&cage);
    ng_geometry_finish(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cube_limit),
        cmocka_unit_test(test_levels_agree),
        cmocka_unit_test(test_winding),
        cmocka_unit_test(test_creases),
        cmocka_unit_test(test_boundary),
        cmocka_unit_test(test_face_varying_uvs),
        cmocka_unit_test(test_moving_cage_and_threads),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_many_faces_on_an_edge),
        cmocka_unit_test(test_repeated_faces),
        cmocka_unit_test(test_touching_surfaces),
        cmocka_unit_test(test_estimate),
        cmocka_unit_test(test_cage_from_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
