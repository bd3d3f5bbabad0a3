// content/: what is committed is what tools/content makes, and what it makes is sound.
#include "test.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/file.h"
#include "components/components.h"
#include "scene/world.h"
#include "tools/content/choreography.h"
#include "tools/content/content.h"
#include "tools/content/interior/palette.h"
#include "tools/content/pieces.h"
#include "tools/content/unseen.h"

#include <math.h>

#define SQUARE 0.06 // of the board, in metres

static void committed_files_are_what_the_tool_makes(void **state)
{
    NG_UNUSED(state);
    for (const struct content_file *f = content_files; f->path; f++) {
        char path[256];
        struct bytes made;
        void *found = NULL;
        size_t size = 0;
        snprintf(path, sizeof path, "content/%s", f->path);
        assert_int_equal(content_build(f, &made), NG_OK);
        assert_int_equal(ng_file_read(path, 0, &found, &size), NG_OK);
        if (size != made.count || memcmp(found, made.items, size) != 0)
            fail_msg("%s is not what tools/content makes: run ninja content and commit it", path);
        free(found);
        bytes_finish(&made);
    }
}

static void files_are_small(void **state)
{
    NG_UNUSED(state);
    size_t chess = 0, units = 0, interior = 0, people = 0;
    for (const struct content_file *f = content_files; f->path; f++) {
        struct bytes made;
        assert_int_equal(content_build(f, &made), NG_OK);
        bool of_interior = strncmp(f->path, "interior_design/", 16) == 0;
        size_t *sum = of_interior                           ? &interior
                      : strncmp(f->path, "people/", 7) == 0 ? &people
                      : strncmp(f->path, "unit/", 5) == 0   ? &units
                                                            : &chess;
        *sum += made.count;
        if (of_interior && !strstr(f->path, "/room.glb") && made.count > 300000)
            fail_msg("%s has %zu bytes: a piece may have 300000", f->path, made.count);
        bytes_finish(&made);
    }
    assert_in_range(chess, 1, 4u << 20);
    assert_in_range(units, 1, 2u << 20);
    assert_in_range(people, 1, 3000000);
    assert_in_range(interior, 1, 6u << 20);
}

// Of the file's scene what it says of itself; a warning fails the test.
static struct ng_gltf_scene load_quietly(const char *file)
{
    char path[256];
    snprintf(path, sizeof path, "content/%s", file);
    struct ng_world *world = NULL;
    struct ng_assets *assets = NULL;
    struct ng_gltf_scene scene;
    struct test_log log;
    assert_int_equal(ng_world_create(NULL, &world), NG_OK);
    assert_int_equal(ng_components_register(world), NG_OK);
    assert_int_equal(ng_assets_create(&assets), NG_OK);
    test_log_begin(&log);
    ng_result result = ng_gltf_load(path, world, assets, NULL, &scene);
    test_log_end(&log);
    if (result != NG_OK || log.warnings)
        fail_msg("%s: %s", path, log.text);
    ng_assets_destroy(&assets);
    ng_world_destroy(&world);
    return scene;
}

static void scenes_load_without_a_word(void **state)
{
    NG_UNUSED(state);
    for (const struct content_file *f = content_files; f->path; f++) {
        if (strcmp(ng_path_extension(f->path), "glb") != 0)
            continue;
        struct ng_gltf_scene scene = load_quietly(f->path);
        bool piece = strncmp(f->path, "interior_design/", 16) == 0 && !strstr(f->path, "/room.glb");
        assert_true(scene.camera_made == piece);
        assert_true(scene.primitive_count > 0 && (piece || scene.light_count > 0));
    }
}

// ---- furniture ----

// Every piece touches with its origin what holds it, and is as large as furniture.
static void furniture_stands_lies_or_hangs_at_its_origin(void **state)
{
    NG_UNUSED(state);
    for (int i = 0; i < PALETTE_COUNT; i++) {
        char file[64];
        snprintf(file, sizeof file, "interior_design/%s.glb", palette[i].name);
        struct ng_gltf_scene s = load_quietly(file);
        const float *low = s.bounds_min, *high = s.bounds_max;
        float touches = palette[i].where == PALETTE_CEILING ? high[1]
                        : palette[i].where == PALETTE_WALL  ? low[2]
                                                            : low[1];
        if (fabsf(touches) > 0.012f)
            fail_msg("%s is %g m off what holds it", file, (double)touches);
        float largest = fmaxf(high[0] - low[0], fmaxf(high[1] - low[1], high[2] - low[2]));
        if (largest < 0.15f || largest > 3.0f)
            fail_msg("%s is %g m large", file, (double)largest);
        if (palette[i].where != PALETTE_WALL && fabsf(high[0] + low[0]) > 0.35f)
            fail_msg("%s is %g m off its middle", file, (double)(0.5f * (high[0] + low[0])));
    }
}

static void every_lamp_shines_and_nothing_else(void **state)
{
    NG_UNUSED(state);
    int lamps = 0;
    for (int i = 0; i < PALETTE_COUNT; i++) {
        char file[64];
        snprintf(file, sizeof file, "interior_design/%s.glb", palette[i].name);
        bool light = strstr(palette[i].what, " light") != NULL;
        assert_true((load_quietly(file).light_count > 0) == light);
        lamps += light;
    }
    assert_in_range(lamps, 8, PALETTE_COUNT / 2);
}

// ---- cages ----

static uint32_t corner(const struct cage *c, size_t face, size_t k)
{
    return c->indices.items[face * 4 + k % 4];
}

static bool has_edge(const struct cage *c, uint32_t a, uint32_t b)
{
    int found = 0;
    for (size_t f = 0; f < c->sizes.count; f++)
        for (size_t k = 0; k < 4; k++)
            found += corner(c, f, k) == a && corner(c, f, k + 1) == b;
    assert_in_range(found, 0, 1); // no edge is used twice in one direction
    return found == 1;
}

// The lowest point that each point is joined to: one label a closed part.
static void label_parts(const struct cage *c, uint32_t *label)
{
    for (uint32_t i = 0; i < c->points.count; i++)
        label[i] = i;
    for (bool changed = true; changed;) {
        changed = false;
        for (size_t f = 0; f < c->sizes.count; f++)
            for (size_t k = 0; k < 4; k++) {
                uint32_t a = corner(c, f, k), b = corner(c, f, k + 1);
                if (label[b] != label[a]) {
                    label[a] = label[b] = label[a] < label[b] ? label[a] : label[b];
                    changed = true;
                }
            }
    }
}

static double part_volume(const struct cage *c, const uint32_t *label, uint32_t part)
{
    double volume = 0.0;
    const struct vec3 *p = c->points.items;
    for (size_t f = 0; f < c->sizes.count; f++)
        for (size_t k = 1; k < 3 && label[corner(c, f, 0)] == part; k++)
            volume +=
                vec3_dot(p[corner(c, f, 0)], vec3_cross(p[corner(c, f, k)], p[corner(c, f, k + 1)])) / 6.0;
    return volume;
}

// Every edge is used once in each direction, and every part holds a volume.
static void check_closed(const struct cage *c)
{
    assert_false(c->failed);
    for (size_t f = 0; f < c->sizes.count; f++) {
        assert_int_equal(c->sizes.items[f], 4);
        for (size_t k = 0; k < 4; k++) {
            assert_true(corner(c, f, k) < c->points.count);
            assert_true(has_edge(c, corner(c, f, k + 1), corner(c, f, k)));
        }
    }
    for (size_t i = 0; i < c->creases.count; i++)
        assert_true(has_edge(c, c->creases.items[i].a, c->creases.items[i].b));
    uint32_t *label = calloc(c->points.count, sizeof *label);
    assert_non_null(label);
    label_parts(c, label);
    for (uint32_t i = 0; i < c->points.count; i++)
        if (label[i] == i)
            assert_true(part_volume(c, label, i) > 0.0);
    free(label);
}

static void pieces_and_knots_are_closed_and_face_outwards(void **state)
{
    NG_UNUSED(state);
    void (*const builders[])(enum piece, struct cage *) = {piece_build, knot_build};
    for (size_t b = 0; b < NG_COUNT(builders); b++)
        for (int kind = 0; kind < PIECE_KINDS; kind++) {
            struct cage c = {0};
            builders[b]((enum piece)kind, &c);
            check_closed(&c);
            cage_finish(&c);
        }
}

// As high as the piece it stands for, and not beyond its square.
static void knots_fit_on_their_squares(void **state)
{
    NG_UNUSED(state);
    for (int kind = 0; kind < PIECE_KINDS; kind++) {
        struct cage c = {0};
        knot_build((enum piece)kind, &c);
        double top = 0.0, bottom = 1.0, aside = 0.0;
        for (size_t i = 0; i < c.points.count; i++) {
            top = fmax(top, c.points.items[i].y);
            bottom = fmin(bottom, c.points.items[i].y);
            aside = fmax(aside, fmax(fabs(c.points.items[i].x), fabs(c.points.items[i].z)));
        }
        assert_true(fabs(bottom) < 1e-9 && fabs(top - piece_height((enum piece)kind)) < 1e-9);
        assert_in_range(1e6 * aside, 1e4, 5e5 * SQUARE);
        cage_finish(&c);
    }
}

static void pieces_have_their_stated_size(void **state)
{
    NG_UNUSED(state);
    for (int kind = 0; kind < PIECE_KINDS; kind++) {
        struct cage c = {0};
        piece_build((enum piece)kind, &c);
        double top = 0.0, bottom = 1.0;
        for (size_t i = 0; i < c.points.count; i++) {
            top = fmax(top, c.points.items[i].y);
            bottom = fmin(bottom, c.points.items[i].y);
        }
        assert_true(bottom == 0.0);
        assert_true(fabs(top / piece_height((enum piece)kind) - 1.0) < 0.05);
        cage_finish(&c);
    }
}

static void chess_has_triangles_enough_to_measure(void **state)
{
    NG_UNUSED(state);
    uint64_t triangles = 0;
    for (int i = 0; i < DANCERS; i++) {
        struct dancer d = dance_get(i);
        struct cage c = {0};
        piece_build(d.kind, &c);
        triangles += cage_refined_triangles(&c, CHESS_PIECE_LEVEL);
        cage_finish(&c);
    }
    assert_true(triangles >= 200000);
}

// ---- the dance ----

enum { BANDS = 32 };
#define BAND 0.004 // metres of height

// A piece in a band of its height: within a circle whose centre may lie before the axis, as a knight's head
// does.
struct band {
    double low, high; // along the way it looks
    double radius;    // 0: nothing there
};

// Encloses the cage's faces, which enclose the surface.
static void measure(enum piece kind, struct band bands[BANDS])
{
    struct cage c = {0};
    piece_build(kind, &c);
    for (int pass = 0; pass < 2; pass++)
        for (size_t f = 0; f < c.sizes.count; f++) {
            struct vec3 p[4];
            for (size_t k = 0; k < 4; k++)
                p[k] = c.points.items[corner(&c, f, k)];
            double bottom = fmin(fmin(p[0].y, p[1].y), fmin(p[2].y, p[3].y));
            double top = fmax(fmax(p[0].y, p[1].y), fmax(p[2].y, p[3].y));
            for (int i = (int)(bottom / BAND); i <= (int)(top / BAND) && i < BANDS; i++)
                for (size_t k = 0; k < 4; k++) {
                    struct band *b = &bands[i];
                    if (pass)
                        b->radius = fmax(b->radius, hypot(p[k].x, p[k].z - 0.5 * (b->low + b->high)));
                    b->low = fmin(b->low, p[k].z);
                    b->high = fmax(b->high, p[k].z);
                }
        }
    cage_finish(&c);
}

// Where the circle's centre is along the ranks: light pieces look up the board, dark ones down.
static double center(const struct dancer *d, double rank, const struct band *b)
{
    return rank * SQUARE + (d->dark ? -0.5 : 0.5) * (b->low + b->high);
}

static bool touch(const struct dancer *d, const struct dancer *e, double time,
                  struct band bands[PIECE_KINDS][BANDS])
{
    struct vec3 p = dance_at(d, time), q = dance_at(e, time);
    int lift = (int)round((p.y - q.y) / BAND); // d's band i is at e's band i + lift
    for (int i = 0; i < BANDS; i++) {
        if (i + lift < 0 || i + lift >= BANDS)
            continue;
        const struct band *a = &bands[d->kind][i], *b = &bands[e->kind][i + lift];
        double apart = hypot(SQUARE * (p.x - q.x), center(d, p.z, a) - center(e, q.z, b));
        if (a->radius > 0.0 && b->radius > 0.0 && a->radius + b->radius > apart)
            return true;
    }
    return false;
}

static void dancers_never_touch(void **state)
{
    NG_UNUSED(state);
    struct band bands[PIECE_KINDS][BANDS] = {0};
    for (int kind = 0; kind < PIECE_KINDS; kind++)
        measure((enum piece)kind, bands[kind]);
    for (int frame = 0; frame <= 30 * (int)DANCE_SECONDS; frame++)
        for (int i = 0; i < DANCERS; i++)
            for (int k = 0; k < i; k++) {
                struct dancer a = dance_get(i), b = dance_get(k);
                if (touch(&a, &b, frame / 30.0, bands))
                    fail_msg("frame %d: the %s from %c%d touches the %s from %c%d", frame, piece_name(a.kind),
                             'a' + a.from[0], a.from[1] + 1, piece_name(b.kind), 'a' + b.from[0],
                             b.from[1] + 1);
            }
}

static void every_dancer_moves_and_returns(void **state)
{
    NG_UNUSED(state);
    for (int i = 0; i < DANCERS; i++) {
        struct dancer d = dance_get(i);
        struct vec3 first = dance_at(&d, 0.0), half = dance_at(&d, 0.5 * DANCE_SECONDS);
        struct vec3 last = dance_at(&d, DANCE_SECONDS);
        assert_true(vec3_length(vec3_sub(first, last)) == 0.0);
        assert_true(vec3_length(vec3_sub(first, half)) >= 1.0);
        assert_true(d.start > 0.0 && d.start + d.duration <= 0.5 * DANCE_SECONDS);
        assert_in_range(d.to[0], 0, 7);
        assert_in_range(d.to[1], 0, 7);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(committed_files_are_what_the_tool_makes),
        cmocka_unit_test(files_are_small),
        cmocka_unit_test(scenes_load_without_a_word),
        cmocka_unit_test(furniture_stands_lies_or_hangs_at_its_origin),
        cmocka_unit_test(every_lamp_shines_and_nothing_else),
        cmocka_unit_test(pieces_and_knots_are_closed_and_face_outwards),
        cmocka_unit_test(knots_fit_on_their_squares),
        cmocka_unit_test(pieces_have_their_stated_size),
        cmocka_unit_test(chess_has_triangles_enough_to_measure),
        cmocka_unit_test(dancers_never_touch),
        cmocka_unit_test(every_dancer_moves_and_returns),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
