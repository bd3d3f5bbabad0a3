// Lamps in one place, and lamps close to other surfaces: in the snapshot, the path tracer and the clues.
#include "picture.h"

#include "components/light_disk.h"
#include "components/light_mesh.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "components/light_spot.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>

enum { SIZE = 32, SPP = 256 };

enum lamp { RECTANGLE, DISK, SPHERE, MESH, LAMPS };

// `turn`: about the lamp's own axis, by which its surface does not change.
static void add_lamp(struct scene *s, enum lamp lamp, float radiance, const float at[3], bool turn)
{
    const struct ng_light_rectangle rectangle = {
        .on = true, .color = {1, 1, 1}, .radiance = radiance, .size = {1, 0.6f}};
    const struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = radiance, .radius = 0.4f};
    const struct ng_light_sphere sphere = {
        .on = true, .color = {1, 1, 1}, .radiance = radiance, .radius = 0.3f};
    // Down, and down after half a turn.
    const float half[4] = {0, 0.70710678f, 0.70710678f, 0}, *rotation = turn ? half : scene_down;
    const float glow[3] = {radiance, radiance, radiance};
    ng_entity e;
    switch (lamp) {
    case RECTANGLE:
        scene_light(s, NG_LIGHT_RECTANGLE, &rectangle, at, rotation);
        break;
    case DISK:
        scene_light(s, NG_LIGHT_DISK, &disk, at, rotation);
        break;
    case SPHERE:
        scene_light(s, NG_LIGHT_SPHERE, &sphere, at, rotation);
        break;
    default:
        e = scene_quad(s, (const float[3]){at[0] - 0.5f, at[1], at[2] - 0.3f}, (const float[3]){1, 0, 0},
                       (const float[3]){0, 0, 0.6f}, scene_glow(s, glow));
        OK(ng_world_add(s->world, e, NG_LIGHT_MESH,
                        &(struct ng_light_mesh){.on = true, .color = {1, 1, 1}, .scale = 1}));
    }
}

static void open_room(struct scene *s)
{
    scene_open(s, 2);
    ng_entity grey = scene_material(s, (const float[3]){0.6f, 0.6f, 0.6f}, 0, 0.3f);
    scene_quad(s, (const float[3]){-2, -1, 2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -4}, grey);
    scene_quad(s, (const float[3]){-2, -1, -2}, (const float[3]){4, 0, 0}, (const float[3]){0, 3, 0}, grey);
}

static void add_ceiling(struct scene *s, float height)
{
    scene_quad(s, (const float[3]){-2, height, -2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, 4},
               scene_material(s, (const float[3]){0.6f, 0.6f, 0.6f}, 0, 0.3f));
}

static double sum_of(const struct scene *s, const char *layer)
{
    float *pixels = scene_render_layer(
        s, &(struct lf_reference_params){.width = SIZE, .height = SIZE, .jobs = s->jobs}, SPP, layer);
    double sum = 0;
    for (int i = 0; i < 3 * SIZE * SIZE; i++)
        sum += (double)pixels[i];
    free(pixels);
    return sum;
}

static double shown_emission(const struct scene *s, uint32_t light)
{
    const struct ng_snapshot *n = s->snapshot;
    for (uint32_t i = 0; i < n->instance_count; i++)
        if (n->instances[i].light == light)
            return (double)n->materials[n->instances[i].material].emission[0];
    return 0;
}

struct measured {
    double direct, indirect, emission;
    double visible; // sum of the diffuse light that the clues say arrives
    float *visibility;
    uint32_t texels;
};

static struct measured measure(struct scene *s)
{
    struct picture p = {0};
    struct measured m;
    size_t size = (size_t)SIZE * SIZE * sizeof(float);
    scene_frame(s, 0);
    m.direct = sum_of(s, "direct");
    m.indirect = sum_of(s, "indirect");
    m.emission = sum_of(s, "emission");
    picture_encode(&p, s, SIZE, SIZE);
    m.visibility = malloc(size);
    assert_non_null(m.visibility);
    memcpy(m.visibility, picture_view(&p, p.lights - 1, LF_INPUT_VIEW_VISIBILITY_DIFFUSE, 0), size);
    m.visible = 0;
    for (int i = 0; i < SIZE * SIZE; i++)
        m.visible += (double)(m.visibility[i] * picture_view(&p, p.lights - 1, LF_INPUT_VIEW_DIFFUSE, 0)[i]);
    m.texels = lf_light_clues_texels(p.light[p.lights - 1]);
    picture_close(&p);
    return m;
}

#define CLOSE(a, b, part) assert_true(fabs((a) - (b)) <= (part)*fabs(b))

// However far apart: nothing up to a tenth of a millimetre.
static void lamps_in_one_place_are_one(void **state)
{
    static const float apart[] = {0, 1e-6f, -1e-5f, 1e-4f};
    NG_UNUSED(state);
    for (enum lamp lamp = 0; lamp < LAMPS; lamp++) {
        struct scene one;
        open_room(&one);
        add_lamp(&one, lamp, 8, (const float[3]){0, 0.9f, 0}, false);
        struct measured want = measure(&one);
        scene_close(&one);
        assert_true(want.direct > 0 && want.indirect > 0 && want.emission > 0);
        for (size_t k = 0; k < NG_COUNT(apart); k++) {
            struct scene two;
            open_room(&two);
            add_lamp(&two, lamp, 4, (const float[3]){0, 0.9f, 0}, false);
            add_lamp(&two, lamp, 4, (const float[3]){0, 0.9f + apart[k], 0}, lamp != MESH);
            struct measured got = measure(&two);
            print_message("lamp %d, %g m apart: direct %.4g %.4g, indirect %.4g %.4g, emission %.4g %.4g\n",
                          (int)lamp, (double)apart[k], got.direct, want.direct, got.indirect, want.indirect,
                          got.emission, want.emission);
            assert_int_equal(two.snapshot->lights[1].place, 0);
            assert_true(shown_emission(&two, 0) == 8 && shown_emission(&two, 1) == 8);
            CLOSE(got.direct, want.direct, 0.005);
            CLOSE(got.indirect, want.indirect, 0.03); // noise
            CLOSE(got.emission, want.emission, 0.01);
            assert_int_equal(got.texels, want.texels);
            for (int i = 0; i < SIZE * SIZE; i++)
                NEAR(got.visibility[i], want.visibility[i], 0.07); // one ray of a block may meet an edge
            free(got.visibility);
            scene_close(&two);
        }
        free(want.visibility);
    }
}

// Of other forms, turned or beside one another: light of both arrives, as far as they are not further apart.
static void lamps_that_overlap_hide_nothing_of_each_other(void **state)
{
    NG_UNUSED(state);
    static const struct {
        enum lamp lamp;
        float x, apart, angle; // angle: in its plane, half of it
    } others[] = {{RECTANGLE, 0, 5e-5f, 0.26f},
                  {RECTANGLE, 0.01f, -5e-5f, 0},
                  {DISK, 0.1f, 1e-4f, 0},
                  {MESH, 0, 1e-4f, 0}};
    const struct ng_light_rectangle panel = {
        .on = true, .color = {1, 1, 1}, .radiance = 4, .size = {1, 0.6f}};
    for (size_t k = 0; k < NG_COUNT(others); k++) {
        double direct[3], visible[3];
        for (int both = 0; both < 3; both++) { // the one, the other, both
            struct scene s;
            const float at[3] = {others[k].x, 0.9f + others[k].apart, 0}, c = cosf(others[k].angle),
                        t = sinf(others[k].angle), h = 0.70710678f;
            open_room(&s);
            if (both != 1)
                add_lamp(&s, RECTANGLE, 4, (const float[3]){0, 0.9f, 0}, false);
            if (both != 0 && others[k].lamp == RECTANGLE)
                scene_light(&s, NG_LIGHT_RECTANGLE, &panel, at,
                            (const float[4]){-h * c, h * t, h * t, h * c});
            else if (both != 0)
                add_lamp(&s, others[k].lamp, 4, at, false);
            struct measured got = measure(&s);
            direct[both] = got.direct;
            visible[both] = got.visible;
            free(got.visibility);
            scene_close(&s);
        }
        print_message("%zu: direct %.4g, %.4g and %.4g\n", k, direct[0], direct[1], direct[2]);
        CLOSE(direct[2], direct[0] + direct[1], 0.01);
        CLOSE(visible[2], visible[1], 0.01); // of the last light
    }
}

// A rectangle is two triangles: along their seam it is no brighter.
static void a_lamp_shows_its_radiance_everywhere(void **state)
{
    NG_UNUSED(state);
    for (enum lamp lamp = 0; lamp < LAMPS; lamp++) {
        struct scene s;
        open_room(&s);
        add_lamp(&s, lamp, 4, (const float[3]){0, 0.9f, 0}, false);
        // Seen from right below, so that the seam runs through the middles of pixels.
        struct ng_transform *camera = ng_world_edit(s.world, s.camera, NG_TRANSFORM);
        memcpy(camera->translation, (const float[3]){0, -0.5f, 0}, sizeof camera->translation);
        memcpy(camera->rotation, (const float[4]){0.70710678f, 0, 0, 0.70710678f}, sizeof camera->rotation);
        scene_frame(&s, 0);
        float *emission = scene_render_layer(
            &s, &(struct lf_reference_params){.width = SIZE, .height = SIZE, .jobs = s.jobs}, 1, "emission");
        int lit = 0;
        for (int i = 0; i < 3 * SIZE * SIZE; i++) {
            assert_true(emission[i] == 0 || emission[i] == 4);
            lit += emission[i] > 0;
        }
        assert_true(lit > 30);
        free(emission);
        scene_close(&s);
    }
}

static void other_lamps_have_places_of_their_own(void **state)
{
    NG_UNUSED(state);
    const struct ng_light_rectangle lamp = {.on = true, .color = {1, 1, 1}, .radiance = 1, .size = {1, 0.6f}};
    struct ng_light_rectangle smaller = lamp;
    smaller.size[1] = 0.599f;
    const float at[3] = {0.3f, 0.9f, -0.2f}, lower[3] = {0.3f, 0.8995f, -0.2f};
    struct scene s;
    open_room(&s);
    scene_light(&s, NG_LIGHT_RECTANGLE, &lamp, at, scene_down);
    scene_light(&s, NG_LIGHT_RECTANGLE, &lamp, lower, scene_down);
    scene_light(&s, NG_LIGHT_RECTANGLE, &smaller, at, scene_down);
    scene_light(&s, NG_LIGHT_RECTANGLE, &lamp, at, (const float[4]){0.70710678f, 0, 0, 0.70710678f}); // up
    ng_entity last = scene_light(&s, NG_LIGHT_RECTANGLE, &lamp, at, scene_down);
    scene_frame(&s, 0);
    for (uint32_t i = 0; i < 4; i++)
        assert_int_equal(s.snapshot->lights[i].place, i);
    assert_int_equal(s.snapshot->lights[4].place, 0);
    uint64_t version = s.snapshot->lights[0].version;
    scene_frame(&s, 1);
    assert_true(s.snapshot->lights[0].version == version);
    // What leaves changes the light that stays.
    struct ng_transform *moved = ng_world_edit(s.world, last, NG_TRANSFORM);
    assert_non_null(moved);
    moved->translation[1] = 0.5f;
    scene_frame(&s, 2);
    assert_int_equal(s.snapshot->lights[4].place, 4);
    assert_true(s.snapshot->lights[0].version != version);
    assert_true(shown_emission(&s, 0) == 1);
    scene_close(&s);
}

// A lamp flush with a ceiling shines; behind it, however closely, it does not.
static void what_hangs_closely_before_a_lamp_hides_it(void **state)
{
    static const float behind[] = {-1e-3f, 0, 1e-4f, 1e-3f, 0.01f};
    const float height = 1.1f;
    NG_UNUSED(state);
    for (int lamp = 0; lamp < LAMPS + 2; lamp++)
        for (size_t k = 0; k < NG_COUNT(behind); k++) {
            struct scene s;
            bool delta = lamp >= LAMPS, hidden = behind[k] > 0;
            if (behind[k] == 0 && (delta || lamp == SPHERE))
                continue; // half of it is, or rounding decides
            open_room(&s);
            add_ceiling(&s, height);
            const float at[3] = {0, height + behind[k], 0}, over[3] = {0, height + behind[k] + 0.3f, 0};
            if (lamp == LAMPS)
                scene_point(&s, 5, at);
            else if (lamp == LAMPS + 1)
                scene_light(&s, NG_LIGHT_SPOT,
                            &(struct ng_light_spot){
                                .on = true, .color = {1, 1, 1}, .intensity = 5, .outer_angle = 0.6f},
                            at, scene_down);
            else if (lamp == SPHERE && !hidden)
                add_lamp(&s, SPHERE, 8, (const float[3]){0, height - 0.301f, 0}, false);
            else
                add_lamp(&s, (enum lamp)lamp, 8, lamp == SPHERE ? over : at, false);
            struct measured got = measure(&s);
            print_message("lamp %d, %g m behind: direct %.4g, indirect %.4g, visible %.4g, texels %u\n", lamp,
                          (double)behind[k], got.direct, got.indirect, got.visible, got.texels);
            if (hidden)
                assert_true(got.direct == 0 && got.indirect < 0.01 && got.visible == 0);
            else
                assert_true(got.direct > 0 && got.indirect > 0 && got.visible > 0);
            free(got.visibility);
            scene_close(&s);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_in_one_place_are_one),
        cmocka_unit_test(lamps_that_overlap_hide_nothing_of_each_other),
        cmocka_unit_test(a_lamp_shows_its_radiance_everywhere),
        cmocka_unit_test(other_lamps_have_places_of_their_own),
        cmocka_unit_test(what_hangs_closely_before_a_lamp_hides_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
