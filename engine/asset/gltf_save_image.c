// Images into textures: those of the file as they are there, others as PNG or, of floats, as OpenEXR beside
// the document, which glTF has no place for.
#include "asset/exr.h"
#include "asset/gltf_save_internal.h"
#include "asset/png.h"

#include <cjson/cJSON.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CLAMP_TO_EDGE = 33071, REPEAT = 10497 };

// The document's image that an asset was loaded from, by the way it is sampled; false if it is no such image.
static bool find_image(const struct gltf_saver *s, ng_asset asset, int *image, unsigned *way)
{
    for (uint32_t i = 0; s->origin && i < s->origin->doc->image_count; i++)
        for (unsigned k = 0; k < 8; k++)
            if (s->origin->images[i][k].id == asset.id) {
                *image = (int)i;
                *way = k;
                return true;
            }
    return false;
}

static int wrap_mode(const cJSON *sampler, const char *key)
{
    int mode = ng_gltf_json_index(sampler, key);
    return mode < 0 ? REPEAT : mode;
}

static bool wraps_like(const struct gltf_saver *s, const cJSON *texture, bool repeat_u, bool repeat_v)
{
    const cJSON *sampler = ng_gltf_at(&s->w, NG_GLTF_SAMPLERS, ng_gltf_json_index(texture, "sampler"));
    return (wrap_mode(sampler, "wrapS") != CLAMP_TO_EDGE) == repeat_u &&
           (wrap_mode(sampler, "wrapT") != CLAMP_TO_EDGE) == repeat_v;
}

static int add_sampler(struct gltf_saver *s, const struct ng_image *image)
{
    cJSON *sampler;
    int index = ng_gltf_append(&s->w, NG_GLTF_SAMPLERS, &sampler);
    ng_gltf_json_number(&s->w, sampler, "magFilter", 9729);
    ng_gltf_json_number(&s->w, sampler, "minFilter", 9987);
    ng_gltf_json_number(&s->w, sampler, "wrapS", image->repeat_u ? REPEAT : CLAMP_TO_EDGE);
    ng_gltf_json_number(&s->w, sampler, "wrapT", image->repeat_v ? REPEAT : CLAMP_TO_EDGE);
    return index;
}

static int add_texture(struct gltf_saver *s, int source, const struct ng_image *image)
{
    cJSON *texture;
    int sampler = add_sampler(s, image);
    int index = ng_gltf_append(&s->w, NG_GLTF_TEXTURES, &texture);
    ng_gltf_json_number(&s->w, texture, "sampler", sampler);
    ng_gltf_json_number(&s->w, texture, "source", source);
    return index;
}

// A picture of floats stands beside the document.
static void put_exr(struct gltf_saver *s, cJSON *object, const struct ng_image *image)
{
    static const char *const names[] = {"R", "G", "B", "A"};
    struct ng_exr_channel channels[4];
    for (unsigned i = 0; i < 4; i++)
        channels[i] = (struct ng_exr_channel){names[i], NG_EXR_FLOAT, (const float *)image->pixels + i, 4};
    const struct ng_exr_params params = {
        .width = image->width, .height = image->height, .channels = channels, .channel_count = 4};
    void *data = NULL;
    size_t size = 0;
    if (ng_exr_encode(s->path, &params, &data, &size) != NG_OK || !ng_array_push(&s->owned, data)) {
        free(data);
        s->w.failed = true;
        return;
    }
    char name[32];
    snprintf(name, sizeof name, ".%zu.exr", s->new_pictures++);
    ng_gltf_save_beside(s, object, name, data, size);
}

static void put_png(struct gltf_saver *s, cJSON *object, const struct ng_image *image)
{
    const struct ng_png_params params = {
        .width = image->width, .height = image->height, .pixels = image->pixels};
    void *data = NULL;
    size_t size = 0;
    if (ng_png_encode(s->path, &params, &data, &size) != NG_OK) {
        s->w.failed = true;
        return;
    }
    ng_gltf_json_text(&s->w, object, "mimeType", "image/png");
    ng_gltf_json_number(&s->w, object, "bufferView", ng_gltf_add_view(&s->w, data, size, NG_GLTF_NO_TARGET));
    free(data);
}

// The pixels as they are now, in an image of the document.
static void put_pixels(struct gltf_saver *s, cJSON *object, const struct ng_image *image)
{
    ng_gltf_json_remove(object, "uri");
    ng_gltf_json_remove(object, "bufferView");
    ng_gltf_json_remove(object, "mimeType");
    (image->format == NG_PIXEL_RGBA32F ? put_exr : put_png)(s, object, image);
}

// How many assets were made of one of the document's images.
static unsigned count_ways(const struct gltf_saver *s, int image)
{
    unsigned ways = 0;
    for (unsigned k = 0; k < 8; k++)
        ways += s->origin->images[image][k].id != 0;
    return ways;
}

static int find_texture(struct gltf_saver *s, ng_asset asset, const struct ng_image *image)
{
    int source;
    unsigned way;
    bool from_file = find_image(s, asset, &source, &way);
    cJSON *object;
    if (!from_file || (!ng_gltf_kept_asset(s->origin, s->assets, asset) && count_ways(s, source) > 1)) {
        source = ng_gltf_append(&s->w, NG_GLTF_IMAGES, &object);
        put_pixels(s, object, image);
        return add_texture(s, source, image);
    }
    if (!ng_gltf_kept_asset(s->origin, s->assets, asset))
        put_pixels(s, ng_gltf_at(&s->w, NG_GLTF_IMAGES, source), image);
    for (uint32_t i = 0; i < s->origin->doc->texture_count; i++)
        if (s->origin->doc->textures[i].image == source &&
            wraps_like(s, ng_gltf_at(&s->w, NG_GLTF_TEXTURES, (int)i), image->repeat_u, image->repeat_v))
            return (int)i;
    return add_texture(s, source, image);
}

int ng_gltf_save_texture(struct gltf_saver *s, ng_asset asset)
{
    const struct ng_image *image = ng_assets_image(s->assets, asset);
    if (!image)
        return -1;
    for (size_t i = 0; i < s->textures.count; i++)
        if (s->textures.items[i].asset.id == asset.id)
            return s->textures.items[i].index;
    struct gltf_index_of found = {asset, find_texture(s, asset, image)};
    s->w.failed |= !ng_array_push(&s->textures, found);
    return found.index;
}

void ng_gltf_save_picture(struct gltf_saver *s, cJSON *field, ng_asset asset)
{
    const struct ng_image *image = ng_assets_image(s->assets, asset);
    int source;
    unsigned way;
    if (image && image->format == NG_PIXEL_RGBA32F && !find_image(s, asset, &source, &way))
        put_exr(s, field, image);
    else
        ng_gltf_json_number(&s->w, field, "texture", ng_gltf_save_texture(s, asset));
}
