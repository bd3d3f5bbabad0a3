// Writes small scene files that a test has as text, and loads them.
#ifndef NG_TESTS_UNIT_SCENE_MAKER_H
#define NG_TESTS_UNIT_SCENE_MAKER_H

#include "test.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/file.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/name.h"
#include "components/scene_scale.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>

struct loaded {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
    struct test_log log;
};

// Writes NAME in the scratch directory; `path` (may be null) gets its path.
static inline void put_file(const char *name, const void *data, size_t size, char path[256])
{
    char file[256];
    test_path(file, sizeof file, name);
    FILE *out = fopen(file, "wb"); // not ng_file_write, which waits for the disk
    assert_non_null(out);
    assert_int_equal(fwrite(data, 1, size, out), size);
    assert_int_equal(fclose(out), 0);
    if (path)
        memcpy(path, file, strlen(file) + 1);
}

static inline void begin_world(struct loaded *l)
{
    *l = (struct loaded){0};
    assert_int_equal(ng_world_create(NULL, &l->world), NG_OK);
    assert_int_equal(ng_components_register(l->world), NG_OK);
    assert_int_equal(ng_assets_create(&l->assets), NG_OK);
}

static inline ng_result load_path(struct loaded *l, const char *path, const struct ng_gltf_params *params)
{
    begin_world(l);
    test_log_begin(&l->log);
    ng_result r = ng_gltf_load(path, l->world, l->assets, params, &l->scene);
    test_log_end(&l->log);
    return r;
}

static inline void finish(struct loaded *l)
{
    ng_assets_destroy(&l->assets);
    ng_world_destroy(&l->world);
}

// The first entity of this name that has a component; null: none.
static inline ng_entity find(const struct loaded *l, const char *name, ng_component component)
{
    ng_entity top = l->scene.root;
    for (ng_entity e = top; !ng_entity_is_null(e); e = ng_world_next_below(l->world, top, e)) {
        const struct ng_name *n = ng_world_get(l->world, e, NG_NAME);
        if (n && strcmp(n->text, name) == 0 && ng_world_has(l->world, e, component))
            return e;
    }
    return (ng_entity){0};
}

static inline const struct ng_geometry *geometry_of(const struct loaded *l, ng_entity e)
{
    const struct ng_mesh *mesh = ng_world_get(l->world, e, NG_MESH);
    assert_non_null(mesh);
    return ng_assets_geometry(l->assets, mesh->geometry);
}

static inline const struct ng_material *material_of(const struct loaded *l, const char *name)
{
    const struct ng_material *m = ng_world_get(l->world, find(l, name, NG_MATERIAL), NG_MATERIAL);
    assert_non_null(m);
    return m;
}

// Twice the sum of the triangles' areas, with the sign of their turn about z.
static inline double signed_area(const struct ng_geometry *g)
{
    double sum = 0;
    for (uint32_t i = 0; i < g->index_count; i += 3) {
        const float *a = g->positions + g->indices[i] * 3, *b = g->positions + g->indices[i + 1] * 3,
                    *c = g->positions + g->indices[i + 2] * 3;
        sum += (double)((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    }
    return sum;
}

#endif
