// Viewing changes nothing in the scene: no entity of the viewer's is in the world, none is saved.
#include "test.h"

#include "app/clip_menu.h"
#include "app/stage.h"
#include "app/watch.h"
#include "asset/gltf_save.h"
#include "base/file.h"
#include "lightformer/methods/methods.h"
#include "scene/world.h"
#include "tools/lightformer/view_studio.h"

#define OK(call) assert_int_equal((call), NG_OK)

// The studio's stage, as it made it.
static struct {
    struct ng_stage *stage;
    uint32_t entities;
    void *saved;
    size_t size;
} seen;

static void *save(const char *name, size_t *size)
{
    char path[256];
    void *bytes;
    test_path(path, sizeof path, name);
    OK(ng_gltf_save(path, &(struct ng_gltf_save_params){.world = seen.stage->world,
                                                        .assets = seen.stage->assets,
                                                        .root = seen.stage->scene.root}));
    OK(ng_file_read(path, 1 << 24, &bytes, size));
    return bytes;
}

ng_result __real_ng_stage_create(const struct ng_stage_params *params, struct ng_stage **out);
ng_result __wrap_ng_stage_create(const struct ng_stage_params *params, struct ng_stage **out);
ng_result __wrap_ng_stage_create(const struct ng_stage_params *params, struct ng_stage **out)
{
    ng_result result = __real_ng_stage_create(params, out);
    seen.stage = *out;
    OK(ng_stage_seek(*out, 0, NULL)); // what the world derives is there
    seen.entities = ng_world_entity_count((*out)->world);
    seen.saved = save("opened.glb", &seen.size);
    return result;
}

static void look_around(struct view_studio *studio, struct view_frame *frame)
{
    struct view_order order = {
        .scene = "content/unit/hierarchy.glb", .opening = 1, .clip = NG_CLIPS_ALL, .width = 32, .height = 24};
    order.sides[VIEW_LEFT].method = lf_method_find("raster");
    for (int i = 0; i < 3; i++) {
        const struct view_drawing drawing = {.order = &order, .jumped = true};
        view_studio_draw(studio, &drawing, frame);
        OK(frame->result);
        order.pose = frame->order.pose;
        order.pose.eye[0] += 1;
        order.stops += 1;
    }
}

static void viewing_leaves_the_scene_as_it_was(void **state)
{
    NG_UNUSED(state);
    const struct opening opening = {0};
    struct view_studio_params params = {.opening = &opening};
    struct view_studio *studio;
    struct view_frame frame = {0};
    size_t size;
    OK(ng_watch_create(&params.watch));
    OK(view_studio_create(&params, &studio));
    look_around(studio, &frame);
    assert_non_null(seen.stage);
    assert_int_equal(ng_world_entity_count(seen.stage->world), seen.entities);
    void *saved = save("viewed.glb", &size);
    assert_int_equal(size, seen.size);
    assert_memory_equal(saved, seen.saved, size);
    free(saved);
    free(seen.saved);
    view_frame_finish(&frame);
    view_studio_destroy(&studio);
    ng_watch_destroy(&params.watch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(viewing_leaves_the_scene_as_it_was)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
