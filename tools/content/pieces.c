// Turned pieces: a foot that all six share, a stem, a head. Drawn in millimetres and scaled
// by DRAWN. What a lathe cannot make (merlons, mitre cut, coronet, cross) is built on the last ring.
#include "pieces.h"

#include "base/result.h"

enum { SIDES = 12 };

#define DRAWN 1.08e-3 // metres a drawing's unit: the pieces fill squares of 60 mm well

static const struct {
    const char *name;
    double radius, height; // millimetres
} sizes[PIECE_KINDS] = {
    {"pawn", 15.0, 51.0},   {"rook", 17.5, 58.0},  {"knight", 18.0, 81.5},
    {"bishop", 17.5, 84.0}, {"queen", 19.5, 98.0}, {"king", 20.5, 116.0},
};

const char *piece_name(enum piece kind)
{
    return sizes[kind].name;
}

double piece_radius(enum piece kind)
{
    return sizes[kind].radius * DRAWN;
}

double piece_height(enum piece kind)
{
    return sizes[kind].height * DRAWN;
}

// Everything below the stem. `radius` is the piece's; heights grow a little with it.
static uint32_t turn_foot(struct cage *c, uint32_t sides, double radius)
{
    double r = radius, h = radius / 17.5;
    const struct cage_profile foot[] = {
        {r * 0.97, 0.0, 4},      {r, 1.0 * h, 1.5},        {r, 4.2 * h, 1.5},
        {r * 0.93, 6.2 * h, 0},  {r * 0.83, 7.0 * h, 2.5}, {r * 0.83, 8.6 * h, 1},
        {r * 0.80, 11.5 * h, 0}, {r * 0.66, 13.8 * h, 0},  {r * 0.58, 14.4 * h, 2.5},
    };
    return cage_turn(c, sides, CAGE_NO_RING, foot, NG_COUNT(foot));
}

static void close_ball(struct cage *c, uint32_t sides, uint32_t ring, double y)
{
    cage_cap(c, sides, ring, vec3_make(0.0, y, 0.0), true);
}

static void build_pawn(struct cage *c)
{
    uint32_t ring = turn_foot(c, SIDES, 15.0);
    const struct cage_profile p[] = {
        {8.4, 14.6, 0},   {7.2, 19.0, 0}, {6.1, 24.0, 0},   {5.8, 29.0, 0}, {6.4, 31.2, 1.5},
        {9.9, 32.2, 2.0}, {9.9, 34.0, 2}, {5.8, 35.0, 2.5}, {7.6, 37.2, 0}, {9.8, 41.0, 0},
        {9.8, 45.0, 0},   {6.6, 49.0, 0}, {2.6, 51.0, 0},
    };
    close_ball(c, SIDES, cage_turn(c, SIDES, ring, p, NG_COUNT(p)), 51.3);
}

// Six merlons around a well: every third sector of the rim is a gap.
static void build_rook(struct cage *c)
{
    enum { N = 18 };
    uint32_t ring = turn_foot(c, N, 17.5);
    const struct cage_profile p[] = {
        {10.2, 15.0, 0}, {9.2, 20.0, 0},  {8.4, 27.0, 0},  {8.4, 34.0, 0},  {9.0, 37.0, 1.5},
        {12.2, 38.6, 2}, {12.2, 40.6, 2}, {10.6, 42.0, 1}, {13.6, 45.5, 2}, {13.6, 50.5, 2},
    };
    uint32_t outer = cage_turn(c, N, ring, p, NG_COUNT(p));
    uint32_t inner = cage_ring(c, N, 9.4, 50.5);
    uint32_t top_outer = cage_ring(c, N, 13.6, 57.5), top_inner = cage_ring(c, N, 9.4, 57.5);
    uint32_t floor = cage_ring(c, N, 9.0, 48.0);
    for (uint32_t i = 0; i < N; i++) {
        uint32_t j = (i + 1) % N;
        bool gap = i % 3 == 2;
        if (gap) {
            cage_quad(c, outer + i, outer + j, inner + j, inner + i);
            cage_quad(c, outer + i, inner + i, top_inner + i, top_outer + i); // the merlons' ends
            cage_quad(c, outer + j, top_outer + j, top_inner + j, inner + j);
            cage_add_crease(c, outer + i, outer + j, 2);
            cage_add_crease(c, inner + i, inner + j, 2);
            for (uint32_t end = i, k = 0; k < 2; end = j, k++) {
                cage_add_crease(c, outer + end, top_outer + end, 2.5);
                cage_add_crease(c, inner + end, top_inner + end, 2.5);
                cage_add_crease(c, top_outer + end, top_inner + end, 2.5);
                cage_add_crease(c, outer + end, inner + end, 2.5);
            }
        } else {
            cage_quad(c, outer + i, outer + j, top_outer + j, top_outer + i);
            cage_quad(c, top_outer + i, top_outer + j, top_inner + j, top_inner + i);
            cage_quad(c, top_inner + i, top_inner + j, inner + j, inner + i);
            cage_add_crease(c, top_outer + i, top_outer + j, 2.5);
            cage_add_crease(c, top_inner + i, top_inner + j, 2.5);
        }
        cage_quad(c, inner + i, inner + j, floor + j, floor + i);
    }
    cage_crease_ring(c, N, floor, 2);
    cage_cap(c, N, floor, vec3_make(0.0, 48.0, 0.0), true);
}

static void build_knight(struct cage *c)
{
    knight_body(c, turn_foot(c, KNIGHT_SIDES, 18.0));
}

// A slot cut into the front of the ring band lower-upper: the band's quads move towards the axis.
static void cut_slot(struct cage *c, uint32_t lower, uint32_t upper, uint32_t from, uint32_t to, double depth)
{
    uint32_t inner_lower = (uint32_t)c->points.count;
    for (uint32_t side = 0; side < 2; side++)
        for (uint32_t i = from; i <= to; i++) {
            struct vec3 p = c->points.items[(side ? upper : lower) + i % SIDES];
            cage_point(c, vec3_make(p.x * (1.0 - depth), p.y, p.z * (1.0 - depth) - 2.0));
        }
    uint32_t inner_upper = inner_lower + (to - from + 1);
    for (uint32_t i = from; i < to; i++) {
        uint32_t a = i % SIDES, b = (i + 1) % SIDES, k = i - from;
        cage_quad(c, lower + a, lower + b, inner_lower + k + 1, inner_lower + k);
        cage_quad(c, inner_lower + k, inner_lower + k + 1, inner_upper + k + 1, inner_upper + k);
        cage_quad(c, inner_upper + k, inner_upper + k + 1, upper + b, upper + a);
        cage_add_crease(c, lower + a, lower + b, 3);
        cage_add_crease(c, upper + a, upper + b, 3);
        cage_add_crease(c, inner_lower + k, inner_lower + k + 1, 3);
        cage_add_crease(c, inner_upper + k, inner_upper + k + 1, 3);
    }
    uint32_t a = from % SIDES, b = to % SIDES, k = to - from;
    cage_quad(c, lower + a, inner_lower, inner_upper, upper + a);
    cage_quad(c, lower + b, upper + b, inner_upper + k, inner_lower + k);
}

static void build_bishop(struct cage *c)
{
    uint32_t ring = turn_foot(c, SIDES, 17.5);
    const struct cage_profile p[] = {
        {9.6, 15.0, 0},  {8.0, 20.0, 0},  {6.6, 28.0, 0},  {6.0, 38.0, 0}, {6.4, 43.0, 1.5},
        {10.2, 44.4, 2}, {10.2, 46.2, 2}, {6.4, 47.6, 2},  {8.0, 48.6, 2}, {8.0, 50.0, 2},
        {6.0, 51.2, 2},  {8.6, 54.0, 0},  {10.0, 59.0, 0},
    };
    uint32_t below = cage_turn(c, SIDES, ring, p, NG_COUNT(p));
    // The cut rises towards the front's right: its two rings are tilted about X.
    enum { FROM = SIDES - 3, TO = SIDES + 3 };
    uint32_t lower = cage_ring(c, SIDES, 9.5, 63.4), upper = cage_ring(c, SIDES, 9.0, 65.6);
    for (uint32_t i = 0; i < 2 * SIDES; i++) {
        struct vec3 *q = &c->points.items[lower + i];
        q->y += 0.62 * q->z;
    }
    cage_bridge(c, SIDES, below, lower);
    for (uint32_t i = TO; i < FROM + SIDES; i++) {
        uint32_t a = i % SIDES, b = (i + 1) % SIDES;
        cage_quad(c, lower + a, lower + b, upper + b, upper + a);
    }
    cut_slot(c, lower, upper, FROM, TO, 0.55);
    const struct cage_profile tip[] = {{5.2, 73.5, 0}, {2.4, 76.0, 1.5}, {2.4, 76.8, 1},
                                       {3.6, 78.8, 0}, {3.4, 81.6, 0},   {1.6, 83.6, 0}};
    close_ball(c, SIDES, cage_turn(c, SIDES, upper, tip, NG_COUNT(tip)), 83.8);
}

static void build_queen(struct cage *c)
{
    enum { N = 16 };
    uint32_t ring = turn_foot(c, N, 19.5);
    const struct cage_profile p[] = {
        {11.2, 17.0, 0}, {9.4, 23.0, 0},  {7.6, 33.0, 0}, {6.8, 46.0, 0},  {7.4, 55.0, 1.5},
        {11.6, 56.6, 2}, {11.6, 58.6, 2}, {7.2, 60.0, 2}, {9.2, 61.0, 2},  {9.2, 62.8, 2},
        {6.6, 64.2, 2},  {7.6, 70.0, 0},  {9.6, 78.0, 0}, {12.2, 84.6, 0},
    };
    uint32_t cup = cage_turn(c, N, ring, p, NG_COUNT(p));
    // The coronet: every other point of the rim is a spike.
    uint32_t outer = cage_ring(c, N, 13.0, 88.0), inner = cage_ring(c, N, 10.8, 88.0);
    for (uint32_t i = 0; i < 2 * N; i += 2) {
        struct vec3 *q = &c->points.items[outer + i];
        *q = vec3_make(q->x * 1.06, q->y + 4.5, q->z * 1.06);
        cage_add_corner(c, outer + i, 2.5);
    }
    for (uint32_t i = 1; i < 2 * N; i += 2)
        c->points.items[outer + i].y -= 1.5;
    cage_bridge(c, N, cup, outer);
    cage_bridge(c, N, outer, inner);
    cage_crease_ring(c, N, outer, 2);
    cage_crease_ring(c, N, inner, 2);
    const struct cage_profile top[] = {{9.0, 84.0, 1.5}, {7.4, 87.0, 0}, {4.6, 89.6, 0}, {2.4, 90.4, 1.5},
                                       {3.9, 92.6, 0},   {3.9, 95.2, 0}, {1.8, 97.6, 0}};
    close_ball(c, N, cage_turn(c, N, inner, top, NG_COUNT(top)), 97.9);
}

// A cross whose arms widen: a plus-shaped outline of 12 points, drawn twice, front and back.
static void add_cross(struct cage *c, double bottom)
{
    static const double outline[12][2] = {
        {-1.5, 5.4}, {-2.7, 0.0}, {2.7, 0.0},   {1.5, 5.4},  {5.6, 4.2},  {5.6, 9.2},
        {1.5, 8.0},  {2.5, 12.6}, {-2.5, 12.6}, {-1.5, 8.0}, {-5.6, 9.2}, {-5.6, 4.2},
    };
    uint32_t first = (uint32_t)c->points.count;
    for (int back = 0; back < 2; back++)
        for (int i = 0; i < 12; i++)
            cage_point(c, vec3_make(outline[i][0], bottom + outline[i][1], back ? -1.7 : 1.7));
    static const uint32_t arms[5][4] = {
        {0, 1, 2, 3}, {3, 4, 5, 6}, {6, 7, 8, 9}, {9, 10, 11, 0}, {0, 3, 6, 9}};
    for (int i = 0; i < 5; i++) {
        const uint32_t *a = arms[i];
        cage_quad(c, first + a[0], first + a[1], first + a[2], first + a[3]);
        cage_quad(c, first + 12 + a[3], first + 12 + a[2], first + 12 + a[1], first + 12 + a[0]);
    }
    for (uint32_t i = 0; i < 12; i++) {
        uint32_t j = (i + 1) % 12;
        cage_quad(c, first + j, first + i, first + 12 + i, first + 12 + j);
        cage_add_crease(c, first + i, first + j, 2);
        cage_add_crease(c, first + 12 + i, first + 12 + j, 2);
        cage_add_crease(c, first + i, first + 12 + i, 2);
    }
}

static void build_king(struct cage *c)
{
    uint32_t ring = turn_foot(c, SIDES, 20.5);
    const struct cage_profile p[] = {
        {11.8, 17.8, 0}, {10.0, 24.0, 0}, {8.2, 35.0, 0},  {7.4, 49.0, 0},  {8.0, 59.0, 1.5},
        {12.4, 60.6, 2}, {12.4, 62.8, 2}, {7.8, 64.2, 2},  {9.8, 65.2, 2},  {9.8, 67.2, 2},
        {7.2, 68.6, 2},  {8.2, 75.0, 0},  {10.2, 84.0, 0}, {12.4, 90.5, 1}, {12.6, 92.6, 2},
        {11.2, 94.0, 2}, {9.4, 97.0, 0},  {5.4, 100.6, 0}, {2.8, 101.4, 2}, {2.8, 103.0, 2},
    };
    close_ball(c, SIDES, cage_turn(c, SIDES, ring, p, NG_COUNT(p)), 103.6);
    add_cross(c, 102.8);
}

void piece_build(enum piece kind, struct cage *c)
{
    static void (*const builders[PIECE_KINDS])(struct cage *) = {build_pawn,   build_rook,  build_knight,
                                                                 build_bishop, build_queen, build_king};
    builders[kind](c);
    cage_scale(c, DRAWN);
}
