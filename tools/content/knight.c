// The knight's head and neck: rings around a spine that bends from the foot up the neck and forward to the
// muzzle. A ring is drawn from the side by two points, front and back, and has a profile across; so the
// silhouette of the piece is the two polylines in `sections`. Ears, eyes and the locks of the mane are small
// closed cages that stand in the body.
#include "pieces.h"

#include "base/result.h"

enum { HALF = KNIGHT_SIDES / 2 };

// Millimetres; y up, z forward, x across.
struct section {
    double front_z, front_y, back_z, back_y;
    double width; // half, at the widest
    double pinch; // 0: an ellipse; towards 1: the front half is narrow (throat), below 0 it is full (cheek)
};

static const struct section sections[] = {
    {10.6, 16.2, -10.6, 16.2, 10.6, 0.0}, // on the foot
    {13.2, 22.0, -12.4, 22.0, 11.2, 0.0}, // chest
    {13.6, 29.0, -14.6, 30.0, 10.6, 0.1}, {10.2, 36.0, -16.4, 40.0, 9.4, 0.2},
    {5.2, 42.0, -16.6, 50.5, 8.4, 0.25},  {2.6, 46.0, -14.2, 60.5, 7.8, 0.2}, // throat
    {4.6, 46.6, -9.6, 67.8, 8.0, -0.2},   {9.6, 43.4, -3.2, 71.6, 9.2, -0.5}, // cheek, poll
    {13.4, 41.6, 4.2, 70.0, 8.2, -0.4},                                       // forehead
    {16.4, 41.2, 10.8, 62.6, 6.4, -0.1},  {19.2, 38.8, 16.6, 55.0, 5.4, 0.0},
    {22.0, 35.6, 22.4, 49.6, 5.6, 0.0}, // chin, nostrils
    {25.4, 36.2, 26.6, 45.6, 5.0, 0.0}, // lips
};

// Point k of a ring: 0 is the front, HALF the back, the rest in between on +X, then on -X.
static struct vec3 section_point(const struct section *s, uint32_t k)
{
    uint32_t m = k <= HALF ? k : KNIGHT_SIDES - k;
    double angle = CONTENT_PI * m / HALF, along = 0.5 - 0.5 * cos(angle);
    double across = s->width * sin(angle) * (1.0 - s->pinch * cos(angle));
    return vec3_make(k <= HALF ? across : -across, s->front_y + along * (s->back_y - s->front_y),
                     s->front_z + along * (s->back_z - s->front_z));
}

static void add_body(struct cage *c, uint32_t below)
{
    for (size_t i = 0; i < NG_COUNT(sections); i++) {
        uint32_t ring = (uint32_t)c->points.count;
        for (uint32_t k = 0; k < KNIGHT_SIDES; k++)
            cage_point(c, section_point(&sections[i], k));
        cage_bridge(c, KNIGHT_SIDES, below, ring);
        below = ring;
    }
    cage_crease_ring(c, KNIGHT_SIDES, below, 1.0);
    cage_cap(c, KNIGHT_SIDES, below, vec3_make(0.0, 40.6, 27.2), true);
}

// A box bent to eight given corners: bottom four counter-clockwise from above, then the top four.
static void add_block(struct cage *c, const struct vec3 p[8], double mirror, double sharpness)
{
    static const uint32_t faces[6][4] = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                         {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    uint32_t first = (uint32_t)c->points.count;
    for (int i = 0; i < 8; i++)
        cage_point(c, vec3_make(p[i].x * mirror, p[i].y, p[i].z));
    for (int f = 0; f < 6; f++) {
        const uint32_t *q = faces[f];
        if (mirror > 0.0)
            cage_quad(c, first + q[0], first + q[1], first + q[2], first + q[3]);
        else
            cage_quad(c, first + q[3], first + q[2], first + q[1], first + q[0]);
    }
    for (uint32_t i = 0; i < 4; i++)
        cage_add_crease(c, first + i, first + i + 4, sharpness);
}

static void add_ears(struct cage *c)
{
    static const struct vec3 ear[8] = {
        {0.8, 67.0, 2.0}, {7.0, 65.0, 2.0}, {7.0, 66.0, -6.5}, {0.8, 68.0, -6.5},
        {3.6, 81.5, 0.4}, {5.2, 81.5, 0.4}, {5.2, 81.5, -1.6}, {3.6, 81.5, -1.6},
    };
    add_block(c, ear, 1.0, 1.0);
    add_block(c, ear, -1.0, 1.0);
}

// Eyes and nostrils: ellipsoids, half sunk.
static void add_face(struct cage *c)
{
    static const struct vec3 at[2] = {{6.0, 63.0, 6.8}, {4.5, 44.6, 22.8}};
    static const struct vec3 half[2] = {{2.6, 2.2, 3.2}, {1.8, 1.6, 2.4}};
    for (int i = 0; i < 2; i++)
        for (int side = -1; side <= 1; side += 2) {
            struct vec3 center = vec3_make(at[i].x * side, at[i].y, at[i].z);
            cage_box(c, vec3_sub(center, half[i]), vec3_add(center, half[i]), 0.0);
        }
}

// Locks along the back of the neck: the middle of each lies on the back line of the sections.
static void add_mane(struct cage *c)
{
    enum { LOCKS = 7 };
    static const double locks[LOCKS][3] = {
        // z, y, tilt (radians, 0: pointing back)
        {-14.8, 31.0, -0.40}, {-16.4, 38.5, -0.30}, {-17.0, 46.0, -0.15}, {-16.0, 53.5, 0.10},
        {-13.4, 60.8, 0.40},  {-9.4, 67.0, 0.75},   {-4.0, 71.4, 1.15},
    };
    static const double square[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}; // across, along the neck
    for (int i = 0; i < LOCKS; i++) {
        double cs = cos(locks[i][2]), sn = sin(locks[i][2]);
        struct vec3 p[8];
        for (int k = 0; k < 8; k++) {
            bool tip = k >= 4;
            double along = square[k % 4][1] * (tip ? 2.6 : 5.6) - (tip ? 3.0 : 0.0), out = tip ? 4.2 : -4.0;
            p[k] = vec3_make(square[k % 4][0] * (tip ? 1.8 : 3.8), locks[i][1] + out * sn + along * cs,
                             locks[i][0] - out * cs + along * sn);
        }
        add_block(c, p, 1.0, 1.0);
    }
}

void knight_body(struct cage *c, uint32_t foot)
{
    add_body(c, foot);
    add_ears(c);
    add_face(c);
    add_mane(c);
}
