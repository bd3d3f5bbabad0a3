#include "texture.h"

#include "base/hash.h"
#include "vec.h"

#include <stdlib.h>

// Value noise on a lattice of nx by ny cells that wraps around; 0 to 1. x and y in [0, 1).
static double noise(double x, double y, uint32_t nx, uint32_t ny, uint64_t seed)
{
    double fx = x * nx, fy = y * ny;
    uint32_t ix = (uint32_t)fx, iy = (uint32_t)fy;
    double tx = fx - ix, ty = fy - iy, value = 0.0;
    tx = tx * tx * (3.0 - 2.0 * tx);
    ty = ty * ty * (3.0 - 2.0 * ty);
    for (uint32_t k = 0; k < 4; k++) {
        uint64_t cell = ((uint64_t)((iy + k / 2) % ny) << 32) | ((ix + k % 2) % nx);
        double v = (double)(ng_hash_combine(seed, cell) >> 40) * 0x1p-24;
        value += v * (k % 2 ? tx : 1.0 - tx) * (k / 2 ? ty : 1.0 - ty);
    }
    return value;
}

// Year rings seen along the plank: a wobbling saw-tooth across u, with fine pores stretched along v.
static double wood_tone(double u, double v, uint64_t seed)
{
    double wobble = noise(u, v, 3, 2, seed) * 0.55 + noise(u, v, 8, 3, seed + 1) * 0.12;
    double ring = (u + wobble) * 9.0;
    ring -= floor(ring);
    double year = ring < 0.8 ? ring / 0.8 : (1.0 - ring) / 0.2;
    double pores = noise(u, v, 128, 6, seed + 2) * 0.6 + noise(u, v, 64, 4, seed + 3) * 0.4;
    double cloud = noise(u, v, 4, 2, seed + 4);
    return 0.42 * year * year + 0.36 * pores + 0.22 * cloud;
}

ng_result texture_wood(enum texture_wood wood, struct bytes *out)
{
    enum { SIZE = 256 };
    static const unsigned char ends[2][2][3] = {
        [TEXTURE_MAPLE] = {{236, 210, 168}, {196, 152, 100}},
        [TEXTURE_WALNUT] = {{120, 78, 50}, {62, 36, 22}},
    };
    unsigned char palette[256][3];
    for (int i = 0; i < 256; i++)
        for (int k = 0; k < 3; k++)
            palette[i][k] =
                (unsigned char)((ends[wood][0][k] * (255 - i) + ends[wood][1][k] * i + 127) / 255);
    unsigned char *pixels = malloc((size_t)SIZE * SIZE);
    if (!pixels)
        return NG_ERROR_MEMORY;
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++)
            pixels[y * SIZE + x] = (unsigned char)(255.0 * wood_tone((x + 0.5) / SIZE, (y + 0.5) / SIZE,
                                                                     100 + 10 * (uint64_t)wood));
    ng_result result = image_png_indexed(SIZE, SIZE, pixels, palette, 256, out);
    free(pixels);
    return result;
}
