// A scene on a stage without a device.
#include "test.h"

#include "app/stage.h"
#include "asset/gltf_save.h"
#include "base/file.h"
#include "components/components.h"
#include "components/placement_system.h"
#include "components/transform.h"
#include "scene/world.h"

#define OK(call) assert_int_equal((call), NG_OK)

static struct ng_stage *open_stage(void)
{
    const struct ng_stage_params params = {.scene = "content/unit/hierarchy.glb", .no_device = true};
    struct ng_stage *stage;
    OK(ng_stage_create(&params, &stage));
    OK(ng_stage_seek(stage, 0, NULL));
    return stage;
}

// As the scene's camera, but pushed to the side.
static struct ng_free_camera beside(const struct ng_stage *stage, float x)
{
    ng_entity e = stage->scene.camera;
    const struct ng_camera *lens = ng_world_get(stage->world, e, NG_CAMERA);
    const struct ng_placement *place = ng_world_get(stage->world, e, NG_PLACEMENT);
    struct ng_free_camera camera = {*lens, *place};
    camera.placement.matrix[12] += x;
    return camera;
}

static char *save(const struct ng_stage *stage, const char *name, size_t *size)
{
    char path[256];
    void *bytes;
    test_path(path, sizeof path, name);
    OK(ng_gltf_save(path, &(struct ng_gltf_save_params){
                              .world = stage->world, .assets = stage->assets, .root = stage->scene.root}));
    OK(ng_file_read(path, 1 << 24, &bytes, size));
    return bytes;
}

static void a_viewer_leaves_nothing_in_the_scene(void **state)
{
    NG_UNUSED(state);
    struct ng_stage *stage = open_stage();
    size_t sizes[2];
    char *before = save(stage, "before.glb", &sizes[0]);
    uint32_t entities = ng_world_entity_count(stage->world);
    float own = stage->snapshot->camera.position[0];
    for (int i = 1; i <= 3; i++) {
        const struct ng_free_camera camera = beside(stage, (float)i);
        ng_stage_look(stage, &camera);
        OK(ng_stage_advance(stage, 0, NULL));
        assert_true(stage->snapshot->camera.position[0] == camera.placement.matrix[12]);
        assert_true(ng_entity_is_null(stage->snapshot->camera.entity));
    }
    assert_int_equal(ng_world_entity_count(stage->world), entities);
    char *after = save(stage, "after.glb", &sizes[1]);
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(before, after, sizes[0]);
    ng_stage_look(stage, NULL);
    OK(ng_stage_advance(stage, 0, NULL));
    assert_true(stage->snapshot->camera.position[0] == own);
    free(before);
    free(after);
    ng_stage_destroy(&stage);
}

// Whatever else is asked for.
static void a_viewer_needs_no_camera_of_the_scene(void **state)
{
    NG_UNUSED(state);
    struct ng_stage *stage = open_stage();
    const struct ng_free_camera camera = beside(stage, 1);
    ng_stage_look(stage, &camera);
    OK(ng_stage_advance(stage, 0, "nobody"));
    OK(ng_entity_destroy(stage->world, stage->scene.camera));
    OK(ng_stage_advance(stage, 0, NULL));
    const struct ng_snapshot_camera *seen = &stage->snapshot->camera;
    assert_true(seen->position[0] == camera.placement.matrix[12]);
    ng_stage_look(stage, NULL); // the default view: a cut, though neither camera is an entity
    OK(ng_stage_advance(stage, 0, NULL));
    seen = &stage->snapshot->camera;
    assert_true(seen->position[0] != camera.placement.matrix[12]);
    assert_memory_equal(seen->view, seen->previous_view, sizeof seen->view);
    ng_stage_destroy(&stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_viewer_leaves_nothing_in_the_scene),
        cmocka_unit_test(a_viewer_needs_no_camera_of_the_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
