#include "cloth.h"

#include "../vec.h"

#include <stdlib.h>

enum { SIZE = 64 };

// Noise on a lattice of `cells` that repeats.
static double tiled(double u, double v, int cells_u, int cells_v, uint32_t seed)
{
    double x = u * cells_u, y = v * cells_v, fx = floor(x), fy = floor(y), tx = x - fx, ty = y - fy,
           sum = 0.0;
    tx = tx * tx * (3.0 - 2.0 * tx);
    ty = ty * ty * (3.0 - 2.0 * ty);
    for (int i = 0; i < 4; i++) {
        uint32_t a = (uint32_t)(((int)fx + (i & 1) + cells_u) % cells_u),
                 b = (uint32_t)(((int)fy + (i >> 1) + cells_v) % cells_v);
        uint32_t h = a * 0x8da6b343u ^ b * 0xd8163841u ^ seed * 0xcb1ab31fu;
        h = (h ^ h >> 15) * 0x2c1b3c6du;
        h = (h ^ h >> 12) * 0x297a2d39u;
        h ^= h >> 15;
        sum += h / 4294967295.0 * (i & 1 ? tx : 1.0 - tx) * (i & 2 ? ty : 1.0 - ty);
    }
    return sum;
}

// Irregular, since the rows of regular threads beat with those of pixels.
static double weave(double u, double v)
{
    return 0.6 * tiled(u, v, 20, 9, 11) + 0.6 * tiled(u, v, 9, 20, 12) + 0.4 * tiled(u, v, 31, 31, 13);
}

static double denim(double u, double v)
{
    return 0.6 * tiled(u + v, v, 12, 5, 5) + 0.5 * tiled(u, v, 25, 25, 6);
}

static double leather(double u, double v)
{
    double n = tiled(u, v, 6, 6, 1) + 0.7 * tiled(u, v, 13, 11, 2) + 0.35 * tiled(u, v, 25, 23, 3);
    return fabs(n - 1.0) * 1.2;
}

static double strands(double u, double v)
{
    return 0.6 * tiled(u, v, 9, 2, 7) + 0.45 * tiled(u, v, 22, 2, 8);
}

static ng_result relief(double (*height)(double, double), double depth, double depth_v, struct bytes *out)
{
    unsigned char *pixels = malloc((size_t)SIZE * SIZE * 3);
    if (!pixels)
        return NG_ERROR_MEMORY;
    const double step = 1.0 / SIZE;
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            double u = (x + 0.5) * step, v = (y + 0.5) * step;
            struct vec3 n =
                vec3_normalize(vec3_make(depth * (height(u - step, v) - height(u + step, v)),
                                         depth_v * (height(u, v + step) - height(u, v - step)), 1.0));
            pixels[(y * SIZE + x) * 3] = (unsigned char)lround(127.5 + 127.5 * n.x);
            pixels[(y * SIZE + x) * 3 + 1] = (unsigned char)lround(127.5 + 127.5 * n.y);
            pixels[(y * SIZE + x) * 3 + 2] = (unsigned char)lround(127.5 + 127.5 * n.z);
        }
    ng_result result = image_png(SIZE, SIZE, 3, pixels, out);
    free(pixels);
    return result;
}

ng_result cloth_weave(struct bytes *out)
{
    return relief(weave, 0.35, 0.35, out);
}

ng_result cloth_denim(struct bytes *out)
{
    return relief(denim, 0.35, 0.35, out);
}

ng_result cloth_leather(struct bytes *out)
{
    return relief(leather, 0.45, 0.45, out);
}

ng_result cloth_strands(struct bytes *out)
{
    return relief(strands, 0.9, 0.15, out);
}
