// Interleaved sampling (Keller and Heidrich 2001): pixels of a block ask different questions (another point
// of the light, another direction of the lobe), and every pixel takes the answers of a block around it, of
// surfaces like its own: as many answers as the block has pixels for one ray each, from a pattern that never
// changes.
#ifndef LF_CLUES_INTERLEAVED_H
#define LF_CLUES_INTERLEAVED_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct lf_clues_scene;
struct lf_pixel_clues;

#define LF_INTERLEAVE      4                   // pixels of a block each way
#define LF_INTERLEAVE_TAPS (LF_INTERLEAVE + 1) // neighbours each way that are looked at
#define LF_INTERLEAVE_HALF 2                   // of them on each side

// Index of a pixel, or of a ray, in its block: 0 to LF_INTERLEAVE^2 - 1.
static inline uint32_t lf_interleave_index(uint32_t x, uint32_t y)
{
    return y % LF_INTERLEAVE * LF_INTERLEAVE + x % LF_INTERLEAVE;
}

// The same 16 numbers in an order in which any four neighbours are far apart.
extern const unsigned char lf_interleave_order[LF_INTERLEAVE * LF_INTERLEAVE];

// One of LF_INTERLEAVE_DIRECTIONS for a pixel in 2 x 2 blocks. Where it is in its block decides more than
// which block that is: so any block has choices from all over.
#define LF_INTERLEAVE_DIRECTIONS (4 * LF_INTERLEAVE * LF_INTERLEAVE)
static inline uint32_t lf_interleave_direction(uint32_t x, uint32_t y)
{
    static const unsigned char quarters[4] = {0, 2, 3, 1};
    return 4u * lf_interleave_order[lf_interleave_index(x, y)] +
           quarters[y / LF_INTERLEAVE % 2 * 2 + x / LF_INTERLEAVE % 2];
}

// Weights of LF_INTERLEAVE_TAPS neighbours in a row, of which those inside a block's width around `at` (in
// pixels from the first) count: so each of a block's samples counts as one, wherever the block is.
void lf_interleave_window(float at, float out[LF_INTERLEAVE_TAPS]);

// What each pixel's own rays found: planes.
struct lf_interleaved {
    float *part;    // from 0 to 1
    float *weight;  // of the answer; 0: nothing was asked
    float *scratch; // overwritten
};

// What a pixel and its neighbours found, as a set.
enum { LF_FOUND_LIT = 1, LF_FOUND_HIDDEN = 2 };

// How much a light asks, by how many the snapshot has: they share the rays of a picture. Those that are off
// count, so that switching one redoes nothing of the others.
enum lf_questions {
    LF_ASK_ALL,      // everywhere, and once more in doubt
    LF_ASK_IN_DOUBT, // a quarter of the pixels; all where these disagree
    LF_ASK_FEW,      // a quarter
};
static inline enum lf_questions lf_questions_of(uint32_t lights)
{
    return lights <= 2 ? LF_ASK_ALL : lights <= 4 ? LF_ASK_IN_DOUBT : LF_ASK_FEW;
}

// A quarter of the pixels asks before the others do, which may then know enough; and those at edges, for
// which no other speaks. Who it is takes turns from block to block, so that all questions have theirs.
bool lf_interleaved_asks_first(const struct lf_pixel_clues *pixels, uint32_t x, uint32_t y);

// Collects what each pixel and its neighbours found, in scratch.
void lf_interleaved_collect(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                            const struct lf_interleaved *rays);
// Those of one pixel and its neighbours; after lf_interleaved_collect.
unsigned lf_interleaved_found(const struct lf_pixel_clues *pixels, const struct lf_interleaved *rays,
                              uint32_t x, uint32_t y);

// The parts that pixels found, as the bilaterally weighted mean of their neighbours': sum of part * weight
// over sum of weight. 0 where no neighbour was asked. `specular`: only neighbours count whose highlights look
// into the same directions. `out` is none of the planes of `rays`.
void lf_interleaved_filter(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                           const struct lf_interleaved *rays, bool specular, float *out);

// At edges few neighbours are alike, and what these found is another surface's, or a neighbour's alone: of
// pixels in doubt there that asked, `own` of the answer is what they found themselves. After
// lf_interleaved_filter, which leaves `out`.
void lf_interleaved_own_at_edges(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                                 const struct lf_interleaved *rays, float own, float *out);

#define LF_EDGE_RAYS     3    // more that pixels in doubt at edges cast
#define LF_OWN_PART      0.8f // of what pixels at edges found by these
#define LF_OWN_PART_ONCE 0.5f // of what they found by one

NG_EXTERN_C_END

#endif
