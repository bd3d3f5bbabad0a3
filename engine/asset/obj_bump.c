// map_Bump names a picture of heights, but most programs write normal maps there. Which of the two a picture
// is, it shows: normals of a surface are blue.
#include "asset/image.h"
#include "asset/obj_internal.h"
#include "asset/png.h"
#include "base/log.h"

#include <math.h>
#include <stdlib.h>

#define STEEP 4.0f // slope where neighbouring texels are black and white, at a -bm of 1

static bool is_normal_map(const struct ng_image *image)
{
    const unsigned char *p = image->pixels;
    double sum[3] = {0}, n = (double)image->width * image->height;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++)
        for (size_t c = 0; c < 3; c++)
            sum[c] += p[i * 4 + c];
    double red = sum[0] / n / 255, green = sum[1] / n / 255, blue = sum[2] / n / 255;
    return blue > 0.6 && blue - red > 0.1 && blue - green > 0.1 && fabs(red - 0.5) < 0.2 &&
           fabs(green - 0.5) < 0.2;
}

static float height(const struct ng_image *image, uint32_t x, uint32_t y)
{
    const unsigned char *p = (const unsigned char *)image->pixels +
                             ((size_t)(y % image->height) * image->width + x % image->width) * 4;
    return (float)(p[0] + p[1] + p[2]) / 765;
}

static unsigned char code(float v)
{
    return (unsigned char)lroundf((v * 0.5f + 0.5f) * 255);
}

// The picture repeats. Rows go down, green points up (glTF 2.0, 3.9.3).
static void write_normals(const struct ng_image *heights, unsigned char *out)
{
    for (uint32_t y = 0; y < heights->height; y++)
        for (uint32_t x = 0; x < heights->width; x++, out += 3) {
            float left = height(heights, x + heights->width - 1, y), right = height(heights, x + 1, y);
            float above = height(heights, x, y + heights->height - 1), below = height(heights, x, y + 1);
            float nx = (left - right) * 0.5f * STEEP, ny = (below - above) * 0.5f * STEEP;
            float length = sqrtf(nx * nx + ny * ny + 1);
            out[0] = code(nx / length);
            out[1] = code(ny / length);
            out[2] = code(1 / length);
        }
}

static ng_result convert(const char *name, const struct ng_image *heights, void **data, size_t *size)
{
    unsigned char *normals = malloc((size_t)heights->width * heights->height * 3 + 1);
    if (!normals)
        return ng_out_of_memory(name);
    write_normals(heights, normals);
    const struct ng_png_params params = {
        .width = heights->width, .height = heights->height, .channels = 3, .pixels = normals};
    free(*data);
    *data = NULL;
    ng_result r = ng_png_encode(name, &params, data, size);
    free(normals);
    return r;
}

ng_result ng_obj_normal_map(const char *name, const struct ng_gltf_params *params, void **data, size_t *size)
{
    struct ng_image image;
    const struct ng_image_params decoding = {
        .no_mips = true, .max_side = params->max_image_side, .max_memory = params->max_image_memory};
    NG_TRY(ng_image_decode(name, *data, *size, &decoding, &image));
    ng_result r = NG_OK;
    if (image.format != NG_PIXEL_RGBA32F && !is_normal_map(&image))
        r = convert(name, &image, data, size);
    ng_image_finish(&image);
    return r;
}
