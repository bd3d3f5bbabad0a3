// The empty room of Interior Design: 6 m wide, 5 m deep, 2.8 m high, two windows to the west, a door. An
// evening sun shines in; the ceiling has no lamp yet.
//
// Walls have a thickness, so that no light passes where they meet.
#include "room.h"

#include "palette.h"
#include "picture.h"

#define WIDTH  6.0
#define DEPTH  5.0
#define HEIGHT 2.8
#define THICK  0.3
#define SILL   0.45 // of the windows
#define LINTEL 2.45
#define WINDOW 1.7 // wide

static const double windows[2] = {-1.15, 1.15}; // along Z
static const double door_z = 1.5;

static void walls(struct furniture *p)
{
    struct solid *s = furniture_part(p, LOOK_PLASTER);
    const double x = 0.5 * WIDTH + 0.5 * THICK, z = 0.5 * DEPTH + 0.5 * THICK, full = DEPTH + 2 * THICK;
    block(s, x, 0, 0, THICK, HEIGHT, full, 0);
    block(s, 0, 0, -z, WIDTH, HEIGHT, THICK, 0);
    block(s, 0, 0, z, WIDTH, HEIGHT, THICK, 0);
    block(s, -x, 0, 0, THICK, SILL, full, 0); // below and above the windows, and between them
    block(s, -x, LINTEL, 0, THICK, HEIGHT - LINTEL, full, 0);
    double from = -0.5 * full;
    for (int i = 0; i <= 2; i++) {
        double to = i < 2 ? windows[i] - 0.5 * WINDOW : 0.5 * full;
        block(s, -x, SILL, 0.5 * (from + to), THICK, LINTEL - SILL, to - from, 0);
        from = i < 2 ? windows[i] + 0.5 * WINDOW : to;
    }
    block(furniture_part(p, LOOK_CEILING), 0, HEIGHT, 0, WIDTH + 2 * THICK, 0.2, full, 0);
    block(furniture_part(p, LOOK_PARQUET), 0, -0.1, 0, WIDTH, 0.1, DEPTH, 0);
}

// Two casements, a sill, a radiator below.
static void window(struct furniture *p, double z)
{
    struct solid *white = furniture_part(p, LOOK_WHITE);
    const double x = -0.5 * WIDTH - 0.12, high = LINTEL - SILL, leaf = 0.5 * WINDOW - 0.045;
    const struct solid_corner frame[5] = {
        {-0.06, -0.035, 0}, {-0.06, 0.035, 0.006}, {0, 0.035, 0}, {0, -0.035, 0}, {-0.06, -0.035, 0}};
    struct place at = place_turn(place_at(x, SILL + 0.5 * high, z), 'y', QUARTER);
    solid_frame(white, at, WINDOW, high, frame, 5);
    for (int i = 0; i < 2; i++) {
        struct place wing = place_move(at, (i ? 0.5 : -0.5) * (leaf - 0.005), 0, 0.012);
        const struct solid_corner sash[5] = {
            {-0.055, -0.03, 0}, {-0.055, 0.03, 0.01}, {0, 0.03, 0.004}, {0, -0.03, 0}, {-0.055, -0.03, 0}};
        solid_frame(white, wing, leaf - 0.01, high - 0.09, sash, 5);
    }
    struct place grip = place_move(at, 0.0, -0.12, 0.045);
    solid_box(furniture_part(p, LOOK_STEEL), grip, 0.026, 0.07, 0.010, 0.003);
    solid_box(furniture_part(p, LOOK_STEEL), place_move(grip, 0, -0.045, 0.03), 0.016, 0.12, 0.012, 0.004);
    block(white, -0.5 * WIDTH + 0.02, SILL - 0.03, z, 0.24, 0.03, WINDOW + 0.12, 0.006);
    for (int i = 0; i < 9; i++)
        block(white, -0.5 * WIDTH + 0.075, 0.10, z - 0.52 + 0.13 * i, 0.05, 0.28, 0.11, 0.012);
    for (int i = 0; i < 2; i++)
        rod(white, -0.5 * WIDTH + 0.075, i ? 0.355 : 0.125, z - 0.55, -0.5 * WIDTH + 0.075, i ? 0.355 : 0.125,
            z + 0.55, 0.012, 0.012);
}

static void door(struct furniture *p)
{
    struct solid *white = furniture_part(p, LOOK_WHITE), *steel = furniture_part(p, LOOK_STEEL);
    const double x = 0.5 * WIDTH, w = 0.9, h = 2.1;
    struct place at = place_turn(place_at(x, 0.5 * h, door_z), 'y', -QUARTER);
    const struct solid_corner casing[5] = {
        {0, 0, 0}, {0, 0.025, 0.004}, {0.07, 0.025, 0.008}, {0.075, 0.018, 0.003}, {0.075, 0, 0}};
    solid_frame(white, at, w, h, casing, 5); // its lower side lies in the floor
    solid_box(white, place_move(at, 0, 0.004, 0.006), w - 0.006, h - 0.012, 0.016, 0.002);
    const struct solid_corner panel[4] = {
        {0, 0, 0}, {0.008, 0.010, 0.004}, {0.030, 0.010, 0.003}, {0.030, 0, 0}};
    solid_frame(white, place_move(at, 0, 0.47, 0.013), w - 0.34, 0.78, panel, 4);
    solid_frame(white, place_move(at, 0, -0.52, 0.013), w - 0.34, 0.68, panel, 4);
    struct place knob = place_move(at, 0.38, 0.0, 0.014);
    solid_box(steel, knob, 0.04, 0.20, 0.008, 0.003);
    struct place lever = place_move(knob, 0, 0.04, 0);
    const struct solid_bend way[3] = {{0, 0, 0, 0}, {0, 0, 0.05, 0.012}, {-0.12, 0, 0.05, 0}};
    solid_tube(steel, lever, way, 3, 0.009, 0.009, 12);
    solid_box(white, place_turn(place_at(x - 0.005, 1.05, door_z - 0.66), 'y', -QUARTER), 0.08, 0.08, 0.010,
              0.003); // switch
    solid_box(white, place_turn(place_at(x - 0.011, 1.05, door_z - 0.66), 'y', -QUARTER), 0.055, 0.055, 0.006,
              0.002);
}

// Skirting boards, interrupted by the door, and a cornice.
static void mouldings(struct furniture *p)
{
    struct solid *white = furniture_part(p, LOOK_WHITE), *ceiling = furniture_part(p, LOOK_CEILING);
    const double x = 0.5 * WIDTH, z = 0.5 * DEPTH, h = 0.09, t = 0.014, gap = 0.45 + 0.075;
    for (int i = 0; i < 2; i++)
        block(white, 0, 0, (i ? 1 : -1) * (z - 0.5 * t), WIDTH, h, t, 0.004);
    block(white, -x + 0.5 * t, 0, 0, t, h, DEPTH, 0.004);
    block(white, x - 0.5 * t, 0, 0.5 * (-z + door_z - gap), t, h, door_z - gap + z, 0.004);
    block(white, x - 0.5 * t, 0, 0.5 * (z + door_z + gap), t, h, z - door_z - gap, 0.004);
    const struct solid_corner cornice[4] = {
        {0, 0, 0}, {-0.012, 0.05, 0.01}, {-0.055, 0.085, 0.05}, {-0.06, 0.10, 0}};
    // Seen from below and inside: from the wall's foot of the cornice up to the ceiling.
    solid_frame(ceiling, place_turn(place_at(0, HEIGHT - 0.10, 0), 'x', -QUARTER), WIDTH, DEPTH, cornice, 4);
    for (int i = 0; i < 2; i++) // sockets on the far wall
        solid_box(white, place_at(i ? 2.2 : -2.2, 0.3, -z + 0.005), 0.08, 0.08, 0.010, 0.003);
}

static void light(struct furniture *p)
{
    struct glb *g = p->g;
    int sky = glb_add_node(g, &(struct glb_node){.name = "sky", .parent = p->node + 1});
    cJSON *map = glb_component(g, NG_GLTF_NODES, sky, "light_environment");
    glb_set(g, map, "intensity", 3.6);
    glb_set_picture(g, map, "map", "evening.hdr");
    // From the west, 22 degrees high, a little from the north.
    struct place sun = place_turn(place_turn(place_at(0, 3, 0), 'y', -QUARTER - 0.32), 'x', -0.40);
    double q[4];
    place_quaternion(&sun, q);
    int lamp = glb_add_light(g, "sun", "directional", (const double[3]){1.0, 0.84, 0.66}, 15, 0, 0);
    glb_add_node(g, &(struct glb_node){.name = "sun",
                                       .parent = p->node + 1,
                                       .translation = {0, 3, 0},
                                       .rotation = {q[0], q[1], q[2], q[3]},
                                       .light = lamp + 1});
}

static void camera(struct glb *g, const char *name, double x, double y, double z, double yaw, double pitch,
                   double fov)
{
    struct place at = place_turn(place_turn(place_at(x, y, z), 'y', yaw), 'x', pitch);
    double q[4];
    place_quaternion(&at, q);
    glb_add_node(g, &(struct glb_node){.name = name,
                                       .translation = {x, y, z},
                                       .rotation = {q[0], q[1], q[2], q[3]},
                                       .camera = glb_add_camera(g, fov, 0.05) + 1});
}

ng_result room_build(struct bytes *out)
{
    struct glb g;
    struct looks looks = {0};
    struct furniture p;
    glb_init(&g);
    camera(&g, "camera", 2.6, 1.5, 2.25, 0.75, -0.08, 1.05);
    camera(&g, "towards the door", -2.5, 1.5, -2.2, 3.85, -0.08, 1.05);
    furniture_begin(&p, &g, &looks, "room", glb_add_node(&g, &(struct glb_node){.name = "room"}));
    walls(&p);
    for (int i = 0; i < 2; i++)
        window(&p, windows[i]);
    door(&p);
    mouldings(&p);
    light(&p);
    furniture_end(&p);
    return glb_finish(&g, out);
}

ng_result room_sky(struct bytes *out)
{
    return picture_evening(out);
}
