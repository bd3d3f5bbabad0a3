// Lamps. Each has light of one type of the engine; its radiance lights a room of some 30 m2 together with two
// or three others at exposure 1.
#include "palette.h"

// A conical shade, open above and below, that glows: the light is its mesh. Its bottom is at y.
struct cone {
    double low, high, height;
};

static struct vec3 cone_surface(double u, double v, const void *user)
{
    const struct cone *c = user;
    double angle = 2 * CONTENT_PI * u, r = c->low + (c->high - c->low) * v;
    return vec3_make(r * sin(angle), v * c->height, r * cos(angle));
}

static void shade(struct furniture *p, double y, double low, double high, double height)
{
    const struct cone c = {low, high, height};
    solid_sheet(furniture_part(p, LOOK_SHADE), place_at(0, y, 0), cone_surface, &c, 32, 4, 1, 1);
    struct solid *metal = furniture_part(p, LOOK_BRASS);
    ring(metal, 0, y, 0, low, 0.003); // the hems
    ring(metal, 0, y + height, 0, high, 0.003);
    for (int i = 0; i < 3; i++) {
        double angle = 2 * CONTENT_PI * i / 3;
        rod(metal, 0, y + height - 0.01, 0, high * sin(angle), y + height - 0.002, high * cos(angle), 0.0025,
            0.0025);
    }
}

void palette_floor_lamp(struct furniture *p)
{
    struct solid *brass = furniture_part(p, LOOK_BRASS);
    const struct solid_corner foot[4] = {
        {0, 0, 0}, {0.15, 0, 0.004}, {0.15, 0.018, 0.006}, {0.011, 0.024, 0.004}};
    solid_turn(furniture_part(p, LOOK_BLACK_METAL), place_at(0, 0, 0), foot, 4, 36);
    rod(brass, 0, 0.02, 0, 0, 1.55, 0, 0.010, 0.010);
    shade(p, 1.25, 0.22, 0.19, 0.32);
}

void palette_bedside_lamp(struct furniture *p)
{
    const struct solid_corner body[6] = {{0, 0, 0},          {0.062, 0, 0.008},    {0.088, 0.07, 0.07},
                                         {0.05, 0.15, 0.06}, {0.016, 0.185, 0.02}, {0.014, 0.20, 0}};
    solid_turn(furniture_part(p, LOOK_CERAMIC), place_at(0, 0, 0), body, 6, 32);
    rod(furniture_part(p, LOOK_BRASS), 0, 0.195, 0, 0, 0.385, 0, 0.007, 0.007);
    shade(p, 0.22, 0.135, 0.105, 0.18);
}

// A globe of opal glass: a sphere light.
static void globe(struct furniture *p, double x, double y, double z, double radius, double radiance)
{
    cJSON *light = furniture_light(p, "light_sphere", place_at(x, y, z), light_soft);
    glb_set(p->g, light, "radius", radius);
    glb_set(p->g, light, "radiance", radiance);
}

void palette_table_lamp(struct furniture *p)
{
    const struct solid_corner foot[5] = {
        {0, 0, 0}, {0.075, 0, 0.004}, {0.075, 0.03, 0.01}, {0.012, 0.036, 0.01}, {0.010, 0.13, 0}};
    solid_turn(furniture_part(p, LOOK_MARBLE), place_at(0, 0, 0), foot, 4, 32);
    rod(furniture_part(p, LOOK_BRASS), 0, 0.03, 0, 0, 0.16, 0, 0.009, 0.009);
    const struct solid_corner holder[4] = {
        {0.009, 0.145, 0}, {0.045, 0.152, 0.006}, {0.052, 0.175, 0.006}, {0.046, 0.18, 0}};
    solid_turn(furniture_part(p, LOOK_BRASS), place_at(0, 0, 0), holder, 4, 24);
    globe(p, 0, 0.26, 0, 0.10, 14);
}

void palette_globe_pendant(struct furniture *p)
{
    struct solid *brass = furniture_part(p, LOOK_BRASS), *cord = furniture_part(p, LOOK_BLACK_METAL);
    solid_cylinder(brass, place_at(0, -0.03, 0), 0.13, 0.03, 0.006, 32);
    static const double at[3][3] = {{-0.09, -0.62, 0.03}, {0.09, -0.88, 0.05}, {0.0, -1.18, -0.07}};
    for (int i = 0; i < 3; i++) {
        const double *q = at[i];
        rod(cord, q[0], -0.02, q[2], q[0], q[1] + 0.10, q[2], 0.0025, 0.0025);
        const struct solid_corner cap[5] = {{0.040, -0.006, 0},
                                            {0.040, 0.012, 0.006},
                                            {0.012, 0.018, 0.006},
                                            {0.010, 0.06, 0.003},
                                            {0, 0.06, 0}};
        solid_turn(brass, place_at(q[0], q[1] + 0.070, q[2]), cap, 5, 24);
        globe(p, q[0], q[1], q[2], 0.08, 18);
    }
}

// A spun dome with a white inside; a disk of light closes it. Its rim is at the place's origin, it opens to
// -Y.
static void dome(struct furniture *p, struct place at, double radius, double height, enum look outside,
                 double radiance)
{
    const struct solid_corner outer[5] = {{radius - 0.003, 0.0, 0},
                                          {radius, 0.0, 0.001},
                                          {radius * 0.96, height * 0.55, radius * 0.7},
                                          {radius * 0.18, height, radius * 0.3},
                                          {0.0, height, 0}};
    solid_turn(furniture_part(p, outside), at, outer, 5, 36);
    const struct solid_corner inner[4] = {{0, height * 0.45, 0},
                                          {radius * 0.6, height * 0.42, radius * 0.2},
                                          {radius * 0.955, height * 0.12, 0},
                                          {radius - 0.003, 0, 0}};
    struct solid_corner down[4];
    for (int i = 0; i < 4; i++) // the inside is seen from below: drawn from its top to its rim
        down[i] = inner[i];
    solid_turn(furniture_part(p, LOOK_WHITE), at, down, 4, 36);
    struct place disk = place_turn(place_move(at, 0, height * 0.13, 0), 'x', -QUARTER);
    cJSON *light = furniture_light(p, "light_disk", disk, light_warm);
    glb_set(p->g, light, "radius", radius * 0.93);
    glb_set(p->g, light, "radiance", radiance);
}

void palette_pendant(struct furniture *p)
{
    struct solid *metal = furniture_part(p, LOOK_BLACK_METAL);
    solid_cylinder(metal, place_at(0, -0.022, 0), 0.05, 0.022, 0.005, 24);
    rod(metal, 0, -0.02, 0, 0, -1.0, 0, 0.0028, 0.0028);
    const struct solid_corner cap[4] = {
        {0.035, -1.06, 0}, {0.022, -1.0, 0.01}, {0.008, -0.98, 0.004}, {0, -0.98, 0}};
    solid_turn(furniture_part(p, LOOK_BRASS), place_at(0, 0, 0), cap, 4, 32);
    dome(p, place_at(0, -1.27, 0), 0.22, 0.215, LOOK_SAGE, 14);
}

void palette_arc_lamp(struct furniture *p)
{
    struct solid *steel = furniture_part(p, LOOK_STEEL);
    block(furniture_part(p, LOOK_MARBLE), -0.75, 0, 0, 0.24, 0.16, 0.32, 0.012);
    const struct solid_bend bow[4] = {
        {-0.75, 0.10, 0, 0}, {-0.75, 2.05, 0, 0.75}, {0.45, 2.05, 0, 0.9}, {0.75, 1.74, 0, 0}};
    solid_tube(steel, place_at(0, 0, 0), bow, 4, 0.014, 0.009, 18);
    dome(p, place_at(0.75, 1.56, 0), 0.17, 0.165, LOOK_STEEL, 20);
    rod(steel, 0.75, 1.70, 0, 0.75, 1.745, 0, 0.016, 0.012);
}

void palette_desk_lamp(struct furniture *p)
{
    struct solid *metal = furniture_part(p, LOOK_BLACK_METAL), *brass = furniture_part(p, LOOK_BRASS);
    const struct solid_corner foot[4] = {
        {0, 0, 0}, {0.09, 0, 0.004}, {0.09, 0.018, 0.006}, {0.012, 0.022, 0}};
    solid_turn(metal, place_at(-0.18, 0, 0), foot, 4, 28);
    rod(metal, -0.18, 0.02, 0, -0.18, 0.06, 0, 0.011, 0.011);
    rod(metal, -0.18, 0.05, 0, -0.29, 0.36, 0, 0.007, 0.007);
    rod(metal, -0.29, 0.36, 0, 0.10, 0.47, 0, 0.007, 0.007);
    static const double joints[3][2] = {{-0.18, 0.055}, {-0.29, 0.36}, {0.10, 0.47}};
    for (int i = 0; i < 3; i++)
        solid_cylinder(brass, place_turn(place_at(joints[i][0], joints[i][1], -0.014), 'x', QUARTER), 0.014,
                       0.028, 0.003, 16);
    // The head looks down and forwards along +X.
    struct place head = place_turn(place_at(0.10, 0.465, 0), 'z', 0.35);
    const struct solid_corner hood[7] = {
        {0.060, -0.105, 0},    {0.064, -0.105, 0.001}, {0.052, -0.045, 0.02}, {0.022, -0.025, 0.012},
        {0.018, 0.012, 0.008}, {0.008, 0.016, 0.004},  {0, 0.016, 0}};
    solid_turn(metal, head, hood, 7, 28);
    const struct solid_corner inside[4] = {
        {0, -0.045, 0}, {0.046, -0.050, 0.01}, {0.058, -0.09, 0}, {0.060, -0.105, 0}};
    solid_turn(furniture_part(p, LOOK_WHITE), head, inside, 4, 28);
    furniture_spot(p, place_turn(place_move(head, 0, -0.06, 0), 'x', -QUARTER), light_soft, 4.0, 0.45, 0.85);
}

// Half a globe a turn: a sphere of paper, a little flat, open below and above.
static struct vec3 lantern_surface(double u, double v, const void *user)
{
    double r = *(const double *)user, angle = 2 * CONTENT_PI * u, up = (v - 0.5) * 0.90 * CONTENT_PI;
    double rib = 1 + 0.012 * cos(2 * CONTENT_PI * v * 7);
    return vec3_make(r * rib * cos(up) * sin(angle), 0.88 * r * sin(up), r * rib * cos(up) * cos(angle));
}

void palette_paper_lantern(struct furniture *p)
{
    const double radius = 0.25;
    struct solid *metal = furniture_part(p, LOOK_BLACK_METAL);
    solid_cylinder(metal, place_at(0, -0.022, 0), 0.045, 0.022, 0.005, 32);
    rod(metal, 0, -0.02, 0, 0, -0.46, 0, 0.0025, 0.0025);
    solid_sheet(furniture_part(p, LOOK_LANTERN), place_at(0, -0.68, 0), lantern_surface, &radius, 28, 28, 1,
                1);
    ring(metal, 0, -0.68 + 0.217, 0, 0.040, 0.0022);
    ring(metal, 0, -0.68 - 0.217, 0, 0.040, 0.0022);
    rod(metal, -0.04, -0.463, 0, 0.04, -0.463, 0, 0.002, 0.002);
}

void palette_ceiling_panel(struct furniture *p)
{
    const struct solid_corner frame[5] = {
        {0, -0.006, 0}, {0, 0.0, 0.001}, {0.015, 0.0, 0.003}, {0.015, -0.045, 0}, {0.014, -0.045, 0}};
    // The frame's front looks down.
    solid_frame(furniture_part(p, LOOK_WHITE), place_turn(place_at(0, -0.045, 0), 'x', QUARTER), 1.17, 0.57,
                frame, 4);
    cJSON *light = furniture_light(p, "light_rectangle", place_down(0, -0.041, 0), light_neutral);
    glb_set_list(p->g, light, "size", (const double[2]){1.17, 0.57}, 2);
    glb_set(p->g, light, "radiance", 9);
}

void palette_spot_rail(struct furniture *p)
{
    struct solid *metal = furniture_part(p, LOOK_BLACK_METAL);
    block(metal, 0, -0.03, 0, 1.2, 0.03, 0.035, 0.004);
    for (int i = 0; i < 3; i++) {
        double x = 0.45 * (i - 1);
        rod(metal, x, -0.03, 0, x, -0.085, 0, 0.008, 0.008);
        struct place head = place_turn(place_turn(place_at(x, -0.10, 0), 'y', 0.5 * (i - 1)), 'x', -0.55);
        const struct solid_corner can[6] = {{0.030, -0.10, 0},    {0.034, -0.10, 0.001},
                                            {0.034, 0.04, 0.008}, {0.012, 0.044, 0.004},
                                            {0.01, 0.044, 0},     {0, 0.044, 0}};
        solid_turn(metal, head, can, 6, 24);
        const struct solid_corner inside[3] = {{0, -0.06, 0}, {0.028, -0.062, 0.004}, {0.030, -0.10, 0}};
        solid_turn(furniture_part(p, LOOK_STEEL), head, inside, 3, 24);
        furniture_spot(p, place_turn(place_move(head, 0, -0.075, 0), 'x', -QUARTER), light_neutral, 7.0, 0.3,
                       0.62);
    }
}

void palette_wall_lamp(struct furniture *p)
{
    struct solid *brass = furniture_part(p, LOOK_BRASS);
    block(brass, 0, -0.05, 0.006, 0.07, 0.10, 0.012, 0.003);
    rod(brass, 0, 0, 0.01, 0, 0, 0.06, 0.008, 0.008);
    const struct solid_corner tube[5] = {
        {0.036, -0.11, 0}, {0.040, -0.11, 0.001}, {0.040, 0.11, 0.001}, {0.036, 0.11, 0}, {0.036, 0.109, 0}};
    solid_turn(brass, place_at(0, 0, 0.095), tube, 5, 28);
    for (int i = 0; i < 2; i++) {
        struct place end = place_turn(place_at(0, 0, 0.095), 'x', i ? 2 * QUARTER : 0);
        const struct solid_corner inside[3] = {{0, -0.055, 0}, {0.035, -0.057, 0.003}, {0.0365, -0.11, 0}};
        solid_turn(furniture_part(p, LOOK_WHITE), end, inside, 3, 24);
        furniture_spot(p, place_turn(place_move(end, 0, -0.07, 0), 'x', -QUARTER), light_warm, 3.2, 0.35,
                       0.72);
    }
}
