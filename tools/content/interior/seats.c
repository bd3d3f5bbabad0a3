// What one sits on.
#include "palette.h"

static void cushion_of(struct furniture *p, const char *name, double w, double h, double d, double bulge,
                       enum look look, struct place at)
{
    struct cage c = {0};
    soft_cushion(&c, w, h, d, 0.03, bulge, 0.7);
    furniture_soft(p, name, &c, look, at);
}

// An upholstered box.
static void padded(struct furniture *p, const char *name, double w, double h, double d, double edge,
                   enum look look, struct place at)
{
    struct cage c = {0};
    soft_box(&c, &(struct soft){.size = {w, h, d}, .edge = edge, .cells = {3, 3, 3}});
    furniture_soft(p, name, &c, look, at);
}

static void pillow(struct furniture *p, double size, enum look look, uint64_t seed, struct place at)
{
    struct cage c = {0};
    soft_pillow(&c, size, 0.32 * size, size, seed);
    furniture_soft(p, "pillow", &c, look, at);
}

// Standing on its edge, leaning back by `lean`.
static struct place leaning(double x, double y, double z, double turn, double lean)
{
    return place_turn(place_turn(place_at(x, y, z), 'y', turn), 'x', QUARTER - lean);
}

// Four round legs that spread outwards, under a body of w by d.
static void legs(struct solid *s, double w, double d, double height, double spread, double thick)
{
    for (int i = 0; i < 4; i++) {
        double x = (i & 1 ? 0.5 : -0.5) * w, z = (i & 2 ? 0.5 : -0.5) * d;
        rod(s, x, height, z, x + (x > 0 ? spread : -spread), 0, z + (z > 0 ? spread : -spread), thick,
            0.62 * thick);
    }
}

void palette_sofa(struct furniture *p)
{
    const enum look cloth = LOOK_GREY_CLOTH;
    legs(furniture_part(p, LOOK_OAK), 1.90, 0.66, 0.15, 0.03, 0.024);
    padded(p, "base", 2.02, 0.17, 0.84, 0.025, cloth, place_at(0, 0.215, 0));
    padded(p, "back", 2.20, 0.66, 0.17, 0.055, cloth, place_turn(place_at(0, 0.45, -0.375), 'x', -0.08));
    for (int i = 0; i < 2; i++) {
        double side = i ? 1.0 : -1.0;
        padded(p, "arm", 0.17, 0.48, 0.86, 0.055, cloth, place_at(side * 1.015, 0.37, 0.03));
        cushion_of(p, "seat", 0.925, 0.17, 0.70, 0.030, cloth, place_at(side * 0.465, 0.385, 0.085));
        cushion_of(p, "back cushion", 0.92, 0.18, 0.44, 0.045, cloth,
                   leaning(side * 0.465, 0.665, -0.20, 0, 0.24));
    }
    pillow(p, 0.44, LOOK_RUST_CLOTH, 1, leaning(-0.72, 0.665, -0.02, 0.25, 0.36));
    pillow(p, 0.40, LOOK_SAND_CLOTH, 2, leaning(0.76, 0.645, -0.015, -0.35, 0.42));
}

struct tufts {
    double size[3];
    int columns, rows;
};

// Buttons pull the upper side in.
static struct vec3 tufted(struct vec3 at, struct vec3 unit, const void *user)
{
    const struct tufts *t = user;
    double x = cos(CONTENT_PI * (unit.x + 1) * t->columns), z = cos(CONTENT_PI * (unit.z + 1) * t->rows);
    double border = (1 - pow(unit.x, 8)) * (1 - pow(unit.z, 8));
    if (unit.y > 0)
        at.y += (0.016 - 0.020 * fmax(x + z - 0.6, 0.0)) * border;
    return at;
}

static void tufted_cushion(struct furniture *p, double w, double h, double d, int columns, int rows,
                           enum look look, struct place at)
{
    struct cage c = {0};
    const struct tufts t = {{w, h, d}, columns, rows};
    soft_box(&c, &(struct soft){.size = {w, h, d},
                                .edge = 0.022,
                                .cells = {(uint32_t)columns * 4 + 2, 3, (uint32_t)rows * 4 + 2},
                                .seam = 1.0,
                                .shape = tufted,
                                .user = &t});
    furniture_soft(p, "tufted cushion", &c, look, at);
}

void palette_leather_sofa(struct furniture *p)
{
    struct solid *steel = furniture_part(p, LOOK_STEEL);
    for (int i = 0; i < 2; i++) {
        double x = i ? 0.80 : -0.80;
        const struct solid_bend side[6] = {{x, 0.30, 0.375, 0},      {x, 0.012, 0.375, 0.04},
                                           {x, 0.012, -0.375, 0.04}, {x, 0.60, -0.375, 0.06},
                                           {x, 0.60, 0.375, 0.06},   {x, 0.29, 0.375, 0}};
        solid_tube(steel, place_at(0, 0, 0), side, 6, 0.0125, 0.0125, 12);
        tufted_cushion(p, 0.74, 0.15, 0.68, 2, 2, LOOK_COGNAC_LEATHER,
                       place_at(i ? 0.375 : -0.375, 0.355, 0.045));
        tufted_cushion(p, 0.74, 0.13, 0.42, 2, 1, LOOK_COGNAC_LEATHER,
                       leaning(i ? 0.375 : -0.375, 0.62, -0.27, 0, 0.15));
        padded(p, "arm", 0.05, 0.24, 0.66, 0.02, LOOK_COGNAC_LEATHER,
               place_at(i ? 0.767 : -0.767, 0.46, 0.0));
        rod(steel, -0.80, 0.26, i ? 0.33 : -0.33, 0.80, 0.26, i ? 0.33 : -0.33, 0.0125, 0.0125);
    }
    rod(steel, -0.80, 0.60, -0.375, 0.80, 0.60, -0.375, 0.0125, 0.0125);
    block(furniture_part(p, LOOK_BLACK_METAL), 0, 0.255, 0.0, 1.52, 0.022, 0.68, 0.004);
}

void palette_armchair(struct furniture *p)
{
    struct solid *oak = furniture_part(p, LOOK_OAK);
    for (int i = 0; i < 2; i++) {
        double s = i ? 1.0 : -1.0;
        rod(oak, s * 0.325, 0.565, 0.30, s * 0.335, 0, 0.345, 0.020, 0.015);
        rod(oak, s * 0.325, 0.560, -0.30, s * 0.335, 0, -0.40, 0.020, 0.015);
        struct place arm = place_turn(place_at(s * 0.328, 0.572, -0.02), 'x', 0.06);
        const struct solid_corner paddle[5] = {{-0.026, -0.36, 0.02},
                                               {0.026, -0.36, 0.02},
                                               {0.036, 0.30, 0.03},
                                               {0.0, 0.36, 0.05},
                                               {-0.036, 0.30, 0.03}};
        solid_extrude(oak, place_turn(arm, 'x', QUARTER), paddle, 5, 0.022);
        rod(oak, s * 0.28, 0.30, 0.33, s * 0.28, 0.225, -0.36, 0.017, 0.017);
        rod(oak, s * 0.25, 0.235, -0.30, s * 0.25, 0.83, -0.44, 0.016, 0.013);
    }
    rod(oak, -0.335, 0.298, 0.322, 0.335, 0.298, 0.322, 0.017, 0.017);
    rod(oak, -0.335, 0.235, -0.345, 0.335, 0.235, -0.345, 0.017, 0.017);
    for (int i = 0; i < 5; i++) {
        double y = 0.36 + 0.105 * i;
        rod(oak, -0.25, y, -0.33 - 0.025 * i, 0.25, y, -0.33 - 0.025 * i, 0.009, 0.009);
    }
    cushion_of(p, "seat", 0.56, 0.13, 0.60, 0.035, LOOK_SAND_CLOTH,
               place_turn(place_at(0, 0.362, 0.01), 'x', -0.105));
    cushion_of(p, "back cushion", 0.55, 0.13, 0.50, 0.040, LOOK_SAND_CLOTH,
               leaning(0, 0.66, -0.275, 0, 0.235));
}

struct bend {
    double radius;
    double high; // of the back above the arms
};

// The strip's width goes around a circle; it is highest in the middle.
static struct vec3 bent(struct vec3 at, struct vec3 unit, const void *user)
{
    const struct bend *b = user;
    double angle = at.x / b->radius, r = b->radius - at.z;
    double up = unit.y > 0 ? b->high * 0.5 * (1 + cos(CONTENT_PI * fmin(fabs(unit.x) * 1.05, 1.0))) : 0.0;
    double lean = 1.0 + 0.10 * (at.y + up) / 0.4;
    return vec3_make(r * lean * sin(angle), at.y + up, -r * lean * cos(angle));
}

void palette_tub_chair(struct furniture *p)
{
    const struct bend b = {0.325, 0.16};
    struct cage shell = {0};
    soft_box(&shell,
             &(struct soft){
                 .size = {1.52, 0.44, 0.095}, .edge = 0.035, .cells = {16, 3, 3}, .shape = bent, .user = &b});
    furniture_soft(p, "shell", &shell, LOOK_BLUE_CLOTH, place_at(0, 0.36, 0));
    struct cage base = {0};
    soft_box(&base, &(struct soft){
                        .size = {0.60, 0.14, 0.60}, .edge = 0.03, .cells = {7, 3, 7}, .shape = soft_round});
    furniture_soft(p, "base", &base, LOOK_BLUE_CLOTH, place_at(0, 0.215, 0.02));
    struct cage seat = {0};
    const double bulge = 0.03;
    soft_box(&seat, &(struct soft){.size = {0.575, 0.15, 0.64},
                                   .edge = 0.035,
                                   .cells = {7, 3, 7},
                                   .seam = 0.8,
                                   .shape = soft_round,
                                   .user = &bulge});
    furniture_soft(p, "seat", &seat, LOOK_BLUE_CLOTH, place_at(0, 0.355, 0.055));
    legs(furniture_part(p, LOOK_WALNUT), 0.40, 0.40, 0.16, 0.035, 0.02);
}

void palette_pouf(struct furniture *p)
{
    const double bulge = 0.035;
    struct cage c = {0};
    soft_box(&c, &(struct soft){.size = {0.55, 0.36, 0.55},
                                .edge = 0.06,
                                .cells = {7, 4, 7},
                                .seam = 0.5,
                                .shape = soft_round,
                                .user = &bulge});
    furniture_soft(p, "pouf", &c, LOOK_RUST_CLOTH, place_at(0, 0.21, 0));
}

void palette_dining_chair(struct furniture *p)
{
    struct solid *oak = furniture_part(p, LOOK_OAK);
    for (int i = 0; i < 2; i++) {
        double s = i ? 1.0 : -1.0;
        rod(oak, s * 0.185, 0.435, 0.175, s * 0.215, 0, 0.215, 0.018, 0.012);
        const struct solid_bend post[3] = {
            {s * 0.205, 0, -0.25, 0}, {s * 0.185, 0.43, -0.19, 0.5}, {s * 0.175, 0.80, -0.255, 0}};
        solid_tube(oak, place_at(0, 0, 0), post, 3, 0.014, 0.012, 14);
        rod(oak, s * 0.198, 0.26, 0.195, s * 0.196, 0.26, -0.213, 0.009, 0.009);
    }
    slab(oak, 0, 0.418, -0.005, 0.44, 0.024, 0.43, 0.07);
    rod(oak, -0.19, 0.385, 0.178, 0.19, 0.385, 0.178, 0.012, 0.012);
    rod(oak, -0.185, 0.385, -0.195, 0.185, 0.385, -0.195, 0.012, 0.012);
    const struct bend b = {0.42, 0.02};
    struct cage rest = {0};
    soft_box(&rest,
             &(struct soft){
                 .size = {0.46, 0.15, 0.022}, .edge = 0.01, .cells = {8, 3, 3}, .shape = bent, .user = &b});
    furniture_soft(p, "back rest", &rest, LOOK_OAK, place_turn(place_at(0, 0.72, 0.175), 'x', -0.12));
    cushion_of(p, "seat", 0.41, 0.045, 0.40, 0.016, LOOK_GREY_CLOTH, place_at(0, 0.462, 0.0));
}

void palette_bar_stool(struct furniture *p)
{
    struct solid *metal = furniture_part(p, LOOK_BLACK_METAL);
    const struct solid_corner seat[5] = {
        {0, 0.648, 0}, {0.155, 0.648, 0.012}, {0.172, 0.690, 0.014}, {0.15, 0.688, 0.05}, {0, 0.672, 0}};
    solid_turn(furniture_part(p, LOOK_OAK), place_at(0, 0, 0), seat, 5, 32);
    for (int i = 0; i < 4; i++) {
        double angle = QUARTER * (i + 0.5), x = sin(angle), z = cos(angle);
        rod(metal, 0.11 * x, 0.65, 0.11 * z, 0.235 * x, 0, 0.235 * z, 0.011, 0.011);
    }
    ring(metal, 0, 0.24, 0, 0.192, 0.009);
}

void palette_bench(struct furniture *p)
{
    struct solid *metal = furniture_part(p, LOOK_BLACK_METAL);
    for (int i = 0; i < 2; i++) {
        double x = i ? 0.52 : -0.52;
        const struct solid_bend hoop[4] = {
            {x, 0.40, -0.16, 0}, {x, 0.012, -0.16, 0.03}, {x, 0.012, 0.16, 0.03}, {x, 0.40, 0.16, 0}};
        solid_tube(metal, place_at(0, 0, 0), hoop, 4, 0.012, 0.012, 12);
    }
    block(furniture_part(p, LOOK_WALNUT), 0, 0.395, 0, 1.25, 0.03, 0.38, 0.004);
    cushion_of(p, "pad", 1.22, 0.06, 0.36, 0.014, LOOK_COGNAC_LEATHER, place_at(0, 0.456, 0));
}

// A five-armed foot on castors.
static void star_base(struct furniture *p)
{
    struct solid *metal = furniture_part(p, LOOK_STEEL), *plastic = furniture_part(p, LOOK_PLASTIC);
    for (int i = 0; i < 5; i++) {
        double angle = 2 * CONTENT_PI * i / 5 + 0.3;
        struct place arm = place_turn(place_at(0, 0, 0), 'y', angle);
        const struct solid_bend way[3] = {{0, 0.125, 0.02, 0}, {0, 0.105, 0.16, 0.2}, {0, 0.072, 0.31, 0}};
        solid_tube(metal, arm, way, 3, 0.024, 0.014, 14);
        rod(metal, 0.30 * sin(angle), 0.085, 0.30 * cos(angle), 0.30 * sin(angle), 0.035, 0.30 * cos(angle),
            0.006, 0.006);
        for (int k = 0; k < 2; k++) {
            struct place wheel = place_turn(place_move(arm, k ? 0.006 : -0.028, 0.028, 0.315), 'z', -QUARTER);
            solid_cylinder(plastic, wheel, 0.028, 0.022, 0.006, 16);
        }
    }
    solid_cylinder(metal, place_at(0, 0.085, 0), 0.034, 0.06, 0.008, 18);
    solid_cylinder(plastic, place_at(0, 0.14, 0), 0.026, 0.14, 0.003, 16);
    solid_cylinder(metal, place_at(0, 0.25, 0), 0.014, 0.15, 0.0, 20);
}

struct dish {
    double across, along; // how much the borders come towards the sitter
};

static struct vec3 dished(struct vec3 at, struct vec3 unit, const void *user)
{
    const struct dish *d = user;
    at.y += d->across * unit.x * unit.x + d->along * unit.z * unit.z * unit.z * (unit.z > 0 ? -1 : 0.2);
    return at;
}

void palette_office_chair(struct furniture *p)
{
    struct solid *plastic = furniture_part(p, LOOK_PLASTIC);
    star_base(p);
    block(plastic, 0, 0.385, -0.02, 0.24, 0.045, 0.30, 0.012);
    const struct dish seat = {0.012, 0.035}, back = {0.045, 0.0};
    struct cage c = {0};
    soft_box(
        &c,
        &(struct soft){
            .size = {0.50, 0.075, 0.48}, .edge = 0.03, .cells = {7, 3, 7}, .shape = dished, .user = &seat});
    furniture_soft(p, "seat", &c, LOOK_GREY_CLOTH, place_at(0, 0.463, 0.0));
    soft_box(
        &c,
        &(struct soft){
            .size = {0.46, 0.05, 0.56}, .edge = 0.022, .cells = {7, 3, 7}, .shape = dished, .user = &back});
    furniture_soft(p, "back", &c, LOOK_GREY_CLOTH, leaning(0, 0.85, -0.275, 0, 0.16));
    const struct solid_bend spine[4] = {
        {0, 0.40, -0.10, 0}, {0, 0.41, -0.30, 0.08}, {0, 0.66, -0.295, 0.3}, {0, 0.90, -0.325, 0}};
    solid_tube(plastic, place_at(0, 0, 0), spine, 4, 0.026, 0.016, 16);
    for (int i = 0; i < 2; i++) {
        double s = i ? 1.0 : -1.0;
        const struct solid_bend arm[3] = {
            {s * 0.10, 0.405, -0.03, 0}, {s * 0.285, 0.405, -0.03, 0.05}, {s * 0.295, 0.645, -0.02, 0}};
        solid_tube(plastic, place_at(0, 0, 0), arm, 3, 0.015, 0.013, 14);
        block(plastic, s * 0.295, 0.64, 0.0, 0.085, 0.028, 0.25, 0.012);
    }
}
