#include "large_scene.h"

#include "base/file.h"
#include "tools/content/stage.h"
#include "tools/content/vec.h"

#include <stdio.h>

// A sphere whose radius swings; `seed` turns the swing, so that no two have a vertex in common.
static struct stage_point stone(double u, double v, const void *seed)
{
    double around = 2.0 * CONTENT_PI * u, up = CONTENT_PI * (v - 0.5), turn = *(const uint32_t *)seed;
    struct vec3 n = vec3_make(cos(up) * sin(around), sin(up), cos(up) * cos(around));
    double swing = sin(11.0 * n.x + turn) + sin(13.0 * n.y + 2.0 * turn) + sin(17.0 * n.z + 3.0 * turn);
    return (struct stage_point){vec3_scale(n, 0.3 + 0.02 * swing), n};
}

static int add_stone(struct glb *g, uint32_t seed, uint32_t triangles, int material)
{
    uint32_t rows = (uint32_t)sqrt(triangles / 4.0);
    const struct stage_patch patch = {.surface = stone, .user = &seed, .columns = 2 * rows, .rows = rows};
    return stage_patch(g, "stone", &patch, material);
}

static void add_room(struct glb *g)
{
    const double half = 0.70710678118654752;
    stage_add_wall(g);
    int wall = stage_plane(g, "side", 8, 4, 4, stage_material(g, "side", 0.5, 0.3, 0.25, 0.9));
    for (int side = -1; side <= 1; side += 2)
        glb_add_node(g, &(struct glb_node){.name = "side",
                                           .translation = {4.0 * side, 2, 1},
                                           .rotation = {0, -half * side, 0, half},
                                           .mesh = wall + 1});
    int top = stage_plane(g, "ceiling", 8, 8, 4, stage_material(g, "ceiling", 0.7, 0.7, 0.7, 0.9));
    glb_add_node(
        g, &(struct glb_node){
               .name = "ceiling", .translation = {0, 4, 1}, .rotation = {half, 0, 0, half}, .mesh = top + 1});
    stage_add_light(g);
}

// In rows of eight, each higher and further back than the one before it.
static void add_things(struct glb *g, const struct large_scene *scene)
{
    int material = stage_material(g, "stone", 0.6, 0.55, 0.5, 0.6), mesh = 0;
    for (uint32_t i = 0; i < scene->things; i++) {
        char name[32];
        uint32_t row = i / 8;
        snprintf(name, sizeof name, "thing %u", i);
        if (i == 0 || !scene->copies)
            mesh = add_stone(g, i, scene->triangles, material);
        stage_place(g, name, mesh, 0.7 * (i % 8) - 2.45, 0.4 + 0.35 * row, 1.0 - 0.7 * row);
    }
}

ng_result large_scene_write(const struct large_scene *scene, const char *path)
{
    struct glb g;
    struct bytes file = {0};
    stage_init(&g);
    add_room(&g);
    add_things(&g, scene);
    ng_result result = glb_finish(&g, &file);
    if (result == NG_OK)
        result = ng_file_write(path, file.items, file.count);
    bytes_finish(&file);
    return result;
}
