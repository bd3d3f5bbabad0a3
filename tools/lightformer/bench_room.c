#include "bench_room.h"

#include "asset/assets.h"
#include "asset/geometry.h"
#include "base/log.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_rectangle.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/scene_scale.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>
#include <stdlib.h>

// Metres; the floor is at 0, the room's middle at the origin.
#define WIDTH  6.0f
#define HEIGHT 2.8f
#define DEPTH  5.0f
#define EYE    1.6f
#define LAMP   0.5f

// A cube of 1 m around the origin, seen from outside or from inside.
static ng_result make_cube(struct ng_assets *assets, bool inside, ng_asset *out)
{
    // Corner bits: x, y, z.
    static const uint32_t triangles[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                           2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    struct ng_geometry g = {.vertex_count = 8, .index_count = 36};
    g.positions = malloc(8 * 3 * sizeof *g.positions);
    g.indices = malloc(sizeof triangles);
    if (!g.positions || !g.indices) {
        ng_geometry_finish(&g);
        return ng_out_of_memory("the room of a benchmark");
    }
    for (size_t i = 0; i < 24; i++)
        g.positions[i] = i / 3 >> i % 3 & 1 ? 0.5f : -0.5f;
    for (size_t i = 0; i < 36; i++)
        g.indices[i] = triangles[inside ? 35 - i : i];
    ng_result result = ng_geometry_complete(&g);
    if (result != NG_OK) {
        ng_geometry_finish(&g);
        return result;
    }
    return ng_assets_take_geometry(assets, inside ? "room" : "box", &g, out);
}

static ng_result add_placed(struct ng_world *world, const struct ng_transform *place, ng_component component,
                            const void *value, ng_entity *out)
{
    *out = ng_entity_create(world);
    NG_TRY(ng_world_add(world, *out, NG_TRANSFORM, place));
    return ng_world_add(world, *out, component, value);
}

static ng_result add_boxes(struct ng_world *world, ng_asset room, ng_asset box)
{
    static const struct {
        float center[3], size[3];
    } boxes[] = {
        {{0, HEIGHT / 2, 0}, {WIDTH, HEIGHT, DEPTH}}, // the room itself
        {{-0.6f, 0.375f, -0.4f}, {1.6f, 0.75f, 0.8f}}, {{-2.6f, 1.0f, -1.6f}, {0.6f, 2.0f, 1.2f}},
        {{1.9f, 0.25f, -1.6f}, {1.4f, 0.5f, 1.0f}},    {{0.9f, 0.225f, 0.5f}, {0.45f, 0.45f, 0.45f}},
    };
    ng_entity material = ng_entity_create(world), e;
    NG_TRY(ng_world_add(world, material, NG_MATERIAL, NULL)); // matte
    struct ng_material *m = ng_world_edit(world, material, NG_MATERIAL);
    for (int c = 0; c < 3; c++)
        m->base_color[c] = 0.7f;
    for (size_t i = 0; i < NG_COUNT(boxes); i++) {
        const float *at = boxes[i].center, *size = boxes[i].size;
        const struct ng_transform place = {{at[0], at[1], at[2]}, {0, 0, 0, 1}, {size[0], size[1], size[2]}};
        const struct ng_mesh mesh = {.geometry = i ? box : room, .material = material, .visible = true};
        NG_TRY(add_placed(world, &place, NG_MESH, &mesh, &e));
    }
    return NG_OK;
}

// Two rows, of four and of three.
static ng_result add_lamps(struct ng_world *world, ng_entity lamps[BENCH_ROOM_LAMPS])
{
    const float half = 0.70710678f;
    const struct ng_light_rectangle lamp = {
        .on = true, .color = {1, 1, 1}, .radiance = 6, .size = {LAMP, LAMP}};
    for (uint32_t i = 0; i < BENCH_ROOM_LAMPS; i++) {
        float x = i < 4 ? -2.1f + 1.4f * (float)i : -1.4f + 1.4f * (float)(i - 4), z = i < 4 ? -1.2f : 1.2f;
        const struct ng_transform place = {{x, HEIGHT - 1e-3f, z}, {-half, 0, 0, half}, {1, 1, 1}};
        NG_TRY(add_placed(world, &place, NG_LIGHT_RECTANGLE, &lamp, &lamps[i]));
    }
    return NG_OK;
}

ng_result bench_room_make(struct ng_world *world, struct ng_assets *assets, ng_entity lamps[BENCH_ROOM_LAMPS])
{
    const struct ng_scene_scale scale = {
        .center = {0, HEIGHT / 2, 0}, .radius = sqrtf(WIDTH * WIDTH + HEIGHT * HEIGHT + DEPTH * DEPTH) / 2};
    const float down = -0.1f; // half the angle
    const struct ng_transform eye = {{0, EYE, DEPTH / 2 - 0.2f}, {sinf(down), 0, 0, cosf(down)}, {1, 1, 1}};
    struct ng_camera view = *(const struct ng_camera *)ng_camera_component.defaults;
    view.fov_y = 1.2f;
    ng_asset room, box;
    ng_entity camera;
    NG_TRY(make_cube(assets, true, &room));
    NG_TRY(make_cube(assets, false, &box));
    NG_TRY(add_placed(world, &eye, NG_CAMERA, &view, &camera));
    NG_TRY(ng_world_add(world, camera, NG_SCENE_SCALE, &scale));
    NG_TRY(add_boxes(world, room, box));
    return add_lamps(world, lamps);
}
