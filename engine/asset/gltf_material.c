// Materials become entities; images are loaded once for each way in which they are sampled.
#include "asset/gltf_loader_internal.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "components/components.h"
#include "components/material.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Decodes a picture and keeps it under a name, once for each way in which its bytes are sampled.
static ng_result keep_image(struct gltf_loader *l, const char *messages, const char *name, const void *data,
                            size_t size, const struct ng_image_params *params, ng_asset *out)
{
    struct gltf_picture picture = {
        ng_hash_bytes(size, data, size), size, params->srgb, params->repeat_u, params->repeat_v, {0}};
    for (size_t i = 0; i < l->pictures.count; i++) {
        const struct gltf_picture *p = &l->pictures.items[i];
        if (p->hash == picture.hash && p->size == size && p->srgb == picture.srgb &&
            p->repeat_u == picture.repeat_u && p->repeat_v == picture.repeat_v) {
            *out = p->image;
            return NG_OK;
        }
    }
    struct ng_image image;
    NG_TRY(ng_image_decode(messages, data, size, params, &image));
    if (!ng_array_reserve(&l->added, l->added.count + 1) ||
        !ng_array_reserve(&l->pictures, l->pictures.count + 1)) {
        ng_image_finish(&image);
        return ng_out_of_memory(l->path);
    }
    l->memory += image.size; // bounded by the decoder, which was told what is left
    NG_TRY(ng_assets_take_image(l->assets, name, &image, out));
    ng_array_push(&l->added, *out);
    picture.image = *out;
    ng_array_push(&l->pictures, picture);
    l->out.image_count++;
    return NG_OK;
}

// What the decoder may use is what the scene has left.
struct image_limits {
    char text[128];
};

static void limit_image(const struct gltf_loader *l, struct ng_image_params *p, struct image_limits *limits)
{
    uint64_t left = l->limits.max_memory - l->memory, most = l->limits.max_image_memory;
    p->max_side = l->limits.max_image_side;
    p->repair = !l->faults.strict;
    p->max_memory = left < most ? left : most;
    p->limit = limits->text;
    if (left < most)
        snprintf(limits->text, sizeof limits->text,
                 "the %llu that are left of the scene's limit of %llu; raise it (--memory-limit)",
                 (unsigned long long)left, (unsigned long long)l->limits.max_memory);
    else
        snprintf(limits->text, sizeof limits->text, "the %llu that one picture may have",
                 (unsigned long long)most);
    // 0 would mean the default, and nothing fits into 1.
    p->max_memory = p->max_memory ? p->max_memory : 1;
}

// A picture file beside the document; the image is named after it, messages also say who refers to it.
static ng_result load_file(struct gltf_loader *l, const char *where, const char *uri,
                           struct ng_image_params *params, ng_asset *out)
{
    char path[4096], name[4096];
    const char *why;
    if (!ng_gltf_uri_path(l->path, uri, path, sizeof path, &why))
        return ng_gltf_error(l, "%s: \"%.60s\" %s", where, uri, why);
    if (l->limits.file)
        l->limits.file(l->limits.user, path);
    snprintf(name, sizeof name, "%.3000s: %.200s: %.800s", l->path, where, path);
    struct image_limits limits;
    limit_image(l, params, &limits);
    void *data;
    size_t size;
    NG_TRY(ng_file_read_named(name, path, l->limits.max_file_size, &data, &size));
    l->out.hash = ng_hash_bytes(l->out.hash, data, size);
    ng_result r = keep_image(l, name, path, data, size, params, out);
    free(data);
    return r;
}

static ng_result load_image(struct gltf_loader *l, int index, struct ng_image_params *params, ng_asset *out)
{
    const struct gltf_image *image = &l->doc->images[index];
    char where[32], name[4096];
    snprintf(where, sizeof where, "image %d", index);
    if (image->uri[0] && !ng_gltf_is_data_uri(image->uri))
        return load_file(l, where, image->uri, params, out);
    snprintf(name, sizeof name, "%.3500s: %s", l->path, where);
    struct image_limits limits;
    limit_image(l, params, &limits);
    const unsigned char *data = NULL;
    unsigned char *own = NULL;
    size_t size = 0;
    if (!image->uri[0] && image->view == -1)
        return ng_gltf_error(l, "%s: has neither a uri nor a buffer view", where);
    if (image->uri[0])
        NG_TRY(ng_gltf_data_uri(&l->faults, where, image->uri, l->limits.max_file_size, &own, &size));
    else
        NG_TRY(ng_gltf_view_bytes(l, image->view, &data, &size));
    const char *kept = image->name[0] ? image->name : name;
    ng_result r = keep_image(l, name, kept, own ? own : data, size, params, out);
    free(own);
    return r;
}

static ng_result wrap_mode(struct gltf_loader *l, int sampler, const char *axis, int mode, bool *repeat)
{
    enum { CLAMP = 33071, MIRRORED = 33648, REPEAT = 10497 };
    if (mode != CLAMP && mode != MIRRORED && mode != REPEAT)
        NG_TRY(ng_gltf_fault(&l->faults, "REPEAT is used", "sampler %d: %s has no mode %d", sampler, axis,
                             mode));
    if (mode == MIRRORED)
        ng_gltf_warn(l, &l->warned_mirror, "sampler %d: MIRRORED_REPEAT is treated as REPEAT", sampler);
    *repeat = mode != CLAMP;
    return NG_OK;
}

ng_result ng_gltf_texture(struct gltf_loader *l, const char *where, int texture, bool srgb, ng_asset *out)
{
    const struct gltf_document *d = l->doc;
    *out = (ng_asset){0};
    if (texture < 0 || (uint32_t)texture >= d->texture_count)
        return ng_gltf_error(l, "%s: texture %d is not one of %u", where, texture, d->texture_count);
    const struct gltf_texture *t = &d->textures[texture];
    if (t->image == -1) { // glTF 2.0, 5.29.2
        if (t->extensions && t->extensions->count)
            ng_gltf_warn(l, &l->warned_source,
                         "texture %d: its picture is that of %.60s, which is not followed; the scene is "
                         "drawn without it",
                         texture, t->extensions->items[0].key);
        return NG_OK;
    }
    if (t->image < 0 || (uint32_t)t->image >= d->image_count)
        return ng_gltf_error(l, "texture %d: image %d is not one of %u", texture, t->image, d->image_count);
    struct ng_image_params params = {.srgb = srgb, .repeat_u = true, .repeat_v = true};
    if (t->sampler >= 0 && (uint32_t)t->sampler >= d->sampler_count) {
        NG_TRY(ng_gltf_fault(&l->faults, "the default is used", "texture %d: sampler %d is not one of %u",
                             texture, t->sampler, d->sampler_count));
    } else if (t->sampler >= 0) {
        const struct gltf_sampler *s = &d->samplers[t->sampler];
        NG_TRY(wrap_mode(l, t->sampler, "wrapS", s->wrap_s, &params.repeat_u));
        NG_TRY(wrap_mode(l, t->sampler, "wrapT", s->wrap_t, &params.repeat_v));
    }
    ng_asset *cached = &l->images[t->image][srgb * 4 + params.repeat_u * 2 + params.repeat_v];
    struct gltf_part part;
    ng_gltf_part_begin(&part, "the scene is drawn without it");
    ng_result r = cached->id || l->image_lost[t->image] ? NG_OK : load_image(l, t->image, &params, cached);
    NG_TRY(ng_gltf_part_end(&l->faults, &part, r));
    l->image_lost[t->image] |= part.lost;
    *out = *cached;
    return NG_OK;
}

ng_result ng_gltf_picture(struct gltf_loader *l, const char *where, const char *uri, ng_asset *out)
{
    // Around a latitude-longitude map u wraps, v does not.
    struct ng_image_params params = {.srgb = true, .repeat_u = true};
    return load_file(l, where, uri, &params, out);
}

static ng_result use_texture(struct gltf_loader *l, const char *where, const struct gltf_texture_use *use,
                             bool srgb, ng_asset *out, uint32_t *uv_set)
{
    if (use->texture == -1)
        return NG_OK;
    if (use->uv_set > 1)
        ng_gltf_warn(l, &l->warned_uv, "%s: a texture uses TEXCOORD_%d; TEXCOORD_0 is used instead", where,
                     use->uv_set);
    *uv_set = use->uv_set == 1;
    struct gltf_part part;
    ng_gltf_part_begin(&part, "the scene is drawn without it");
    part.where = where;
    return ng_gltf_part_end(&l->faults, &part, ng_gltf_texture(l, where, use->texture, srgb, out));
}

static void copy3(float out[3], const double *in)
{
    for (int i = 0; i < 3; i++)
        out[i] = (float)in[i];
}

static ng_result alpha_mode(struct gltf_loader *l, const char *where, const char *mode, bool *mask)
{
    bool blend = strcmp(mode, "BLEND") == 0;
    if (!blend && strcmp(mode, "MASK") != 0 && strcmp(mode, "OPAQUE") != 0)
        return ng_gltf_fault(&l->faults, "OPAQUE is used",
                             "%s: alphaMode \"%.40s\" is not OPAQUE, MASK or BLEND", where, mode);
    if (blend)
        ng_gltf_warn(l, &l->warned_blend, "%s: alpha mode BLEND is treated as MASK", where);
    *mask = strcmp(mode, "OPAQUE") != 0;
    return NG_OK;
}

// Before KHR_materials_emissive_strength exporters wrote factors above 1.
static ng_result emission(struct gltf_loader *l, const char *where, const struct gltf_material *m,
                          struct ng_material *out)
{
    copy3(out->emissive, m->emissive.items);
    out->emissive_strength = (float)m->emissive_strength;
    float most = fmaxf(fmaxf(out->emissive[0], out->emissive[1]), out->emissive[2]);
    if (!(most > 1) || !isfinite(most))
        return NG_OK;
    for (int i = 0; i < 3; i++)
        out->emissive[i] /= most;
    out->emissive_strength *= most;
    return ng_gltf_fault(&l->faults, "it counts as strength", "%s: emissiveFactor has %g, more than 1", where,
                         (double)most);
}

static ng_result make_material(struct gltf_loader *l, const char *where, const struct gltf_material *m,
                               ng_entity e)
{
    struct ng_material out;
    memcpy(&out, ng_material_component.defaults, sizeof out);
    copy3(out.base_color, m->base_color.items);
    NG_TRY(emission(l, where, m, &out));
    out.alpha = (float)m->base_color.items[3];
    out.metallic = (float)m->metallic;
    out.roughness = (float)m->roughness;
    out.alpha_cutoff = (float)m->alpha_cutoff;
    out.normal_scale = (float)m->normal_scale;
    out.double_sided = m->double_sided;
    NG_TRY(alpha_mode(l, where, m->alpha_mode, &out.alpha_mask));
    NG_TRY(
        use_texture(l, where, &m->base_color_texture, true, &out.base_color_texture, &out.base_color_uv_set));
    NG_TRY(use_texture(l, where, &m->metallic_roughness_texture, false, &out.metallic_roughness_texture,
                       &out.metallic_roughness_uv_set));
    NG_TRY(use_texture(l, where, &m->normal_texture, false, &out.normal_texture, &out.normal_uv_set));
    NG_TRY(use_texture(l, where, &m->emissive_texture, true, &out.emissive_texture, &out.emissive_uv_set));
    NG_TRY(ng_gltf_add(l, e, where, NG_MATERIAL, &out));
    return ng_gltf_components(l, e, where, m->extension, NULL);
}

ng_result ng_gltf_materials(struct gltf_loader *l)
{
    const struct gltf_document *d = l->doc;
    if (d->material_count == 0)
        return NG_OK;
    ng_entity group;
    NG_TRY(ng_gltf_entity(l, l->out.root, "materials", "group", 0, &group));
    for (uint32_t i = 0; i < d->material_count; i++) {
        const struct gltf_material *m = &d->materials[i];
        char where[32];
        snprintf(where, sizeof where, "material %u", i);
        NG_TRY(ng_gltf_entity(l, group, m->name, "material", i, &l->materials[i]));
        NG_TRY(make_material(l, where, m, l->materials[i]));
    }
    l->out.material_count = d->material_count;
    return NG_OK;
}
