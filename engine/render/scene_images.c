// Textures on the GPU: one image an asset, and one bind group for each set of textures that a material has.
#include "render/scene_gpu_internal.h"

#include "asset/assets.h"
#include "base/hash.h"
#include "base/log.h"
#include "gpu/transfer.h"

#include <string.h>

#define TEXTURES   NG_TEXTURE_COUNT
#define ANISOTROPY 8.0f // of textures on surfaces, where the device draws them well with it

static ng_result make_texel(struct ng_gpu *gpu, const char *name, uint32_t rgba, struct ng_gpu_image **out)
{
    NG_TRY(ng_gpu_image_create(gpu,
                               &(struct ng_gpu_image_params){
                                   .name = name, .width = 1, .height = 1, .format = VK_FORMAT_R8G8B8A8_UNORM},
                               out));
    return ng_upload_image(*out, &(struct ng_upload_image_params){.data = &rgba, .size = sizeof rgba});
}

ng_result ng_texture_cache_init(struct ng_texture_cache *c, struct ng_gpu *gpu)
{
    c->gpu = gpu;
    NG_TRY(make_texel(gpu, "white", 0xffffffffu, &c->white));
    return make_texel(gpu, "black", 0, &c->black);
}

// ---- Images ----------------------------------------------------------------------------------------------

static VkFormat format_of(const struct ng_image *image)
{
    static const VkFormat formats[] = {[NG_PIXEL_RGBA8] = VK_FORMAT_R8G8B8A8_UNORM,
                                       [NG_PIXEL_RGBA8_SRGB] = VK_FORMAT_R8G8B8A8_SRGB,
                                       [NG_PIXEL_RGBA32F] = VK_FORMAT_R32G32B32A32_SFLOAT};
    return formats[image->format];
}

static ng_result make_image(struct ng_gpu *gpu, const struct ng_image *image, struct ng_gpu_image **out)
{
    return ng_gpu_image_create(gpu,
                               &(struct ng_gpu_image_params){.name = "texture",
                                                             .width = image->width,
                                                             .height = image->height,
                                                             .mips = image->levels,
                                                             .format = format_of(image)},
                               out);
}

static VkSamplerAddressMode address_mode(enum ng_wrap wrap)
{
    static const VkSamplerAddressMode modes[] = {[NG_WRAP_CLAMP] = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                 [NG_WRAP_REPEAT] = VK_SAMPLER_ADDRESS_MODE_REPEAT,
                                                 [NG_WRAP_MIRROR] = VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT};
    return modes[wrap];
}

static VkFilter filter_of(enum ng_filter filter)
{
    return filter == NG_FILTER_NEAREST ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
}

VkSampler ng_texture_cache_sampler(struct ng_gpu *gpu, const struct ng_image *image, float anisotropy)
{
    const struct ng_sampling *s = &image->sampling;
    bool smooth = s->magnify == NG_FILTER_LINEAR && s->minify == NG_FILTER_LINEAR && s->mips == NG_MIP_LINEAR;
    return ng_gpu_sampler(gpu, &(struct ng_gpu_sampler_params){
                                   .mag_filter = filter_of(s->magnify),
                                   .min_filter = filter_of(s->minify),
                                   .mip_filter = s->mips == NG_MIP_LINEAR ? VK_SAMPLER_MIPMAP_MODE_LINEAR
                                                                          : VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                   .no_mips = s->mips == NG_MIP_NONE,
                                   .address_u = address_mode(s->wrap_u),
                                   .address_v = address_mode(s->wrap_v),
                                   .anisotropy = smooth ? anisotropy : 0});
}

static void drop_groups(struct ng_texture_cache *c, uint64_t oldest)
{
    size_t before = c->groups.count;
    for (size_t i = before; i-- > 0;)
        if (c->groups.items[i].last_used < oldest) {
            ng_gpu_bind_group_destroy(&c->groups.items[i].group);
            ng_array_swap_remove(&c->groups, i);
        }
    if (c->groups.count == before)
        return;
    ng_index_map_clear(&c->group_at);
    for (uint32_t i = 0; i < c->groups.count; i++)
        (void)ng_index_map_set(&c->group_at, c->groups.items[i].key, i); // does not grow: it held as many
}

// Whether texels of another revision can go where those before were.
static bool fits(const struct ng_image_entry *e, const struct ng_image *image, VkSampler sampler)
{
    return e->image && e->sampler == sampler && e->image->width == image->width &&
           e->image->height == image->height && e->image->mips == image->levels &&
           e->image->format == format_of(image);
}

static ng_result upload_image(struct ng_texture_cache *c, struct ng_image_entry *e,
                              const struct ng_snapshot_image *image)
{
    VkSampler sampler = ng_texture_cache_sampler(c->gpu, image->image, ANISOTROPY);
    if (!sampler)
        return NG_ERROR_DEVICE;
    if (!fits(e, image->image, sampler)) {
        if (e->image)
            drop_groups(c, UINT64_MAX); // some of them hold its view
        ng_gpu_image_destroy(&e->image);
        e->sampler = sampler;
        NG_TRY(make_image(c->gpu, image->image, &e->image));
    }
    e->revision = image->revision;
    const struct ng_upload_image_params texels = {.data = image->image->pixels, .size = image->image->size};
    return ng_upload_image(e->image, &texels);
}

static ng_result find_entry(struct ng_texture_cache *c, uint32_t index, uint64_t key)
{
    uint32_t at = c->of.items[index];
    if (at < c->images.count && c->images.items[at].key == key)
        return NG_OK;
    at = ng_index_map_get(&c->image_at, key);
    if (at == UINT32_MAX) {
        at = (uint32_t)c->images.count;
        if (!ng_array_push(&c->images, (struct ng_image_entry){.key = key}) ||
            !ng_index_map_set(&c->image_at, key, at))
            return ng_out_of_memory("the scene on the GPU");
    }
    c->of.items[index] = at;
    return NG_OK;
}

static ng_result update_image(struct ng_texture_cache *c, uint32_t index)
{
    const struct ng_snapshot_image *image = &c->snapshot->images[index];
    NG_TRY(find_entry(c, index, image->key));
    struct ng_image_entry *e = &c->images.items[c->of.items[index]];
    e->last_used = c->frame;
    if (e->image && e->revision == image->revision)
        return NG_OK;
    ng_result r = upload_image(c, e, image);
    if (r != NG_OK) {
        drop_groups(c, UINT64_MAX);
        ng_gpu_image_destroy(&e->image);
    }
    return r;
}

ng_result ng_texture_cache_update(struct ng_texture_cache *c, const struct ng_snapshot *snapshot,
                                  uint64_t frame)
{
    c->snapshot = snapshot;
    c->frame = frame;
    if (!ng_array_resize(&c->of, snapshot->image_count))
        return ng_out_of_memory("the scene on the GPU");
    for (uint32_t i = 0; i < snapshot->image_count; i++)
        NG_TRY(update_image(c, i));
    return NG_OK;
}

struct ng_gpu_binding ng_texture_cache_image(const struct ng_texture_cache *c, uint32_t image,
                                             uint32_t binding)
{
    const struct ng_image_entry *e = image == NG_NONE ? NULL : &c->images.items[c->of.items[image]];
    return (struct ng_gpu_binding){.binding = binding,
                                   .view = e ? e->image->view : c->white->view,
                                   .sampler = e ? e->sampler
                                                : ng_gpu_sampler(c->gpu, &(struct ng_gpu_sampler_params){0})};
}

// ---- Groups ----------------------------------------------------------------------------------------------

static void material_images(const struct ng_snapshot_material *m, uint32_t out[TEXTURES])
{
    for (int i = 0; i < TEXTURES; i++)
        out[i] = m->textures[i].image;
}

bool ng_material_is_textured(const struct ng_snapshot_material *m)
{
    uint32_t images[TEXTURES];
    material_images(m, images);
    for (int i = 0; i < TEXTURES; i++)
        if (images[i] != NG_NONE)
            return true;
    return m->alpha_mode != NG_ALPHA_OPAQUE;
}

bool ng_material_chooses_uvs(const struct ng_snapshot_material *m, bool second)
{
    for (int i = 0; i < TEXTURES; i++)
        if (m->textures[i].image != NG_NONE &&
            (m->textures[i].transformed || (second && m->textures[i].uv_set)))
            return true;
    return false;
}

uint64_t ng_texture_cache_group_key(const struct ng_texture_cache *c, const struct ng_snapshot_material *m)
{
    uint32_t images[TEXTURES];
    uint64_t key = 1;
    material_images(m, images);
    for (int i = 0; i < TEXTURES; i++)
        key = ng_hash_combine(key, images[i] == NG_NONE ? 0 : c->snapshot->images[images[i]].key + 1);
    return key | 1; // never 0
}

ng_result ng_texture_cache_group(struct ng_texture_cache *c, const struct ng_snapshot_material *m,
                                 const struct ng_gpu_pipeline *pipeline, const struct ng_gpu_bind_group **out)
{
    uint64_t key = ng_texture_cache_group_key(c, m);
    uint32_t known = ng_index_map_get(&c->group_at, key);
    if (known != UINT32_MAX) {
        c->groups.items[known].last_used = c->frame;
        *out = c->groups.items[known].group;
        return NG_OK;
    }
    struct ng_gpu_binding bindings[TEXTURES];
    uint32_t images[TEXTURES];
    material_images(m, images);
    for (uint32_t i = 0; i < TEXTURES; i++)
        bindings[i] = ng_texture_cache_image(c, images[i], i);
    if (!ng_array_reserve(&c->groups, c->groups.count + 1))
        return ng_out_of_memory("the scene on the GPU");
    struct ng_group_entry e = {.key = key, .last_used = c->frame};
    NG_TRY(ng_gpu_bind_group_create(c->gpu, "material", pipeline, 1, bindings, TEXTURES, &e.group));
    if (!ng_index_map_set(&c->group_at, key, (uint32_t)c->groups.count)) {
        ng_gpu_bind_group_destroy(&e.group);
        return ng_out_of_memory("the scene on the GPU");
    }
    c->groups.items[c->groups.count++] = e;
    *out = e.group;
    return NG_OK;
}

void ng_texture_cache_drop(struct ng_texture_cache *c, uint64_t oldest)
{
    size_t before = c->images.count;
    drop_groups(c, oldest);
    // Groups hold views of images, so images wait as long again.
    for (size_t i = before; i-- > 0;)
        if (c->images.items[i].last_used + NG_SCENE_UNUSED_FRAMES < oldest) {
            ng_gpu_image_destroy(&c->images.items[i].image);
            ng_array_swap_remove(&c->images, i);
        }
    if (c->images.count == before)
        return;
    ng_index_map_clear(&c->image_at);
    for (uint32_t i = 0; i < c->images.count; i++)
        (void)ng_index_map_set(&c->image_at, c->images.items[i].key, i);
}

void ng_texture_cache_finish(struct ng_texture_cache *c)
{
    for (size_t i = 0; i < c->groups.count; i++)
        ng_gpu_bind_group_destroy(&c->groups.items[i].group);
    for (size_t i = 0; i < c->images.count; i++)
        ng_gpu_image_destroy(&c->images.items[i].image);
    ng_gpu_image_destroy(&c->white);
    ng_gpu_image_destroy(&c->black);
    ng_array_finish(&c->groups);
    ng_array_finish(&c->images);
    ng_index_map_finish(&c->image_at);
    ng_index_map_finish(&c->group_at);
    ng_array_finish(&c->of);
}
