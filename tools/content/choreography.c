// Sixteen moves, the same for both sides but for the order: dark moves mirror light ones, but the knights,
// which would meet in the air, wait. Each move needs its way free when its turn comes, which the test of this
// file checks for every frame.
#include "choreography.h"

static const struct {
    enum piece kind;
    const char *from, *to; // of the light piece
    int dark_turn;         // light's turn is its place here
} moves[DANCERS / 2] = {
    {PIECE_PAWN, "a2", "a4", 0},   {PIECE_PAWN, "h3", "h4", 1},  {PIECE_PAWN, "e3", "e4", 2},
    {PIECE_KNIGHT, "f3", "g5", 7}, {PIECE_PAWN, "f2", "f4", 8},  {PIECE_KNIGHT, "c3", "b5", 9},
    {PIECE_PAWN, "c2", "c3", 10},  {PIECE_PAWN, "d3", "d4", 3},  {PIECE_BISHOP, "c4", "a2", 4},
    {PIECE_BISHOP, "d2", "e3", 5}, {PIECE_PAWN, "b2", "b3", 6},  {PIECE_QUEEN, "e2", "f3", 11},
    {PIECE_PAWN, "g2", "g3", 12},  {PIECE_KING, "g1", "g2", 13}, {PIECE_ROOK, "e1", "h1", 14},
    {PIECE_ROOK, "a1", "d1", 15},
};

static const double first_move = 0.2, between_moves = 0.255, dark_follows = 0.13;

static void square(const char *name, bool dark, int out[2])
{
    out[0] = name[0] - 'a';
    out[1] = dark ? '8' - name[1] : name[1] - '1';
}

struct dancer dance_get(int i)
{
    int move = i % (DANCERS / 2);
    struct dancer d = {.kind = moves[move].kind, .dark = i >= DANCERS / 2};
    int turn = d.dark ? moves[move].dark_turn : move;
    square(moves[move].from, d.dark, d.from);
    square(moves[move].to, d.dark, d.to);
    double length = hypot(d.to[0] - d.from[0], d.to[1] - d.from[1]);
    d.start = first_move + between_moves * turn + (d.dark ? dark_follows : 0.0);
    d.duration = 0.42 + 0.11 * length;
    if (d.kind == PIECE_KNIGHT) {
        d.duration += 0.25;
        d.lift = 0.16;
    }
    return d;
}

// A move eases in and out; a hop is a parabola over it.
struct vec3 dance_at(const struct dancer *d, double time)
{
    double t = time < 0.5 * DANCE_SECONDS ? time : DANCE_SECONDS - time;
    double s = fmin(fmax((t - d->start) / d->duration, 0.0), 1.0);
    double along = s * s * (3.0 - 2.0 * s);
    return vec3_make(d->from[0] + along * (d->to[0] - d->from[0]), d->lift * 4.0 * along * (1.0 - along),
                     d->from[1] + along * (d->to[1] - d->from[1]));
}
