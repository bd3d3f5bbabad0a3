// Yaw and pitch are the state, so that the horizon stays level however one moves; directions and the rotation
// are derived from them.
#include "app/camera_controller.h"

#include <cglm/cglm.h>

#define PITCH_LIMIT     1.55f // radians; a little less than straight up
#define DISTANCE_MIN    1e-3f
#define DRAG_ANGLE      3.0f // radians for a drag over the window's height
#define FLY_FAST        4.0f
#define DISTANCE_A_STEP 0.9f

static void rotation(const struct ng_camera_controller *c, versor out)
{
    versor turn, tilt;
    glm_quatv(turn, c->yaw, (vec3){0, 1, 0});
    glm_quatv(tilt, c->pitch, (vec3){1, 0, 0});
    glm_quat_mul(turn, tilt, out);
}

// The camera's own direction (right, up or back) in the world.
static void direction(const struct ng_camera_controller *c, float x, float y, float z, vec3 out)
{
    versor q;
    rotation(c, q);
    glm_quat_rotatev(q, (vec3){x, y, z}, out);
}

static void set_angles(struct ng_camera_controller *c, float yaw, float pitch)
{
    c->yaw = remainderf(yaw, 2 * GLM_PIf);
    c->pitch = glm_clamp(pitch, -PITCH_LIMIT, PITCH_LIMIT);
}

void ng_camera_controller_look(struct ng_camera_controller *c, const float matrix[16], float distance)
{
    vec3 ahead = {-matrix[8], -matrix[9], -matrix[10]};
    glm_vec3_normalize(ahead);
    vec3 right = {matrix[0], matrix[1], matrix[2]}, up = {matrix[4], matrix[5], matrix[6]}, across;
    glm_vec3_cross(up, ahead, across); // against the right, unless a mirror is between
    *c = (struct ng_camera_controller){
        .eye = {matrix[12], matrix[13], matrix[14]},
        .distance = glm_max(distance, DISTANCE_MIN),
        .speed = glm_max(distance, DISTANCE_MIN),
        .mirrors = glm_vec3_dot(across, right) > 0,
    };
    // Straight up or down has no direction on the ground: take it from where the top of the image points.
    bool vertical = fabsf(ahead[1]) > 0.9999f;
    float x = vertical ? -matrix[4] * ahead[1] : ahead[0], z = vertical ? -matrix[6] * ahead[1] : ahead[2];
    set_angles(c, atan2f(-x, -z), asinf(glm_clamp(ahead[1], -1, 1)));
}

void ng_camera_controller_orbit(struct ng_camera_controller *c, float yaw, float pitch)
{
    vec3 point, back;
    direction(c, 0, 0, -c->distance, point);
    glm_vec3_add(c->eye, point, point);
    set_angles(c, c->yaw + yaw, c->pitch + pitch);
    direction(c, 0, 0, c->distance, back);
    glm_vec3_add(point, back, c->eye);
}

void ng_camera_controller_turn(struct ng_camera_controller *c, float yaw, float pitch)
{
    set_angles(c, c->yaw + yaw, c->pitch + pitch);
}

void ng_camera_controller_move(struct ng_camera_controller *c, float right, float up, float ahead)
{
    vec3 step;
    direction(c, right, up, -ahead, step);
    glm_vec3_add(c->eye, step, c->eye);
}

void ng_camera_controller_zoom(struct ng_camera_controller *c, float steps)
{
    float nearer = glm_max(c->distance * powf(DISTANCE_A_STEP, steps), DISTANCE_MIN);
    ng_camera_controller_move(c, 0, 0, c->distance - nearer);
    c->distance = nearer;
}

static float axis(const struct ng_input *input, char positive, char negative)
{
    return (float)input->down[(int)positive] - (float)input->down[(int)negative];
}

void ng_camera_controller_update(struct ng_camera_controller *c, const struct ng_input *input, float height,
                                 float seconds)
{
    float by = 1 / glm_max(height, 1), angle = -DRAG_ANGLE * by, side = c->mirrors ? -1.0f : 1.0f;
    const float *orbit = input->drag[NG_BUTTON_LEFT], *turn = input->drag[NG_BUTTON_RIGHT];
    const float *slide = input->drag[NG_BUTTON_MIDDLE];
    if (orbit[0] != 0 || orbit[1] != 0) // turning by nothing would still round the eye, frame after frame
        ng_camera_controller_orbit(c, orbit[0] * angle * side, orbit[1] * angle);
    ng_camera_controller_turn(c, turn[0] * angle * side, turn[1] * angle);
    ng_camera_controller_move(c, -slide[0] * by * c->distance * side, slide[1] * by * c->distance, 0);
    if (input->scroll != 0)
        ng_camera_controller_zoom(c, input->scroll);
    float step = c->speed * seconds * (input->down[NG_KEY_SHIFT] ? FLY_FAST : 1);
    ng_camera_controller_move(c, axis(input, 'D', 'A') * step * side, axis(input, 'E', 'Q') * step,
                              axis(input, 'W', 'S') * step);
}

struct ng_transform ng_camera_controller_transform(const struct ng_camera_controller *c)
{
    struct ng_transform t = {.scale = {c->mirrors ? -1.0f : 1.0f, 1, 1}};
    rotation(c, t.rotation);
    glm_vec3_copy((float *)c->eye, t.translation);
    return t;
}
