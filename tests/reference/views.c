#include "views.h"

#include "app/stage.h"
#include "components/camera.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>

bool view_is_inside(const uint32_t *ids, int width, int height, int x, int y)
{
    if (x < 1 || y < 1 || x >= width - 1 || y >= height - 1)
        return false;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++)
            if (ids[(y + j) * width + x + i] != ids[y * width + x])
                return false;
    return true;
}

double view_difference(const float *a, const float *b, const uint32_t *ids, uint32_t channels, int width,
                       int height)
{
    double sum = 0, size = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (uint32_t c = 0; view_is_inside(ids, width, height, x, y) && c < channels; c++) {
                size_t at = ((size_t)y * (size_t)width + (size_t)x) * channels + c;
                sum += fabs((double)a[at] - (double)b[at]);
                size += fabs((double)b[at]);
            }
    return size > 0 ? sum / size : sum;
}

void view_mirror_normal_maps(struct ng_stage *stage)
{
    OK(ng_stage_seek(stage, 0, NULL));
    const struct ng_snapshot *s = stage->snapshot;
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (s->materials[s->instances[i].material].textures[NG_TEXTURE_NORMAL].image != NG_NONE)
            ((struct ng_transform *)ng_world_edit(stage->world, s->instances[i].entity, NG_TRANSFORM))
                ->scale[0] = -1;
}

void view_turn_normals(struct ng_stage *stage)
{
    OK(ng_stage_seek(stage, 0, NULL));
    const struct ng_snapshot *s = stage->snapshot;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        for (size_t k = 0; k < (size_t)s->meshes[i].vertex_count * 3; k++)
            ((float *)s->meshes[i].normals)[k] *= -1;
}

static void scale_camera(struct ng_stage *stage, float x, float y, float z)
{
    OK(ng_stage_seek(stage, 0, NULL));
    float *scale =
        ((struct ng_transform *)ng_world_edit(stage->world, stage->scene.camera, NG_TRANSFORM))->scale;
    scale[0] = x, scale[1] = y, scale[2] = z;
}

static void mirror_camera(struct ng_stage *stage)
{
    scale_camera(stage, -1, 1, 1);
}

static void mirror_camera_upwards(struct ng_stage *stage)
{
    scale_camera(stage, 1, -3, 1);
}

static void turn_camera(struct ng_stage *stage)
{
    scale_camera(stage, -0.5f, -2, 1);
}

static void mirror_parent_of_camera(struct ng_stage *stage)
{
    OK(ng_stage_seek(stage, 0, NULL));
    ng_entity parent = ng_entity_create(stage->world);
    OK(ng_world_add(
        stage->world, parent, NG_TRANSFORM,
        &(struct ng_transform){.rotation = {0, 0, 0.3826834f, 0.9238795f}, .scale = {-1, 1.3f, 1}}));
    OK(ng_world_set_parent(stage->world, stage->scene.camera, parent, (ng_entity){0}));
}

void (*const view_cameras[VIEW_CAMERAS])(struct ng_stage *) = {mirror_camera, mirror_camera_upwards,
                                                               turn_camera, mirror_parent_of_camera};

void view_look_in_parallel(struct ng_stage *stage)
{
    struct ng_camera *camera = ng_world_edit(stage->world, stage->scene.camera, NG_CAMERA);
    camera->projection = NG_PROJECTION_ORTHOGRAPHIC;
    camera->height = 3;
}
