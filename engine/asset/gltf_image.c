// Pictures of a document: each is decoded once for each way in which its bytes are used.
#include "asset/gltf_loader_internal.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool same_use(const struct gltf_image_use *a, const struct gltf_image_use *b)
{
    return a->srgb == b->srgb &&
           memcmp(&a->sampling, &b->sampling, sizeof a->sampling) == 0; // enumerators alone: no padding
}

static struct gltf_image_use use_of(const struct ng_image_params *p)
{
    return (struct gltf_image_use){p->srgb, p->sampling};
}

ng_result ng_gltf_keep_image(struct gltf_loader *l, const char *name, struct ng_image *image, ng_asset *out)
{
    if (!ng_array_reserve(&l->added, l->added.count + 1)) {
        ng_image_finish(image);
        return ng_out_of_memory(l->path);
    }
    l->memory += image->size; // bounded by ng_gltf_limit_image
    NG_TRY(ng_assets_take_image(l->assets, name, image, out));
    ng_array_push(&l->added, *out);
    l->out.image_count++;
    return NG_OK;
}

// Decodes a picture and keeps it under a name, once for each way in which its bytes are used.
static ng_result decode(struct gltf_loader *l, const char *messages, const char *name, const void *data,
                        size_t size, const struct ng_image_params *params, ng_asset *out)
{
    struct gltf_picture picture = {ng_hash_bytes(size, data, size), size, use_of(params), {0}};
    for (size_t i = 0; i < l->pictures.count; i++) {
        const struct gltf_picture *p = &l->pictures.items[i];
        if (p->hash == picture.hash && p->size == size && same_use(&p->use, &picture.use)) {
            *out = p->image;
            return NG_OK;
        }
    }
    struct ng_image image;
    NG_TRY(ng_image_decode(messages, data, size, params, &image));
    NG_TRY(ng_gltf_keep_image(l, name, &image, out));
    picture.image = *out;
    return ng_array_push(&l->pictures, picture) ? NG_OK : ng_out_of_memory(l->path);
}

void ng_gltf_limit_image(const struct gltf_loader *l, struct ng_image_params *p, char text[128])
{
    uint64_t left = l->limits.max_memory - l->memory, most = l->limits.max_image_memory;
    p->max_side = l->limits.max_image_side;
    p->repair = !l->faults.strict;
    p->max_memory = left < most ? left : most;
    p->limit = text;
    if (left < most)
        snprintf(text, 128, "the %llu that are left of the scene's limit of %llu" NG_GLTF_RAISE,
                 (unsigned long long)left, (unsigned long long)l->limits.max_memory);
    else
        snprintf(text, 128, "the %llu that one picture may have" NG_GLTF_RAISE, (unsigned long long)most);
    // 0 would mean the default, and nothing fits into 1.
    p->max_memory = p->max_memory ? p->max_memory : 1;
}

// A picture file beside the document; the image is named after it, messages also say who refers to it.
static ng_result load_file(struct gltf_loader *l, const char *where, const char *uri,
                           const struct ng_image_params *params, ng_asset *out)
{
    struct ng_image_params limited = *params;
    char path[4096], name[4096];
    const char *why;
    if (!ng_gltf_uri_path(l->path, uri, path, sizeof path, &why))
        return ng_gltf_error(l, "%s: \"%.60s\" %s", where, uri, why);
    if (l->limits.file)
        l->limits.file(l->limits.user, path);
    snprintf(name, sizeof name, "%.3000s: %.200s: %.800s", l->path, where, path);
    char limit[128];
    ng_gltf_limit_image(l, &limited, limit);
    void *data;
    size_t size;
    NG_TRY(ng_file_read_named(name, path, l->limits.max_file_size, NG_GLTF_RAISE, &data, &size));
    l->out.hash = ng_hash_bytes(l->out.hash, data, size);
    ng_result r = decode(l, name, path, data, size, &limited, out);
    free(data);
    return r;
}

static ng_result load_image(struct gltf_loader *l, int index, const struct ng_image_params *params,
                            ng_asset *out)
{
    const struct gltf_image *image = &l->doc->images[index];
    struct ng_image_params limited = *params;
    char where[32], name[4096];
    snprintf(where, sizeof where, "image %d", index);
    bool has_uri = image->uri[0] && image->view < 0; // of both the view is there
    if (has_uri && !ng_gltf_is_data_uri(image->uri))
        return load_file(l, where, image->uri, params, out);
    snprintf(name, sizeof name, "%.3500s: %s", l->path, where);
    char limit[128];
    ng_gltf_limit_image(l, &limited, limit);
    const unsigned char *data = NULL;
    unsigned char *own = NULL;
    size_t size = 0;
    if (!has_uri && image->view == -1)
        return ng_gltf_error(l, "%s: has neither a uri nor a buffer view", where);
    if (has_uri)
        NG_TRY(ng_gltf_data_uri(&l->faults, where, image->uri, l->limits.max_file_size, &own, &size));
    else
        NG_TRY(ng_gltf_view_bytes(l, image->view, &data, &size));
    const char *kept = image->name[0] ? image->name : name;
    ng_result r = decode(l, name, kept, own ? own : data, size, &limited, out);
    free(own);
    return r;
}

enum { NEAREST = 9728, LINEAR, FIRST_OF_MIPS = 9984, LAST_OF_MIPS = 9987 };
enum { CLAMP = 33071, MIRRORED = 33648, REPEAT = 10497 };

static bool is_wrap(int mode)
{
    return mode == CLAMP || mode == MIRRORED || mode == REPEAT;
}

static bool is_filter(int filter)
{
    return filter == 0 || filter == NEAREST || filter == LINEAR;
}

static bool has_mips(int filter)
{
    return filter >= FIRST_OF_MIPS && filter <= LAST_OF_MIPS;
}

static enum ng_wrap wrap_of(int mode)
{
    return mode == CLAMP ? NG_WRAP_CLAMP : mode == MIRRORED ? NG_WRAP_MIRROR : NG_WRAP_REPEAT;
}

struct ng_sampling ng_gltf_sampling(int wrap_s, int wrap_t, int mag_filter, int min_filter)
{
    struct ng_sampling s = {.wrap_u = wrap_of(wrap_s), .wrap_v = wrap_of(wrap_t)};
    bool mips = has_mips(min_filter);
    s.magnify = mag_filter == NEAREST ? NG_FILTER_NEAREST : NG_FILTER_LINEAR;
    s.minify = min_filter == NEAREST || (mips && min_filter % 2 == 0) ? NG_FILTER_NEAREST : NG_FILTER_LINEAR;
    s.mips = min_filter == NEAREST || min_filter == LINEAR ? NG_MIP_NONE
             : mips && min_filter < FIRST_OF_MIPS + 2      ? NG_MIP_NEAREST
                                                           : NG_MIP_LINEAR;
    return s;
}

static ng_result read_sampler(struct gltf_loader *l, int texture, int sampler, struct ng_sampling *out)
{
    const struct gltf_document *d = l->doc;
    *out = (struct ng_sampling){.wrap_u = NG_WRAP_REPEAT, .wrap_v = NG_WRAP_REPEAT};
    if (sampler < 0)
        return NG_OK;
    if ((uint32_t)sampler >= d->sampler_count)
        return ng_gltf_fault(&l->faults, "the default is used", "texture %d: sampler %d is not one of %u",
                             texture, sampler, d->sampler_count);
    const struct gltf_sampler *s = &d->samplers[sampler];
    if (!is_wrap(s->wrap_s) || !is_wrap(s->wrap_t))
        NG_TRY(ng_gltf_fault(&l->faults, "REPEAT is used", "sampler %d: %s has no mode %d", sampler,
                             is_wrap(s->wrap_s) ? "wrapT" : "wrapS",
                             is_wrap(s->wrap_s) ? s->wrap_t : s->wrap_s));
    if (!is_filter(s->mag_filter) || (!is_filter(s->min_filter) && !has_mips(s->min_filter)))
        NG_TRY(ng_gltf_fault(&l->faults, "the smooth one is used", "sampler %d: %s has no mode %d", sampler,
                             is_filter(s->mag_filter) ? "minFilter" : "magFilter",
                             is_filter(s->mag_filter) ? s->min_filter : s->mag_filter));
    *out = ng_gltf_sampling(s->wrap_s, s->wrap_t, s->mag_filter, s->min_filter);
    return NG_OK;
}

static uint32_t find_loaded(const struct gltf_loader *l, int image, const struct gltf_image_use *use)
{
    uint32_t i = l->first_image[image];
    while (i && !same_use(&l->images.items[i - 1].use, use))
        i = l->images.items[i - 1].next;
    return i;
}

// Where the picture cannot be read the image is null, and nobody tries again.
static ng_result load_once(struct gltf_loader *l, int image, struct ng_image_params *params, ng_asset *out)
{
    struct gltf_part part;
    const struct gltf_image_use use = use_of(params);
    if (l->image_lost[image])
        return NG_OK;
    ng_gltf_part_begin(&part, "the scene is drawn without it");
    NG_TRY(ng_gltf_part_end(&l->faults, &part, load_image(l, image, params, out)));
    l->image_lost[image] |= part.lost;
    if (!ng_array_push(&l->images, ((struct gltf_loaded){use, image, *out, l->first_image[image]})))
        return ng_out_of_memory(l->path);
    l->first_image[image] = (uint32_t)l->images.count;
    return NG_OK;
}

ng_result ng_gltf_texture(struct gltf_loader *l, const char *where, int texture, bool srgb, ng_asset *out)
{
    const struct gltf_document *d = l->doc;
    *out = (ng_asset){0};
    if (texture < 0 || (uint32_t)texture >= d->texture_count)
        return ng_gltf_error(l, "%s: texture %d is not one of %u", where, texture, d->texture_count);
    const struct gltf_texture *t = &d->textures[texture];
    int image = t->image;
    if (t->webp >= 0 && (uint32_t)t->webp < d->image_count && d->images[t->webp].webp)
        image = t->webp;
    else if (t->webp != -1)
        NG_TRY(ng_gltf_fault(&l->faults, "the texture is what it is without the extension",
                             "texture %d: EXT_texture_webp: image %d is no WebP picture", texture, t->webp));
    if (image == -1) { // glTF 2.0, 5.29.2
        if (t->extensions && t->extensions->count && t->webp == -1)
            ng_gltf_warn(l, &l->warned_source,
                         "texture %d: its picture is that of %.60s, which is not followed; the scene is "
                         "drawn without it",
                         texture, t->extensions->items[0].key);
        return NG_OK;
    }
    if (image < 0 || (uint32_t)image >= d->image_count)
        return ng_gltf_error(l, "texture %d: image %d is not one of %u", texture, image, d->image_count);
    struct ng_image_params params = {.srgb = srgb};
    NG_TRY(read_sampler(l, texture, t->sampler, &params.sampling));
    const struct gltf_image_use use = use_of(&params);
    uint32_t loaded = find_loaded(l, image, &use);
    if (!loaded)
        return load_once(l, image, &params, out);
    *out = l->images.items[loaded - 1].image;
    return NG_OK;
}

ng_result ng_gltf_picture(struct gltf_loader *l, const char *where, const char *uri, ng_asset *out)
{
    // Around a latitude-longitude map u wraps, v does not.
    struct ng_image_params params = {.srgb = true, .sampling.wrap_u = NG_WRAP_REPEAT};
    return load_file(l, where, uri, &params, out);
}
