// Value noise and a few formulas; every picture wraps around at its edges.
#include "texture.h"

#include "base/hash.h"
#include "vec.h"

#include <stdlib.h>

double texture_noise(double x, double y, uint32_t nx, uint32_t ny, uint64_t seed)
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
    double wobble = texture_noise(u, v, 3, 2, seed) * 0.55 + texture_noise(u, v, 8, 3, seed + 1) * 0.12;
    double ring = (u + wobble) * 9.0;
    ring -= floor(ring);
    double year = ring < 0.8 ? ring / 0.8 : (1.0 - ring) / 0.2;
    double pores = texture_noise(u, v, 128, 6, seed + 2) * 0.6 + texture_noise(u, v, 64, 4, seed + 3) * 0.4;
    double cloud = texture_noise(u, v, 4, 2, seed + 4);
    return 0.42 * year * year + 0.36 * pores + 0.22 * cloud;
}

// A palette from the colour of spring wood to that of pores and late wood, both sRGB.
static ng_result wood_png(const unsigned char spring[3], const unsigned char late[3], uint64_t seed,
                          struct bytes *out)
{
    enum { SIZE = 256 };
    unsigned char palette[256][3];
    for (int i = 0; i < 256; i++)
        for (int k = 0; k < 3; k++)
            palette[i][k] = (unsigned char)((spring[k] * (255 - i) + late[k] * i + 127) / 255);
    unsigned char *pixels = malloc((size_t)SIZE * SIZE);
    if (!pixels)
        return NG_ERROR_MEMORY;
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++)
            pixels[y * SIZE + x] =
                (unsigned char)(255.0 * wood_tone((x + 0.5) / SIZE, (y + 0.5) / SIZE, seed));
    ng_result result = image_png_indexed(SIZE, SIZE, pixels, palette, 256, out);
    free(pixels);
    return result;
}

ng_result texture_maple(struct bytes *out)
{
    static const unsigned char spring[3] = {236, 210, 168}, late[3] = {196, 152, 100};
    return wood_png(spring, late, 100, out);
}

ng_result texture_walnut(struct bytes *out)
{
    static const unsigned char spring[3] = {120, 78, 50}, late[3] = {62, 36, 22};
    return wood_png(spring, late, 110, out);
}

// ---- pictures made pixel by pixel ----

enum { SMALL = 64 };

// Fills `pixel` (channels as asked) for u, v of a pixel's centre.
typedef void (*shader)(double u, double v, unsigned char *pixel);

static ng_result small_png(shader shade, uint32_t channels, struct bytes *out)
{
    unsigned char *pixels = calloc((size_t)SMALL * SMALL, channels);
    if (!pixels)
        return NG_ERROR_MEMORY;
    for (uint32_t y = 0; y < SMALL; y++)
        for (uint32_t x = 0; x < SMALL; x++)
            shade((x + 0.5) / SMALL, (y + 0.5) / SMALL, pixels + ((size_t)y * SMALL + x) * channels);
    ng_result result = image_png(SMALL, SMALL, channels, pixels, out);
    free(pixels);
    return result;
}

static void set_rgb(unsigned char *pixel, int r, int g, int b)
{
    pixel[0] = (unsigned char)r;
    pixel[1] = (unsigned char)g;
    pixel[2] = (unsigned char)b;
}

static void panes(double u, double v, unsigned char *pixel)
{
    static const unsigned char glass[4][3] = {
        {255, 90, 70}, {255, 220, 120}, {90, 200, 255}, {150, 255, 140}};
    double x = u * 2.0 - floor(u * 2.0), y = v * 2.0 - floor(v * 2.0);
    const unsigned char *c = glass[(u > 0.5) + 2 * (v > 0.5)];
    if (fmin(fmin(x, 1.0 - x), fmin(y, 1.0 - y)) < 0.06)
        set_rgb(pixel, 6, 6, 6);
    else
        set_rgb(pixel, c[0], c[1], c[2]);
}

ng_result texture_panes(struct bytes *out)
{
    return small_png(panes, 3, out);
}

static void checker(double u, double v, unsigned char *pixel)
{
    if (((int)(u * 8.0) + (int)(v * 8.0)) % 2)
        set_rgb(pixel, 235, 225, 205);
    else
        set_rgb(pixel, 40, 60, 110);
}

ng_result texture_checker(struct bytes *out)
{
    return small_png(checker, 3, out);
}

// Distance from the middle of the cell of a 4 x 4 lattice, in cells; x and y from the middle.
static double cell(double u, double v, double *x, double *y)
{
    *x = u * 4.0 - floor(u * 4.0) - 0.5;
    *y = v * 4.0 - floor(v * 4.0) - 0.5;
    return sqrt(*x * *x + *y * *y);
}

static void holes(double u, double v, unsigned char *pixel)
{
    double x, y, alpha = fmin(fmax((cell(u, v, &x, &y) - 0.34) / 0.08 + 0.5, 0.0), 1.0);
    set_rgb(pixel, 210, 120, 40);
    pixel[3] = (unsigned char)(alpha * 255.0 + 0.5);
}

ng_result texture_holes(struct bytes *out)
{
    return small_png(holes, 4, out);
}

// Spherical caps; +Y of the normal is up in the picture, where v grows downwards.
static void domes(double u, double v, unsigned char *pixel)
{
    double x, y, r = cell(u, v, &x, &y);
    double nx = r < 0.4 ? x * 1.8 : 0.0, ny = r < 0.4 ? -y * 1.8 : 0.0, nz = sqrt(1.0 - nx * nx - ny * ny);
    set_rgb(pixel, (int)(nx * 127.5 + 128.0), (int)(ny * 127.5 + 128.0), (int)(nz * 127.5 + 127.5));
}

ng_result texture_domes(struct bytes *out)
{
    return small_png(domes, 3, out);
}

static void metal_stripes(double u, double v, unsigned char *pixel)
{
    set_rgb(pixel, 0, (int)(u * 8.0) % 2 ? 200 : 50, (int)(v * 4.0) % 2 ? 255 : 0);
}

ng_result texture_metal_stripes(struct bytes *out)
{
    return small_png(metal_stripes, 3, out);
}

// ---- the sky ----

ng_result texture_sky(struct bytes *out)
{
    enum { W = 64, H = 32 };
    float *rgb = calloc((size_t)W * H, 3 * sizeof *rgb);
    if (!rgb)
        return NG_ERROR_MEMORY;
    for (int i = 0; i < W * H; i++) {
        int x = i % W, y = i / W;
        double up = cos(CONTENT_PI * (y + 0.5) / H), haze = 1.0 - fabs(up);
        double sky[3] = {0.25 + 0.35 * haze, 0.40 + 0.30 * haze, 0.75 + 0.10 * haze};
        double ground[3] = {0.16, 0.13, 0.10};
        bool sun = y >= 8 && y <= 9 && x >= 14 && x <= 15;
        for (int k = 0; k < 3; k++)
            rgb[i * 3 + k] = (float)(sun ? 60.0 - 10.0 * k : up > 0.0 ? sky[k] : ground[k]);
    }
    ng_result result = image_hdr(W, H, rgb, out);
    free(rgb);
    return result;
}
