// Most are a field of heights or tones over the unit square, painted with a ramp of colours or turned into
// slopes. An indexed picture takes a byte a texel, whatever it holds, so slopes and roughness are indexed
// too.
#include "picture.h"

#include "../texture.h"
#include "../vec.h"
#include "solid.h"

#include <stdlib.h>

typedef double (*field)(double u, double v);

struct rgb {
    double r, g, b; // sRGB, 0 to 255
};

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

static double step_smooth(double from, double to, double x)
{
    double t = clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

static double fraction(double x)
{
    return x - floor(x);
}

static struct rgb mix(struct rgb a, struct rgb b, double t)
{
    return (struct rgb){a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}

static unsigned char to_byte(double x)
{
    return (unsigned char)(clamp(x, 0.0, 255.0) + 0.5);
}

// ---- fields as pictures ----

static ng_result indexed(uint32_t width, uint32_t height, const unsigned char *pixels,
                         const struct rgb *colors, struct bytes *out)
{
    unsigned char palette[256][3];
    for (int i = 0; i < 256; i++) {
        palette[i][0] = to_byte(colors[i].r);
        palette[i][1] = to_byte(colors[i].g);
        palette[i][2] = to_byte(colors[i].b);
    }
    return image_png_indexed(width, height, pixels, palette, 256, out);
}

// The field from 0 to 1 as a ramp of `stops` colours.
static ng_result ramp(field f, uint32_t width, uint32_t height, const struct rgb *colors, int stops,
                      struct bytes *out)
{
    struct rgb palette[256];
    unsigned char *pixels = malloc((size_t)width * height);
    if (!pixels)
        return NG_ERROR_MEMORY;
    for (int i = 0; i < 256; i++) {
        double x = i / 255.0 * (stops - 1);
        int k = x < stops - 1 ? (int)x : stops - 2;
        palette[i] = mix(colors[k], colors[k + 1], x - k);
    }
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            pixels[(size_t)y * width + x] = to_byte(255.0 * f((x + 0.5) / width, (y + 0.5) / height));
    ng_result result = indexed(width, height, pixels, palette, out);
    free(pixels);
    return result;
}

static ng_result roughness(field f, uint32_t width, uint32_t height, double low, double high,
                           struct bytes *out)
{
    const struct rgb ends[2] = {{0, 255.0 * low, 0}, {0, 255.0 * high, 0}};
    return ramp(f, width, height, ends, 2, out);
}

// A height's slope over one texel, in steps of 1/16 of `steepest` in each direction.
static ng_result relief(field f, uint32_t width, uint32_t height, double steepest, double high,
                        struct bytes *out)
{
    enum { STEPS = 16 };
    struct rgb palette[256];
    unsigned char *pixels = malloc((size_t)width * height);
    if (!pixels)
        return NG_ERROR_MEMORY;
    for (int i = 0; i < 256; i++) {
        double x = (i % STEPS - 7) * steepest / 7.5, y = (i / STEPS - 7) * steepest / 7.5;
        struct vec3 n = vec3_normalize(vec3_make(-x, y, 1.0)); // v grows downwards, green upwards
        palette[i] = (struct rgb){n.x * 127.5 + 127.5, n.y * 127.5 + 127.5, n.z * 127.5 + 127.5};
    }
    double du = 0.5 / width, dv = 0.5 / height;
    for (uint32_t j = 0; j < height; j++)
        for (uint32_t i = 0; i < width; i++) {
            double u = (i + 0.5) / width, v = (j + 0.5) / height;
            double x = (f(u + du, v) - f(fraction(u - du), v)) * high / steepest;
            double y = (f(u, v + dv) - f(u, fraction(v - dv))) * high / steepest;
            int a = (int)clamp(floor(x * 7.5 + 7.5), 0, STEPS - 1),
                b = (int)clamp(floor(y * 7.5 + 7.5), 0, STEPS - 1);
            pixels[(size_t)j * width + i] = (unsigned char)(b * STEPS + a);
        }
    ng_result result = indexed(width, height, pixels, palette, out);
    free(pixels);
    return result;
}

// ---- pictures of several colours, each texel the mean of nine places ----

// Colour in sRGB and alpha from 0 to 1; v grows downwards.
typedef double (*painter)(double u, double v, struct rgb *color);

static ng_result paint(painter at, uint32_t width, uint32_t height, bool alpha, struct bytes *out)
{
    uint32_t channels = alpha ? 4 : 3;
    unsigned char *pixels = calloc((size_t)width * height, channels);
    if (!pixels)
        return NG_ERROR_MEMORY;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            struct rgb sum = {0, 0, 0};
            double cover = 0.0;
            for (int k = 0; k < 9; k++) {
                struct rgb c = {0, 0, 0};
                cover += at((x + (k % 3 + 0.5) / 3.0) / width, (y + (k / 3 + 0.5) / 3.0) / height, &c) / 9.0;
                sum = mix(sum, c, 1.0 / (k + 1));
            }
            unsigned char *p = pixels + ((size_t)y * width + x) * channels;
            p[0] = to_byte(sum.r);
            p[1] = to_byte(sum.g);
            p[2] = to_byte(sum.b);
            if (alpha)
                p[3] = to_byte(255.0 * cover);
        }
    ng_result result = image_png(width, height, channels, pixels, out);
    free(pixels);
    return result;
}

// ---- wood ----

// Year rings cut lengthwise: lines along v that bend around a knot of higher ground.
static double wood_rings(double u, double v)
{
    double ground = texture_noise(u, v, 4, 1, 300) * 0.9 + texture_noise(u, v, 9, 2, 301) * 0.22 +
                    texture_noise(u, v, 30, 3, 302) * 0.03;
    double ring = fraction(ground * 8.0);
    return ring < 0.75 ? ring / 0.75 : (1.0 - ring) / 0.25;
}

static double wood_fibres(double u, double v)
{
    return texture_noise(u, v, 90, 4, 303) * 0.6 + texture_noise(u, v, 45, 3, 304) * 0.4;
}

static double wood_tone(double u, double v)
{
    double pores = step_smooth(0.72, 0.9, texture_noise(u, v, 100, 18, 305));
    return clamp(0.1 + 0.34 * pow(wood_rings(u, v), 1.6) + 0.36 * wood_fibres(u, v) + 0.25 * pores, 0.0, 1.0);
}

enum { WOOD_WIDTH = 128, WOOD_HEIGHT = 192 };

ng_result picture_oak(struct bytes *out)
{
    static const struct rgb colors[3] = {{222, 190, 147}, {199, 161, 114}, {158, 119, 78}};
    return ramp(wood_tone, WOOD_WIDTH, WOOD_HEIGHT, colors, 3, out);
}

ng_result picture_walnut(struct bytes *out)
{
    static const struct rgb colors[3] = {{142, 100, 69}, {108, 71, 47}, {64, 41, 28}};
    return ramp(wood_tone, WOOD_WIDTH, WOOD_HEIGHT, colors, 3, out);
}

ng_result picture_wood_relief(struct bytes *out)
{
    return relief(wood_tone, WOOD_WIDTH, WOOD_HEIGHT / 3, 0.16, -0.35, out);
}

ng_result picture_wood_roughness(struct bytes *out)
{
    return roughness(wood_tone, WOOD_WIDTH / 2, WOOD_HEIGHT / 4, 0.38, 0.62, out);
}

// ---- cloth and leather ----

enum { THREADS = 24 };

// Height of a plain weave: threads go over and under one another.
static double weave(double u, double v)
{
    double x = u * THREADS, y = v * THREADS;
    int i = (int)x % THREADS, j = (int)y % THREADS;
    double a = sin(CONTENT_PI * fraction(x)), b = sin(CONTENT_PI * fraction(y));
    bool warp = (i + j) % 2;
    double thread = solid_random(warp ? 310 : 311, (uint64_t)(warp ? i : j)) * 0.25;
    return clamp((warp ? sqrt(a) * (0.45 + 0.55 * b) : sqrt(b) * (0.45 + 0.55 * a)) * 0.8 + thread, 0.0, 1.0);
}

static double weave_tone(double u, double v)
{
    int i = (int)(u * THREADS) % THREADS, j = (int)(v * THREADS) % THREADS;
    double thread = (i + j) % 2 ? solid_random(312, (uint64_t)i) : solid_random(313, (uint64_t)j);
    double slub = texture_noise(u, v, (i + j) % 2 ? 24 : 5, (i + j) % 2 ? 5 : 24, 314);
    return clamp(0.45 * weave(u, v) + 0.25 * thread + 0.3 * slub, 0.0, 1.0);
}

ng_result picture_weave(struct bytes *out)
{
    static const struct rgb colors[2] = {{168, 168, 168}, {255, 255, 255}};
    return ramp(weave_tone, 96, 96, colors, 2, out);
}

ng_result picture_weave_relief(struct bytes *out)
{
    return relief(weave, 96, 96, 0.8, 0.9, out);
}

// Distance from the borders of cells around jittered points, a little over 0 at a border.
static double pebbles(double u, double v)
{
    enum { CELLS = 22 };
    double x = u * CELLS, y = v * CELLS, first = 9.0, second = 9.0;
    for (int k = 0; k < 9; k++) {
        int i = (int)floor(x) + k % 3 - 1, j = (int)floor(y) + k / 3 - 1;
        uint64_t cell = (uint64_t)((j + CELLS) % CELLS * CELLS + (i + CELLS) % CELLS);
        double dx = i + 0.15 + 0.7 * solid_random(320, cell) - x,
               dy = j + 0.15 + 0.7 * solid_random(321, cell) - y;
        double d = hypot(dx, dy);
        second = fmin(second, fmax(first, d));
        first = fmin(first, d);
    }
    return step_smooth(0.0, 0.45, second - first) * 0.8 + 0.2 * texture_noise(u, v, 9, 9, 322);
}

ng_result picture_leather_relief(struct bytes *out)
{
    return relief(pebbles, 96, 96, 0.4, 0.55, out);
}

// ---- stone, wicker, plaster ----

static double marble(double u, double v)
{
    double warp = texture_noise(u, v, 3, 3, 330) + 0.5 * texture_noise(u, v, 7, 7, 331) +
                  0.25 * texture_noise(u, v, 15, 15, 332);
    double vein = fabs(fraction(warp * 1.6 + 0.15) - 0.5) * 2.0,
           fine = fabs(fraction(warp * 4.3) - 0.5) * 2.0;
    double cloud = texture_noise(u, v, 4, 4, 333) * 0.6 + texture_noise(u, v, 12, 12, 334) * 0.4;
    return clamp(0.62 * (1.0 - step_smooth(0.0, 0.14, vein)) * cloud +
                     0.22 * (1.0 - step_smooth(0.0, 0.1, fine)) + 0.22 * cloud,
                 0.0, 1.0);
}

ng_result picture_marble(struct bytes *out)
{
    static const struct rgb colors[3] = {{240, 238, 234}, {214, 211, 207}, {120, 117, 116}};
    return ramp(marble, 192, 192, colors, 3, out);
}

static double wicker(double u, double v)
{
    enum { STRANDS = 10 };
    double x = u * STRANDS, y = v * STRANDS * 2;
    double over = sin(CONTENT_PI * (x + floor(y)));
    double strand = sqrt(fmax(sin(CONTENT_PI * fraction(y)), 0.0));
    return clamp(strand * (0.55 + 0.45 * over), 0.0, 1.0);
}

static double wicker_tone(double u, double v)
{
    double fibre = texture_noise(u, v, 12, 80, 340);
    return clamp(0.75 * wicker(u, v) + 0.3 * fibre - 0.05, 0.0, 1.0);
}

ng_result picture_wicker(struct bytes *out)
{
    static const struct rgb colors[3] = {{74, 51, 30}, {171, 132, 84}, {214, 178, 126}};
    return ramp(wicker_tone, 96, 96, colors, 3, out);
}

ng_result picture_wicker_relief(struct bytes *out)
{
    return relief(wicker, 96, 96, 0.9, 0.8, out);
}

static double plaster(double u, double v)
{
    return texture_noise(u, v, 40, 40, 350) * 0.5 + texture_noise(u, v, 18, 18, 351) * 0.3 +
           texture_noise(u, v, 7, 7, 352) * 0.2;
}

ng_result picture_plaster_relief(struct bytes *out)
{
    return relief(plaster, 96, 96, 0.06, 0.12, out);
}

// ---- rugs ----

// A Berber rug: lozenges of dark lines on cream, a fringe of plain ground at the ends.
static double rug(double u, double v)
{
    double wobble = 0.010 * (texture_noise(u, v, 12, 12, 360) - 0.5);
    double x = fabs(fraction(u * 3.0 + wobble) - 0.5) * 2.0,
           y = fabs(fraction(v * 4.0 + wobble * 2.0) - 0.5) * 2.0;
    double line = fabs(x + y - 1.0), inner = fabs(x + y - 0.45);
    double mark = fmax(1.0 - step_smooth(0.050, 0.085, line), 1.0 - step_smooth(0.035, 0.065, inner));
    double border = fmin(fmin(u, 1.0 - u) * 1.45, fmin(v, 1.0 - v));
    mark *= step_smooth(0.035, 0.04, border);
    mark = fmax(mark, step_smooth(0.016, 0.02, border) - step_smooth(0.026, 0.03, border));
    double pile = texture_noise(u, v, 128, 96, 361) * 0.65 + texture_noise(u, v, 20, 14, 362) * 0.35;
    return clamp(mark * 0.8 + 0.2 * pile, 0.0, 1.0);
}

ng_result picture_rug(struct bytes *out)
{
    static const struct rgb colors[3] = {{232, 222, 204}, {206, 192, 170}, {62, 56, 54}};
    return ramp(rug, 256, 192, colors, 3, out);
}

static double rings(double u, double v)
{
    double r = hypot(u - 0.5, v - 0.5) * 2.0, angle = atan2(v - 0.5, u - 0.5);
    double braid = 0.5 + 0.5 * sin(CONTENT_PI * 2.0 * r * 18.0);
    double plait = 0.5 + 0.5 * sin(angle * 90.0 + floor(r * 18.0) * 2.4);
    double band = fraction(floor(r * 18.0) * 0.38);
    return clamp(0.35 * (1.0 - braid) + 0.25 * plait + 0.45 * (band > 0.7), 0.0, 1.0);
}

ng_result picture_round_rug(struct bytes *out)
{
    static const struct rgb colors[3] = {{214, 189, 146}, {183, 153, 108}, {122, 97, 66}};
    return ramp(rings, 256, 256, colors, 3, out);
}

// ---- books ----

static double spines(double u, double v, struct rgb *color)
{
    static const struct rgb cloth[16] = {
        {176, 70, 52}, {236, 226, 208}, {38, 62, 88},    {214, 164, 74},  {58, 84, 72},    {240, 238, 232},
        {122, 44, 52}, {92, 118, 140},  {30, 32, 36},    {204, 120, 86},  {150, 160, 132}, {226, 206, 170},
        {64, 54, 92},  {238, 196, 160}, {112, 130, 108}, {198, 198, 194},
    };
    int i = (int)(u * 16.0) % 16;
    double x = fraction(u * 16.0), style = solid_random(370, (uint64_t)i), at = 0.2 + 0.5 * style;
    struct rgb ink = cloth[i].r + cloth[i].g > 300 ? (struct rgb){50, 46, 44} : (struct rgb){232, 214, 170};
    *color = cloth[i];
    bool title = x > 0.3 && x < 0.7 && fabs(v - at) < 0.13 && fraction(v * 28.0) < 0.66;
    bool band = style > 0.4 && (fabs(v - 0.1) < 0.012 || fabs(v - 0.9) < 0.012);
    if (title || band)
        *color = ink;
    return 1.0;
}

ng_result picture_spines(struct bytes *out)
{
    return paint(spines, 112, 64, false, out);
}

// ---- prints ----

static struct rgb paper(double u, double v, struct rgb tone)
{
    double grain = (texture_noise(u, v, 90, 120, 380) - 0.5) * 10.0;
    return (struct rgb){tone.r + grain, tone.g + grain, tone.b + grain};
}

// A sun over two hills.
static double print_sun(double u, double v, struct rgb *color)
{
    struct rgb c = {240, 230, 212};
    double y = v * 1.33;
    bool inside = u > 0.1 && u < 0.9 && v > 0.08 && v < 0.92;
    if (inside) {
        c = (struct rgb){236, 212, 178};
        if (hypot(u - 0.58, y - 0.46) < 0.19)
            c = (struct rgb){206, 92, 54};
        if (y > 0.72 - 0.13 * sin(u * 4.2 + 0.4))
            c = (struct rgb){196, 142, 96};
        if (y > 0.93 + 0.12 * sin(u * 4.6 + 1.2))
            c = (struct rgb){62, 88, 86};
        if (y > 1.08 + 0.05 * sin(u * 6.0))
            c = (struct rgb){36, 52, 58};
    }
    *color = paper(u, v, c);
    return 1.0;
}

ng_result picture_print_sun(struct bytes *out)
{
    return paint(print_sun, 96, 128, false, out);
}

// Arches within one another, and a stone.
static double print_arches(double u, double v, struct rgb *color)
{
    static const struct rgb bands[4] = {{58, 66, 80}, {190, 124, 92}, {226, 190, 150}, {118, 132, 116}};
    struct rgb c = {238, 232, 220};
    double y = v * 1.33, up = fmax(0.72 - y, 0.0), r = hypot(u - 0.47, up);
    if (y < 1.14 && r < 0.36)
        c = bands[(int)(r / 0.09) % 4];
    if (hypot((u - 0.68) / 1.15, (y - 1.02) / 0.8) < 0.13)
        c = (struct rgb){210, 168, 82};
    *color = paper(u, v, c);
    return 1.0;
}

ng_result picture_print_arches(struct bytes *out)
{
    return paint(print_arches, 96, 128, false, out);
}

// A twig with paired leaves, drawn in ink.
static double print_leaves(double u, double v, struct rgb *color)
{
    struct rgb c = {242, 239, 231};
    double y = v * 1.33, bend = 0.5 + 0.05 * sin(y * 3.0);
    bool ink = fabs(u - bend) < 0.006 && y > 0.2 && y < 1.15;
    for (int i = 0; i < 12; i++) {
        double side = i % 2 ? 1.0 : -1.0, at = 0.26 + 0.068 * i, size = 0.17 + 0.012 * (6 - abs(i - 6));
        double x0 = u - 0.5 - 0.05 * sin(at * 3.0), y0 = y - at;
        double along = (x0 * side * 0.84 - y0 * 0.54) / size, over = (x0 * side * 0.54 + y0 * 0.84) / size;
        if (along > 0.0 && along < 1.0 && fabs(over) < 0.26 * sin(CONTENT_PI * pow(along, 0.8)) &&
            fabs(over) > 0.012)
            ink = true;
    }
    if (ink)
        c = (struct rgb){54, 82, 66};
    *color = paper(u, v, c);
    return 1.0;
}

ng_result picture_print_leaves(struct bytes *out)
{
    return paint(print_leaves, 96, 128, false, out);
}

static double clock_face(double u, double v, struct rgb *color)
{
    double x = u - 0.5, y = 0.5 - v, r = hypot(x, y),
           hour = fraction(atan2(x, y) / (2.0 * CONTENT_PI) + 1.0) * 12.0;
    *color = (struct rgb){244, 243, 240};
    bool quarter = fabs(fraction(hour / 3.0 + 0.5) - 0.5) < 0.1;
    bool mark = r > (quarter ? 0.36 : 0.40) && r < 0.45 &&
                fabs(fraction(hour + 0.5) - 0.5) * r < (quarter ? 0.018 : 0.010);
    if (mark)
        *color = (struct rgb){34, 34, 36};
    return 1.0;
}

ng_result picture_clock(struct bytes *out)
{
    return paint(clock_face, 96, 96, false, out);
}

// ---- what glows ----

// A lake at dusk.
static double screen(double u, double v, struct rgb *color)
{
    const double shore = 0.62;
    double y = v < shore ? v : 2.0 * shore - v; // the lake mirrors
    double low = step_smooth(0.0, shore, y);
    struct rgb c = mix((struct rgb){44, 74, 128}, (struct rgb){250, 170, 104}, low * low);
    double sun = hypot((u - 0.63) * 1.78, y - 0.5);
    c = mix(c, (struct rgb){255, 232, 176}, exp(-sun * sun * 60.0));
    for (int i = 0; i < 3; i++) {
        double ridge = shore - 0.20 + 0.075 * i -
                       (0.12 - 0.03 * i) * texture_noise(fraction(u + 0.3 * i), 0.5, 5 + 3 * (uint32_t)i, 1,
                                                         390 + (uint64_t)i) -
                       0.02 * texture_noise(u, 0.5, 24, 1, 395 + (uint64_t)i);
        if (y > ridge)
            c = mix((struct rgb){120, 98, 122}, (struct rgb){26, 38, 54}, i / 2.0);
    }
    if (v > shore) {
        double ripple = texture_noise(u, v, 10, 90, 398);
        c = mix(c, (struct rgb){30, 48, 78}, 0.25 + 0.3 * ripple);
    }
    *color = c;
    return 1.0;
}

ng_result picture_screen(struct bytes *out)
{
    return paint(screen, 192, 108, false, out);
}

static double shade(double u, double v, struct rgb *color)
{
    double middle = exp(-pow((v - 0.55) / 0.42, 2.0)), linen = texture_noise(u, v, 64, 1, 400) * 0.07;
    double bright = 0.55 + 0.45 * middle - linen;
    *color = (struct rgb){255.0 * bright, 244.0 * pow(bright, 1.15), 226.0 * pow(bright, 1.35)};
    return 1.0;
}

ng_result picture_shade(struct bytes *out)
{
    return paint(shade, 64, 32, false, out);
}

// Ribs of bamboo under rice paper.
static double lantern(double u, double v, struct rgb *color)
{
    double rib = fabs(fraction(v * 14.0) - 0.5) * 2.0;
    double bright = (0.62 + 0.38 * sin(CONTENT_PI * v)) * (1.0 - 0.35 * step_smooth(0.82, 0.95, rib)) -
                    0.05 * texture_noise(u, v, 24, 40, 401);
    *color = (struct rgb){255.0 * bright, 241.0 * pow(bright, 1.1), 214.0 * pow(bright, 1.3)};
    return 1.0;
}

ng_result picture_lantern(struct bytes *out)
{
    return paint(lantern, 16, 128, false, out);
}

// ---- leaves ----

static struct rgb leaf_green(double u, double v, double vein, struct rgb dark, struct rgb light)
{
    double mottle = texture_noise(u, v, 10, 10, 410) * 0.5 + texture_noise(u, v, 26, 26, 411) * 0.2;
    return mix(mix(dark, light, mottle), (struct rgb){168, 190, 120}, vein);
}

// A heart with cuts between its veins, and holes near its middle.
static double monstera(double u, double v, struct rgb *color)
{
    double x = (u - 0.5) * 2.0, y = 1.0 - v; // y from stem to tip
    double side = fabs(x),
           heart = 0.98 * sqrt(fmax(0.0, 1.0 - pow((y - 0.42) / 0.58, 2.0))) * (1.0 - 0.28 * y);
    if (y < 0.16) // the two lobes beside the stem
        heart *= step_smooth(0.0, 0.16, y + 0.02);
    double notch = step_smooth(0.0, 0.2, 0.2 - y) * 0.24;
    double along = y - 0.42 * side; // veins climb outwards
    double rib = fabs(fraction(along * 6.5 + 0.25) - 0.5) * 2.0;
    bool cut = rib > 0.70 + 0.25 * (1.0 - side / fmax(heart, 0.01)) && side > 0.42 * heart && y < 0.93;
    bool hole = rib > 0.80 && side > 0.13 && side < 0.24 && y > 0.2 && y < 0.75;
    bool stem = side < 0.018;
    double vein = fmax(1.0 - step_smooth(0.012, 0.03, side), 0.6 * (1.0 - step_smooth(0.04, 0.12, rib)));
    *color = leaf_green(u, v, 0.35 * vein, (struct rgb){28, 66, 34}, (struct rgb){62, 112, 52});
    return side < heart && side > notch && !cut && !hole ? 1.0 : stem && y > 0.0 && y < 0.9 ? 1.0 : 0.0;
}

ng_result picture_monstera(struct bytes *out)
{
    return paint(monstera, 96, 96, true, out);
}

static double fiddle_leaf(double u, double v, struct rgb *color)
{
    double side = fabs(u - 0.5) * 2.0, y = 1.0 - v;
    double broad = pow(fmax(sin(CONTENT_PI * pow(y, 0.85)), 0.0), 0.62) * (0.62 + 0.36 * y);
    double along = y - 0.16 * side, rib = fabs(fraction(along * 9.0) - 0.5) * 2.0;
    double vein = fmax(1.0 - step_smooth(0.02, 0.05, side), 0.7 * (1.0 - step_smooth(0.05, 0.16, rib)));
    *color = leaf_green(u, v, 0.5 * vein, (struct rgb){40, 78, 36}, (struct rgb){86, 130, 60});
    return side < broad ? 1.0 : 0.0;
}

ng_result picture_fiddle_leaf(struct bytes *out)
{
    return paint(fiddle_leaf, 64, 96, true, out);
}

// A palm's frond: narrow leaflets on both sides of a stalk.
static double frond(double u, double v, struct rgb *color)
{
    double x = (u - 0.5) * 2.0, side = fabs(x), y = 1.0 - v;
    double reach = 0.95 * pow(fmax(sin(CONTENT_PI * pow(clamp(y, 0.0, 1.0), 0.7)), 0.0), 0.5);
    double along = y - 0.30 * side, which = fabs(fraction(along * 17.0 + (x > 0.0 ? 0.5 : 0.0)) - 0.5) * 2.0;
    double taper = 1.0 - side / fmax(reach, 0.01);
    bool leaflet = side < reach && which < 0.66 * pow(clamp(taper, 0.0, 1.0), 0.45) && y > 0.06;
    bool stalk = side < 0.035 * (1.2 - y);
    *color = leaf_green(u, v, stalk ? 0.6 : 0.0, (struct rgb){52, 96, 40}, (struct rgb){104, 150, 66});
    return leaflet || stalk ? 1.0 : 0.0;
}

ng_result picture_frond(struct bytes *out)
{
    return paint(frond, 96, 128, true, out);
}

// ---- the room ----

enum { PLANKS = 8 };

// A floor of staves side by side, their ends staggered; the tile is PLANKS staves wide and four ends long.
static double stave(double u, double v, uint64_t *which)
{
    double x = u * PLANKS;
    int i = (int)x % PLANKS;
    double y = v * 2.0 + solid_random(420, (uint64_t)i);
    int j = (int)floor(y) % 2;
    *which = (uint64_t)(i * 2 + j);
    double across = fmin(fraction(x), 1.0 - fraction(x)) / PLANKS,
           along = fmin(fraction(y), 1.0 - fraction(y)) / 2.0;
    return fmin(across, along * 1.6); // distance from the joint
}

static double parquet(double u, double v)
{
    uint64_t which;
    double joint = stave(u, v, &which);
    double wood_u = fraction(u * 2.0 + solid_random(421, which)),
           wood_v = fraction(v * 1.0 + solid_random(422, which));
    double tone = 0.62 * wood_tone(wood_u, wood_v) + 0.40 * solid_random(423, which);
    return clamp(fmax(tone * 0.86, 1.0 - step_smooth(0.0006, 0.0022, joint)), 0.0, 1.0);
}

static double parquet_height(double u, double v)
{
    uint64_t which;
    double joint = stave(u, v, &which);
    double wood_u = fraction(u * 2.0 + solid_random(421, which)),
           wood_v = fraction(v * 1.0 + solid_random(422, which));
    return step_smooth(0.0, 0.004, joint) - 0.10 * wood_tone(wood_u, wood_v);
}

ng_result picture_parquet(struct bytes *out)
{
    static const struct rgb colors[4] = {{216, 176, 126}, {188, 143, 94}, {152, 108, 66}, {70, 46, 28}};
    return ramp(parquet, 400, 400, colors, 4, out);
}

ng_result picture_parquet_relief(struct bytes *out)
{
    return relief(parquet_height, 256, 256, 0.5, 0.6, out);
}

ng_result picture_parquet_roughness(struct bytes *out)
{
    return roughness(parquet, 160, 160, 0.22, 0.5, out);
}

// Linear radiance of an evening half an hour before sunset, sun excluded, over meadows and far hills.
static void evening(double azimuth, double up, double rgb[3])
{
    double x = azimuth / (2.0 * CONTENT_PI), glow = 0.5 + 0.5 * cos(azimuth - 0.5 * CONTENT_PI); // towards -X
    double low = pow(1.0 - clamp(up, 0.0, 1.0), 4.0);
    const double high_sky[3] = {0.16, 0.30, 0.62}, low_sky[3] = {0.98, 0.74, 0.52},
                 far_sky[3] = {0.52, 0.58, 0.70};
    for (int k = 0; k < 3; k++)
        rgb[k] = high_sky[k] + (far_sky[k] + (low_sky[k] - far_sky[k]) * glow - high_sky[k]) * low;
    double v = clamp(up * 2.2, 0.0, 0.999);
    double cloud = texture_noise(x, v, 9, 5, 430) * 0.5 + texture_noise(x, v, 21, 12, 431) * 0.3 +
                   texture_noise(x, v, 52, 30, 432) * 0.2;
    cloud = step_smooth(0.52, 0.80, cloud) * step_smooth(0.02, 0.12, up);
    const double lit[3] = {1.5, 1.12, 0.88};
    for (int k = 0; k < 3; k++)
        rgb[k] += (lit[k] * (0.55 + 0.45 * glow) - rgb[k]) * cloud * 0.75;
    double hills = 0.035 * texture_noise(x, 0.5, 7, 1, 433) + 0.012 * texture_noise(x, 0.5, 31, 1, 434);
    double trees = 0.008 + 0.016 * texture_noise(x, 0.5, 90, 1, 435) +
                   0.02 * pow(texture_noise(x, 0.5, 40, 1, 436), 3.0);
    const double hill[3] = {0.20, 0.22, 0.26}, tree[3] = {0.045, 0.06, 0.03}, meadow[3] = {0.07, 0.08, 0.035};
    if (up < trees || up < hills)
        for (int k = 0; k < 3; k++)
            rgb[k] = (up < trees ? tree[k] : hill[k]) * (0.8 + 0.5 * glow);
    if (up < 0.0) {
        double haze = pow(clamp(1.0 + up * 6.0, 0.0, 1.0), 2.0),
               grass = texture_noise(x, clamp(-up, 0, 0.999), 120, 60, 437);
        for (int k = 0; k < 3; k++)
            rgb[k] =
                meadow[k] * (0.75 + 0.4 * grass) * (0.8 + 0.4 * glow) * (1.0 - 0.4 * haze) + tree[k] * haze;
    }
}

ng_result picture_evening(struct bytes *out)
{
    enum { W = 384, H = 192 };
    float *rgb = calloc((size_t)W * H, 3 * sizeof *rgb);
    if (!rgb)
        return NG_ERROR_MEMORY;
    for (int i = 0; i < W * H; i++) {
        double light[3], azimuth = 2.0 * CONTENT_PI * (i % W + 0.5) / W;
        evening(azimuth, sin(CONTENT_PI * (0.5 - (i / W + 0.5) / H)), light);
        for (int k = 0; k < 3; k++) // a grid of 1/256, so that the last bit of a sine does not show
            rgb[i * 3 + k] = (float)(round(light[k] * 256.0) / 256.0);
    }
    ng_result result = image_hdr(W, H, rgb, out);
    free(rgb);
    return result;
}
