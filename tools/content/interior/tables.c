// Tables, and the bed.
#include "palette.h"

void palette_coffee_table(struct furniture *p)
{
    struct solid *wood = furniture_part(p, LOOK_WALNUT);
    slab(wood, 0, 0.372, 0, 1.15, 0.028, 0.62, 0.14);
    slab(wood, 0, 0.185, 0, 0.86, 0.018, 0.40, 0.08);
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 1.0 : -1.0, z = i & 2 ? 1.0 : -1.0;
        rod(wood, x * 0.40, 0.374, z * 0.175, x * 0.46, 0, z * 0.235, 0.021, 0.013);
    }
}

void palette_side_table(struct furniture *p)
{
    const struct solid_corner top[6] = {{0, 0.505, 0},        {0.19, 0.505, 0.01},  {0.225, 0.515, 0.008},
                                        {0.225, 0.53, 0.006}, {0.215, 0.53, 0.003}, {0, 0.53, 0}};
    solid_turn(furniture_part(p, LOOK_MARBLE), place_at(0, 0, 0), top, 6, 48);
    const struct solid_corner foot[6] = {{0, 0, 0},           {0.15, 0, 0.006},    {0.15, 0.012, 0.006},
                                         {0.014, 0.03, 0.05}, {0.012, 0.49, 0.03}, {0.06, 0.506, 0}};
    solid_turn(furniture_part(p, LOOK_BRASS), place_at(0, 0, 0), foot, 6, 32);
}

void palette_dining_table(struct furniture *p)
{
    struct solid *oak = furniture_part(p, LOOK_OAK);
    const struct solid_corner section[6] = {{-0.45, 0.745, 0.006}, {-0.45, 0.727, 0.006},
                                            {-0.40, 0.708, 0.01},  {0.40, 0.708, 0.01},
                                            {0.45, 0.727, 0.006},  {0.45, 0.745, 0.006}};
    solid_extrude(oak, place_turn(place_at(0, 0, 0), 'y', QUARTER), section, 6, 1.8);
    for (int i = 0; i < 2; i++) {
        double s = i ? 1.0 : -1.0;
        block(oak, s * 0.62, 0.668, 0, 0.07, 0.042, 0.66, 0.006);
        for (int k = 0; k < 2; k++) {
            double t = k ? 1.0 : -1.0;
            rod(oak, s * 0.62, 0.67, t * 0.27, s * 0.72, 0, t * 0.37, 0.032, 0.018);
        }
    }
    block(oak, 0, 0.672, 0, 1.24, 0.034, 0.06, 0.005);
}

// The front of a drawer with a round knob.
static void drawer(struct solid *front, struct solid *knob, double x, double y, double z, double w, double h)
{
    block(front, x, y, z, w, h, 0.02, 0.0025);
    const struct solid_corner turned[5] = {
        {0.006, 0, 0}, {0.006, 0.012, 0.006}, {0.014, 0.016, 0.004}, {0.013, 0.024, 0.003}, {0, 0.025, 0}};
    solid_turn(knob, place_turn(place_at(x, y + 0.5 * h, z + 0.009), 'x', QUARTER), turned, 5, 20);
}

void palette_desk(struct furniture *p)
{
    struct solid *oak = furniture_part(p, LOOK_OAK), *white = furniture_part(p, LOOK_WHITE),
                 *metal = furniture_part(p, LOOK_BLACK_METAL);
    block(oak, 0, 0.715, 0, 1.40, 0.025, 0.68, 0.003);
    for (int i = 0; i < 2; i++) {
        double x = i ? 0.655 : -0.655;
        const struct solid_bend hoop[4] = {
            {x, 0.712, -0.29, 0}, {x, 0.012, -0.29, 0.02}, {x, 0.012, 0.29, 0.02}, {x, 0.712, 0.29, 0}};
        solid_tube(metal, place_at(0, 0, 0), hoop, 4, 0.013, 0.013, 12);
    }
    rod(metal, -0.655, 0.68, -0.27, 0.655, 0.68, -0.27, 0.011, 0.011);
    block(white, 0.40, 0.325, -0.02, 0.40, 0.39, 0.54, 0.002);
    for (int i = 0; i < 3; i++)
        drawer(white, metal, 0.40, 0.331 + 0.128 * i, 0.258, 0.388, 0.124);
}

void palette_bedside_table(struct furniture *p)
{
    struct solid *oak = furniture_part(p, LOOK_OAK);
    block(oak, 0, 0.50, 0, 0.46, 0.02, 0.40, 0.003);
    block(oak, 0, 0.20, 0, 0.46, 0.02, 0.40, 0.003);
    for (int i = 0; i < 2; i++)
        block(oak, i ? 0.22 : -0.22, 0.22, 0, 0.02, 0.28, 0.40, 0.002);
    block(oak, 0, 0.22, -0.19, 0.42, 0.28, 0.012, 0);
    block(oak, 0, 0.345, 0, 0.42, 0.015, 0.385, 0.001);
    drawer(furniture_part(p, LOOK_WHITE), furniture_part(p, LOOK_BRASS), 0, 0.365, 0.185, 0.414, 0.13);
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 1.0 : -1.0, z = i & 2 ? 1.0 : -1.0;
        rod(oak, x * 0.175, 0.20, z * 0.145, x * 0.205, 0, z * 0.175, 0.017, 0.011);
    }
}

void palette_bed(struct furniture *p)
{
    struct solid *oak = furniture_part(p, LOOK_OAK);
    struct cage c = {0};
    for (int i = 0; i < 2; i++)
        block(oak, i ? 0.835 : -0.835, 0.15, 0.01, 0.03, 0.15, 2.06, 0.005);
    block(oak, 0, 0.15, 1.025, 1.64, 0.15, 0.03, 0.005);
    block(oak, 0, 0.15, 0, 1.64, 0.02, 2.02, 0);
    for (int i = 0; i < 4; i++)
        block(oak, i & 1 ? 0.78 : -0.78, 0, i & 2 ? 0.93 : -0.93, 0.06, 0.15, 0.06, 0.006);
    for (int i = 0; i < 3; i++) {
        const double bulge = 0.02;
        soft_cushion(&c, 0.575, 0.10, 0.72, 0.03, bulge, 0.6);
        furniture_soft(p, "head board", &c, LOOK_SAND_CLOTH,
                       place_turn(place_at(0.577 * (i - 1), 0.66, -1.065), 'x', QUARTER - 0.05));
    }
    block(furniture_part(p, LOOK_OAK), 0, 0.0, -1.10, 1.72, 0.95, 0.03, 0.005);
    soft_cushion(&c, 1.60, 0.24, 2.0, 0.05, 0.008, 0.8);
    furniture_soft(p, "mattress", &c, LOOK_LINEN, place_at(0, 0.29, 0.0));
    soft_cover(
        &c, &(struct soft_cover){
                .w = 1.64, .d = 1.48, .drop = 0.26, .front = 0.24, .t = 0.045, .folds = 0.020, .seed = 500});
    furniture_soft(p, "duvet", &c, LOOK_LINEN, place_at(0, 0.405, 0.28));
    soft_cover(
        &c, &(struct soft_cover){
                .w = 1.735, .d = 0.50, .drop = 0.30, .front = 0.0, .t = 0.016, .folds = 0.012, .seed = 511});
    furniture_soft(p, "blanket", &c, LOOK_RUST_CLOTH, place_at(0, 0.465, 0.48));
    for (int i = 0; i < 2; i++) {
        double s = i ? 1.0 : -1.0;
        soft_pillow(&c, 0.70, 0.20, 0.48, 520);
        furniture_soft(p, "pillow", &c, LOOK_LINEN, place_turn(place_at(s * 0.385, 0.55, -0.76), 'x', 0.45));
        soft_pillow(&c, 0.48, 0.17, 0.46, 530);
        furniture_soft(p, "small pillow", &c, LOOK_GREY_CLOTH,
                       place_turn(place_turn(place_at(s * 0.33, 0.59, -0.53), 'y', -s * 0.12), 'x', 0.85));
    }
}
