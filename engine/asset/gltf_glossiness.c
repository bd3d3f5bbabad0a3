// KHR_materials_pbrSpecularGlossiness in the terms of our materials. An infinite index of refraction makes
// the specular colour F0 itself, so that nothing is guessed as it is where metalness is made of it. What the
// extension takes from the diffuse colour (1 - the largest of F0) and has as glossiness (1 - roughness) needs
// pictures of its own.
#include "asset/gltf_loader_internal.h"
#include "asset/image_internal.h"

#include <stdio.h>
#include <string.h>

// Our BRDF takes 4 % from the diffuse part of a usual dielectric itself.
#define USUAL 0.96f

static float largest(const float rgb[3])
{
    float m = rgb[0] > rgb[1] ? rgb[0] : rgb[1];
    return m > rgb[2] ? m : rgb[2];
}

// What F0 leaves of the diffuse colour.
static float left_by(const float f0[3])
{
    float left = (1 - largest(f0)) / USUAL;
    return left < 0 ? 0 : left > 1 ? 1 : left;
}

// A picture of the size of another, to be filled in; its mips are made after that.
static ng_result begin_picture(struct gltf_loader *l, const char *where, const struct ng_image *of,
                               enum ng_pixel_format format, struct ng_image *out)
{
    struct ng_image_params params = {.sampling = of->sampling};
    char limit[128];
    ng_gltf_limit_image(l, &params, limit);
    return ng_image_allocate(where, of->width, of->height, format, &params, out);
}

static ng_result end_picture(struct gltf_loader *l, const char *name, struct ng_image *image, ng_asset *out)
{
    ng_result r = ng_image_make_mips(image);
    if (r == NG_OK)
        return ng_gltf_keep_image(l, name, image, out);
    ng_image_finish(image);
    return r;
}

// Roughness (G) from glossiness (A); no metal (B).
static ng_result make_roughness(struct gltf_loader *l, const char *where, const struct ng_image *gloss,
                                float factor, ng_asset *out)
{
    struct ng_image image;
    char name[80];
    NG_TRY(begin_picture(l, where, gloss, NG_PIXEL_RGBA8, &image));
    const unsigned char *from = gloss->pixels;
    unsigned char *to = image.pixels;
    for (size_t i = 0; i < (size_t)image.width * image.height; i++) {
        to[i * 4 + 1] = (unsigned char)(255.5f - factor * (float)from[i * 4 + 3]);
        to[i * 4 + 3] = 255;
    }
    snprintf(name, sizeof name, "%.40s: roughness", where);
    return end_picture(l, name, &image, out);
}

// The texel of an image where texel (x, y) of another of its shape is.
static const unsigned char *texel_beside(const struct ng_image *image, const struct ng_image *other, size_t x,
                                         size_t y)
{
    size_t u = (2 * x + 1) * image->width / (2 * (size_t)other->width);
    size_t v = (2 * y + 1) * image->height / (2 * (size_t)other->height);
    return (const unsigned char *)image->pixels + (v * image->width + u) * 4;
}

// The diffuse colour that F0 leaves, both of pictures; `diffuse` may be null: white.
static ng_result make_base(struct gltf_loader *l, const char *where, const struct ng_image *diffuse,
                           const struct ng_image *gloss, const struct ng_material *m, ng_asset *out)
{
    struct ng_image image;
    char name[80];
    float linear[256];
    const struct ng_image *shape = diffuse ? diffuse : gloss;
    NG_TRY(begin_picture(l, where, shape, NG_PIXEL_RGBA8_SRGB, &image));
    ng_image_linear_values(linear);
    unsigned char *to = image.pixels;
    for (size_t y = 0; y < image.height; y++)
        for (size_t x = 0; x < image.width; x++, to += 4) {
            static const unsigned char white[4] = {255, 255, 255, 255};
            const unsigned char *from = diffuse ? texel_beside(diffuse, shape, x, y) : white;
            const unsigned char *specular = texel_beside(gloss, shape, x, y);
            float f0[3];
            for (int c = 0; c < 3; c++)
                f0[c] = m->specular_color[c] * linear[specular[c]];
            for (int c = 0; c < 3; c++)
                to[c] = ng_image_srgb_code(linear[from[c]] * left_by(f0));
            to[3] = from[3];
        }
    snprintf(name, sizeof name, "%.40s: base colour", where);
    return end_picture(l, name, &image, out);
}

static bool same_transform(const struct ng_texture_transform *a, const struct ng_texture_transform *b)
{
    const float of_a[] = {a->offset[0], a->offset[1], a->rotation, a->scale[0], a->scale[1]};
    const float of_b[] = {b->offset[0], b->offset[1], b->rotation, b->scale[0], b->scale[1]};
    for (size_t i = 0; i < NG_COUNT(of_a); i++)
        if (of_a[i] < of_b[i] || of_a[i] > of_b[i])
            return false;
    return true;
}

// Pictures can be multiplied where the same coordinates look them up.
static bool same_place(const struct ng_material *m)
{
    return !m->base_color_texture.id ||
           (m->base_color_uv_set == m->specular_color_uv_set &&
            same_transform(&m->base_color_transform, &m->specular_color_transform));
}

static bool is_bytes(const struct ng_image *image)
{
    return !image || image->format != NG_PIXEL_RGBA32F;
}

static ng_result use_pictures(struct gltf_loader *l, const char *where, const struct ng_image *gloss,
                              float glossiness, struct ng_material *out)
{
    const struct ng_image *diffuse = ng_assets_image(l->assets, out->base_color_texture);
    if (!is_bytes(gloss) || !is_bytes(diffuse))
        return ng_gltf_error(l, "%s: a picture of 32 bits a channel is no specular-glossiness texture",
                             where);
    ng_asset base = out->base_color_texture;
    NG_TRY(make_roughness(l, where, gloss, glossiness, &out->metallic_roughness_texture));
    out->metallic_roughness_uv_set = out->specular_color_uv_set;
    out->metallic_roughness_transform = out->specular_color_transform;
    out->roughness = 1;
    if (!same_place(out))
        return NG_OK;
    // The store may have moved what it holds.
    NG_TRY(make_base(l, where, ng_assets_image(l->assets, base),
                     ng_assets_image(l->assets, out->specular_color_texture), out, &out->base_color_texture));
    out->base_color_uv_set = out->specular_color_uv_set;
    out->base_color_transform = out->specular_color_transform;
    return NG_OK;
}

ng_result ng_gltf_glossiness(struct gltf_loader *l, const char *where, const struct gltf_value *extension,
                             struct ng_material *out)
{
    const struct gltf_texture_use diffuse_use = ng_gltf_texture_use(extension, "diffuseTexture");
    const struct gltf_texture_use gloss_use = ng_gltf_texture_use(extension, "specularGlossinessTexture");
    float diffuse[4] = {1, 1, 1, 1}, glossiness = (float)ng_gltf_number(extension, "glossinessFactor", 1);
    ng_gltf_numbers(extension, "diffuseFactor", 4, diffuse);
    ng_gltf_numbers(extension, "specularFactor", 3, out->specular_color);
    out->metallic = 0;
    out->ior = 0; // infinite
    out->roughness = 1 - glossiness;
    out->alpha = diffuse[3];
    memcpy(out->base_color, diffuse, sizeof out->base_color);
    NG_TRY(ng_gltf_use_texture(l, where, &diffuse_use, true, GLTF_SLOT(out, base_color)));
    NG_TRY(ng_gltf_use_texture(l, where, &gloss_use, true, GLTF_SLOT(out, specular_color)));
    const struct ng_image *gloss = ng_assets_image(l->assets, out->specular_color_texture);
    if (!gloss || !same_place(out))
        for (int i = 0; i < 3; i++)
            out->base_color[i] = diffuse[i] * left_by(out->specular_color);
    return gloss ? use_pictures(l, where, gloss, glossiness, out) : NG_OK;
}
