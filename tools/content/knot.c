// Torus knots: a curve that runs p times around a torus while it runs q times around its tube, with a tube of
// its own around it. The torus stands on its edge.
#include "unseen.h"

// Turns around the axis and around the tube: coprime, so that the curve is one.
static const int turns[PIECE_KINDS][2] = {
    [PIECE_PAWN] = {2, 3},   [PIECE_ROOK] = {3, 2},  [PIECE_KNIGHT] = {2, 5},
    [PIECE_BISHOP] = {3, 4}, [PIECE_QUEEN] = {4, 3}, [PIECE_KING] = {3, 5},
};

enum { SIDES = 6, SEGMENTS_A_TURN = 14 };
#define TORUS 0.60 // radii, for a knot of radius 1
#define TUBE  0.26
#define THICK 0.16
#define WIDER 1.3 // than the foot of the piece

static struct vec3 torus_at(double around, double across, double radius)
{
    double out = TORUS + radius * cos(across);
    return vec3_make(out * cos(around), out * sin(around), radius * sin(across));
}

// Ring `i` of `count`, in the plane across the curve; the direction away from the tube's middle is never
// along the curve, so it serves as the other axis.
static void add_ring(struct cage *c, const int turn[2], int i, int count)
{
    double t = 2.0 * CONTENT_PI * i / count, step = 1e-4;
    struct vec3 at = torus_at(turn[0] * t, turn[1] * t, TUBE);
    struct vec3 ahead = torus_at(turn[0] * (t + step), turn[1] * (t + step), TUBE);
    struct vec3 along = vec3_normalize(vec3_sub(ahead, at));
    struct vec3 away = vec3_sub(at, torus_at(turn[0] * t, 0.0, 0.0));
    away = vec3_normalize(vec3_sub(away, vec3_scale(along, vec3_dot(away, along))));
    struct vec3 side = vec3_cross(along, away);
    for (int k = 0; k < SIDES; k++) {
        double angle = 2.0 * CONTENT_PI * k / SIDES;
        struct vec3 offset =
            vec3_add(vec3_scale(away, THICK * cos(angle)), vec3_scale(side, THICK * sin(angle)));
        cage_point(c, vec3_add(at, offset));
    }
}

// From radius 1 around the origin to a piece's place and size.
static void stand(struct cage *c, enum piece kind)
{
    double bottom = 0.0, top = 0.0, wide = WIDER * piece_radius(kind);
    for (size_t i = 0; i < c->points.count; i++) {
        bottom = fmin(bottom, c->points.items[i].y);
        top = fmax(top, c->points.items[i].y);
    }
    double high = piece_height(kind) / (top - bottom);
    for (size_t i = 0; i < c->points.count; i++) {
        struct vec3 *p = &c->points.items[i];
        *p = vec3_make(p->x * wide, (p->y - bottom) * high, p->z * wide);
    }
}

void knot_build(enum piece kind, struct cage *c)
{
    const int *turn = turns[kind];
    int count = SEGMENTS_A_TURN * (turn[0] > turn[1] ? turn[0] : turn[1]);
    for (int i = 0; i < count; i++)
        add_ring(c, turn, i, count);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < SIDES; k++) {
            uint32_t here = (uint32_t)(i * SIDES), next = (uint32_t)((i + 1) % count * SIDES);
            uint32_t a = (uint32_t)k, b = (uint32_t)((k + 1) % SIDES);
            cage_quad(c, here + a, here + b, next + b, next + a);
        }
    stand(c, kind);
}
