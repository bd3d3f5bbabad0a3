// Images into textures: those of the file as they are there, others as PNG or, of floats, as OpenEXR beside
// the document, which glTF has no place for.
#include "asset/exr.h"
#include "asset/gltf_save_internal.h"
#include "asset/png.h"

#include <cjson/cJSON.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    NEAREST = 9728,
    LINEAR,
    FIRST_OF_MIPS = 9984,
    CLAMP_TO_EDGE = 33071,
    MIRRORED = 33648,
    REPEAT = 10497
};

// The document's image that an asset was loaded from; false if it is no such image.
static bool find_image(const struct gltf_saver *s, ng_asset asset, int *image)
{
    for (size_t i = 0; s->origin && i < s->origin->images.count; i++)
        if (s->origin->images.items[i].image.id == asset.id) {
            *image = s->origin->images.items[i].source;
            return true;
        }
    return false;
}

static int mode_of(const cJSON *sampler, const char *key, int missing)
{
    int mode = ng_gltf_json_index(sampler, key);
    return mode < 0 ? missing : mode;
}

static bool samples_like(const struct gltf_saver *s, const cJSON *texture, const struct ng_sampling *wanted)
{
    const cJSON *sampler = ng_gltf_at(&s->w, NG_GLTF_SAMPLERS, ng_gltf_json_index(texture, "sampler"));
    struct ng_sampling has =
        ng_gltf_sampling(mode_of(sampler, "wrapS", REPEAT), mode_of(sampler, "wrapT", REPEAT),
                         mode_of(sampler, "magFilter", 0), mode_of(sampler, "minFilter", 0));
    return memcmp(&has, wanted, sizeof has) == 0; // enumerators alone: no padding
}

static int wrap_mode(enum ng_wrap wrap)
{
    return wrap == NG_WRAP_CLAMP ? CLAMP_TO_EDGE : wrap == NG_WRAP_MIRROR ? MIRRORED : REPEAT;
}

static int add_sampler(struct gltf_saver *s, const struct ng_image *image)
{
    const struct ng_sampling *how = &image->sampling;
    int linear = how->minify == NG_FILTER_LINEAR;
    int first = how->mips == NG_MIP_NONE      ? NEAREST
                : how->mips == NG_MIP_NEAREST ? FIRST_OF_MIPS
                                              : FIRST_OF_MIPS + 2;
    cJSON *sampler;
    int index = ng_gltf_append(&s->w, NG_GLTF_SAMPLERS, &sampler);
    ng_gltf_json_number(&s->w, sampler, "magFilter", how->magnify == NG_FILTER_LINEAR ? LINEAR : NEAREST);
    ng_gltf_json_number(&s->w, sampler, "minFilter", first + linear);
    ng_gltf_json_number(&s->w, sampler, "wrapS", wrap_mode(how->wrap_u));
    ng_gltf_json_number(&s->w, sampler, "wrapT", wrap_mode(how->wrap_v));
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
    ng_gltf_release_view(s, ng_gltf_json_index(object, "bufferView"));
    ng_gltf_json_remove(object, "uri");
    ng_gltf_json_remove(object, "bufferView");
    ng_gltf_json_remove(object, "mimeType");
    (image->format == NG_PIXEL_RGBA32F ? put_exr : put_png)(s, object, image);
}

// How many assets were made of one of the document's images.
static unsigned count_ways(const struct gltf_saver *s, int image)
{
    unsigned ways = 0;
    for (size_t i = 0; i < s->origin->images.count; i++)
        ways += s->origin->images.items[i].source == image;
    return ways;
}

// In the image's old place. A texture that named it as WebP has it as what it is now.
static void replace_pixels(struct gltf_saver *s, int source, const struct ng_image *image)
{
    put_pixels(s, ng_gltf_at(&s->w, NG_GLTF_IMAGES, source), image);
    for (uint32_t i = 0; i < s->origin->doc->texture_count; i++) {
        cJSON *texture = ng_gltf_at(&s->w, NG_GLTF_TEXTURES, (int)i);
        const cJSON *webp = ng_gltf_json_get(ng_gltf_json_get(texture, "extensions"), "EXT_texture_webp");
        if (!webp || ng_gltf_json_index(webp, "source") != source)
            continue;
        ng_gltf_json_remove_extension(texture, "EXT_texture_webp");
        ng_gltf_json_number(&s->w, texture, "source", source);
    }
}

static int find_texture(struct gltf_saver *s, ng_asset asset, const struct ng_image *image)
{
    int source;
    bool from_file = find_image(s, asset, &source);
    cJSON *object;
    if (!from_file || (!ng_gltf_kept_asset(s->origin, s->assets, asset) && count_ways(s, source) > 1)) {
        source = ng_gltf_append(&s->w, NG_GLTF_IMAGES, &object);
        put_pixels(s, object, image);
        return add_texture(s, source, image);
    }
    if (!ng_gltf_kept_asset(s->origin, s->assets, asset))
        replace_pixels(s, source, image);
    for (uint32_t i = 0; i < s->origin->doc->texture_count; i++)
        if ((s->origin->doc->textures[i].image == source || s->origin->doc->textures[i].webp == source) &&
            samples_like(s, ng_gltf_at(&s->w, NG_GLTF_TEXTURES, (int)i), &image->sampling))
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
    if (image && image->format == NG_PIXEL_RGBA32F && !find_image(s, asset, &source))
        put_exr(s, field, image);
    else
        ng_gltf_json_number(&s->w, field, "texture", ng_gltf_save_texture(s, asset));
}
