// The six chess pieces as subdivision cages: standing at the origin, +Y up, knights face +Z. Metres.
#ifndef CONTENT_PIECES_H
#define CONTENT_PIECES_H

#include "cage.h"

enum piece { PIECE_PAWN, PIECE_ROOK, PIECE_KNIGHT, PIECE_BISHOP, PIECE_QUEEN, PIECE_KING, PIECE_KINDS };

// Fills an empty cage.
void piece_build(enum piece kind, struct cage *c);
// The body of the knight above its foot, from an open ring of KNIGHT_SIDES points. Millimetres.
#define KNIGHT_SIDES 12
void knight_body(struct cage *c, uint32_t foot);

const char *piece_name(enum piece kind);
double piece_radius(enum piece kind); // of the foot, the widest part
double piece_height(enum piece kind);

#endif
