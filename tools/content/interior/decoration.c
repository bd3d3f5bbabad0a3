// Plants, pictures, crockery.
#include "palette.h"

// ---- plants ----

struct leaf {
    double w, h;      // of the blade
    double bow, fold; // how far its tip drops; how far its sides rise
};

static struct vec3 leaf_surface(double u, double v, const void *user)
{
    const struct leaf *l = user;
    double x = (u - 0.5) * l->w, side = 2 * fabs(u - 0.5);
    double angle = l->bow * v; // the midrib is an arc
    double y = fabs(l->bow) > 1e-3 ? l->h * sin(angle) / l->bow : l->h * v;
    double z = fabs(l->bow) > 1e-3 ? -l->h * (1 - cos(angle)) / l->bow : 0.0;
    return vec3_make(x * (1 - 0.1 * side), y, z + l->fold * l->w * side * side);
}

// A leaf that starts at the place and grows along its Y, its upper side towards Z.
static void leaf(struct solid *s, struct place at, const struct leaf *l)
{
    uint32_t first = (uint32_t)s->vertices.count;
    solid_sheet(s, at, leaf_surface, l, 4, 6, 1, 1);
    for (size_t i = first; i < s->vertices.count; i++)
        s->vertices.items[i].v = 1.0 - s->vertices.items[i].v;
}

// From the middle of the plant: which way, how far up the stem leans (0: level), and how long it is.
static struct place stem_end(struct solid *bark, double turn, double rise, double length, double y,
                             double from, double thick)
{
    double x = sin(turn), z = cos(turn), out = length * cos(rise), up = length * sin(rise);
    const struct solid_bend way[3] = {
        {from * x, y, from * z, 0},
        {(from + 0.35 * out) * x, y + 0.7 * up, (from + 0.35 * out) * z, length},
        {(from + out) * x, y + up, (from + out) * z, 0}};
    solid_tube(bark, place_at(0, 0, 0), way, 3, thick, 0.6 * thick, 7);
    return place_turn(place_at((from + out) * x, y + up, (from + out) * z), 'y', turn);
}

static void pot(struct furniture *p, enum look look, double r, double h)
{
    const struct solid_corner outline[7] = {{0, 0, 0},
                                            {0.72 * r, 0, 0.01},
                                            {r, h, 0.3 * r},
                                            {0.99 * r, h + 0.004, 0.002},
                                            {0.91 * r, h + 0.004, 0.003},
                                            {0.88 * r, 0.86 * h, 0},
                                            {0.8 * r, 0.85 * h, 0}};
    solid_turn(furniture_part(p, look), place_at(0, 0, 0), outline, 7, 32);
    const struct solid_corner soil[3] = {
        {0.89 * r, 0.87 * h, 0}, {0.4 * r, 0.90 * h, 0.2 * r}, {0, 0.91 * h, 0}};
    solid_turn(furniture_part(p, LOOK_SOIL), place_at(0, 0, 0), soil, 3, 32);
}

void palette_monstera(struct furniture *p)
{
    enum { LEAVES = 15 };
    pot(p, LOOK_CERAMIC, 0.17, 0.30);
    struct solid *bark = furniture_part(p, LOOK_SAGE), *leaves = furniture_part(p, LOOK_MONSTERA);
    for (int i = 0; i < LEAVES; i++) {
        double t = (double)i / (LEAVES - 1), turn = 2.399963 * i + 0.4, size = 0.33 - 0.11 * t;
        double rise = 0.62 + 0.72 * t + 0.12 * (solid_random(800, (uint64_t)i) - 0.5);
        struct place end = stem_end(bark, turn, rise, 0.36 + 0.26 * t + 0.08 * solid_random(801, (uint64_t)i),
                                    0.27, 0.03, 0.006);
        struct place blade = place_turn(place_turn(end, 'x', 1.95 - 0.45 * t), 'y',
                                        0.5 * (solid_random(802, (uint64_t)i) - 0.5));
        leaf(leaves, place_turn(blade, 'y', 2 * QUARTER), &(struct leaf){size, size, -0.7, 0.12});
    }
}

void palette_fig_tree(struct furniture *p)
{
    pot(p, LOOK_STONEWARE, 0.19, 0.34);
    struct solid *bark = furniture_part(p, LOOK_BARK), *leaves = furniture_part(p, LOOK_FIDDLE_LEAF);
    const struct solid_bend trunk[4] = {
        {0, 0.28, 0, 0}, {0.03, 0.75, 0.01, 0.8}, {-0.02, 1.2, -0.02, 0.8}, {0.01, 1.66, 0, 0}};
    solid_tube(bark, place_at(0, 0, 0), trunk, 4, 0.017, 0.008, 10);
    for (int i = 0; i < 44; i++) {
        double t = i / 43.0, y = 0.72 + 0.98 * t, turn = 2.399963 * i,
               crown = sin(CONTENT_PI * (0.18 + 0.72 * t));
        double rise = -0.1 + 0.75 * t + 0.25 * (solid_random(810, (uint64_t)i) - 0.5);
        struct place end = stem_end(bark, turn, rise, 0.07 + 0.13 * crown, y, 0.0, 0.004);
        double size = (0.17 + 0.09 * crown) * (0.85 + 0.3 * solid_random(811, (uint64_t)i));
        struct place blade = place_turn(end, 'x', QUARTER - rise + 0.25);
        leaf(leaves, place_turn(blade, 'y', 2 * QUARTER),
             &(struct leaf){0.72 * size, 1.25 * size, -0.8, 0.16});
    }
}

void palette_palm(struct furniture *p)
{
    const struct solid_corner wall[6] = {
        {0, 0, 0},       {0.16, 0, 0.03}, {0.19, 0.30, 0.5}, {0.19, 0.312, 0.006}, {0.175, 0.312, 0.006},
        {0.165, 0.25, 0}};
    solid_turn(furniture_part(p, LOOK_WICKER), place_at(0, 0, 0), wall, 6, 32);
    const struct solid_corner soil[2] = {{0.172, 0.26, 0}, {0, 0.275, 0}};
    solid_turn(furniture_part(p, LOOK_SOIL), place_at(0, 0, 0), soil, 2, 32);
    struct solid *stalks = furniture_part(p, LOOK_SAGE), *leaves = furniture_part(p, LOOK_FROND);
    for (int i = 0; i < 22; i++) {
        double t = i / 21.0, turn = 2.399963 * i + 0.9, rise = 0.85 + 0.55 * t;
        struct place end = stem_end(stalks, turn, rise, 0.30 + 0.38 * t, 0.25,
                                    0.025 + 0.02 * solid_random(820, (uint64_t)i), 0.006);
        double length = 0.62 + 0.16 * solid_random(821, (uint64_t)i);
        struct place blade = place_turn(place_turn(end, 'x', QUARTER - rise + 0.05), 'y',
                                        0.4 * (solid_random(822, (uint64_t)i) - 0.5));
        leaf(leaves, place_turn(blade, 'y', 2 * QUARTER), &(struct leaf){0.40, length, -1.15, 0.14});
    }
}

// ---- on the wall ----

static void framed(struct furniture *p, struct place at, double w, double h, enum look frame, enum look print)
{
    const struct solid_corner moulding[6] = {{0, 0.008, 0},         {0, 0.020, 0.002}, {0.004, 0.024, 0.002},
                                             {0.020, 0.024, 0.003}, {0.020, 0, 0},     {0.019, 0, 0}};
    solid_frame(furniture_part(p, frame), at, w, h, moulding, 5);
    picture_plane(furniture_part(p, print), place_move(at, 0, 0, 0.010), w + 0.004, h + 0.004);
    solid_box(furniture_part(p, frame), place_move(at, 0, 0, 0.004), w + 0.02, h + 0.02, 0.008, 0);
}

void palette_picture(struct furniture *p)
{
    framed(p, place_at(0, 0, 0), 0.60, 0.80, LOOK_OAK, LOOK_PRINT_SUN);
}

void palette_picture_trio(struct furniture *p)
{
    static const enum look prints[3] = {LOOK_PRINT_LEAVES, LOOK_PRINT_ARCHES, LOOK_PRINT_SUN};
    for (int i = 0; i < 3; i++)
        framed(p, place_at(0.40 * (i - 1), 0, 0), 0.30, 0.40, LOOK_BLACK_METAL, prints[i]);
}

void palette_round_mirror(struct furniture *p)
{
    struct place face = place_turn(place_at(0, 0, 0), 'x', QUARTER);
    const struct solid_corner rim[6] = {
        {0, 0, 0},         {0.41, 0, 0.003}, {0.41, 0.026, 0.004}, {0.395, 0.026, 0.003},
        {0.395, 0.014, 0}, {0.394, 0.014, 0}};
    solid_turn(furniture_part(p, LOOK_BRASS), face, rim, 6, 72);
    const struct solid_corner glass[2] = {{0.396, 0.015, 0}, {0, 0.015, 0}};
    solid_turn(furniture_part(p, LOOK_MIRROR), face, glass, 2, 72);
}

void palette_clock(struct furniture *p)
{
    struct place face = place_turn(place_at(0, 0, 0), 'x', QUARTER);
    const struct solid_corner rim[6] = {
        {0, 0, 0},         {0.155, 0, 0.003}, {0.155, 0.04, 0.005}, {0.145, 0.04, 0.004},
        {0.145, 0.026, 0}, {0.144, 0.026, 0}};
    solid_turn(furniture_part(p, LOOK_BLACK_METAL), face, rim, 6, 48);
    picture_plane(furniture_part(p, LOOK_CLOCK), place_at(0, 0, 0.028), 0.21, 0.21);
    const struct solid_corner white[2] = {{0.146, 0.027, 0}, {0, 0.027, 0}};
    solid_turn(furniture_part(p, LOOK_CERAMIC), face, white, 2, 48);
    struct solid *metal = furniture_part(p, LOOK_BLACK_METAL);
    static const double hands[2][3] = {{-1.05, 0.07, 0.0045}, {1.05, 0.11, 0.0030}}; // ten past ten
    for (int i = 0; i < 2; i++) {
        struct place at = place_turn(place_at(0, 0, 0.031 + 0.003 * i), 'z', -hands[i][0]);
        solid_box(metal, place_move(at, 0, 0.5 * hands[i][1] - 0.012, 0), 2 * hands[i][2], hands[i][1],
                  0.0015, 0);
    }
    solid_cylinder(metal, place_turn(place_at(0, 0, 0.029), 'x', QUARTER), 0.008, 0.008, 0.002, 16);
}

// ---- on the table ----

void palette_vase(struct furniture *p)
{
    const struct solid_corner outline[8] = {{0, 0, 0},
                                            {0.055, 0, 0.01},
                                            {0.092, 0.10, 0.08},
                                            {0.060, 0.21, 0.06},
                                            {0.034, 0.245, 0.02},
                                            {0.042, 0.27, 0.003},
                                            {0.037, 0.27, 0.003},
                                            {0.028, 0.24, 0}};
    solid_turn(furniture_part(p, LOOK_CERAMIC), place_at(0, 0, 0), outline, 8, 32);
    struct solid *twig = furniture_part(p, LOOK_BARK), *leaves = furniture_part(p, LOOK_FIDDLE_LEAF);
    for (int i = 0; i < 5; i++) {
        double turn = 1.26 * i + 0.5, lean = 0.10 + 0.07 * solid_random(830, (uint64_t)i),
               high = 0.62 + 0.18 * solid_random(831, (uint64_t)i);
        double x = sin(turn), z = cos(turn);
        const struct solid_bend way[3] = {{-0.02 * x, 0.12, -0.02 * z, 0},
                                          {0.015 * x, 0.30, 0.015 * z, 0.6},
                                          {2.0 * lean * x, high, 2.0 * lean * z, 0}};
        solid_tube(twig, place_at(0, 0, 0), way, 3, 0.0032, 0.0015, 7);
        for (int k = 0; k < 9; k++) {
            double t = 0.25 + 0.75 * k / 8.0, r = 0.015 + (2.0 * lean - 0.015) * t;
            struct place at = place_turn(place_at(r * x, 0.30 + (high - 0.30) * t, r * z), 'y',
                                         turn + (k % 2 ? 1.3 : -1.3));
            leaf(leaves,
                 place_turn(place_turn(at, 'x', 0.9 + 0.3 * solid_random(832, (uint64_t)(9 * i + k))), 'y',
                            2 * QUARTER),
                 &(struct leaf){0.026, 0.062, -0.5, 0.15});
        }
    }
}

void palette_bowl(struct furniture *p)
{
    const struct solid_corner outline[8] = {{0, 0, 0},           {0.065, 0, 0.004},    {0.06, 0.012, 0.004},
                                            {0.15, 0.075, 0.15}, {0.158, 0.10, 0.003}, {0.151, 0.10, 0.003},
                                            {0.10, 0.032, 0.10}, {0, 0.022, 0}};
    solid_turn(furniture_part(p, LOOK_STONEWARE), place_at(0, 0, 0), outline, 8, 36);
    static const double at[6][3] = {{-0.045, 0.066, 0.035}, {0.05, 0.066, 0.03},    {0.0, 0.066, -0.055},
                                    {0.004, 0.124, 0.004},  {-0.093, 0.096, -0.03}, {0.085, 0.094, -0.04}};
    for (int i = 0; i < 6; i++) {
        struct place place = place_turn(place_at(at[i][0], at[i][1] - 0.038, at[i][2]), 'x', 0.0);
        struct solid_corner fruit[9];
        for (int k = 0; k < 9; k++) {
            double angle = CONTENT_PI * k / 8.0;
            fruit[k] = (struct solid_corner){0.0395 * sin(angle), 0.038 * (1 - cos(angle)), 0.03};
        }
        fruit[0].x = fruit[8].x = 0.0;
        solid_turn(furniture_part(p, LOOK_ORANGE), place, fruit, 9, 18);
    }
}

static void cup(struct solid *s, double x, double z)
{
    const struct solid_corner body[8] = {{0, 0.006, 0},        {0.022, 0.006, 0.003},  {0.024, 0.01, 0.004},
                                         {0.038, 0.030, 0.03}, {0.041, 0.068, 0.0015}, {0.038, 0.068, 0.0015},
                                         {0.034, 0.026, 0.02}, {0, 0.016, 0}};
    const struct solid_corner saucer[6] = {
        {0, 0, 0},    {0.035, 0, 0.003}, {0.072, 0.012, 0.02}, {0.070, 0.0145, 0.001}, {0.034, 0.005, 0.01},
        {0, 0.005, 0}};
    solid_turn(s, place_at(x, 0.014, z), body, 8, 24);
    solid_turn(s, place_at(x, 0.014, z), saucer, 6, 28);
    const struct solid_bend grip[5] = {{0.037, 0.056, 0, 0},
                                       {0.054, 0.060, 0, 0.008},
                                       {0.062, 0.044, 0, 0.012},
                                       {0.054, 0.028, 0, 0.01},
                                       {0.033, 0.024, 0, 0}};
    solid_tube(s, place_turn(place_at(x, 0.014, z), 'y', 0.6), grip, 5, 0.0035, 0.0035, 10);
}

void palette_tea_set(struct furniture *p)
{
    struct solid *oak = furniture_part(p, LOOK_WALNUT), *white = furniture_part(p, LOOK_CERAMIC);
    slab(oak, 0, 0, 0, 0.46, 0.010, 0.30, 0.04);
    const struct solid_corner rim[4] = {{0, 0, 0}, {0, 0.024, 0.002}, {0.008, 0.024, 0.002}, {0.008, 0, 0}};
    solid_frame(oak, place_turn(place_at(0, 0.0, 0), 'x', -QUARTER), 0.448, 0.288, rim, 4);
    cup(white, 0.10, 0.05);
    cup(white, 0.13, -0.085);
    const struct solid_corner body[8] = {{0, 0.001, 0},         {0.045, 0.001, 0.006}, {0.078, 0.05, 0.06},
                                         {0.060, 0.105, 0.05},  {0.030, 0.122, 0.004}, {0.026, 0.128, 0.003},
                                         {0.008, 0.134, 0.004}, {0.008, 0.138, 0}};
    solid_turn(white, place_at(-0.10, 0.010, -0.02), body, 8, 32);
    const struct solid_corner knob[3] = {{0.006, 0.134, 0}, {0.012, 0.148, 0.008}, {0, 0.156, 0}};
    solid_turn(white, place_at(-0.10, 0.010, -0.02), knob, 3, 16);
    struct place pot = place_turn(place_at(-0.10, 0.010, -0.02), 'y', -0.5);
    const struct solid_bend spout[3] = {{0.055, 0.045, 0, 0}, {0.098, 0.062, 0, 0.04}, {0.118, 0.112, 0, 0}};
    solid_tube(white, pot, spout, 3, 0.015, 0.008, 16);
    const struct solid_bend grip[4] = {
        {-0.055, 0.098, 0, 0}, {-0.108, 0.100, 0, 0.02}, {-0.112, 0.042, 0, 0.025}, {-0.062, 0.034, 0, 0}};
    solid_tube(white, pot, grip, 4, 0.006, 0.005, 14);
}
