// Assets have history: edits, replacements, what comes and goes, and the way back, also where memory ends.
#include "test.h"

#include "asset/assets.h"
#include "asset/geometry.h"
#include "base/hash.h"
#include "scene/history.h"

#include <math.h>

#define OK(call) assert_int_equal((call), NG_OK)

// ---- Memory that ends ------------------------------------------------------------------------------------
static int64_t allocations = INT64_MAX; // left

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);

void *__wrap_malloc(size_t size)
{
    return allocations-- > 0 ? __real_malloc(size) : NULL;
}

void *__wrap_calloc(size_t count, size_t size)
{
    return allocations-- > 0 ? __real_calloc(count, size) : NULL;
}

void *__wrap_realloc(void *old, size_t size)
{
    return allocations-- > 0 ? __real_realloc(old, size) : NULL;
}

// ---- Assets of all kinds ---------------------------------------------------------------------------------
struct fixture {
    struct ng_world *world;
    struct ng_assets *assets;
    ng_asset geometry, cage, image, clip, skeleton;
};

static void *copy_of(const void *data, size_t size)
{
    void *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, data, size);
    return copy;
}

static const uint32_t quad_indices[6] = {0, 1, 2, 0, 2, 3};

static struct ng_geometry make_quad(float size)
{
    const float positions[12] = {0, 0, 0, size, 0, 0, size, size, 0, 0, size, 0};
    const float normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, uvs[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    struct ng_geometry g = {.vertex_count = 4,
                            .index_count = 6,
                            .positions = copy_of(positions, sizeof positions),
                            .normals = copy_of(normals, sizeof normals),
                            .uvs = copy_of(uvs, sizeof uvs),
                            .indices = copy_of(quad_indices, sizeof quad_indices)};
    OK(ng_geometry_complete(&g));
    return g;
}

static struct ng_cage make_cage(void)
{
    const float positions[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    const uint32_t four = 4, indices[4] = {0, 1, 2, 3};
    return (struct ng_cage){.vertex_count = 4,
                            .face_count = 1,
                            .index_count = 4,
                            .positions = copy_of(positions, sizeof positions),
                            .face_sizes = copy_of(&four, sizeof four),
                            .face_indices = copy_of(indices, sizeof indices)};
}

// Two levels: 2 x 2 texels of one value each, and their mean.
static struct ng_image make_image(unsigned char value)
{
    struct ng_image image = {.width = 2, .height = 2, .levels = 2, .size = 20, .pixels = malloc(20)};
    assert_non_null(image.pixels);
    memset(image.pixels, value, 20);
    return image;
}

static struct ng_clip make_clip(float end)
{
    const float times[2] = {0, end}, values[2] = {1, 2};
    struct ng_channel channel = {.width = 1,
                                 .key_count = 2,
                                 .times = copy_of(times, sizeof times),
                                 .values = copy_of(values, sizeof values)};
    return (struct ng_clip){
        .channel_count = 1, .channels = copy_of(&channel, sizeof channel), .duration = end};
}

static void begin(struct fixture *f)
{
    *f = (struct fixture){0};
    OK(ng_world_create(NULL, &f->world));
    OK(ng_assets_create(&f->assets));
    ng_assets_set_history(f->assets, f->world);
    struct ng_geometry g = make_quad(1);
    struct ng_cage cage = make_cage();
    struct ng_image image = make_image(7);
    struct ng_clip clip = make_clip(1);
    struct ng_skeleton skeleton = {0};
    OK(ng_assets_take_geometry(f->assets, "quad", &g, &f->geometry));
    OK(ng_assets_take_cage(f->assets, "cage", &cage, &f->cage));
    OK(ng_assets_take_image(f->assets, "image", &image, &f->image));
    OK(ng_assets_take_clip(f->assets, "clip", &clip, &f->clip));
    OK(ng_assets_take_skeleton(f->assets, "skeleton", &skeleton, &f->skeleton));
}

static void end(struct fixture *f)
{
    ng_world_destroy(&f->world);
    ng_assets_destroy(&f->assets);
}

// Of everything that the assets are: contents, order, revisions, memory.
static uint64_t hash_of(const struct fixture *f)
{
    const struct ng_geometry *g = ng_assets_geometry(f->assets, f->geometry);
    const struct ng_cage *cage = ng_assets_cage(f->assets, f->cage);
    const struct ng_image *image = ng_assets_image(f->assets, f->image);
    const struct ng_clip *clip = ng_assets_clip(f->assets, f->clip);
    const ng_asset ids[] = {f->geometry, f->cage, f->image, f->clip, f->skeleton};
    uint64_t hash = ng_hash_combine(0, ng_assets_memory(f->assets));
    for (size_t i = 0; i < NG_COUNT(ids); i++) {
        struct ng_asset_revision revision = ng_assets_revision(f->assets, ids[i]);
        hash = ng_hash_bytes(hash, &revision, sizeof revision);
        hash =
            ng_hash_combine(hash, ng_assets_next(f->assets, (enum ng_asset_kind)(i + 1), (ng_asset){0}).id);
    }
    if (g) {
        hash = ng_hash_bytes(hash, g->positions, g->vertex_count * 12);
        hash = ng_hash_bytes(hash, g->normals, g->vertex_count * 12);
        hash = ng_hash_bytes(hash, g->tangents, g->vertex_count * 16);
        hash = ng_hash_bytes(hash, g->indices, g->index_count * 4);
        hash = ng_hash_bytes(hash, g->bounds_max, sizeof g->bounds_max);
        hash = ng_hash_combine(hash, g->rest_positions != NULL);
    }
    if (cage) {
        hash = ng_hash_bytes(hash, cage->positions, cage->vertex_count * 12);
        hash = ng_hash_combine(hash, cage->rest_positions != NULL);
    }
    hash = image ? ng_hash_bytes(hash, image->pixels, image->size) : hash;
    for (uint32_t i = 0; clip && i < clip->channel_count; i++)
        hash = ng_hash_bytes(hash, clip->channels[i].values, clip->channels[i].key_count * 4);
    return clip ? ng_hash_bytes(hash, &clip->duration, sizeof clip->duration) : hash;
}

// ---- What can be done to them ----------------------------------------------------------------------------
static ng_result move_point(struct fixture *f, ng_asset id, float to)
{
    float *points = ng_assets_edit_points(f->assets, id);
    if (!points)
        return NG_ERROR_MEMORY;
    points[2] = to;
    return ng_assets_changed(f->assets, id);
}

static ng_result move_geometry(struct fixture *f)
{
    return move_point(f, f->geometry, 0.5f);
}

static ng_result move_cage(struct fixture *f)
{
    return move_point(f, f->cage, 0.5f);
}

static ng_result replace_geometry(struct fixture *f)
{
    struct ng_geometry g = make_quad(3);
    return ng_assets_replace_geometry(f->assets, f->geometry, &g);
}

static ng_result replace_cage(struct fixture *f)
{
    struct ng_cage cage = make_cage();
    cage.positions[0] = -1;
    return ng_assets_replace_cage(f->assets, f->cage, &cage);
}

static ng_result paint(struct fixture *f)
{
    unsigned char *texels = ng_assets_edit_texels(f->assets, f->image);
    if (!texels)
        return NG_ERROR_MEMORY;
    const struct ng_image *image = ng_assets_image(f->assets, f->image);
    memset(texels, 99, (size_t)image->width * image->height * 4);
    return ng_assets_changed(f->assets, f->image);
}

static ng_result replace_image(struct fixture *f)
{
    struct ng_image image = {.width = 1, .height = 1, .levels = 1, .size = 4, .pixels = calloc(1, 4)};
    return ng_assets_replace_image(f->assets, f->image, &image);
}

static ng_result edit_clip(struct fixture *f)
{
    struct ng_clip *clip = ng_assets_edit_clip(f->assets, f->clip);
    if (!clip)
        return NG_ERROR_MEMORY;
    clip->channels[0].values[1] = 5;
    clip->channels[0].times[1] = 4;
    return ng_assets_changed(f->assets, f->clip);
}

static ng_result replace_clip(struct fixture *f)
{
    struct ng_clip clip = make_clip(9);
    return ng_assets_replace_clip(f->assets, f->clip, &clip);
}

static ng_result take_one(struct fixture *f)
{
    struct ng_image image = make_image(1);
    ng_asset id;
    return ng_assets_take_image(f->assets, "another", &image, &id);
}

static ng_result remove_geometry(struct fixture *f)
{
    return ng_assets_remove(f->assets, f->geometry) ? NG_OK : NG_ERROR_MEMORY;
}

static ng_result remove_image(struct fixture *f)
{
    return ng_assets_remove(f->assets, f->image) ? NG_OK : NG_ERROR_MEMORY;
}

static ng_result remove_skeleton(struct fixture *f)
{
    return ng_assets_remove(f->assets, f->skeleton) ? NG_OK : NG_ERROR_MEMORY;
}

static ng_result (*const acts[])(struct fixture *f) = {
    move_geometry, move_cage,    replace_geometry, replace_cage,    paint,        replace_image,
    edit_clip,     replace_clip, take_one,         remove_geometry, remove_image, remove_skeleton};

// ---- The way back ----------------------------------------------------------------------------------------
// Each alone, and each pair in one transaction, but for what is done to assets that are no more.
static void every_act_is_taken_back_and_done_again(void **state)
{
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(acts); i++)
        for (size_t k = 0; k <= NG_COUNT(acts); k++) {
            struct fixture f;
            begin(&f);
            if (k < NG_COUNT(acts) &&
                (acts[i] == remove_geometry || acts[i] == remove_image || acts[i] == remove_skeleton)) {
                end(&f);
                continue;
            }
            uint64_t before = hash_of(&f);
            OK(ng_world_begin(f.world, "act"));
            OK(acts[i](&f));
            if (k < NG_COUNT(acts))
                OK(acts[k](&f));
            OK(ng_world_commit(f.world));
            uint64_t after = hash_of(&f);
            assert_true(after != before);
            for (int n = 0; n < 2; n++) {
                uint64_t latest = ng_assets_latest(f.assets).content;
                OK(ng_world_undo(f.world));
                assert_true(ng_assets_latest(f.assets).content > latest);
                assert_true(hash_of(&f) == before);
                OK(ng_world_redo(f.world));
                assert_true(hash_of(&f) == after);
            }
            OK(ng_world_begin(f.world, "never mind"));
            if (acts[i] != remove_geometry && acts[i] != remove_image && acts[i] != remove_skeleton &&
                (k == NG_COUNT(acts) ||
                 (acts[k] != remove_geometry && acts[k] != remove_image && acts[k] != remove_skeleton)))
                OK(acts[i](&f));
            OK(ng_world_cancel(f.world));
            assert_true(hash_of(&f) == after);
            end(&f);
        }
}

static void a_drag_is_one_entry_and_one_copy(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    begin(&f);
    uint64_t before = hash_of(&f);
    OK(ng_world_begin(f.world, "drag"));
    for (int i = 1; i <= 100; i++) {
        uint64_t revision = ng_assets_revision(f.assets, f.cage).content;
        uint64_t topology = ng_assets_revision(f.assets, f.cage).topology;
        allocations = i > 1 ? 0 : INT64_MAX; // later edits allocate nothing
        OK(move_point(&f, f.cage, (float)i));
        allocations = INT64_MAX;
        assert_true(ng_assets_revision(f.assets, f.cage).content > revision);
        assert_true(ng_assets_revision(f.assets, f.cage).topology == topology);
    }
    OK(ng_world_commit(f.world));
    assert_true(ng_world_history_bytes(f.world) < 4096); // not a hundred copies
    assert_true(ng_assets_cage(f.assets, f.cage)->rest_positions[2] == 0);
    OK(ng_world_undo(f.world));
    assert_null(ng_world_undo_label(f.world));
    assert_true(hash_of(&f) == before);
    assert_null(ng_assets_cage(f.assets, f.cage)->rest_positions);
    OK(ng_world_redo(f.world));
    assert_true(ng_assets_cage(f.assets, f.cage)->positions[2] == 100);
    end(&f);
}

static void a_removed_asset_comes_back_under_its_id(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    begin(&f);
    const struct ng_image *was = ng_assets_image(f.assets, f.image);
    OK(ng_world_begin(f.world, "remove"));
    assert_true(ng_assets_remove(f.assets, f.image));
    assert_false(ng_assets_remove(f.assets, f.image));
    OK(ng_world_commit(f.world));
    assert_null(ng_assets_image(f.assets, f.image));
    assert_null(ng_assets_edit_texels(f.assets, f.image));
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(replace_image(&f), NG_ERROR_NOT_FOUND);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    struct ng_image other = make_image(3);
    ng_asset id;
    OK(ng_assets_take_image(f.assets, "other", &other, &id)); // must not take the id
    assert_true(id.id != f.image.id);
    OK(ng_world_undo(f.world));
    assert_ptr_equal(ng_assets_image(f.assets, f.image), was);
    assert_string_equal(ng_assets_name(f.assets, f.image), "image");
    OK(ng_world_redo(f.world));
    ng_world_clear_history(f.world); // for good: its slot is free
    OK(ng_assets_take_image(f.assets, "third", &(struct ng_image){0}, &id));
    assert_true(id.id != f.image.id);
    assert_null(ng_assets_image(f.assets, f.image));
    end(&f);
}

// Either of world and store may go first, with old content in the history.
static void the_store_may_go_before_its_world(void **state)
{
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(acts); i++) {
        struct fixture f;
        begin(&f);
        OK(ng_world_begin(f.world, "act"));
        OK(acts[i](&f));
        OK(ng_world_commit(f.world));
        ng_assets_destroy(&f.assets);
        OK(ng_world_undo(f.world));
        OK(ng_world_redo(f.world));
        ng_world_destroy(&f.world);
    }
}

static struct ng_geometry make_triangle(void)
{
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t indices[3] = {0, 1, 2};
    struct ng_geometry g = {.vertex_count = 3,
                            .index_count = 3,
                            .positions = copy_of(positions, sizeof positions),
                            .indices = copy_of(indices, sizeof indices)};
    OK(ng_geometry_complete(&g));
    return g;
}

// Another number of vertices, or as many.
static void unrecorded_changes_are_passed_over(void **state)
{
    NG_UNUSED(state);
    for (int alike = 0; alike < 2; alike++) {
        struct fixture f;
        begin(&f);
        OK(ng_world_begin(f.world, "move"));
        OK(move_geometry(&f));
        OK(ng_world_commit(f.world));
        struct ng_geometry other = alike ? make_quad(3) : make_triangle();
        OK(ng_assets_replace_geometry(f.assets, f.geometry, &other));
        uint64_t now = hash_of(&f);
        OK(ng_world_undo(f.world));
        assert_true(hash_of(&f) == now);
        assert_true(ng_assets_remove(f.assets, f.geometry));
        OK(ng_world_redo(f.world));
        assert_null(ng_assets_geometry(f.assets, f.geometry));
        end(&f);
    }
}

// ---- Points ----------------------------------------------------------------------------------------------
static void what_follows_from_points_does_not_depend_on_the_way(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    begin(&f);
    const struct ng_geometry *g = ng_assets_geometry(f.assets, f.geometry);
    for (int i = 0; i < 9; i++)
        OK(move_point(&f, f.geometry, sinf((float)i)));
    OK(move_point(&f, f.geometry, 1));
    struct ng_geometry way = make_quad(1);
    ng_asset direct;
    OK(ng_assets_take_geometry(f.assets, "direct", &way, &direct));
    OK(move_point(&f, direct, 1));
    const struct ng_geometry *h = ng_assets_geometry(f.assets, direct);
    assert_memory_equal(g->normals, h->normals, 48);
    assert_memory_equal(g->tangents, h->tangents, 64);
    // Vertex 0 is of both triangles, which now lean away from it.
    float down[2] = {g->normals[0], g->normals[1]};
    assert_true(down[0] > 0.3f && down[1] > 0.3f && g->normals[2] > 0.3f);
    assert_float_equal(down[0] * down[0] + down[1] * down[1] + g->normals[2] * g->normals[2], 1, 1e-5);
    assert_float_equal(g->bounds_max[2], 1, 0);
    // Back where it was: what the file had.
    OK(move_point(&f, f.geometry, 0));
    const float flat[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    assert_memory_equal(g->normals, flat, sizeof flat);
    assert_memory_equal(g->tangents, g->rest_tangents, 64);
    end(&f);
}

// A corner of three faces, split by their normals; and a smooth edge, split by its UVs alone.
static void smooth_points_stay_smooth_and_hard_edges_hard(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    begin(&f);
    // Two triangles over an edge from (0, 0, 0) to (0, 1, 0); each has vertices of its own.
    for (int hard = 0; hard < 2; hard++) {
        const float positions[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, -1, 0, 0};
        const uint32_t indices[6] = {0, 1, 2, 3, 4, 5};
        float normals[18] = {0};
        for (int i = 0; i < 6; i++)
            normals[i * 3 + 2] = 1;
        for (int i = 3; i < 6 && hard; i++)
            normals[i * 3] = -0.6f, normals[i * 3 + 2] = 0.8f;
        struct ng_geometry g = {.vertex_count = 6,
                                .index_count = 6,
                                .positions = copy_of(positions, sizeof positions),
                                .normals = copy_of(normals, sizeof normals),
                                .indices = copy_of(indices, sizeof indices)};
        ng_asset id;
        OK(ng_geometry_complete(&g));
        OK(ng_assets_take_geometry(f.assets, "edge", &g, &id));
        float *points = ng_assets_edit_points(f.assets, id);
        points[5] = 0.7f; // vertex 1, of the first triangle
        OK(ng_assets_changed(f.assets, id));
        const struct ng_geometry *now = ng_assets_geometry(f.assets, id);
        if (!hard)
            assert_memory_equal(now->normals, now->normals + 9, 12);
        assert_true(now->normals[0] < -0.1f);
        assert_memory_equal(now->normals + 15, now->rest_normals + 15, 12); // nothing around it moved
        if (hard)
            assert_memory_equal(now->normals + 9, now->rest_normals + 9, 12);
    }
    end(&f);
}

static void other_levels_and_durations_follow(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    begin(&f);
    OK(paint(&f));
    const struct ng_image *image = ng_assets_image(f.assets, f.image);
    assert_int_equal(((const unsigned char *)image->pixels)[16], 99);
    uint64_t revision = ng_assets_clip(f.assets, f.clip)->revision;
    OK(edit_clip(&f));
    assert_float_equal(ng_assets_clip(f.assets, f.clip)->duration, 4, 0);
    assert_true(ng_assets_clip(f.assets, f.clip)->revision > revision);
    assert_null(ng_assets_edit_points(f.assets, f.image)); // other kinds
    assert_null(ng_assets_edit_texels(f.assets, f.clip));
    assert_null(ng_assets_edit_clip(f.assets, f.geometry));
    end(&f);
}

// ---- Out of memory ---------------------------------------------------------------------------------------
// Whichever allocation fails: the transaction is cancelled, and everything is as it was.
static void nothing_is_lost_where_memory_ends(void **state)
{
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(acts); i++)
        for (int64_t n = 0;; n++) {
            struct fixture f;
            struct test_log log;
            begin(&f);
            uint64_t before = hash_of(&f);
            bool makes = acts[i] == replace_geometry || acts[i] == replace_cage || acts[i] == replace_image ||
                         acts[i] == replace_clip || acts[i] == take_one;
            if (makes) { // allocates content of its own first
                end(&f);
                break;
            }
            OK(ng_world_begin(f.world, "act"));
            test_log_begin(&log);
            allocations = n;
            ng_result r = acts[i](&f);
            allocations = 0; // the way back needs none
            OK(ng_world_cancel(f.world));
            allocations = INT64_MAX;
            test_log_end(&log);
            assert_true(hash_of(&f) == before);
            end(&f);
            if (r == NG_OK)
                break;
            assert_int_equal(r, NG_ERROR_MEMORY);
            assert_true(log.errors > 0);
        }
}

// Content that is moved in is freed where it cannot be taken.
static void content_that_is_refused_is_freed(void **state)
{
    NG_UNUSED(state);
    bool taken = false;
    for (int64_t n = 0; !taken; n++) {
        struct fixture f;
        struct test_log log;
        begin(&f);
        struct ng_geometry g = make_quad(2), h = make_quad(2);
        ng_asset id;
        OK(ng_world_begin(f.world, "act"));
        uint64_t before = hash_of(&f);
        test_log_begin(&log);
        allocations = n;
        ng_result replaced = ng_assets_replace_geometry(f.assets, f.geometry, &g);
        taken = ng_assets_take_geometry(f.assets, "quad", &h, &id) == NG_OK;
        allocations = 0;
        OK(ng_world_cancel(f.world));
        allocations = INT64_MAX;
        test_log_end(&log);
        assert_true(replaced == NG_OK || !taken || n > 0);
        assert_true(hash_of(&f) == before);
        assert_true(!g.positions && !h.positions);
        end(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_act_is_taken_back_and_done_again),
        cmocka_unit_test(a_drag_is_one_entry_and_one_copy),
        cmocka_unit_test(a_removed_asset_comes_back_under_its_id),
        cmocka_unit_test(the_store_may_go_before_its_world),
        cmocka_unit_test(unrecorded_changes_are_passed_over),
        cmocka_unit_test(what_follows_from_points_does_not_depend_on_the_way),
        cmocka_unit_test(smooth_points_stay_smooth_and_hard_edges_hard),
        cmocka_unit_test(other_levels_and_durations_follow),
        cmocka_unit_test(nothing_is_lost_where_memory_ends),
        cmocka_unit_test(content_that_is_refused_is_freed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
