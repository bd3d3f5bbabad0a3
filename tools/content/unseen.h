// Shapes that nothing trained on the chess scene has seen: torus knots and a skinned figure, each in place of
// a piece.
#ifndef CONTENT_UNSEEN_H
#define CONTENT_UNSEEN_H

#include "glb.h"
#include "pieces.h"

// Fills an empty cage with a knot that stands where a piece of this kind would, as high.
void knot_build(enum piece kind, struct cage *c);

// What all figures of a file share (character.c).
struct figure {
    int mesh, inverse_bind;
};
struct figure figure_init(struct glb *g, int material);
// A figure of this size on the ground of node `parent` (index + 1), which walks in the animation `clip`.
void figure_add(struct glb *g, const struct figure *f, const char *name, int parent, double scale, int clip);
#define FIGURE_HEIGHT 1.8 // at life size

#endif
