// Yaw and pitch are the state, so that the horizon stays level however one moves; directions and the rotation
// are derived from them.
#include "app/camera_controller.h"

#include <cglm/cglm.h>

#define PITCH_LIMIT     1.55f // radians; a little less than straight up
#define NEAREST         1e-3f // metres that the eye keeps from the point
#define DRAG_ANGLE      3.0f  // radians for a drag over the window's height
#define FLY_FAST        4.0f
#define DISTANCE_A_STEP 0.9f
#define SPEED_A_STEP    1.25f
#define SPEED_RANGE     1e4f // times the reach, and as much below it
#define STEPS_AT_ONCE   20.0f
#define FRAME_MARGIN    1.1f

static void rotation(const struct ng_camera_controller *c, versor out)
{
    versor turn, tilt;
    glm_quatv(turn, c->yaw, (vec3){0, 1, 0});
    glm_quatv(tilt, c->pitch, (vec3){1, 0, 0});
    glm_quat_mul(turn, tilt, out);
}

// From the camera's own directions (right, up, ahead) to the world's.
static void to_world(const struct ng_camera_controller *c, const float own[3], vec3 out)
{
    versor q;
    rotation(c, q);
    glm_quat_rotatev(q, (vec3){own[0], own[1], -own[2]}, out);
}

static void set_angles(struct ng_camera_controller *c, float yaw, float pitch)
{
    c->yaw = remainderf(yaw, 2 * GLM_PIf);
    c->pitch = glm_clamp(pitch, -PITCH_LIMIT, PITCH_LIMIT);
}

void ng_camera_controller_look(struct ng_camera_controller *c, const float matrix[16], float reach)
{
    vec3 ahead = {-matrix[8], -matrix[9], -matrix[10]};
    glm_vec3_normalize(ahead);
    vec3 right = {matrix[0], matrix[1], matrix[2]}, up = {matrix[4], matrix[5], matrix[6]}, across;
    glm_vec3_cross(up, ahead, across); // against the right, unless a mirror is between
    reach = glm_max(reach, NEAREST);
    *c = (struct ng_camera_controller){
        .eye = {matrix[12], matrix[13], matrix[14]},
        .point = {0, 0, reach},
        .reach = reach,
        .speed = reach,
        .mirrors = glm_vec3_dot(across, right) > 0,
        .lens = 2,
    };
    // Straight up or down has no direction on the ground: take it from where the top of the image points.
    bool vertical = fabsf(ahead[1]) > 0.9999f;
    float x = vertical ? -matrix[4] * ahead[1] : ahead[0], z = vertical ? -matrix[6] * ahead[1] : ahead[2];
    set_angles(c, atan2f(-x, -z), asinf(glm_clamp(ahead[1], -1, 1)));
}

void ng_camera_controller_see(struct ng_camera_controller *c, float lens, bool parallel)
{
    c->lens = lens;
    c->parallel = parallel;
}

// Height of what is seen at a distance along the view, metres.
static float height_at(const struct ng_camera_controller *c, float distance)
{
    return c->parallel ? c->lens : c->lens * distance;
}

void ng_camera_controller_take(struct ng_camera_controller *c, const float world[3])
{
    versor q, back;
    vec3 own;
    rotation(c, q);
    glm_quat_inv(q, back);
    glm_vec3_sub((float *)world, c->eye, own);
    glm_quat_rotatev(back, own, own);
    c->point[0] = own[0];
    c->point[1] = own[1];
    c->point[2] = glm_max(-own[2], NEAREST);
}

void ng_camera_controller_take_nothing(struct ng_camera_controller *c, float x, float y, float aspect)
{
    float half = height_at(c, c->reach) / 2, side = c->mirrors ? -1.0f : 1.0f;
    glm_vec3_copy((vec3){x * side * half * aspect, -y * half, c->reach}, c->point);
}

void ng_camera_controller_point(const struct ng_camera_controller *c, float world[3])
{
    vec3 way;
    to_world(c, c->point, way);
    glm_vec3_add((float *)c->eye, way, world);
}

void ng_camera_controller_orbit(struct ng_camera_controller *c, float yaw, float pitch)
{
    vec3 point, way;
    ng_camera_controller_point(c, point);
    set_angles(c, c->yaw + yaw, c->pitch + pitch);
    to_world(c, c->point, way);
    glm_vec3_sub(point, way, c->eye);
}

void ng_camera_controller_turn(struct ng_camera_controller *c, float yaw, float pitch)
{
    set_angles(c, c->yaw + yaw, c->pitch + pitch);
}

void ng_camera_controller_move(struct ng_camera_controller *c, float right, float up, float ahead)
{
    vec3 step;
    to_world(c, (vec3){right, up, ahead}, step);
    glm_vec3_add(c->eye, step, c->eye);
}

// Moves the eye alone.
static void move_past_point(struct ng_camera_controller *c, vec3 step)
{
    ng_camera_controller_move(c, step[0], step[1], step[2]);
    glm_vec3_sub(c->point, step, c->point);
}

void ng_camera_controller_slide(struct ng_camera_controller *c, float right, float up)
{
    float height = height_at(c, c->point[2]);
    move_past_point(c, (vec3){right * height, up * height, 0});
}

void ng_camera_controller_zoom(struct ng_camera_controller *c, float steps)
{
    float ratio = powf(DISTANCE_A_STEP, glm_clamp(steps, -STEPS_AT_ONCE, STEPS_AT_ONCE));
    vec3 step;
    ratio = glm_max(ratio, NEAREST / c->point[2]);
    glm_vec3_scale(c->point, 1 - ratio, step);
    move_past_point(c, step);
    if (c->parallel)
        c->lens = glm_clamp(c->lens * ratio, 1e-4f, 1e6f);
}

void ng_camera_controller_frame(struct ng_camera_controller *c, const float center[3], float radius,
                                float aspect)
{
    radius = glm_max(radius, NEAREST) * FRAME_MARGIN;
    float narrow = glm_min(aspect, 1), distance = 2 * radius;
    if (c->parallel)
        c->lens = 2 * radius / narrow;
    else // the sphere touches the sides of the view
        distance = radius / sinf(atanf(c->lens / 2 * narrow));
    vec3 way;
    glm_vec3_copy((vec3){0, 0, distance}, c->point);
    to_world(c, c->point, way);
    glm_vec3_sub((float *)center, way, c->eye);
}

static float held(const struct ng_input *input, char key)
{
    return input->held[(int)key] + (FLY_FAST - 1) * input->hurried[(int)key];
}

static float axis(const struct ng_input *input, char positive, char negative)
{
    return held(input, positive) - held(input, negative);
}

bool ng_camera_controller_flies(const struct ng_input *input)
{
    bool flies = input->buttons[NG_BUTTON_RIGHT];
    for (const char *key = "WASDEQ"; *key; key++)
        flies |= input->down[(int)*key] || input->held[(int)*key] > 0;
    return flies;
}

static void wheel(struct ng_camera_controller *c, const struct ng_input *input)
{
    if (input->scroll == 0)
        return;
    if (!ng_camera_controller_flies(input)) {
        ng_camera_controller_zoom(c, input->scroll);
        return;
    }
    float steps = glm_clamp(input->scroll, -STEPS_AT_ONCE, STEPS_AT_ONCE);
    c->speed =
        glm_clamp(c->speed * powf(SPEED_A_STEP, steps), c->reach / SPEED_RANGE, c->reach * SPEED_RANGE);
}

void ng_camera_controller_update(struct ng_camera_controller *c, const struct ng_input *input, float height)
{
    float by = 1 / glm_max(height, 1), angle = -DRAG_ANGLE * by, side = c->mirrors ? -1.0f : 1.0f;
    const float *orbit = input->drag[NG_BUTTON_LEFT], *turn = input->drag[NG_BUTTON_RIGHT];
    const float *slide = input->drag[NG_BUTTON_MIDDLE];
    if (orbit[0] != 0 || orbit[1] != 0) // turning by nothing would still round the eye, frame after frame
        ng_camera_controller_orbit(c, orbit[0] * angle * side, orbit[1] * angle);
    ng_camera_controller_turn(c, turn[0] * angle * side, turn[1] * angle);
    ng_camera_controller_slide(c, -slide[0] * by * side, slide[1] * by);
    wheel(c, input);
    ng_camera_controller_move(c, axis(input, 'D', 'A') * c->speed * side, axis(input, 'E', 'Q') * c->speed,
                              axis(input, 'W', 'S') * c->speed);
}

struct ng_transform ng_camera_controller_transform(const struct ng_camera_controller *c)
{
    struct ng_transform t = {.scale = {c->mirrors ? -1.0f : 1.0f, 1, 1}};
    rotation(c, t.rotation);
    glm_vec3_copy((float *)c->eye, t.translation);
    return t;
}
