#include "pose.h"

#include "app/camera_controller.h"
#include "base/log.h"
#include "base/printable.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/name.h"
#include "components/placement.h"
#include "components/placement_system.h"
#include "components/scene_scale.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NUMBERS     6
#define MOST_NUMBER 1e9f // metres

// Numbers between commas; how many, or 0 if it is anything else.
static int read_numbers(const char *text, float out[NUMBERS])
{
    for (int n = 0; n < NUMBERS; n++) {
        char *end;
        out[n] = strtof(text, &end);
        if (end == text || !(fabsf(out[n]) <= MOST_NUMBER))
            return 0;
        if (*end == 0)
            return n + 1;
        if (*end != ',')
            return 0;
        text = end + 1;
    }
    return 0;
}

bool pose_check(const char *text, const char *command)
{
    float numbers[NUMBERS] = {0};
    int count = text ? read_numbers(text, numbers) : NUMBERS - 1;
    if (count >= NUMBERS - 1 && numbers[NUMBERS - 1] >= 0)
        return true;
    ng_print_line(stderr, "lightformer %s: --pose: \"%s\" is not X,Y,Z,YAW,PITCH or X,Y,Z,YAW,PITCH,HEIGHT",
                  command, text);
    return false;
}

struct pose pose_read(const char *text)
{
    float n[NUMBERS] = {0};
    if (read_numbers(text, n) == NUMBERS - 1)
        n[NUMBERS - 1] = 0;
    return (struct pose){{n[0], n[1], n[2]}, n[3], n[4], n[5]};
}

void pose_write(const struct pose *p, char out[POSE_TEXT])
{
    int n = snprintf(out, POSE_TEXT, "%.9g,%.9g,%.9g,%.9g,%.9g", (double)p->eye[0], (double)p->eye[1],
                     (double)p->eye[2], (double)p->yaw, (double)p->pitch);
    if (p->height > 0)
        snprintf(out + n, POSE_TEXT - (size_t)n, ",%.9g", (double)p->height);
}

struct pose pose_of(const struct ng_camera_controller *c)
{
    return (struct pose){{c->eye[0], c->eye[1], c->eye[2]}, c->yaw, c->pitch, c->parallel ? c->lens : 0};
}

void pose_take(const struct pose *p, struct ng_camera_controller *c)
{
    memcpy(c->eye, p->eye, sizeof c->eye);
    c->yaw = p->yaw;
    c->pitch = p->pitch;
    if (c->parallel && p->height > 0)
        c->lens = p->height;
}

// ---- Cameras
// -----------------------------------------------------------------------------------------------

ng_entity pose_find_camera(const struct ng_world *world, ng_entity root, const char *name)
{
    for (ng_entity e = root; !ng_entity_is_null(e); e = ng_world_next_below(world, root, e)) {
        const struct ng_name *n = ng_world_get(world, e, NG_NAME);
        if (ng_world_has(world, e, NG_CAMERA) && n && strcmp(n->text, name) == 0)
            return e;
    }
    return (ng_entity){0};
}

bool pose_look(const struct ng_world *world, ng_entity root, ng_entity camera,
               struct ng_camera_controller *out)
{
    const struct ng_camera *lens = ng_world_get(world, camera, NG_CAMERA);
    const struct ng_placement *placement = ng_world_get(world, camera, NG_PLACEMENT);
    const struct ng_scene_scale *scale = ng_world_get(world, root, NG_SCENE_SCALE);
    if (!lens || !placement)
        return false;
    bool parallel = lens->projection == NG_PROJECTION_ORTHOGRAPHIC;
    ng_camera_controller_look(out, placement->matrix, scale ? scale->radius : 1);
    ng_camera_controller_see(out, parallel ? lens->height : 2 * tanf(lens->fov_y / 2), parallel);
    return true;
}

struct ng_free_camera pose_camera(const struct ng_camera_controller *c, const struct ng_camera *like)
{
    const struct ng_transform pose = ng_camera_controller_transform(c);
    struct ng_free_camera camera = {*like, ng_placement_of(&pose)};
    if (c->parallel)
        camera.lens.height = c->lens;
    return camera;
}
