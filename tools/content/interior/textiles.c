// Rugs, curtains, baskets.
#include "palette.h"

struct carpet {
    uint64_t seed;
};

static struct vec3 lie(struct vec3 at, struct vec3 unit, const void *user)
{
    NG_UNUSED(user);
    at.y -= (unit.y > 0 ? 0.004 : 0.0) * pow(fmax(fabs(unit.x), fabs(unit.z)), 20);
    return at;
}

// Texture coordinates of a rug run over all of it, from 0 to 1.
static void lay(struct furniture *p, struct cage *c, double w, double d, enum look look, double height)
{
    for (size_t i = 0; i < c->uvs.count; i++) {
        c->uvs.items[i].u += 0.5 * w;
        c->uvs.items[i].v += 0.5 * d;
    }
    furniture_soft(p, "rug", c, look, place_at(0, 0.5 * height, 0));
}

void palette_rug(struct furniture *p)
{
    struct cage c = {0};
    soft_box(&c, &(struct soft){.size = {2.4, 0.018, 1.7}, .edge = 0.012, .cells = {6, 3, 5}, .shape = lie});
    lay(p, &c, 2.4, 1.7, LOOK_RUG, 0.018);
}

void palette_round_rug(struct furniture *p)
{
    struct cage c = {0};
    soft_box(&c, &(struct soft){
                     .size = {1.8, 0.014, 1.8}, .edge = 0.012, .cells = {10, 3, 10}, .shape = soft_round});
    // The picture is of the disk, not of the square that it was.
    for (size_t i = 0; i < c.uvs.count; i++) {
        struct vec3 q = c.points.items[c.indices.items[i]];
        c.uvs.items[i].u = q.x;
        c.uvs.items[i].v = q.z;
    }
    lay(p, &c, 1.8, 1.8, LOOK_ROUND_RUG, 0.014);
}

// A pleated panel: folds that are narrow above and swing wider below.
struct panel {
    double x, width, height;
    uint64_t seed;
};

static struct vec3 pleats(double u, double v, const void *user)
{
    const struct panel *p = user;
    double fold = 9.0, sway = 0.5 + 0.5 * (1 - v);
    double phase = 2 * CONTENT_PI * (u * fold + 0.25 * sin(5.0 * u + (double)p->seed) * (1 - v));
    double x = p->x + (u - 0.5) * p->width + 0.010 * sway * sin(2 * phase);
    double depth = 0.042 * (0.65 + 0.35 * sway) * sin(phase) + 0.012 * (1 - v) * sin(2.3 * u * fold + 1.7);
    return vec3_make(x, v * p->height + 0.015, 0.09 + depth);
}

void palette_curtains(struct furniture *p)
{
    struct solid *veil = furniture_part(p, LOOK_VEIL), *metal = furniture_part(p, LOOK_BLACK_METAL);
    const double rail = 2.45;
    for (int i = 0; i < 2; i++) {
        double s = i ? 1.0 : -1.0;
        const struct panel panel = {s * 0.92, 0.72, rail - 0.05, 3 + (uint64_t)i * 4};
        solid_sheet(veil, place_at(0, 0, 0), pleats, &panel, 108, 6, 1.3, rail);
        solid_cylinder(metal, place_turn(place_at(s * 1.34, rail, 0.09), 'z', -s * QUARTER), 0.02, 0.03,
                       0.008, 16);
        rod(metal, s * 1.2, rail, 0.09, s * 1.2, rail, 0.004, 0.008, 0.008);
        solid_cylinder(metal, place_turn(place_at(s * 1.2, rail, 0), 'x', QUARTER), 0.025, 0.008, 0.003, 16);
        for (int k = 0; k < 9; k++) {
            struct place at = place_at(s * 0.92 - 0.32 + 0.08 * k, rail - 0.005, 0.09);
            struct place upright = place_turn(at, 'z', QUARTER);
            struct solid_bend way[9];
            for (int n = 0; n < 9; n++)
                way[n] = (struct solid_bend){0.021 * cos(CONTENT_PI * n / 4), 0,
                                             0.021 * sin(CONTENT_PI * n / 4), 0};
            solid_tube(metal, upright, way, 9, 0.0025, 0.0025, 5);
        }
    }
    rod(metal, -1.34, rail, 0.09, 1.34, rail, 0.09, 0.012, 0.012);
}

void palette_cushion(struct furniture *p)
{
    struct cage c = {0};
    soft_pillow(&c, 0.45, 0.16, 0.45, 700);
    furniture_soft(p, "pillow", &c, LOOK_BLUE_CLOTH, place_at(0, 0.075, 0));
}

static struct vec3 folded(struct vec3 at, struct vec3 unit, const void *user)
{
    NG_UNUSED(user);
    at.y += 0.05 * (1 - unit.x * unit.x) + 0.012 * sin(9 * at.x + 4 * at.z) +
            0.07 * unit.z * (unit.y > 0 ? 1 : 0.6);
    return at;
}

void palette_basket(struct furniture *p)
{
    const struct solid_corner wall[6] = {
        {0, 0, 0},      {0.17, 0, 0.03}, {0.215, 0.34, 0.4}, {0.215, 0.352, 0.006}, {0.200, 0.352, 0.006},
        {0.16, 0.03, 0}};
    solid_turn(furniture_part(p, LOOK_WICKER), place_at(0, 0, 0), wall, 6, 32);
    struct solid *wicker = furniture_part(p, LOOK_WICKER);
    ring(wicker, 0, 0.348, 0, 0.208, 0.011);
    for (int i = 0; i < 2; i++) {
        double s = i ? 1.0 : -1.0;
        const struct solid_bend grip[4] = {{s * 0.208, 0.34, -0.07, 0},
                                           {s * 0.225, 0.43, -0.055, 0.04},
                                           {s * 0.225, 0.43, 0.055, 0.04},
                                           {s * 0.208, 0.34, 0.07, 0}};
        solid_tube(wicker, place_at(0, 0, 0), grip, 4, 0.008, 0.008, 10);
    }
    struct cage c = {0};
    soft_box(&c,
             &(struct soft){.size = {0.32, 0.16, 0.24}, .edge = 0.05, .cells = {8, 3, 6}, .shape = folded});
    furniture_soft(p, "blanket", &c, LOOK_LINEN, place_turn(place_at(0, 0.30, 0), 'y', 0.4));
}
