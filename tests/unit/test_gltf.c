#include "test.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "components/components.h"
#include "components/material.h"
#include "components/mesh.h"
#include "scene/world.h"

// A world and a store, and a file loaded into them.
struct loaded {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
};

static ng_result load(struct loaded *l, const char *path)
{
    assert_int_equal(ng_world_create(NULL, &l->world), NG_OK);
    assert_int_equal(ng_components_register(l->world), NG_OK);
    assert_int_equal(ng_assets_create(&l->assets), NG_OK);
    return ng_gltf_load(path, l->world, l->assets, NULL, &l->scene);
}

static void finish(struct loaded *l)
{
    ng_assets_destroy(&l->assets);
    ng_world_destroy(&l->world);
}

// The entity of this name, which must exist.
static ng_entity named(const struct loaded *l, const char *name)
{
    for (ng_entity e = l->scene.root; !ng_entity_is_null(e);
         e = ng_world_next_below(l->world, l->scene.root, e)) {
        const char *text = ng_world_get(l->world, e, NG_NAME);
        if (text && strcmp(text, name) == 0)
            return e;
    }
    fail_msg("no entity is called %s", name);
    return (ng_entity){0};
}

static void test_triangle(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load(&l, "tests/files/good/triangle.gltf"), NG_OK);
    const struct ng_mesh *mesh = ng_world_get(l.world, named(&l, "triangle"), NG_MESH);
    assert_non_null(mesh);
    const struct ng_geometry *g = ng_assets_geometry(l.assets, mesh->geometry);
    assert_int_equal(g->vertex_count, 3);
    assert_float_equal(g->normals[2], 1, 1e-6);
    const struct ng_material *m = ng_world_get(l.world, mesh->material, NG_MATERIAL);
    assert_float_equal(m->base_color[1], 0.25, 1e-6);
    finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_triangle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
