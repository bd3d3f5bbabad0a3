// Shelves, cupboards, the kitchen.
#include "palette.h"
#include "picture.h"

// ---- books ----

// A book that stands, its spine to +Z: three boards of cloth with a picture on the spine, and pages.
static void book(struct furniture *p, struct place at, int cloth, double w, double h, double d)
{
    struct solid *cover = furniture_part(p, LOOK_SPINES), *pages = furniture_part(p, LOOK_PAPER);
    double u0 = (cloth + 0.02) / 16.0, u1 = (cloth + 0.98) / 16.0, plain = (cloth + 0.1) / 16.0;
    const struct vec3 box[6][4] = {
        {{-0.5, 0, 0.5}, {0.5, 0, 0.5}, {0.5, 1, 0.5}, {-0.5, 1, 0.5}}, // spine
        {{0.5, 0, 0.5}, {0.5, 0, -0.5}, {0.5, 1, -0.5}, {0.5, 1, 0.5}}, // sides
        {{-0.5, 0, -0.5}, {-0.5, 0, 0.5}, {-0.5, 1, 0.5}, {-0.5, 1, -0.5}},
        {{-0.5, 1, 0.5}, {0.5, 1, 0.5}, {0.5, 1, -0.5}, {-0.5, 1, -0.5}}, // the pages: above, below, behind
        {{-0.5, 0, -0.5}, {0.5, 0, -0.5}, {0.5, 0, 0.5}, {-0.5, 0, 0.5}},
        {{0.5, 0, -0.5}, {-0.5, 0, -0.5}, {-0.5, 1, -0.5}, {0.5, 1, -0.5}}};
    static const struct vec3 normals[6] = {{0, 0, 1}, {1, 0, 0},  {-1, 0, 0},
                                           {0, 1, 0}, {0, -1, 0}, {0, 0, -1}};
    for (int side = 0; side < 6; side++) {
        struct solid *s = side < 3 ? cover : pages;
        uint32_t first = (uint32_t)s->vertices.count;
        for (int k = 0; k < 4; k++) {
            struct vec3 q = {box[side][k].x * w, box[side][k].y * (side < 3 ? h : h - 0.004),
                             box[side][k].z * d};
            double u = side ? plain : k == 0 || k == 3 ? u0 : u1;
            solid_vertex(s, &at, q, normals[side], u, side ? 0.04 : 1.0 - box[side][k].y);
        }
        solid_quad(s, first, first + 1, first + 2, first + 3);
    }
}

// Books side by side from x to `end`, the last ones leaning.
static void row_of_books(struct furniture *p, double x, double end, double y, double z, uint64_t seed)
{
    for (uint64_t i = 0; x < end; i++) {
        double w = 0.014 + 0.034 * solid_random(seed, 3 * i), h = 0.19 + 0.09 * solid_random(seed, 3 * i + 1);
        double d = 0.14 + 0.05 * solid_random(seed, 3 * i + 2);
        if (x + w > end)
            break;
        book(p, place_at(x + 0.5 * w, y, z - 0.5 * d), (int)(16 * solid_random(seed + 1, i)), w, h, d);
        x += w + 0.0008;
    }
}

static void lying_books(struct furniture *p, double x, double y, double z, int count, uint64_t seed)
{
    for (int i = 0; i < count; i++) {
        double w = 0.018 + 0.022 * solid_random(seed, 2 * (uint64_t)i), h = 0.25 - 0.02 * i,
               turn = 0.3 * (solid_random(seed, 90 + (uint64_t)i) - 0.5);
        struct place at = place_turn(place_turn(place_at(x, y + 0.5 * w, z), 'y', turn), 'z', QUARTER);
        book(p, place_move(at, 0, -0.5 * h, 0), (int)(16 * solid_random(seed + 2, (uint64_t)i)), w, h,
             0.18 - 0.008 * i);
        y += w + 0.0005;
    }
}

void palette_books(struct furniture *p)
{
    lying_books(p, 0, 0, 0, 4, 610);
}

// ---- small things on shelves ----

static void jug(struct solid *s, double x, double y, double z, double scale)
{
    const struct solid_corner outline[8] = {
        {0, 0, 0},           {0.045, 0, 0.006},    {0.075, 0.075, 0.06}, {0.03, 0.15, 0.05},
        {0.030, 0.20, 0.03}, {0.042, 0.22, 0.002}, {0.036, 0.22, 0.002}, {0.022, 0.18, 0.01}};
    struct solid_corner scaled[8];
    for (int i = 0; i < 8; i++)
        scaled[i] =
            (struct solid_corner){outline[i].x * scale, outline[i].y * scale, outline[i].radius * scale};
    solid_turn(s, place_at(x, y, z), scaled, 8, 24);
}

static void small_bowl(struct solid *s, double x, double y, double z, double r)
{
    const struct solid_corner outline[7] = {{0, 0, 0},
                                            {0.45 * r, 0, 0.004},
                                            {0.5 * r, 0.06 * r, 0.01},
                                            {r, 0.62 * r, 0.8 * r},
                                            {0.95 * r, 0.62 * r, 0.003},
                                            {0.5 * r, 0.14 * r, 0.5 * r},
                                            {0, 0.1 * r, 0}};
    solid_turn(s, place_at(x, y, z), outline, 7, 24);
}

void palette_bookshelf(struct furniture *p)
{
    struct solid *oak = furniture_part(p, LOOK_OAK);
    const double w = 1.0, d = 0.32, h = 2.0, t = 0.024;
    for (int i = 0; i < 2; i++)
        block(oak, (i ? 0.5 : -0.5) * (w - t), 0, 0, t, h, d, 0.002);
    block(oak, 0, 0.04, -0.5 * d + 0.006, w - 2 * t, h - 0.05, 0.008, 0);
    block(oak, 0, 0, 0.5 * d - 0.03, w - 2 * t, 0.06, 0.015, 0);
    for (int i = 0; i < 6; i++) {
        double y = 0.06 + i * 0.3816;
        block(oak, 0, y, 0, w - 2 * t, t, d - 0.004, 0.0015);
    }
    const double z = 0.5 * d - 0.03, left = -0.5 * w + t + 0.004, right = 0.5 * w - t - 0.004;
    double y[5];
    for (int i = 0; i < 5; i++)
        y[i] = 0.06 + t + i * 0.3816;
    row_of_books(p, left, right - 0.22, y[0], z, 620);
    lying_books(p, right - 0.14, y[0], 0.04, 4, 621);
    row_of_books(p, left, -0.06, y[1], z, 630);
    jug(furniture_part(p, LOOK_STONEWARE), 0.16, y[1], 0.02, 1.05);
    small_bowl(furniture_part(p, LOOK_CERAMIC), 0.33, y[1], 0.03, 0.085);
    row_of_books(p, left + 0.30, right, y[2], z, 640);
    lying_books(p, left + 0.14, y[2], 0.04, 5, 641);
    row_of_books(p, left, 0.18, y[3], z, 650);
    jug(furniture_part(p, LOOK_TERRACOTTA), 0.33, y[3], 0.0, 1.15);
    row_of_books(p, left + 0.42, right, y[4], z, 660);
    jug(furniture_part(p, LOOK_CERAMIC), -0.33, y[4], 0.01, 1.2);
    small_bowl(furniture_part(p, LOOK_STONEWARE), -0.15, y[4], 0.05, 0.07);
}

void palette_wall_shelf(struct furniture *p)
{
    block(furniture_part(p, LOOK_WALNUT), 0, -0.015, 0.11, 1.0, 0.03, 0.22, 0.003);
    jug(furniture_part(p, LOOK_CERAMIC), -0.36, 0.015, 0.11, 1.0);
    jug(furniture_part(p, LOOK_TERRACOTTA), -0.22, 0.015, 0.12, 0.7);
    row_of_books(p, 0.08, 0.34, 0.015, 0.18, 671);
    small_bowl(furniture_part(p, LOOK_STONEWARE), 0.42, 0.015, 0.11, 0.06);
}

// ---- cupboards ----

// A bow handle, upright or level, on the face at z.
static void handle(struct solid *metal, double x, double y, double z, double length, bool upright)
{
    double a = upright ? 0 : 0.5 * length, b = upright ? 0.5 * length : 0;
    const struct solid_bend way[4] = {{x - a, y - b, z - 0.002, 0},
                                      {x - a, y - b, z + 0.032, 0.01},
                                      {x + a, y + b, z + 0.032, 0.01},
                                      {x + a, y + b, z - 0.002, 0}};
    solid_tube(metal, place_at(0, 0, 0), way, 4, 0.0055, 0.0055, 8);
}

void palette_wardrobe(struct furniture *p)
{
    struct solid *white = furniture_part(p, LOOK_WHITE), *oak = furniture_part(p, LOOK_OAK),
                 *brass = furniture_part(p, LOOK_BRASS);
    block(white, 0, 0.08, -0.012, 1.50, 2.04, 0.576, 0.002);
    block(oak, 0, 0, -0.03, 1.44, 0.08, 0.50, 0.002);
    block(oak, 0, 2.12, -0.0, 1.52, 0.02, 0.60, 0.003);
    const struct solid_corner panel[4] = {
        {0, 0, 0}, {0.004, 0.009, 0.003}, {0.060, 0.009, 0.002}, {0.060, 0, 0}};
    for (int i = 0; i < 3; i++) {
        double x = 0.5 * (i - 1);
        block(white, x, 0.085, 0.281, 0.494, 2.03, 0.012, 0.001);
        solid_frame(white, place_at(x, 1.10, 0.287), 0.374, 1.91, panel, 4);
        handle(brass, x + (i == 2 ? -0.215 : 0.215), 1.10, 0.297, 0.19, true);
    }
}

void palette_chest_of_drawers(struct furniture *p)
{
    struct solid *sage = furniture_part(p, LOOK_SAGE), *oak = furniture_part(p, LOOK_OAK);
    block(sage, 0, 0.16, -0.01, 1.10, 0.64, 0.43, 0.003);
    block(oak, 0, 0.80, 0, 1.13, 0.025, 0.47, 0.004);
    for (int row = 0; row < 3; row++)
        for (int i = 0; i < 2; i++) {
            double x = i ? 0.2725 : -0.2725, y = 0.172 + 0.209 * row;
            block(sage, x, y, 0.212, 0.535, 0.202, 0.022, 0.003);
            handle(furniture_part(p, LOOK_BRASS), x, y + 0.13, 0.223, 0.12, false);
        }
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 1.0 : -1.0, z = i & 2 ? 1.0 : -1.0;
        rod(oak, x * 0.48, 0.162, z * 0.155, x * 0.51, 0, z * 0.185, 0.021, 0.013);
    }
}

void palette_tv_board(struct furniture *p)
{
    struct solid *wood = furniture_part(p, LOOK_WALNUT), *metal = furniture_part(p, LOOK_BLACK_METAL);
    const double w = 1.80, d = 0.42, low = 0.14, high = 0.50, t = 0.022;
    block(wood, 0, high - t, 0, w, t, d, 0.003);
    block(wood, 0, low, 0, w, t, d, 0.003);
    for (int i = 0; i < 2; i++) {
        block(wood, (i ? 0.5 : -0.5) * (w - t), low + t, 0, t, high - low - 2 * t, d, 0.002);
        block(wood, i ? 0.32 : -0.32, low + t, -0.01, t, high - low - 2 * t, d - 0.03, 0.001);
        block(metal, i ? 0.60 : -0.60, low + t, 0.15, 0.54, high - low - 2 * t, 0.004, 0);
    }
    block(wood, 0, low + t, -0.5 * d + 0.006, w - 2 * t, high - low - 2 * t, 0.008, 0);
    block(wood, 0, 0.32, -0.01, 0.62, 0.018, d - 0.04, 0.001);
    for (int i = 0; i < 40; i++) { // slats before the cupboards on both sides
        double x = (i < 20 ? -0.869 : 0.342) + (i % 20) * 0.0277;
        block(wood, x, low + t + 0.002, 0.19, 0.016, high - low - 2 * t - 0.004, 0.016, 0);
    }
    for (int i = 0; i < 4; i++)
        rod(metal, i & 1 ? 0.74 : -0.74, low, i & 2 ? 0.15 : -0.15, i & 1 ? 0.76 : -0.76, 0,
            i & 2 ? 0.17 : -0.17, 0.012, 0.009);
    block(furniture_part(p, LOOK_PLASTIC), 0.0, 0.338, 0.03, 0.42, 0.055, 0.25, 0.004);
    lying_books(p, -0.08, low + t, 0.05, 3, 680);
}

static void television(struct furniture *p)
{
    struct solid *plastic = furniture_part(p, LOOK_PLASTIC);
    block(plastic, 0, 0.065, 0, 1.235, 0.71, 0.022, 0.004);
    block(plastic, 0, 0.12, -0.025, 0.80, 0.40, 0.03, 0.01);
    for (int i = 0; i < 2; i++) {
        double x = i ? 0.43 : -0.43;
        rod(plastic, x, 0.075, 0.0, x, 0.006, 0.12, 0.008, 0.006);
        rod(plastic, x, 0.075, 0.0, x, 0.006, -0.12, 0.008, 0.006);
    }
}

void palette_tv(struct furniture *p)
{
    television(p);
    block(furniture_part(p, LOOK_GLASS), 0, 0.075, 0.0105, 1.223, 0.692, 0.003, 0.001);
}

void palette_tv_playing(struct furniture *p)
{
    television(p);
    // It shines along -Z of its node: towards the front.
    cJSON *light =
        furniture_light(p, "light_rectangle", place_turn(place_at(0, 0.421, 0.0125), 'y', 2 * QUARTER),
                        (const double[3]){1, 1, 1});
    glb_set(p->g, light, "radiance", 2.2);
    glb_set_list(p->g, light, "size", (const double[2]){1.219, 0.686}, 2);
    glb_set_texture(p->g, light, "texture", look_texture(p->looks, p->g, picture_screen));
}

// ---- the kitchen ----

static void front(struct solid *s, struct solid *metal, double x, double y, double w, double h)
{
    block(s, x, y, 0.29, w - 0.004, h - 0.004, 0.02, 0.002);
    handle(metal, x, y + h - 0.045, 0.30, fmin(0.5 * w, 0.24), false);
}

void palette_kitchen(struct furniture *p)
{
    struct solid *sage = furniture_part(p, LOOK_SAGE), *oak = furniture_part(p, LOOK_OAK),
                 *metal = furniture_part(p, LOOK_BLACK_METAL);
    struct solid *steel = furniture_part(p, LOOK_STEEL), *glass = furniture_part(p, LOOK_GLASS),
                 *white = furniture_part(p, LOOK_WHITE);
    block(metal, 0, 0, -0.04, 2.36, 0.10, 0.50, 0);
    block(sage, -0.75, 0.10, -0.01, 0.90, 0.58, 0.58, 0); // lower, below the sink
    block(sage, -1.19, 0.10, -0.01, 0.02, 0.77, 0.58, 0);
    block(sage, 0.45, 0.10, -0.01, 1.50, 0.77, 0.58, 0);
    // The worktop with a hole for the sink: four slabs around it.
    const double top = 0.87, t = 0.035, sx = -0.60, sw = 0.52, sd = 0.38;
    block(oak, 0.5 * (sx - 0.5 * sw - 1.21), top, 0, sx - 0.5 * sw + 1.21, t, 0.63, 0.002);
    block(oak, 0.5 * (sx + 0.5 * sw + 1.21), top, 0, 1.21 - sx - 0.5 * sw, t, 0.63, 0.002);
    block(oak, sx, top, 0.25, sw, t, 0.63 - 0.5 - 0.0, 0.002);
    block(oak, sx, top, -0.2575, sw, t, 0.115, 0.002);
    block(steel, sx, top + t - 0.19, 0, sw, 0.006, sd + 0.03, 0); // its floor and sides
    for (int i = 0; i < 2; i++) {
        block(steel, sx + (i ? 0.5 : -0.5) * (sw - 0.008), top + t - 0.19, -0.0, 0.008, 0.192, sd + 0.03,
              0.001);
        block(steel, sx, top + t - 0.19, (i ? 0.1825 : -0.1975), sw, 0.192, 0.008, 0);
    }
    solid_cylinder(metal, place_at(sx, top + t - 0.184, 0), 0.035, 0.002, 0, 16);
    const struct solid_bend tap[4] = {{sx, top + t, -0.24, 0},
                                      {sx, top + t + 0.34, -0.24, 0.10},
                                      {sx, top + t + 0.34, -0.05, 0.10},
                                      {sx, top + t + 0.22, -0.05, 0}};
    solid_tube(steel, place_at(0, 0, 0), tap, 4, 0.013, 0.013, 18);
    solid_cylinder(steel, place_at(sx, top + t, -0.24), 0.025, 0.03, 0.004, 18);
    rod(steel, sx + 0.01, top + t + 0.07, -0.24, sx + 0.09, top + t + 0.10, -0.24, 0.006, 0.005);
    block(glass, 0.60, top + t, 0, 0.58, 0.005, 0.51, 0.002);
    for (int i = 0; i < 4; i++)
        ring(steel, 0.60 + (i & 1 ? 0.14 : -0.14), top + t + 0.0046, i & 2 ? 0.12 : -0.12,
             i == 1 ? 0.10 : 0.08, 0.0008);
    // Below: a cupboard, two drawers and a cupboard, the oven, a cupboard.
    front(sage, metal, -0.90, 0.105, 0.60, 0.76);
    for (int i = 0; i < 3; i++)
        front(sage, metal, -0.15,
              0.105 + (i == 0   ? 0
                       : i == 1 ? 0.31
                                : 0.545),
              0.90,
              i == 0   ? 0.31
              : i == 1 ? 0.235
                       : 0.215);
    front(sage, metal, 1.05, 0.105, 0.30, 0.76);
    block(glass, 0.60, 0.205, 0.29, 0.594, 0.46, 0.022, 0.003);
    block(glass, 0.60, 0.67, 0.29, 0.594, 0.19, 0.022, 0.003);
    front(sage, metal, 0.60, 0.105, 0.60, 0.095);
    handle(steel, 0.60, 0.62, 0.301, 0.46, false);
    for (int i = 0; i < 3; i++)
        solid_cylinder(steel, place_turn(place_at(0.44 + 0.16 * i, 0.765, 0.30), 'x', QUARTER), 0.021, 0.022,
                       0.003, 18);
    // On the wall: cupboards beside a hood, an open shelf.
    block(white, 0, top + t, -0.295, 2.40, 0.52, 0.010, 0);
    for (int i = 0; i < 3; i++) {
        double x = -0.90 + 0.60 * i;
        if (i < 2) {
            block(sage, x, 1.43, -0.13, 0.598, 0.72, 0.34, 0);
            block(sage, x, 1.43, 0.05, 0.594, 0.72, 0.02, 0.002);
            handle(metal, x + (i ? -0.25 : 0.25), 1.56, 0.06, 0.16, true);
        }
    }
    const struct solid_corner hood[4] = {
        {-0.30, 1.48, 0.004}, {0.30, 1.48, 0.004}, {0.13, 1.62, 0.02}, {-0.13, 1.62, 0.02}};
    solid_extrude(steel, place_at(0.60, 0, -0.07), hood, 4, 0.45);
    block(steel, 0.60, 1.60, -0.15, 0.24, 0.55, 0.24, 0.003);
    block(oak, 0.10, 1.43, -0.18, 0.38, 0.025, 0.24, 0.002);
    jug(furniture_part(p, LOOK_CERAMIC), 0.02, 1.455, -0.17, 0.9);
    small_bowl(furniture_part(p, LOOK_STONEWARE), 0.19, 1.455, -0.17, 0.07);
    small_bowl(furniture_part(p, LOOK_CERAMIC), -0.08, top + t, 0.02, 0.12);
}
