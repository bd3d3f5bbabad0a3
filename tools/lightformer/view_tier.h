// How many pixels a picture has while something moves: as many as can be made in time. Plain data.
//
// Level 0 is all of them. Plain levels have three quarters of the pixels of the level before. Where light can
// be upsampled, level 1 computes it for a quarter of the pixels, and it is the picture that gets smaller from
// there.
#ifndef LIGHTFORMER_VIEW_TIER_H
#define LIGHTFORMER_VIEW_TIER_H

#include <stdbool.h>
#include <stdint.h>

#define VIEW_TIERS     16u
#define VIEW_MOVING_MS 100.0 // that a picture may take while something moves

// Zero to begin with, but for what upsamples.
struct view_tier {
    bool upsamples;
    uint32_t level; // of the next picture
    uint32_t calm;  // pictures in a row that left time for more pixels
    double ms;      // of the last picture, as if it had been of level 1; 0: none was made
    double ratio;   // what level 0 takes of that; 0: not measured
};

// A picture of that level, made while something moved, took so long. Levels fall at once and rise after a few
// pictures, so that they do not flutter.
void view_tier_add(struct view_tier *tier, uint32_t level, double ms);
// The first picture after that, whole and of something at rest, took so long.
void view_tier_add_whole(struct view_tier *tier, double ms);

struct view_pixels {
    uint32_t picture[2], light[2]; // width and height
};
struct view_pixels view_tier_pixels(const struct view_tier *tier, uint32_t level, const uint32_t whole[2]);

#endif
