// Who stands where when: the chess scene's ten-second dance of all 32 pieces.
//
// From a developed position every piece makes one move of its own kind into the middle game, then they take
// their moves back, last first, and the loop closes. Times in seconds; board coordinates are in squares: file
// a to h = 0 to 7, rank 1 to 8 = 0 to 7, heights above the board in metres.
#ifndef CONTENT_CHOREOGRAPHY_H
#define CONTENT_CHOREOGRAPHY_H

#include "pieces.h"

#include <stdbool.h>

enum { DANCERS = 32 };
#define DANCE_SECONDS 10.0

struct dancer {
    enum piece kind;
    bool dark;
    int from[2], to[2];     // file, rank
    double start, duration; // of the move there; the way back mirrors it in time
    double lift;            // height of the hop; 0: it slides
};

// Dancer `i`, light pieces first.
struct dancer dance_get(int i);
// Where the dancer is: file, height, rank.
struct vec3 dance_at(const struct dancer *d, double time);

#endif
