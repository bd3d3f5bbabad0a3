// Sharing rays between neighbours. Pixels of a block ask different questions (another point of the light,
// another direction of the lobe), and every pixel takes the answers of a block around it, of surfaces like
// its own: as many answers as the block has pixels for one ray each, from a pattern that never changes
// (interleaved sampling; Keller and Heidrich 2001).
#ifndef LF_CLUES_INTERLEAVED_H
#define LF_CLUES_INTERLEAVED_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct lf_encode_scene;
struct lf_pixel_clues;

#define LF_BLOCK       4              // places each way
#define LF_BLOCK_REACH (LF_BLOCK + 1) // neighbours each way that are looked at
#define LF_BLOCK_HALF  2              // of them on each side

// Place of a pixel, or of a ray, in its block: 0 to LF_BLOCK^2 - 1.
static inline uint32_t lf_block_place(uint32_t x, uint32_t y)
{
    return y % LF_BLOCK * LF_BLOCK + x % LF_BLOCK;
}

// The same 16 numbers in an order in which any four neighbours are far apart.
extern const unsigned char lf_block_order[LF_BLOCK * LF_BLOCK];

// One of LF_BLOCK_CHOICES for a place in 2 x 2 blocks. Where it is in its block decides more than which block
// that is: so any block has choices from all over.
#define LF_BLOCK_CHOICES (4 * LF_BLOCK * LF_BLOCK)
static inline uint32_t lf_block_choice(uint32_t x, uint32_t y)
{
    static const unsigned char quarters[4] = {0, 2, 3, 1};
    return 4u * lf_block_order[lf_block_place(x, y)] + quarters[y / LF_BLOCK % 2 * 2 + x / LF_BLOCK % 2];
}

// Weights of LF_BLOCK_REACH places in a row, of which those inside a block's width around `at` (in places
// from the first) count: so each of a block's places counts as one, wherever the block is.
void lf_block_window(float at, float out[LF_BLOCK_REACH]);

// What each pixel's own rays found: planes.
struct lf_block_rays {
    float *part;    // from 0 to 1
    float *weight;  // of the answer; 0: nothing was asked
    float *scratch; // overwritten
};

// What a pixel and its neighbours found, as a set.
enum { LF_BLOCK_LIT = 1, LF_BLOCK_HIDDEN = 2 };

// Finds the opinions of all pixels, in scratch.
void lf_block_ask(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                  const struct lf_block_rays *rays);
// Those of one pixel and its neighbours; after lf_block_ask.
unsigned lf_block_opinions(const struct lf_pixel_clues *pixels, const struct lf_block_rays *rays, uint32_t x,
                           uint32_t y);

// The parts that pixels found, as the weighted mean of their neighbours': sum of part * weight over sum of
// weight. 0 where no neighbour was asked. `lobes`: only neighbours count whose highlights look into the same
// directions. `out` is none of the planes of `rays`.
void lf_block_average(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                      const struct lf_block_rays *rays, bool lobes, float *out);

NG_EXTERN_C_END

#endif
