// Random cages: soups of faces, fans, poles, grids that are cut up and glued wrongly. Each is refused with a
// reason, or refined to finite points whose weights add up to one.
#include "fuzz.h"

#include "asset/assets.h"
#include "asset/refiner.h"
#include "components/subdivision.h"

#include <math.h>

enum { MAX_FACES = 1300, MAX_CORNERS = 6000, MAX_MARKS = 32 };

struct made {
    struct ng_cage cage;
    float positions[MAX_CORNERS * 3], uvs[MAX_CORNERS * 2];
    uint32_t sizes[MAX_FACES], indices[MAX_CORNERS];
    uint32_t creases[MAX_MARKS * 2], corners[MAX_MARKS];
    float crease_sharpness[MAX_MARKS], corner_sharpness[MAX_MARKS];
};

static void add_face(struct made *m, uint32_t size, const uint32_t *vertices)
{
    struct ng_cage *c = &m->cage;
    if (c->face_count == MAX_FACES || c->index_count + size > MAX_CORNERS)
        return;
    m->sizes[c->face_count++] = size;
    memcpy(m->indices + c->index_count, vertices, size * sizeof *vertices);
    c->index_count += size;
    for (uint32_t i = 0; i < size; i++)
        c->vertex_count = vertices[i] >= c->vertex_count ? vertices[i] + 1 : c->vertex_count;
}

// ---- kinds of cages --------------------------------------------------------------------------------------

static void make_soup(struct made *m, struct ng_rng *r)
{
    uint32_t vertices = 3 + ng_rng_below(r, 20), faces = 1 + ng_rng_below(r, 40);
    for (uint32_t f = 0; f < faces; f++) {
        uint32_t size = 3 + ng_rng_below(r, vertices < 6 ? vertices - 2 : 4), face[8];
        for (uint32_t i = 0; i < size; i++) {
            face[i] = ng_rng_below(r, vertices);
            for (uint32_t k = 0; k < i;)
                if (face[k++] == face[i]) {
                    face[i] = (face[i] + 1) % vertices;
                    k = 0;
                }
        }
        add_face(m, size, face);
    }
}

// Faces around one edge, or one face many times.
static void make_fan(struct made *m, struct ng_rng *r)
{
    uint32_t faces = 1 + ng_rng_below(r, 60), kind = ng_rng_below(r, 3);
    for (uint32_t f = 0; f < faces; f++) {
        uint32_t out = kind ? 2 + f * 2 : 2;
        bool turned = fuzz_one_in(r, 4);
        add_face(m, kind == 2 ? 3 : 4, (uint32_t[]){turned, !turned, out, out + 1});
    }
}

// Triangles around a vertex, closed or open, or one face of many corners.
static void make_pole(struct made *m, struct ng_rng *r)
{
    uint32_t faces = 1 + ng_rng_below(r, fuzz_one_in(r, 8) ? MAX_FACES : 80), all[MAX_FACES];
    bool open = fuzz_one_in(r, 2);
    for (uint32_t f = 0; f < faces; f++) {
        all[f] = f + 1;
        add_face(m, 3, (uint32_t[]){0, f + 1, f + 1 == faces && !open ? 1 : f + 2});
    }
    if (fuzz_one_in(r, 2) && faces >= 3)
        add_face(m, faces, all);
}

static void make_grid(struct made *m, struct ng_rng *r)
{
    uint32_t across = 1 + ng_rng_below(r, 8), down = 1 + ng_rng_below(r, 8);
    bool around = fuzz_one_in(r, 2);
    for (uint32_t y = 0; y < down; y++)
        for (uint32_t x = 0; x < across; x++) {
            uint32_t width = across + 1, right = around ? (x + 1) % width : x + 1;
            add_face(
                m, 4,
                (uint32_t[]){y * width + x, y * width + right, (y + 1) * width + right, (y + 1) * width + x});
        }
}

// ---- what goes wrong with them ---------------------------------------------------------------------------

static void turn_face(struct made *m, struct ng_rng *r)
{
    uint32_t face = ng_rng_below(r, m->cage.face_count), first = 0;
    for (uint32_t f = 0; f < face; f++)
        first += m->sizes[f];
    for (uint32_t i = first, k = first + m->sizes[face] - 1; i < k; i++, k--) {
        uint32_t kept = m->indices[i];
        m->indices[i] = m->indices[k];
        m->indices[k] = kept;
    }
}

static void damage(struct made *m, struct ng_rng *r)
{
    struct ng_cage *c = &m->cage;
    uint32_t a = ng_rng_below(r, c->vertex_count), b = ng_rng_below(r, c->vertex_count);
    switch (ng_rng_below(r, 6)) {
    case 0:
        turn_face(m, r);
        break;
    case 1: // glues two vertices
        for (uint32_t i = 0; i < c->index_count; i++)
            m->indices[i] = m->indices[i] == a ? b : m->indices[i];
        break;
    case 2:
        m->indices[ng_rng_below(r, c->index_count)] = b;
        break;
    case 3: // repeats its first faces
        for (uint32_t n = ng_rng_below(r, 16), end = c->index_count, f = 0, at = 0;
             f < n && f < c->face_count && at + m->sizes[f] <= end; at += m->sizes[f++])
            add_face(m, m->sizes[f], m->indices + at);
        break;
    case 4: // vertices without faces
        c->vertex_count += ng_rng_below(r, 4);
        break;
    default:
        c->vertex_count -= fuzz_one_in(r, 20) ? 1 : 0;
        c->index_count -= fuzz_one_in(r, 20) ? 1 : 0;
        m->sizes[0] += fuzz_one_in(r, 20) ? 1 : 0;
    }
}

static float sharpness(struct ng_rng *r)
{
    static const float special[] = {0, 10, 1e-30f, 9.999999f, 11, -1, NAN, INFINITY};
    return fuzz_one_in(r, 3) ? special[ng_rng_below(r, fuzz_one_in(r, 8) ? NG_COUNT(special) : 4)]
                             : ng_rng_range(r, 0, 10);
}

// Along edges of faces, and between any vertices.
static void add_marks(struct made *m, struct ng_rng *r)
{
    struct ng_cage *c = &m->cage;
    c->crease_count = fuzz_one_in(r, 2) ? ng_rng_below(r, MAX_MARKS) : 0;
    for (uint32_t i = 0; i < c->crease_count; i++) {
        uint32_t at = ng_rng_below(r, c->index_count), next = (at + 1) % c->index_count;
        m->creases[i * 2] = m->indices[at];
        m->creases[i * 2 + 1] = fuzz_one_in(r, 8) ? ng_rng_below(r, c->vertex_count) : m->indices[next];
        m->crease_sharpness[i] = sharpness(r);
    }
    c->corner_count = fuzz_one_in(r, 2) ? ng_rng_below(r, MAX_MARKS) : 0;
    for (uint32_t i = 0; i < c->corner_count; i++) {
        m->corners[i] = ng_rng_below(r, c->vertex_count + (fuzz_one_in(r, 200) ? 1 : 0));
        m->corner_sharpness[i] = sharpness(r);
    }
}

static void add_uvs(struct made *m, struct ng_rng *r)
{
    uint32_t kind = ng_rng_below(r, 4);
    m->cage.face_uvs = kind ? m->uvs : NULL;
    for (uint32_t i = 0; i < m->cage.index_count * 2; i++)
        if (kind == 1)
            m->uvs[i] = ng_rng_float(r);
        else if (kind == 2)
            m->uvs[i] = (float)ng_rng_below(r, 3);
        else // as smooth as the surface, with a seam now and then
            m->uvs[i] = 0.1f * (float)m->indices[i >> 1] + (fuzz_one_in(r, 12) ? 1 : 0);
}

static void make_cage(struct made *m, struct ng_rng *r)
{
    static void (*const kinds[])(struct made *, struct ng_rng *) = {make_soup, make_fan, make_pole,
                                                                    make_grid};
    m->cage = (struct ng_cage){.positions = m->positions,
                               .face_sizes = m->sizes,
                               .face_indices = m->indices,
                               .crease_edges = m->creases,
                               .crease_sharpness = m->crease_sharpness,
                               .corners = m->corners,
                               .corner_sharpness = m->corner_sharpness};
    kinds[ng_rng_below(r, NG_COUNT(kinds))](m, r);
    for (uint32_t n = ng_rng_below(r, 5); n > 0; n--)
        damage(m, r);
    add_marks(m, r);
    add_uvs(m, r);
    for (uint32_t i = 0; i < m->cage.vertex_count * 3; i++)
        m->positions[i] = ng_rng_range(r, -1, 1);
}

// ---- refining --------------------------------------------------------------------------------------------

static float *refine(const struct ng_refiner *refiner, const float *cage)
{
    size_t n = ng_refiner_get_mesh(refiner).vertex_count;
    float *out = malloc(n * 40 + 1);
    ng_refiner_apply(refiner, NULL, &(struct ng_refiner_vertices){cage, out, out + n * 3, out + n * 6});
    for (size_t i = 0; i < n * 10; i++)
        assert_true(isfinite(out[i]));
    return out;
}

static void check_refined(struct made *m, const struct ng_refiner *refiner)
{
    struct ng_refiner_mesh mesh = ng_refiner_get_mesh(refiner);
    for (uint32_t i = 0; i < mesh.index_count; i++)
        assert_true(mesh.indices[i] < mesh.vertex_count);
    for (uint32_t i = 0; i < mesh.vertex_count * 2; i++)
        assert_true(isfinite(mesh.uvs[i]));
    free(refine(refiner, m->positions));
    for (uint32_t i = 0; i < m->cage.vertex_count * 3; i++)
        m->positions[i] = 1;
    float *ones = refine(refiner, m->positions);
    for (uint32_t i = 0; i < mesh.vertex_count * 3; i++)
        assert_float_equal(ones[i], 1, 1e-3);
    free(ones);
}

static void test_cages(void **state)
{
    NG_UNUSED(state);
    struct made *m = malloc(sizeof *m);
    uint32_t refined = 0;
    assert_non_null(m);
    for (uint32_t round = 0; round < fuzz.rounds; round++) {
        struct ng_rng r = fuzz_round(fuzz.first + round);
        make_cage(m, &r);
        struct ng_refiner_params params = {.level = ng_rng_below(&r, m->cage.index_count > 500 ? 2 : 4),
                                           .boundary = ng_rng_below(&r, NG_BOUNDARY_EDGE_AND_CORNER + 1)};
        struct ng_refiner *refiner;
        char why[NG_REASON_SIZE] = "";
        ng_result result = ng_refiner_create(&m->cage, &params, why, &refiner);
        if (result == NG_OK)
            check_refined(m, refiner);
        else
            assert_true(result == NG_ERROR_FORMAT && why[0]);
        refined += result == NG_OK;
        ng_refiner_destroy(&refiner);
    }
    assert_true(refined > fuzz.rounds / 2); // most are not refused
    free(m);
}

int main(int argc, char **argv)
{
    fuzz_arguments(argc, argv);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cages)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
